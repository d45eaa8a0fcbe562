//! `boresight calibrate`: a survey file to `result.json`, `report.html` and `parameters.csv`.

use std::path::{Path, PathBuf};

use super::Ending;
use super::args::{Calibrate, ExportName};
use super::error::CliError;
use super::out::{RESULT_FILES, tried};
use super::talk::Talk;
use crate::calibrate::seam::{Finished, Settings};
use crate::procedures;
use crate::report::{self, Export};

/// Runs the command.
pub fn run(args: &Calibrate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let settings = Settings {
        method: args.method.into(),
        seed: args.seed,
        simple: args.simple,
        ..Settings::default()
    };
    let procedure = procedures::of_file(&args.survey)?;
    settings.fit(procedure)?;
    let survey = procedure.read(&args.survey)?;
    let folder = args.out.clone().unwrap_or_else(|| folder_of(survey.name()));
    let exports = exports(&args.export);
    let files = RESULT_FILES.into_iter();
    let files: Vec<&str> = files.chain(exports.iter().map(|e| e.file_name())).collect();
    tried(&folder, &files)?;
    let finished = survey.calibrate(&settings, None, talk)?;
    finish(&folder, &finished, None, &exports, talk)?;
    Ok(ending(&finished))
}

/// The forms that were asked for, each once.
fn exports(asked: &[ExportName]) -> Vec<Export> {
    let mut all: Vec<Export> = vec![];
    for form in asked.iter().flat_map(|name| name.forms()) {
        if !all.contains(&form) {
            all.push(form);
        }
    }
    all
}

/// Exit code 0 or 1.
pub fn ending(finished: &Finished) -> Ending {
    if finished.result.usable {
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
    exports: &[Export],
    talk: &Talk,
) -> Result<(), CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let written = report::write_all(folder, &finished.result, &finished.page, exports)?;
    let cards: String = written
        .exports
        .iter()
        .map(|file| format!("Export  {}\n", file.display()))
        .collect();
    let survey = survey.map_or_else(String::new, |s| format!("Survey  {}\n", s.display()));
    let text = format!(
        "{}\n{survey}Result  {}\nReport  {}\nTable   {}\n{cards}",
        report::text::summary(&finished.result, &finished.page),
        written.result.display(),
        written.report.display(),
        written.parameters.display()
    );
    talk.result(&text, &report::json::to_bytes(&finished.result)?)
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
