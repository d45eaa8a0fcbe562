//! The pool calibration behind the seam: its readers, its calibration, its errors against the truth.

use std::path::Path;

use nalgebra::{Matrix3, Vector3, Vector6};
use serde_json::Value;

use super::check::checked;
use super::preview::preview;
use super::summary::{self, Dropped};
use super::survey::{LoadedSurvey, ScenarioFile, load, scenario, write_survey};
use super::{PoolInput, calibrate};
use crate::calibrate::seam::{
    Checked, Count, Finished, InputError, Loaded, Procedure, Progress, ScenarioRun, Settings,
    Simulated, TrueError, Uses, make_folder, provenance, read_truth,
};
use crate::calibrate::tried::Tried;
use crate::geometry::rotation;
use crate::results::{self, Angles, AnyResult, Estimate, PoolResult};
use crate::simulate::{DEMO, Simulated as Survey, Truth, simulate};

/// A multibeam against a target in a pool that a laser scanner sees too.
#[derive(Clone, Copy, Debug)]
pub struct Pool;

impl Procedure for Pool {
    fn name(&self) -> &'static str {
        "pool"
    }

    fn about(&self) -> &'static str {
        "a multibeam echo sounder against a target in a pool that a laser scanner sees too"
    }

    /// With the simple joint model as a third column.
    fn demo(&self) -> String {
        format!("{DEMO}\n[joint]\nsimple = true\n")
    }

    fn uses(&self) -> Uses {
        Uses {
            seed: true,
            simple: true,
            survey_budget: true,
        }
    }

    fn read(&self, survey: &Path) -> Result<Box<dyn Loaded>, InputError> {
        Ok(Box::new(load(survey)?))
    }

    fn scenario(&self, file: &Path, text: &str) -> Result<Box<dyn ScenarioRun>, InputError> {
        Ok(Box::new(scenario::beside(file, text)?))
    }
}

impl Loaded for LoadedSurvey {
    fn name(&self) -> &str {
        &self.file.name
    }

    fn calibrate(
        &self,
        settings: &Settings,
        truth: Option<&Value>,
        progress: Progress<'_>,
    ) -> Result<Finished, InputError> {
        let mut file = self.file.clone();
        file.joint.simple |= settings.simple;
        let input = PoolInput {
            joint: &file.joint,
            ..input(self, settings)
        };
        let truth: Option<Truth> = truth.map(read_truth).transpose()?;
        let outcome = calibrate(&input, progress).map_err(InputError::unworkable)?;
        progress("comparing and drawing");
        let dropped = Dropped {
            soundings: self.counts.soundings_dropped as u64,
            returns: self.counts.laser_dropped as u64,
        };
        let provenance = provenance(&file, &self.inputs, settings)?;
        let result = summary::result(&outcome, &input, dropped, provenance);
        let samples = summary::samples(&outcome, &file.name, truth.as_ref().map(for_page));
        let notes = self.notes.iter().chain(&outcome.scene.notes);
        Ok(Finished {
            errors: truth.map_or_else(Vec::new, |truth| errors(&result, &truth)),
            notes: notes.cloned().collect(),
            result: AnyResult::Pool(Box::new(result), Box::new(samples)),
        })
    }

    fn check(&self, settings: &Settings, progress: Progress<'_>) -> Result<Checked, InputError> {
        progress("looking at the geometry");
        let preview = preview(&input(self, settings)).map_err(InputError::unworkable)?;
        Ok(checked(self, &preview))
    }
}

/// A loaded survey as the calibration takes it.
#[must_use]
pub fn input<'s>(survey: &'s LoadedSurvey, settings: &Settings) -> PoolInput<'s> {
    PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.pose,
        method: settings.method,
        sequential: &survey.file.sequential,
        joint: &survey.file.joint,
        seed: settings.seed(),
    }
}

impl ScenarioRun for ScenarioFile {
    fn name(&self) -> &str {
        &self.scenario.name
    }

    fn seed(&self) -> u64 {
        self.scenario.seed
    }

    fn write(
        &self,
        seed: u64,
        folder: &Path,
        progress: Progress<'_>,
    ) -> Result<Simulated, InputError> {
        progress(&format!(
            "simulating {} with seed {seed}",
            self.scenario.name
        ));
        let survey = simulate(&self.scenario, seed).map_err(InputError::unworkable)?;
        progress(&format!("writing {}", folder.display()));
        make_folder(folder)?;
        write_survey(folder, self, &survey)?;
        Ok(Simulated {
            counts: counts(&survey),
            truth: serde_json::to_value(&survey.truth)?,
        })
    }

    fn tried(&self) -> Result<Option<Box<dyn Tried + '_>>, InputError> {
        Ok(None)
    }
}

fn counts(survey: &Survey) -> Vec<Count> {
    let campaign = &survey.campaign;
    let records = campaign.trajectory.time_s.len();
    vec![
        Count::new("trajectory_records", "trajectory records", records),
        Count::new("returns", "laser returns", campaign.laser.len()),
        Count::new("soundings", "soundings", campaign.soundings.len()),
    ]
}

/// Name, unit and factor from degrees or metres of each parameter.
const ROWS: [(&str, &str, f64); 6] = [
    ("pitch", "deg", 1.0),
    ("roll", "deg", 1.0),
    ("yaw", "deg", 1.0),
    ("lx right", "mm", 1e3),
    ("ly forward", "mm", 1e3),
    ("lz up", "mm", 1e3),
];

fn for_page(truth: &Truth) -> results::Truth {
    let c = truth.correction_deg;
    let arm = truth.lever_arm() - Vector3::from(truth.nominal_lever_arm_m);
    results::Truth {
        correction_deg: Angles {
            pitch: c.pitch,
            roll: c.roll,
            yaw: c.yaw,
        },
        lever_arm_correction_m: arm.into(),
    }
}

/// Errors of every path; empty when nothing was found.
fn errors(result: &PoolResult, truth: &Truth) -> Vec<TrueError> {
    let solutions = &result.solutions;
    let of = |estimate: Option<&Estimate>| estimate.and_then(|e| error(e, truth));
    let reference = of(solutions.sequential.as_ref().map(|s| &s.estimate));
    let joint = of(solutions.joint.as_ref().map(|s| &s.estimate));
    let simple = of(solutions.joint_simple.as_ref().map(|s| &s.estimate));
    if joint.is_none() && reference.is_none() {
        return vec![];
    }
    let sigmas = solutions.joint.as_ref().and_then(|s| s.standard_deviation);
    let sigmas = sigmas.map(|s| [s.pitch_deg, s.roll_deg, s.yaw_deg, s.lx_m, s.ly_m, s.lz_m]);
    let row = |(i, (name, unit, factor)): (usize, &(&str, &str, f64))| {
        let scaled = |six: Option<Vector6<f64>>| six.map(|v| v[i] * factor);
        TrueError {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
            reference: scaled(reference),
            joint: scaled(joint),
            sigma: sigmas.map(|s| s[i] * factor),
            joint_simple: scaled(simple),
        }
    };
    ROWS.iter().enumerate().map(row).collect()
}

/// Rotation vector (degrees, body frame) and lever arm (metres) from the truth to the estimate.
fn error(estimate: &Estimate, truth: &Truth) -> Option<Vector6<f64>> {
    let found = Matrix3::from_row_iterator(estimate.rotation_matrix?.into_iter().flatten());
    let turn = rotation::log(&(found * truth.rotation().transpose())).map(f64::to_degrees);
    let arm = Vector3::from(estimate.lever_arm_m?) - truth.lever_arm();
    Some(Vector6::new(turn.x, turn.y, turn.z, arm.x, arm.y, arm.z))
}
