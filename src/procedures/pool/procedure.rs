//! The pool calibration behind the seam: its readers, its calibration, its errors against the truth.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::budget::planner::planner;
use super::budget::trials::{Configuration, PoolObserved, PoolTrials};
use super::check::checked;
use super::preview::preview;
use super::summary::{self, Dropped};
use super::survey::claims::claims;
use super::survey::{LoadedSurvey, ScenarioFile, load, scenario, write_survey};
use super::{PoolError, PoolInput, calibrate_with};
use crate::calibrate::cloud::{Calibrated, Cloud};
use crate::calibrate::planning::{PlanAsk, Planner};
use crate::calibrate::seam::{
    Checked, Count, Finished, InputError, Loaded, Procedure, Progress, ScenarioRun, Settings,
    Simulated, Uses, make_folder, provenance, read_truth,
};
use crate::calibrate::tried::Tried;
use crate::results::InputFile;
use crate::simulate::{DEMO, Simulated as Survey, Truth, simulate};
use crate::survey::recorded::own_points::Against;
use crate::survey::schema::Key;

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

    fn survey_keys(&self) -> &'static [Key] {
        super::survey::file::SurveyFile::KEYS
    }

    fn targets(&self) -> &'static [(&'static str, &'static [Key])] {
        &[
            (
                "A wall with two columns of blocks.",
                super::survey::keys::WALL,
            ),
            ("Any faces.", super::survey::keys::FACES),
        ]
    }

    fn planner(
        &self,
        file: &Path,
        text: &str,
        ask: &PlanAsk,
    ) -> Result<Option<Box<dyn Planner>>, InputError> {
        planner(file, text, ask).map(Some)
    }

    fn template_from(&self, files: &[PathBuf]) -> Option<String> {
        Some(super::survey::from_files::template(files))
    }

    fn uses(&self) -> Uses {
        Uses {
            seed: true,
            simple: true,
            survey_budget: true,
            extras: true,
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
        let mut file = self.file.clone();
        file.joint.simple |= settings.simple;
        let input = PoolInput {
            joint: &file.joint,
            extras: &settings.extras,
            ..input(self, settings)
        };
        let truth: Option<Truth> = truth.map(read_truth).transpose()?;
        let outcome = calibrate_with(&input, &[], progress).map_err(|error| match error {
            PoolError::Stopped(stopped) => stopped.into(),
            other => InputError::unworkable(other),
        })?;
        progress.begin("comparing and drawing")?;
        let dropped = Dropped {
            soundings: self.counts.soundings_dropped as u64,
            returns: self.counts.laser_dropped as u64,
        };
        let provenance = provenance(&file, &self.inputs, settings)?;
        let result = summary::result(&outcome, &input, dropped, &self.notes, provenance)?;
        let page = summary::page(&outcome, &result, &file.name, truth.as_ref())?;
        whole(self)?;
        Ok(Finished { result, page })
    }

    fn cloud(&self, calibrated: &Calibrated) -> Result<Option<Cloud<'_>>, InputError> {
        let cloud = super::apply::cloud(self, &calibrated.sensor).map_err(PoolError::from);
        Ok(Some(cloud.map_err(InputError::unworkable)?))
    }

    fn check(&self, settings: &Settings, progress: Progress<'_>) -> Result<Checked, InputError> {
        progress.begin("looking at the geometry")?;
        let preview = preview(&input(self, settings), progress).map_err(InputError::unworkable)?;
        whole(self)?;
        let mut found = checked(self, &preview);
        if !self.recorders.is_empty() {
            progress.begin("georeferencing as the sounder did")?;
            let own = Against::files(&self.recorders)?;
            found.text.push_str(&own.text());
            found.json["own_solution"] = own.json();
        }
        Ok(found)
    }

    fn observed(&self, settings: &Settings) -> Result<Option<Box<dyn Tried + '_>>, InputError> {
        let observed = |claims| PoolObserved {
            claims,
            configuration: Configuration {
                sequential: self.file.sequential.clone(),
                joint: self.file.joint.clone(),
            },
            input: input(self, settings),
            notes: self.notes.clone(),
        };
        Ok(claims(self).map(|claims| Box::new(observed(claims)) as Box<dyn Tried>))
    }
}

/// Refuses what was made of soundings that could not be read again from their file.
fn whole(survey: &LoadedSurvey) -> Result<(), InputError> {
    let fault = survey.campaign.soundings.fault().cloned();
    fault.map_or(Ok(()), |fault| {
        Err(InputError::unworkable(PoolError::from(fault)))
    })
}

/// A loaded survey as the calibration takes it, without unknowns of the caller's own.
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
        extras: &[],
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
        progress.begin(&format!(
            "simulating {} with seed {seed}",
            self.scenario.name
        ))?;
        let survey = simulate(&self.scenario, seed).map_err(InputError::unworkable)?;
        progress.begin(&format!("writing {}", folder.display()))?;
        make_folder(folder)?;
        write_survey(folder, self, &survey)?;
        Ok(Simulated {
            counts: counts(&survey),
            truth: serde_json::to_value(&survey.truth)?,
        })
    }

    fn tried(&self) -> Result<Box<dyn Tried + '_>, InputError> {
        let calibration = self.calibration(&self.file)?;
        Ok(Box::new(PoolTrials {
            scenario: self.scenario.clone(),
            configuration: Configuration {
                sequential: calibration.sequential,
                joint: calibration.joint,
            },
        }))
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
