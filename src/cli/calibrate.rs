//! `boresight calibrate`: a survey file to `result.json` and `report.html`.

use std::path::{Path, PathBuf};

use super::Ending;
use super::args::Calibrate;
use super::error::CliError;
use super::talk::Talk;
use crate::calibrate::seam::{Finished, Settings, TrueError};
use crate::procedures;
use crate::report::any as report;
use crate::ruled::Ruled;

/// Runs the command.
pub fn run(args: &Calibrate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let settings = Settings {
        method: args.method.into(),
        seed: args.seed,
        simple: args.simple,
    };
    let procedure = procedures::of_file(&args.survey)?;
    settings.fit(procedure)?;
    let survey = procedure.read(&args.survey)?;
    let folder = args.out.clone().unwrap_or_else(|| folder_of(survey.name()));
    let finished = survey.calibrate(&settings, None, &|what| talk.step(what))?;
    finish(&folder, &finished, None, talk)?;
    Ok(ending(&finished))
}

/// Exit code 0 or 1.
pub fn ending(finished: &Finished) -> Ending {
    if finished.result.usable() {
        Ending::Usable
    } else {
        Ending::Unusable
    }
}

/// Writes the files of a calibration and prints it; `survey` is the survey file of a demo.
pub fn finish(
    folder: &Path,
    finished: &Finished,
    survey: Option<&Path>,
    talk: &Talk,
) -> Result<(), CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let written = report::write(folder, &finished.result)?;
    let mut text = format!(
        "{}{}\n",
        report::summary(&finished.result),
        notes(&finished.notes)
    );
    if !finished.errors.is_empty() {
        text.push_str(&format!("{}\n\n", against_truth(&finished.errors)));
    }
    if let Some(survey) = survey {
        text.push_str(&format!("Survey  {}\n", survey.display()));
    }
    text.push_str(&format!(
        "Result  {}\nReport  {}\n",
        written.result.display(),
        written.report.display()
    ));
    talk.result(&text, &report::to_bytes(&finished.result)?)
}

/// A table of each path's errors, the joint one's also in its own standard deviations.
fn against_truth(errors: &[TrueError]) -> Ruled {
    let simple = errors.iter().any(|e| e.joint_simple.is_some());
    let header = [
        "error against the truth",
        "reference",
        "joint",
        "joint, in sigmas",
        "joint, simple model",
    ];
    let mut table = Ruled::new(header.into_iter().take(if simple { 5 } else { 4 }));
    let shown = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:+.4}"));
    for e in errors {
        let sigmas = e.joint.zip(e.sigma);
        let mut row = vec![
            format!("{}, {}", e.name, e.unit),
            shown(e.reference),
            shown(e.joint),
            sigmas.map_or_else(String::new, |(e, s)| format!("{:+.1}", e / s)),
        ];
        row.extend(simple.then(|| shown(e.joint_simple)));
        table.row(row);
    }
    table
}

/// The notes as a paragraph, empty without any.
fn notes(notes: &[String]) -> String {
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

    #[test]
    fn the_simple_model_has_a_column_only_where_it_was_solved() {
        let mut error = TrueError {
            name: "yaw".to_owned(),
            unit: "deg".to_owned(),
            joint: Some(0.5),
            sigma: Some(0.25),
            ..TrueError::default()
        };
        let without = against_truth(std::slice::from_ref(&error)).to_string();
        assert!(without.contains("yaw, deg") && without.contains("+2.0"));
        assert!(!without.contains("simple"));
        error.joint_simple = Some(1.0);
        assert!(against_truth(&[error]).to_string().contains("+1.0000"));
    }
}
