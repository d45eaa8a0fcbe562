//! A folder with `result.json`, `report.html` and `parameters.csv`.

use super::{csv, html, json};
use crate::results::{Calibration, Page, WriteError, write_whole};
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
}

/// Writes `result.json`, `report.html` and `parameters.csv` into `folder`, each whole or not at all; the folder is made when missing.
///
/// # Errors
/// [`ReportError`]; all texts are made before the first is written.
pub fn write_all(folder: &Path, result: &Calibration, page: &Page) -> Result<Written, ReportError> {
    let written = Written {
        result: folder.join("result.json"),
        report: folder.join("report.html"),
        parameters: folder.join("parameters.csv"),
    };
    let (bytes, page) = (json::to_bytes(result)?, html::render(result, page)?);
    write_whole(&written.result, &bytes)?;
    write_whole(&written.report, page.as_bytes())?;
    write_whole(&written.parameters, csv::parameters(result).as_bytes())?;
    Ok(written)
}
