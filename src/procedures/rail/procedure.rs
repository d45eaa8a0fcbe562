//! The rail calibration behind the seam: its readers, its calibration, what a check says, its errors against the truth.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::simulate::{DEMO, RailTruth, SimulatedRail, simulate};
use super::survey::scenario::parse_scenario;
use super::survey::{LoadedRail, RailScenarioFile, load, write_rail};
use super::trials::RailTrials;
use super::{
    RailInput, RailJointConfig, RailReferenceConfig, RailScene, calibrate, summary, verdict,
};
use crate::calibrate::choices::Method;
use crate::calibrate::seam::{
    Checked, Count, Finished, InputError, Loaded, Procedure, Progress, ScenarioRun, Settings,
    Simulated, Uses, looks_like, make_folder, provenance, read_truth,
};
use crate::calibrate::tried::Tried;
use crate::formats::Format;
use crate::results::InputFile;
use crate::ruled::Ruled;
use crate::survey::schema::Key;

/// Laser profilers on a measuring beam against a standard rail.
#[derive(Clone, Copy, Debug)]
pub struct Rail;

impl Procedure for Rail {
    fn name(&self) -> &'static str {
        "rail"
    }

    fn about(&self) -> &'static str {
        "laser profilers on a measuring beam against a standard rail"
    }

    fn demo(&self) -> String {
        DEMO.to_owned()
    }

    fn survey_keys(&self) -> &'static [Key] {
        super::survey::file::RailSurveyFile::KEYS
    }

    fn targets(&self) -> &'static [(&'static str, &'static [Key])] {
        &[("A rail's profile.", super::survey::keys::MODEL)]
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
        let read = parse_scenario(file, text, file.parent().unwrap_or(Path::new("")))?;
        let (reference, joint) = read.calibration(file)?;
        Ok(Box::new(RailRun {
            read,
            reference,
            joint,
        }))
    }
}

impl Loaded for LoadedRail {
    fn name(&self) -> &str {
        &self.file.name
    }

    fn inputs(&self) -> &[InputFile] {
        &self.inputs
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
        let truth: Option<RailTruth> = truth.map(read_truth).transpose()?;
        progress.begin("calibrating")?;
        let input = input(self, settings.method);
        let outcome = calibrate(&input);
        progress.begin("comparing and drawing")?;
        let provenance = provenance(&self.file, &self.inputs, settings)?;
        let result = summary::result(&outcome, provenance)?;
        let page = summary::page(&outcome, &result, &self.file.name, truth.as_ref())?;
        Ok(Finished { result, page })
    }

    fn check(&self, _: &Settings, progress: Progress<'_>) -> Result<Checked, InputError> {
        progress.begin("looking at the geometry")?;
        let scene = RailScene::new(&self.campaign, &self.rail);
        let preview = verdict::preview(&scene, &input(self, Method::Joint));
        Ok(Checked {
            text: in_words(self, &scene, &preview),
            json: as_json(self, &scene, &preview),
            determined: preview.words.is_empty() && preview.mistake.is_none(),
        })
    }
}

fn input(survey: &LoadedRail, method: Method) -> RailInput<'_> {
    RailInput {
        campaign: &survey.campaign,
        rail: &survey.rail,
        method,
        reference: &survey.file.reference,
        joint: &survey.file.joint,
    }
}

/// A scenario file and how its survey is calibrated.
struct RailRun {
    read: RailScenarioFile,
    reference: RailReferenceConfig,
    joint: RailJointConfig,
}

impl ScenarioRun for RailRun {
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
        let survey =
            simulate(&self.read.scenario, &self.read.rail, seed).map_err(InputError::unworkable)?;
        progress.begin(&format!("writing {}", folder.display()))?;
        make_folder(folder)?;
        write_rail(folder, &self.read, &survey)?;
        Ok(Simulated {
            counts: counts(&survey),
            truth: serde_json::to_value(&survey.truth)?,
        })
    }

    fn tried(&self) -> Result<Box<dyn Tried + '_>, InputError> {
        Ok(Box::new(RailTrials {
            scenario: self.read.scenario.clone(),
            rail: self.read.rail.clone(),
            reference: self.reference.clone(),
            joint: self.joint.clone(),
        }))
    }
}

fn counts(survey: &SimulatedRail) -> Vec<Count> {
    let campaign = &survey.campaign;
    vec![
        Count::new("points", "points", campaign.points.len()),
        Count::new("positions", "positions of the table", campaign.table.len()),
    ]
}

fn in_words(survey: &LoadedRail, scene: &RailScene, preview: &verdict::Preview) -> String {
    let mut text = format!(
        "Survey \"{}\" is readable and consistent.\n\n",
        survey.file.name
    );
    let _ = writeln!(
        text,
        "{} points, {} attitude records, {} positions of the table; {} points while it turned",
        survey.campaign.points.len(),
        survey.campaign.attitude.time_s.len(),
        scene.positions.len(),
        scene.turning
    );
    let (heading, pitch) = scene.turned_rad();
    let _ = writeln!(
        text,
        "table turned by {:.2} deg about the vertical, {:.2} deg about the lateral axis\n",
        heading.to_degrees(),
        pitch.to_degrees()
    );
    text.push_str("Points, and the standard deviations to expect of the joint path\n");
    let _ = writeln!(text, "{}\n", seen(preview, survey));
    for words in &preview.words {
        let _ = writeln!(text, "{words}");
    }
    if let Some(mistake) = &preview.mistake {
        let _ = writeln!(text, "{}", looks_like(mistake));
    }
    text
}

fn as_json(survey: &LoadedRail, scene: &RailScene, preview: &verdict::Preview) -> Value {
    let (heading, pitch) = scene.turned_rad();
    json!({
        "survey": survey.file.name,
        "procedure": "rail",
        "points": survey.campaign.points.len(),
        "positions": scene.positions.len(),
        "turned_deg": [heading.to_degrees(), pitch.to_degrees()],
        "expected_sigma": preview.expected,
        "undetermined": preview.words,
        "mistake": preview.mistake,
    })
}

/// Points near the rail and expected standard deviations, profiler by profiler.
fn seen(preview: &verdict::Preview, survey: &LoadedRail) -> Ruled {
    let mut table = Ruled::new([
        "profiler",
        "points",
        "on the rail",
        "pitch, deg",
        "roll, deg",
        "yaw, deg",
        "lx, mm",
        "lz, mm",
    ]);
    for (k, profiler) in survey.file.profiler.iter().enumerate() {
        let mine = survey.campaign.points.profiler.iter();
        let points = mine.filter(|p| **p as usize == k).count();
        let mut row = vec![
            profiler.name.clone(),
            points.to_string(),
            preview.near[k].to_string(),
        ];
        let own = preview.expected.iter().skip(5 * k).take(5);
        row.extend(own.map(|s| s.map_or_else(|| "-".to_owned(), |s| format!("{s:.4}"))));
        table.row(row);
    }
    table
}
