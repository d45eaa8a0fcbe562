//! `boresight demo`: the whole job with no input.

use std::path::Path;

use super::args::Demo;
use super::calibrate::calibrated;
use super::error::CliError;
use super::talk::Talk;
use super::{Ending, simulate};
use crate::calibrate::choices::Method;
use crate::procedures::pool::survey::{self as survey, ScenarioFile, scenario};
use crate::survey::SURVEY_FILE;

/// Runs the command: simulate, write the survey, read it again, calibrate, report, compare with the truth.
pub fn run(args: &Demo, talk: &Talk) -> Result<Ending, CliError> {
    let folder = args.out.join("survey");
    let simulated = simulate::written(&scenario()?, args.seed, &folder, talk)?;
    talk.step("reading the survey");
    let survey = survey::load(&folder.join(SURVEY_FILE))?;
    let truth = Some(&simulated.truth);
    let finished = calibrated(&survey, Method::Both, args.seed, truth, talk)?;
    finished.told_of(Some(&folder.join(SURVEY_FILE)), &args.out, talk)
}

/// The embedded scenario, with the simple joint model as a third column.
fn scenario() -> Result<ScenarioFile, CliError> {
    let mut file = scenario::from_text(Path::new("demo.toml"), crate::simulate::DEMO)?;
    let joint = toml::Table::from_iter([("simple".to_owned(), toml::Value::Boolean(true))]);
    file.calibration
        .insert("joint".to_owned(), toml::Value::Table(joint));
    Ok(file)
}
