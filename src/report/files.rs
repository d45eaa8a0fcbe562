//! A folder with `result.json` and `report.html`.

use super::{html, json};
use crate::files::land;
use crate::results::{PoolResult, ReportSamples, WriteError};
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
}

impl Written {
    fn in_folder(folder: &Path) -> Self {
        Self {
            result: folder.join("result.json"),
            report: folder.join("report.html"),
        }
    }

    /// The same files in another folder.
    #[must_use]
    pub fn moved_to(&self, folder: &Path) -> Self {
        Self::in_folder(folder)
    }
}

/// Writes `result.json` and `report.html` into `folder`, together or not at all; the folder is made when missing.
///
/// # Errors
/// [`ReportError`]; both texts are made before the first is written.
pub fn write_all(
    folder: &Path,
    result: &PoolResult,
    samples: &ReportSamples,
) -> Result<Written, ReportError> {
    both(
        folder,
        &json::to_bytes(result)?,
        &html::render(result, samples)?,
    )
}

/// Writes both texts together or not at all.
pub(super) fn both(folder: &Path, bytes: &[u8], page: &str) -> Result<Written, ReportError> {
    land(
        folder,
        &[("result.json", bytes), ("report.html", page.as_bytes())],
    )?;
    Ok(Written::in_folder(folder))
}
