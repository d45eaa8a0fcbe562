//! [`crate::files::write_whole`] with the errors of this floor.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use serde::Serialize;

use super::error::FormatError;
use crate::files;

/// Lets `write` fill a temporary file in the folder of `path`, which must be there, and gives it that name when all went well.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`; the old file, if any, is untouched then.
pub fn write_whole<E: Into<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Result<(), FormatError> {
    let folder = files::whole::folder_of(path);
    std::fs::metadata(folder).map_err(|e| FormatError::unwritable(path, &e))?;
    files::write_whole(path, write).map_err(|e| FormatError::unwritable(path, &e.source))
}

/// Writes a value as TOML.
///
/// # Errors
/// As [`write_whole`].
pub fn write_toml(path: &Path, value: &impl Serialize) -> Result<(), FormatError> {
    let text = toml::to_string(value).map_err(|e| FormatError::unwritable(path, &e))?;
    write_whole(path, |out| out.write_all(text.as_bytes()))
}

/// Writes a value as JSON.
///
/// # Errors
/// As [`write_whole`].
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), FormatError> {
    write_whole(path, |out| serde_json::to_writer_pretty(out, value))
}
