//! The seabed calibration behind the seam: its readers, its calibration, what a check says, its errors against the truth.

use std::path::Path;

use nalgebra::Matrix3;
use serde_json::{Value, json};

use super::joint::{JointError, overlap};
use super::layout::Layout;
use super::run::{SeabedInput, SeabedOutcome, calibrate};
use super::simulate::{DEMO, SeabedScenario, SeabedTruth, parse_scenario, simulate, write};
use super::summary;
use super::survey::{LoadedSeabed, load};
use super::{SeabedConfig, scene::Scene};
use crate::calibrate::seam::{
    Checked, Count, Finished, InputError, Loaded, Procedure, Progress, ScenarioRun, Settings,
    Simulated, TrueError, Uses, make_folder, provenance, read_truth,
};
use crate::calibrate::tried::Tried;
use crate::geometry::rotation;
use crate::results::AnyResult;
use crate::ruled::Ruled;

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

    fn uses(&self) -> Uses {
        Uses {
            seed: true,
            ..Uses::default()
        }
    }

    fn read(&self, survey: &Path) -> Result<Box<dyn Loaded>, InputError> {
        Ok(Box::new(load(survey)?))
    }

    fn scenario(&self, file: &Path, text: &str) -> Result<Box<dyn ScenarioRun>, InputError> {
        Ok(Box::new(SeabedRun(parse_scenario(file, text)?)))
    }
}

impl Loaded for LoadedSeabed {
    fn name(&self) -> &str {
        &self.file.name
    }

    fn calibrate(
        &self,
        settings: &Settings,
        truth: Option<&Value>,
        progress: Progress<'_>,
    ) -> Result<Finished, InputError> {
        let truth: Option<SeabedTruth> = truth.map(read_truth).transpose()?;
        let config = self.file.config(settings.seed());
        let input = SeabedInput {
            scene: &self.scene,
            method: settings.method,
            joint: &config,
            reference: &self.file.reference,
        };
        progress("calibrating");
        let outcome = calibrate(&input);
        let provenance = provenance(&self.file, &self.inputs, settings)?;
        let result = summary::result(&outcome, &input, self.read, provenance);
        Ok(Finished {
            errors: truth.map_or_else(Vec::new, |t| errors(&outcome, &self.scene, &t)),
            notes: vec![],
            result: AnyResult::Seabed(Box::new(result)),
        })
    }

    fn check(&self, settings: &Settings, progress: Progress<'_>) -> Result<Checked, InputError> {
        progress("looking where the lines meet");
        let config: SeabedConfig = self.file.config(settings.seed());
        Ok(match overlap(&self.scene, &config) {
            Ok(met) => checked(self, &Layout::new(&self.scene, &met.tiles)),
            Err(error) => apart(self, &error),
        })
    }
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
            format!("{:.1}", track.course_deg),
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

/// Each path's errors against the truth: pitch, roll, yaw, latency.
fn errors(outcome: &SeabedOutcome, scene: &Scene, truth: &SeabedTruth) -> Vec<TrueError> {
    let true_rotation = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let of = |values: &super::model::Values| {
        let turn = rotation::log(&(values.mounting.rotation * true_rotation.transpose()));
        let late = values.from_nominal(scene)[3] - truth.latency_s;
        [
            turn.x.to_degrees(),
            turn.y.to_degrees(),
            turn.z.to_degrees(),
            late * 1e3,
        ]
    };
    let joint = match &outcome.joint {
        Some(Ok((joint, _))) => Some((of(&joint.values), joint)),
        _ => None,
    };
    let patch = match &outcome.reference {
        Some(Ok(patch)) => Some((of(&patch.values), patch.found)),
        _ => None,
    };
    let names = [
        ("pitch", "deg"),
        ("roll", "deg"),
        ("yaw", "deg"),
        ("latency", "ms"),
    ];
    let one = |(k, (name, unit)): (usize, &(&str, &str))| {
        let size = if k < 3 { 1f64.to_degrees() } else { 1e3 };
        TrueError {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
            reference: patch.and_then(|(e, found)| found[k].then_some(e[k])),
            joint: joint.map(|(e, _)| e[k]),
            sigma: joint.map(|(_, j)| j.sigma(k) * size),
            joint_simple: None,
        }
    };
    names.iter().enumerate().map(one).collect()
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
        progress(&format!("simulating {} with seed {seed}", self.name()));
        let survey = simulate(&self.0, seed);
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

    fn tried(&self) -> Result<Option<Box<dyn Tried + '_>>, InputError> {
        Ok(None)
    }
}
