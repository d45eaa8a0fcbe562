//! `result.json`.

use crate::results::{Calibration, SCHEMA};
use serde::{Deserialize, Serialize};
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// The bytes of `result.json`: one member a line, arrays in one line, every float with the digits that bring it back, a final newline.
/// The same result gives the same bytes. Values that are not finite become `null`.
///
/// # Errors
/// None for a [`Calibration`] made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &Calibration) -> serde_json::Result<Vec<u8>> {
    lines(result)
}

/// Any result in that form.
pub(super) fn lines(result: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    result.serialize(&mut serde_json::Serializer::with_formatter(
        &mut bytes,
        Lines::default(),
    ))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A file is not a result that this version reads.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not JSON, or a member is missing or of the wrong kind.
    #[error("found {0}")]
    Json(#[from] serde_json::Error),
    /// Written by another version.
    #[error(
        "found a result of schema {found}, expected schema {SCHEMA}; make it again from its survey: boresight calibrate SURVEY.toml"
    )]
    Schema {
        /// The number in the file.
        found: u64,
    },
}

/// Only the schema's number.
#[derive(Deserialize)]
struct Numbered {
    schema: u64,
}

/// Reads `result.json`.
///
/// # Errors
/// [`ReadError`]: line and column where the text is not a result, or the number of another schema.
pub fn from_slice(bytes: &[u8]) -> Result<Calibration, ReadError> {
    let Numbered { schema } = serde_json::from_slice(bytes)?;
    if schema != u64::from(SCHEMA) {
        return Err(ReadError::Schema { found: schema });
    }
    Ok(serde_json::from_slice(bytes)?)
}

/// Members on lines of their own, array elements side by side, so that a matrix takes one line.
#[derive(Default)]
struct Lines {
    depth: usize,
    empty: bool,
}

impl Lines {
    fn new_line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        write!(writer, "\n{:indent$}", "", indent = 2 * self.depth)
    }
}

impl Formatter for Lines {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.empty = true;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if !std::mem::take(&mut self.empty) {
            self.new_line(writer)?;
        }
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.empty = false;
        if !first {
            writer.write_all(b",")?;
        }
        self.new_line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array_value<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first {
            Ok(())
        } else {
            writer.write_all(b", ")
        }
    }
}
