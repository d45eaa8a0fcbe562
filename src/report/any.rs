//! The result of any procedure for the terminal, as JSON and as a page.

use std::path::Path;

use super::{ReportError, Written, json, rail, text, usbl, write_all, write_rail, write_usbl};
use crate::results::AnyResult;

/// The summary for the terminal. Ends with a newline.
#[must_use]
pub fn summary(result: &AnyResult) -> String {
    match result {
        AnyResult::Pool(result, _) => text::summary(result),
        AnyResult::Usbl(result, _) => usbl::summary(result),
        AnyResult::Rail(result, _) => rail::summary(result),
    }
}

/// The bytes of `result.json`.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &AnyResult) -> serde_json::Result<Vec<u8>> {
    match result {
        AnyResult::Pool(result, _) => json::to_bytes(result),
        AnyResult::Usbl(result, _) => usbl::to_bytes(result),
        AnyResult::Rail(result, _) => rail::to_bytes(result),
    }
}

/// Writes `result.json` and `report.html` into `folder`.
///
/// # Errors
/// [`ReportError`]; both texts are made before the first is written.
pub fn write(folder: &Path, result: &AnyResult) -> Result<Written, ReportError> {
    match result {
        AnyResult::Pool(result, samples) => write_all(folder, result, samples),
        AnyResult::Usbl(result, samples) => write_usbl(folder, result, samples),
        AnyResult::Rail(result, samples) => write_rail(folder, result, samples),
    }
}
