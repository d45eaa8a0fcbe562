//! Reading a survey file's text and the files that it names: what every procedure does in the same way.

use std::path::Path;

use super::document::Document;
use super::problem::{Problem, SurveyError};
use crate::formats::digest::sha256;
use crate::results::InputFile;

/// The checked text as its type; what the tables of keys let through and serde does not is a problem without a key.
pub(crate) fn typed<T: serde::de::DeserializeOwned>(
    path: &Path,
    text: &str,
) -> Result<T, SurveyError> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let message = error.message().replace('\n', " ");
        Problem::new(
            path,
            "whole file",
            format!("\"{message}\""),
            "values of the right kind",
        )
        .into()
    })
}

pub(crate) fn read_text(path: &Path) -> Result<String, SurveyError> {
    let text = crate::formats::error::read_text(path)?;
    if text.trim().is_empty() {
        return Err(Problem::new(path, "whole file", "an empty file", "TOML").into());
    }
    Ok(text)
}

/// The value, or its problems on the list.
pub(crate) fn keep<T>(problems: &mut Vec<Problem>, result: Result<T, SurveyError>) -> Option<T> {
    result.map_err(|error| problems.extend(error.problems)).ok()
}

/// The digests of a survey file, under its bare name, and of all files that it names.
///
/// # Errors
/// [`SurveyError`] naming a file that cannot be read.
pub fn digests(path: &Path, folder: &Path, named: &[&str]) -> Result<Vec<InputFile>, SurveyError> {
    let own = path.file_name().unwrap_or_default().to_string_lossy();
    let mut inputs = vec![digest(path, &own)?];
    for name in named {
        inputs.push(digest(&folder.join(name), name)?);
    }
    Ok(inputs)
}

fn digest(path: &Path, name: &str) -> Result<InputFile, SurveyError> {
    Ok(InputFile {
        path: name.to_owned(),
        sha256: sha256(path)?,
    })
}

/// Keys whose paths do not lead to a file.
pub(crate) fn missing_files(
    document: &Document<'_>,
    folder: &Path,
    keys: &[[&str; 2]],
) -> Vec<Problem> {
    let missing = |key: &[&str; 2]| {
        let name = document.string(key)?;
        let found = match std::fs::metadata(folder.join(name)) {
            Ok(file) if file.is_dir() => format!("\"{name}\", a folder"),
            Ok(_) => return None,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                format!("\"{name}\", no such file")
            }
            Err(error) => format!("\"{name}\": {error}"),
        };
        Some(document.problem(key, found, "a file, its path relative to the survey file"))
    };
    keys.iter().filter_map(missing).collect()
}
