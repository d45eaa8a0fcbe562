//! Reading a `result.json` that the user names.

use std::path::Path;

use super::error::CliError;
use crate::formats::error::{FaultKind, FormatError, Place, read_text};
use crate::report::json;
use crate::results::Calibration;

/// The calibration in a file.
pub fn read_result(path: &Path) -> Result<Calibration, CliError> {
    let text = read_text(path)?;
    if text.is_empty() {
        return Err(FormatError::new(
            FaultKind::Empty,
            path,
            Place::File,
            "nothing",
            "a result.json",
        )
        .into());
    }
    json::from_slice(text.as_bytes()).map_err(|e| CliError::NoResult {
        file: path.to_owned(),
        found: e.to_string(),
    })
}
