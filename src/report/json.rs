//! `result.json`.

use crate::results::PoolResult;
use serde::Serialize;
use serde_json::ser::Formatter;
use std::io::{Result, Write};

/// The bytes of `result.json`: one member a line, arrays in one line, every float with the digits that bring it back, a final newline.
/// The same result gives the same bytes. Values that are not finite become `null`.
///
/// # Errors
/// None for a [`PoolResult`] made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &PoolResult) -> serde_json::Result<Vec<u8>> {
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

/// Reads `result.json`.
///
/// # Errors
/// The line and column where the text is not a pool result.
pub fn from_slice(bytes: &[u8]) -> serde_json::Result<PoolResult> {
    serde_json::from_slice(bytes)
}

/// Members on lines of their own, array elements side by side, so that a matrix takes one line.
#[derive(Default)]
struct Lines {
    depth: usize,
    empty: bool,
}

impl Lines {
    fn new_line<W: ?Sized + Write>(&self, writer: &mut W) -> Result<()> {
        write!(writer, "\n{:indent$}", "", indent = 2 * self.depth)
    }
}

impl Formatter for Lines {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        self.depth += 1;
        self.empty = true;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        self.depth -= 1;
        if !std::mem::take(&mut self.empty) {
            self.new_line(writer)?;
        }
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> Result<()> {
        self.empty = false;
        if !first {
            writer.write_all(b",")?;
        }
        self.new_line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> Result<()> {
        if first {
            Ok(())
        } else {
            writer.write_all(b", ")
        }
    }
}
