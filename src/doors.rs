//! The short doors: one call for one job. What lies behind them is open too, for whoever needs a part of it. The door for arrays
//! in memory is in the folder of the procedure that takes them.

use std::path::Path;

use crate::calibrate::seam::{Checked, Finished, InputError, Settings, Simulated};
use crate::procedures;
use crate::watch::{Unwatched, Watch};

/// Calibrates a survey file by both paths, whichever procedure it names. Writes nothing.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let survey = folder.path().join("survey.toml");
/// # let usbl = boresight::procedures::find("usbl").ok_or("no such procedure")?;
/// # usbl.scenario("demo.toml".as_ref(), &usbl.demo())?.write(1, folder.path(), &boresight::watch::Unwatched)?;
/// let found = boresight::calibrate(&survey)?; // "survey.toml"
/// println!("{}", boresight::report::text::summary(&found.result, &found.page));
/// assert!(found.result.usable);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`InputError`] with everything that is wrong with the input; a calibration without a usable result is no error.
pub fn calibrate(survey: impl AsRef<Path>) -> Result<Finished, InputError> {
    calibrate_with(survey, &Settings::default(), &Unwatched)
}

/// As [`calibrate`], with settings; `progress` is told what is being done and may stop it ([`Watch`]).
///
/// # Errors
/// As [`calibrate`]; also [`InputError::Unused`] for a setting that the procedure has no use for, [`InputError::Stopped`] once
/// `progress` says so.
pub fn calibrate_with(
    survey: impl AsRef<Path>,
    settings: &Settings,
    progress: &dyn Watch,
) -> Result<Finished, InputError> {
    let procedure = procedures::of_file(survey.as_ref())?;
    settings.fit(procedure)?;
    let survey = procedure.read(survey.as_ref())?;
    progress.go_on()?;
    survey.calibrate(settings, None, progress)
}

/// Says what a survey holds and what its geometry can and cannot determine. Solves nothing.
///
/// # Errors
/// As [`calibrate`].
pub fn check(survey: impl AsRef<Path>) -> Result<Checked, InputError> {
    procedures::read(survey.as_ref())?.check(&Settings::default(), &Unwatched)
}

/// Simulates a scenario file under its own seed and writes a complete survey into a folder, which is made when missing.
///
/// # Errors
/// [`InputError`] with everything that is wrong with the scenario, or a file that cannot be written.
pub fn simulate(
    scenario: impl AsRef<Path>,
    folder: impl AsRef<Path>,
) -> Result<Simulated, InputError> {
    let scenario = procedures::scenario(scenario.as_ref())?;
    scenario.write(scenario.seed(), folder.as_ref(), &Unwatched)
}
