//! The seabed calibration behind the seam: its readers, its calibration, what a check says, its errors against the truth.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::joint::{JointError, overlap};
use super::layout::Layout;
use super::run::{SeabedInput, calibrate_watched};
use super::simulate::{Acts, SeabedTruth, simulate};
use super::summary;
use super::survey::{
    DEMO, LoadedSeabed, SeabedScenario, SeabedSurveyFile, load, parse_scenario, write,
};
use super::trials::SeabedTrials;
use crate::calibrate::cloud::{Calibrated, Cloud};
use crate::calibrate::planning::{PlanAsk, Planner};
use crate::calibrate::seam::{
    Checked, Count, Finished, InputError, Loaded, Procedure, Progress, ScenarioRun, Settings,
    Simulated, Uses, make_folder, provenance, read_truth,
};
use crate::calibrate::tried::Tried;
use crate::results::InputFile;
use crate::ruled::Ruled;
use crate::survey::recorded::own_points::Against;
use crate::survey::schema::Key;

/// A multibeam over natural seabed.
#[derive(Clone, Copy, Debug)]
pub struct SeabedProcedure;

impl Procedure for SeabedProcedure {
    fn name(&self) -> &'static str {
        "seabed"
    }

    fn about(&self) -> &'static str {
        "a multibeam over natural seabed, from lines that overlap"
    }

    fn demo(&self) -> String {
        DEMO.to_owned()
    }

    fn survey_keys(&self) -> &'static [Key] {
        SeabedSurveyFile::KEYS
    }

    fn template_from(&self, files: &[PathBuf]) -> Option<String> {
        Some(super::survey::from_files::template(files))
    }

    fn uses(&self) -> Uses {
        Uses {
            seed: true,
            extras: true,
            ..Uses::default()
        }
    }

    fn read(&self, survey: &Path) -> Result<Box<dyn Loaded>, InputError> {
        Ok(Box::new(load(survey)?))
    }

    fn planner(
        &self,
        file: &Path,
        text: &str,
        ask: &PlanAsk,
    ) -> Result<Option<Box<dyn Planner>>, InputError> {
        super::plan::planner(file, text, ask).map(Some)
    }

    fn scenario(&self, file: &Path, text: &str) -> Result<Box<dyn ScenarioRun>, InputError> {
        Ok(Box::new(SeabedRun(parse_scenario(file, text)?)))
    }
}

impl Loaded for LoadedSeabed {
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
        let truth: Option<SeabedTruth> = truth.map(read_truth).transpose()?;
        let config = self.file.joint(settings.seed());
        let extended = (!settings.extras.is_empty())
            .then(|| self.scene.with_extras(&settings.extras, self.read))
            .transpose()
            .map_err(InputError::unworkable)?;
        let scene = extended.as_ref().unwrap_or(&self.scene);
        let input = SeabedInput {
            scene,
            method: settings.method,
            joint: &config,
            reference: &self.file.reference,
        };
        progress.begin("calibrating")?;
        let outcome = calibrate_watched(&input, progress)?;
        let provenance = provenance(&self.file, &self.inputs, settings)?;
        let mut result = summary::result(&outcome, &input, self.read, provenance);
        result.notes.extend(self.notes.iter().cloned());
        let page = summary::page(&outcome, scene, &self.file.name, truth.as_ref());
        Ok(Finished { result, page })
    }

    fn cloud(&self, calibrated: &Calibrated) -> Result<Option<Cloud<'_>>, InputError> {
        let cloud = super::apply::cloud(self, calibrated);
        cloud.map(Some).map_err(InputError::unworkable)
    }

    fn check(&self, settings: &Settings, progress: Progress<'_>) -> Result<Checked, InputError> {
        progress.begin("looking where the lines meet")?;
        let config = self.file.joint(settings.seed());
        let mut found = match overlap(&self.scene, &config) {
            Ok(met) => checked(self, &Layout::new(&self.scene, &met.tiles)),
            Err(error) => apart(self, &error),
        };
        if !self.recorders.is_empty() {
            progress.begin("georeferencing as the sounder did")?;
            let own = Against::files(&self.recorders)?;
            found.text.push_str(&own.text());
            found.json["own_solution"] = own.json();
        }
        found.text.push_str(&noted(&self.notes));
        found.json["notes"] = json!(self.notes);
        Ok(found)
    }
}

/// What was done on reading, one line each; nothing where nothing was.
fn noted(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    let lines: String = notes.iter().map(|note| format!("- {note}\n")).collect();
    format!("\nOn reading:\n{lines}")
}

fn apart(survey: &LoadedSeabed, error: &JointError) -> Checked {
    Checked {
        text: format!(
            "Survey \"{}\" is readable and consistent.\n\nNothing can be determined: {error}.\n",
            survey.file.name
        ),
        json: json!({ "survey": survey.file.name, "procedure": "seabed", "undetermined": [error.to_string()] }),
        determined: false,
    }
}

fn checked(survey: &LoadedSeabed, layout: &Layout) -> Checked {
    let mut lines = Ruled::new(["line", "course, deg", "speed, m/s", "length, m"]);
    for track in &layout.tracks {
        lines.row([
            track.name.clone(),
            format!("{:.1}", (10.0 * track.course_deg).round() / 10.0 % 360.0),
            format!("{:.2}", track.speed_m_s),
            format!("{:.0}", track.length_m),
        ]);
    }
    let mut pairs = Ruled::new(["pair", "kind", "apart, m", "speeds", "common tiles"]).texts(2);
    for pair in &layout.pairs {
        let name = |k: usize| &layout.tracks[pair.lines[k]].name;
        pairs.row([
            format!("{} and {}", name(0), name(1)),
            format!("{:?}", pair.kind).to_lowercase(),
            format!("{:.1}", pair.apart_m),
            format!("1 : {:.2}", pair.speed_ratio),
            pair.tiles.to_string(),
        ]);
    }
    let missing: Vec<&str> = layout.missing().into_iter().flatten().collect();
    let words: String = missing.iter().map(|m| format!("{m}\n")).collect();
    Checked {
        text: format!(
            "Survey \"{}\" is readable and consistent.\n\n{} soundings on {} lines\n{lines}\n{pairs}\n{words}",
            survey.file.name,
            survey.scene.soundings.len(),
            survey.scene.lines.len()
        ),
        json: json!({
            "survey": survey.file.name,
            "procedure": "seabed",
            "soundings": survey.scene.soundings.len(),
            "layout": layout,
            "undetermined": missing,
        }),
        determined: missing.is_empty(),
    }
}

/// A scenario ready to be simulated.
struct SeabedRun(SeabedScenario);

impl ScenarioRun for SeabedRun {
    fn name(&self) -> &str {
        &self.0.name
    }

    fn seed(&self) -> u64 {
        self.0.seed
    }

    fn write(
        &self,
        seed: u64,
        folder: &Path,
        progress: Progress<'_>,
    ) -> Result<Simulated, InputError> {
        progress.begin(&format!("simulating {} with seed {seed}", self.name()))?;
        let survey = simulate(&self.0, seed, Acts::ALL);
        make_folder(folder)?;
        write::write(folder, &self.0, &survey)?;
        Ok(Simulated {
            counts: vec![
                Count::new("soundings", "soundings", survey.shots.len()),
                Count::new("records", "records of the trajectory", survey.records.len()),
            ],
            truth: serde_json::to_value(&survey.truth)?,
        })
    }

    fn tried(&self) -> Result<Box<dyn Tried + '_>, InputError> {
        Ok(Box::new(SeabedTrials {
            scenario: self.0.clone(),
        }))
    }
}
