//! A folder with `result.json`, `report.html` and `parameters.csv`.

use super::{Export, csv, html, json};
use crate::files::land;
use crate::results::{Calibration, Page, WriteError};
use std::path::{Path, PathBuf};

/// A report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A value has no place in JSON; a fault of this program.
    #[error("the result cannot be written as JSON: {0}")]
    Serialise(#[from] serde_json::Error),
    /// The operating system refused.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Where the files are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// `result.json`.
    pub result: PathBuf,
    /// `report.html`.
    pub report: PathBuf,
    /// `parameters.csv`.
    pub parameters: PathBuf,
    /// The other forms that were asked for, in their order.
    pub exports: Vec<PathBuf>,
}

/// Writes `result.json`, `report.html`, `parameters.csv` and the other forms that are asked for into `folder`, together or not at all;
/// the folder is made when missing.
///
/// # Errors
/// [`ReportError`]; all texts are made before the first is written.
pub fn write_all(
    folder: &Path,
    result: &Calibration,
    page: &Page,
    exports: &[Export],
) -> Result<Written, ReportError> {
    let names = exports.iter().map(|form| form.file_name());
    let written = Written {
        result: folder.join("result.json"),
        report: folder.join("report.html"),
        parameters: folder.join("parameters.csv"),
        exports: names.clone().map(|name| folder.join(name)).collect(),
    };
    let texts: Vec<String> = exports
        .iter()
        .map(|form| form.text(result, &page.title))
        .collect();
    let (bytes, page) = (json::to_bytes(result)?, html::render(result, page)?);
    let table = csv::parameters(result);
    let mut files: Vec<(&str, &[u8])> = vec![
        ("result.json", &bytes),
        ("report.html", page.as_bytes()),
        ("parameters.csv", table.as_bytes()),
    ];
    files.extend(names.zip(texts.iter().map(String::as_bytes)));
    land(folder, &files)?;
    Ok(written)
}
