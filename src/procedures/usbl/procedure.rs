//! The USBL calibration behind the seam: its readers, its calibration, what a check says, its errors against the truth.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::observed::Role;
use super::simulate::{DEMO, Simulated as Survey, Truth, simulate};
use super::survey::{LoadedUsbl, UsblScenarioFile, load, scenario, write_survey};
use super::trials::UsblTrials;
use super::{Layout, Scene, UsblInput, calibrate, summary, suspected};
use crate::calibrate::choices::Method;
use crate::calibrate::seam::{
    Checked, Count, Finished, InputError, Loaded, Procedure, Progress, ScenarioRun, Settings,
    Simulated, Uses, looks_like, make_folder, provenance, read_truth,
};
use crate::calibrate::tried::Tried;
use crate::formats::Format;
use crate::results::InputFile;
use crate::survey::schema::Key;

/// An ultra-short baseline transducer against surveyed beacons.
#[derive(Clone, Copy, Debug)]
pub struct Usbl;

impl Procedure for Usbl {
    fn name(&self) -> &'static str {
        "usbl"
    }

    fn about(&self) -> &'static str {
        "an ultra-short baseline transducer against surveyed beacons"
    }

    fn demo(&self) -> String {
        DEMO.to_owned()
    }

    fn survey_keys(&self) -> &'static [Key] {
        super::survey::file::UsblFile::KEYS
    }

    fn formats(&self) -> &'static [Format] {
        super::formats::FORMATS
    }

    fn uses(&self) -> Uses {
        Uses::default()
    }

    fn read(&self, survey: &Path) -> Result<Box<dyn Loaded>, InputError> {
        Ok(Box::new(load(survey)?))
    }

    fn scenario(&self, file: &Path, text: &str) -> Result<Box<dyn ScenarioRun>, InputError> {
        let read = scenario::from_text(file, text)?;
        let calibration = read.calibration(file)?;
        Ok(Box::new(UsblRun { read, calibration }))
    }
}

impl Loaded for LoadedUsbl {
    fn name(&self) -> &str {
        &self.file.name
    }

    fn inputs(&self) -> &[InputFile] {
        &self.inputs
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn configuration(&self) -> Result<Value, InputError> {
        Ok(serde_json::to_value(&self.file)?)
    }

    fn calibrate(
        &self,
        settings: &Settings,
        truth: Option<&Value>,
        progress: Progress<'_>,
    ) -> Result<Finished, InputError> {
        let input = input(self, settings.method);
        let truth: Option<Truth> = truth.map(read_truth).transpose()?;
        progress.begin("calibrating")?;
        let outcome = calibrate(&input).map_err(InputError::unworkable)?;
        progress.begin("comparing and drawing")?;
        let read = (self.fixes_read, self.fixes_dropped);
        let provenance = provenance(&self.file, &self.inputs, settings)?;
        let result = summary::result(&outcome, &input, read, &self.notes, provenance)?;
        let page = summary::page(&outcome, &result, &self.file.name, truth.as_ref())?;
        Ok(Finished { result, page })
    }

    fn check(&self, _: &Settings, _: Progress<'_>) -> Result<Checked, InputError> {
        let scene = Scene::new(&self.campaign).map_err(InputError::unworkable)?;
        let layout = Layout::of(&scene);
        let mistake = suspected(&input(self, Method::Joint), &scene);
        let mut checked = Checked {
            text: in_words(self, &scene, &layout),
            json: as_json(self, &scene, &layout),
            determined: layout.determines_mounting() && mistake.is_none(),
        };
        if let Some(mistake) = &mistake {
            let _ = writeln!(checked.text, "{}", looks_like(mistake));
        }
        checked.json["mistake"] = json!(mistake);
        Ok(checked)
    }
}

fn input(survey: &LoadedUsbl, method: Method) -> UsblInput<'_> {
    UsblInput {
        campaign: &survey.campaign,
        method,
        reference: survey.file.reference,
        joint: survey.file.joint.clone(),
    }
}

/// A scenario file and how its survey is calibrated.
struct UsblRun {
    read: UsblScenarioFile,
    calibration: scenario::Calibration,
}

impl ScenarioRun for UsblRun {
    fn name(&self) -> &str {
        &self.read.scenario.name
    }

    fn seed(&self) -> u64 {
        self.read.scenario.seed
    }

    fn write(
        &self,
        seed: u64,
        folder: &Path,
        progress: Progress<'_>,
    ) -> Result<Simulated, InputError> {
        progress.begin(&format!("simulating {} with seed {seed}", self.name()))?;
        let survey = simulate(&self.read.scenario, seed).map_err(InputError::unworkable)?;
        progress.begin(&format!("writing {}", folder.display()))?;
        make_folder(folder)?;
        write_survey(folder, &self.read, &self.calibration, &survey)?;
        Ok(Simulated {
            counts: counts(&survey),
            truth: serde_json::to_value(&survey.truth)?,
        })
    }

    fn tried(&self) -> Result<Box<dyn Tried + '_>, InputError> {
        Ok(Box::new(UsblTrials {
            scenario: self.read.scenario.clone(),
            reference: self.calibration.reference,
            joint: self.calibration.joint.clone(),
        }))
    }
}

fn counts(survey: &Survey) -> Vec<Count> {
    let campaign = &survey.campaign;
    vec![
        Count::new("beacons", "beacons", campaign.beacons.len()),
        Count::new("fixes", "fixes", campaign.fixes.len()),
        Count::new(
            "attitude_records",
            "attitude records",
            survey.attitude_rad.len(),
        ),
    ]
}

fn in_words(survey: &LoadedUsbl, scene: &Scene, layout: &Layout) -> String {
    let mut text = read_in_words(survey, scene.common.len());
    let verdict = if layout.determines_mounting() {
        "Pitch, roll and yaw of the mounting can be determined."
    } else {
        "The mounting cannot be determined."
    };
    let _ = writeln!(text, "{verdict}");
    let words = layout.in_words();
    if !words.is_empty() {
        let _ = writeln!(text, "Layout: {words}.");
    }
    for note in &survey.notes {
        let _ = writeln!(text, "Note: {note}.");
    }
    text
}

fn as_json(survey: &LoadedUsbl, scene: &Scene, layout: &Layout) -> Value {
    json!({
        "survey": survey.file.name,
        "procedure": "usbl",
        "fixes": { "read": survey.fixes_read, "common": scene.common.len(), "dropped": survey.fixes_dropped },
        "attitude_records": survey.campaign.attitude.len(),
        "beacons": beacons(survey),
        "mounting_determined": layout.determines_mounting(),
        "layout": layout.in_words(),
        "notes": survey.notes,
    })
}

/// Name, role, place and number of fixes of every beacon.
fn beacons(survey: &LoadedUsbl) -> Vec<Value> {
    let campaign = &survey.campaign;
    let numbered = campaign.beacons.iter().enumerate();
    numbered
        .map(|(k, beacon)| {
            let place: [f64; 3] = beacon.point.position_m.into();
            json!({
                "name": beacon.point.name,
                "role": role(beacon.role),
                "position_m": place,
                "fixes": campaign.fixes.of_beacon(k as u32),
            })
        })
        .collect()
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Common => "common",
        Role::Check => "check",
    }
}

fn read_in_words(survey: &LoadedUsbl, common: usize) -> String {
    let campaign = &survey.campaign;
    let mut text = format!(
        "{}: USBL survey, {} fixes read, {common} of common beacons, {} without attitude; {} attitude records\n",
        survey.file.name,
        survey.fixes_read,
        survey.fixes_dropped,
        campaign.attitude.len()
    );
    for (k, beacon) in campaign.beacons.iter().enumerate() {
        let [east, north, up]: [f64; 3] = beacon.point.position_m.into();
        let _ = writeln!(
            text,
            "  {} ({}): {east:.3} east, {north:.3} north, {up:.3} up of the transducer, {} fixes",
            beacon.point.name,
            role(beacon.role),
            campaign.fixes.of_beacon(k as u32)
        );
    }
    text
}
