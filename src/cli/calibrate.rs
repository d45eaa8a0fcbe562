//! `boresight calibrate`: a survey file to `result.json` and `report.html`.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::Ending;
use super::args::Calibrate;
use super::error::CliError;
use super::talk::Talk;
use crate::procedures::pool::summary::{self, Dropped};
use crate::procedures::pool::survey::{self as survey, LoadedSurvey};
use crate::procedures::pool::{self, Method, PoolInput};
use crate::report;
use crate::results::{InputFile, PoolResult, Provenance, ReportSamples, Software, Truth};

/// Runs the command.
pub fn run(args: &Calibrate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let mut survey = survey::load(&args.survey)?;
    survey.file.joint.simple |= args.simple;
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| folder_of(&survey.file.name));
    let finished = calibrated(&survey, args.method.into(), args.seed, None, talk)?;
    let place = write(&folder, &finished, talk)?;
    let text = format!(
        "{}{}\n{place}",
        report::text::summary(&finished.result),
        notes(&finished.notes)
    );
    talk.result(&text, &report::json::to_bytes(&finished.result)?)?;
    Ok(finished.ending())
}

/// A calibration that came to its end, with or without a usable result.
#[derive(Debug)]
pub struct Finished {
    /// `result.json`.
    pub result: PoolResult,
    /// What the pictures are drawn from.
    pub samples: ReportSamples,
    /// Sentences that the reader should know.
    pub notes: Vec<String>,
}

impl Finished {
    /// Exit code 0 or 1.
    pub fn ending(&self) -> Ending {
        if self.result.usable {
            Ending::Usable
        } else {
            Ending::Unusable
        }
    }
}

/// Calibrates a survey in memory.
pub fn calibrated(
    survey: &LoadedSurvey,
    method: Method,
    seed: u64,
    truth: Option<Truth>,
    talk: &Talk,
) -> Result<Finished, CliError> {
    let input = input(survey, method, seed);
    let outcome = pool::calibrate(&input, &|what| talk.step(what))?;
    talk.step("comparing and drawing");
    let dropped = Dropped {
        soundings: survey.counts.soundings_dropped as u64,
        returns: survey.counts.laser_dropped as u64,
    };
    let result = summary::result(
        &outcome,
        &input,
        dropped,
        provenance(&survey.file, &survey.inputs, method, seed)?,
    );
    let samples = summary::samples(&outcome, &survey.file.name, truth);
    let notes = survey
        .notes
        .iter()
        .chain(&outcome.scene.notes)
        .cloned()
        .collect();
    Ok(Finished {
        result,
        samples,
        notes,
    })
}

/// A loaded survey as the calibration takes it.
pub fn input(survey: &LoadedSurvey, method: Method, seed: u64) -> PoolInput<'_> {
    PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.pose,
        method,
        sequential: &survey.file.sequential,
        joint: &survey.file.joint,
        seed,
    }
}

/// What a result says of where it comes from: the configuration as it took effect and the files it was read from.
pub fn provenance(
    configuration: &impl Serialize,
    inputs: &[InputFile],
    method: Method,
    seed: u64,
) -> Result<Provenance, CliError> {
    let mut configuration = serde_json::to_value(configuration)?;
    if let Some(table) = configuration.as_object_mut() {
        table.insert("method".to_owned(), method.name().into());
    }
    Ok(Provenance {
        software: Software::this(),
        seed,
        inputs: inputs.to_vec(),
        configuration,
    })
}

/// Where a result's files are, for the terminal.
pub fn place(written: &report::Written) -> String {
    format!(
        "Result  {}\nReport  {}\n",
        written.result.display(),
        written.report.display()
    )
}

/// Writes both files and says where they are.
pub fn write(folder: &Path, finished: &Finished, talk: &Talk) -> Result<String, CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let written = report::write_all(folder, &finished.result, &finished.samples)?;
    Ok(place(&written))
}

/// The notes as a paragraph, empty without any.
pub fn notes(notes: &[String]) -> String {
    let lines: Vec<String> = notes
        .iter()
        .map(|note| format!("Note: {note}.\n"))
        .collect();
    if lines.is_empty() {
        String::new()
    } else {
        format!("\n{}", lines.concat())
    }
}

/// A folder named after the survey, in the working directory.
pub fn folder_of(name: &str) -> PathBuf {
    let safe: String = name
        .chars()
        .map(|c| {
            if c.is_alphanumeric() || "-_.".contains(c) {
                c
            } else {
                '-'
            }
        })
        .collect();
    let safe = safe.trim_matches(['.', '-']);
    PathBuf::from(if safe.is_empty() {
        "boresight-result"
    } else {
        safe
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_s_name_never_leaves_the_working_directory() {
        assert_eq!(folder_of("three-pass"), Path::new("three-pass"));
        assert_eq!(folder_of("../../etc/x y"), Path::new("etc-x-y"));
        assert_eq!(folder_of(".."), Path::new("boresight-result"));
    }
}
