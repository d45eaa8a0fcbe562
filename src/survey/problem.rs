//! What is wrong with a survey: a list, so that everything can be mended in one go.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::formats::FormatError;
use crate::formats::error::said;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file.
    pub file: PathBuf,
    /// The place in it: line and key, record, column.
    pub place: String,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&said(&self.file, &self.place, &self.found, &self.expected))
    }
}

impl Problem {
    /// From its parts.
    #[must_use]
    pub fn new(
        file: &Path,
        place: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            file: file.to_owned(),
            place: place.into(),
            found: found.into(),
            expected: expected.into(),
        }
    }
}

impl From<FormatError> for Problem {
    /// The first fault.
    fn from(error: FormatError) -> Self {
        Self {
            place: error.place.to_string(),
            file: error.file.into(),
            found: error.found,
            expected: error.expected,
        }
    }
}

/// Everything that is wrong with a survey, never empty.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", list(problems))]
pub struct SurveyError {
    /// In the order of the files and of the lines in them.
    pub problems: Vec<Problem>,
}

impl From<FormatError> for SurveyError {
    fn from(error: FormatError) -> Self {
        let others = error.others().to_vec();
        let all = std::iter::once(error).chain(others);
        Self {
            problems: all.map(Problem::from).collect(),
        }
    }
}

impl From<Problem> for SurveyError {
    fn from(problem: Problem) -> Self {
        Self {
            problems: vec![problem],
        }
    }
}

/// Nothing when there is no problem.
///
/// # Errors
/// [`SurveyError`] with the problems, if there are any.
pub fn none_of(problems: Vec<Problem>) -> Result<(), SurveyError> {
    if problems.is_empty() {
        Ok(())
    } else {
        Err(SurveyError { problems })
    }
}

fn list(problems: &[Problem]) -> String {
    let lines: Vec<_> = problems.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// What is wrong with a scenario file; every fault that can be told at once.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", of_file(file, faults))]
pub struct ScenarioError {
    /// The file.
    pub file: PathBuf,
    /// One sentence each: place, found, expected.
    pub faults: Vec<String>,
}

fn of_file(file: &Path, faults: &[String]) -> String {
    let line = |fault: &String| format!("{}: {fault}", file.display());
    faults.iter().map(line).collect::<Vec<_>>().join("\n")
}
