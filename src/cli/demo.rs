//! `boresight demo`: the whole job with no input.

use std::path::Path;

use super::args::Demo;
use super::calibrate::{calibrated, notes, write};
use super::error::CliError;
use super::talk::Talk;
use super::{Ending, simulate, truth};
use crate::calibrate::choices::Method;
use crate::procedures::pool::survey::{self as survey, ScenarioFile, scenario};
use crate::report;
use crate::survey::SURVEY_FILE;

/// Runs the command: simulate, write the survey, read it again, calibrate, report, compare with the truth.
pub fn run(args: &Demo, talk: &Talk) -> Result<Ending, CliError> {
    let folder = args.out.join("survey");
    let simulated = simulate::written(&scenario()?, args.seed, &folder, talk)?;
    talk.step("reading the survey");
    let survey = survey::load(&folder.join(SURVEY_FILE))?;
    let truth = &simulated.truth;
    let finished = calibrated(
        &survey,
        Method::Both,
        args.seed,
        Some(truth::for_report(truth)),
        talk,
    )?;
    let place = write(&args.out, &finished, talk)?;
    let text = format!(
        "{}{}\n{}\nSurvey  {}\n{place}",
        report::text::summary(&finished.result),
        notes(&finished.notes),
        truth::table(&finished.result, truth),
        folder.join(SURVEY_FILE).display(),
    );
    talk.result(&text, &report::json::to_bytes(&finished.result)?)?;
    Ok(finished.ending())
}

/// The embedded scenario, with the simple joint model as a third column.
fn scenario() -> Result<ScenarioFile, CliError> {
    let mut file = scenario::from_text(Path::new("demo.toml"), crate::simulate::DEMO)?;
    let joint = toml::Table::from_iter([("simple".to_owned(), toml::Value::Boolean(true))]);
    file.calibration
        .insert("joint".to_owned(), toml::Value::Table(joint));
    Ok(file)
}
