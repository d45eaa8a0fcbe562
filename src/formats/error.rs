//! What is wrong with a file, and where.

use std::fmt;
use std::path::Path;

use thiserror::Error;

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// The header line or block.
    Header,
    /// A line of a text file, counted from 1, and the column's name.
    Line {
        /// Line, counted from 1.
        line: u64,
        /// Name of the column, empty when the whole line is meant.
        column: String,
    },
    /// A record of a binary file, counted from 0, and where it begins.
    Record {
        /// Record, counted from 0.
        record: u64,
        /// Offset of its first byte.
        byte: u64,
    },
    /// A row of a table without lines, counted from 1, and the column's name.
    Row {
        /// Row, counted from 1 through the whole file.
        row: u64,
        /// Name of the column.
        column: String,
    },
    /// A part of a column that is stored together, counted from 1.
    Group {
        /// Row group, counted from 1.
        group: usize,
        /// Name of the column.
        column: String,
    },
    /// A record of a compressed file, counted from 0.
    Point(u64),
    /// An offset in bytes.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => write!(f, "whole file"),
            Self::Header => write!(f, "header"),
            Self::Line { line, column } if column.is_empty() => write!(f, "line {line}"),
            Self::Line { line, column } => write!(f, "line {line}, column {column}"),
            Self::Row { row, column } => write!(f, "row {row}, column {column}"),
            Self::Group { group, column } => write!(f, "row group {group}, column {column}"),
            Self::Record { record, byte } => write!(f, "record {record} (byte {byte})"),
            Self::Point(point) => write!(f, "point {point}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Kind of a fault, for callers that treat kinds differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// Missing, a folder, no permission, or a read that failed.
    Unreadable,
    /// No extension or content that a reader knows.
    UnknownFormat,
    /// Nothing in it.
    Empty,
    /// It ends too early.
    Truncated,
    /// A column that must be there is not.
    MissingColumn,
    /// A value that cannot be read or cannot be.
    BadValue,
    /// Times that do not ascend.
    Order,
    /// The values make sense in another unit.
    WrongUnit,
    /// The file could not be written.
    Unwritable,
}

/// What is wrong with a file: where, what was found, what was expected; of a table with several faulty rows the first.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", lines(self))]
pub struct FormatError {
    /// Its kind.
    pub kind: FaultKind,
    /// The file.
    pub file: Box<Path>,
    /// The place in it.
    pub place: Place,
    /// What was found there.
    pub found: String,
    /// What was expected there.
    pub expected: String,
    /// On the heap together, so that an error stays small.
    others: Option<Box<Others>>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Others(Vec<FormatError>);

/// A line for each fault.
fn lines(error: &FormatError) -> String {
    let all = std::iter::once(error).chain(error.others());
    let line = |e: &FormatError| said(&e.file, &e.place, &e.found, &e.expected);
    all.map(line).collect::<Vec<_>>().join("\n")
}

/// What is said of a file that is not there.
pub const NO_SUCH_FILE: &str = "no such file";

/// "no.toml: no such file" or "a.csv: line 3: found "x", expected a number".
pub(crate) fn said(file: &Path, place: &dyn fmt::Display, found: &str, expected: &str) -> String {
    let file = file.display();
    if found == NO_SUCH_FILE {
        return format!("{file}: {found}");
    }
    format!("{file}: {place}: found {found}, expected {expected}")
}

impl FormatError {
    /// From its parts.
    #[must_use]
    pub fn new(
        kind: FaultKind,
        file: &Path,
        place: Place,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let (file, found, expected) = (file.into(), found.into(), expected.into());
        Self {
            kind,
            file,
            place,
            found,
            expected,
            others: None,
        }
    }

    /// The same with further faulty rows, and how many there are in all.
    #[must_use]
    pub fn with(mut self, others: Vec<Self>) -> Self {
        self.others = (!others.is_empty()).then(|| Box::new(Others(others)));
        self
    }

    /// Further faulty rows, and how many there are in all ([`super::faults`]).
    #[must_use]
    pub fn others(&self) -> &[Self] {
        self.others.as_ref().map_or(&[], |others| &others.0)
    }

    /// A file that cannot be opened or read.
    #[must_use]
    pub fn unreadable(file: &Path, error: &std::io::Error) -> Self {
        let found = match error.kind() {
            std::io::ErrorKind::NotFound => NO_SUCH_FILE.to_owned(),
            std::io::ErrorKind::PermissionDenied => "no permission to read it".to_owned(),
            std::io::ErrorKind::IsADirectory => "a folder".to_owned(),
            _ => format!("\"{error}\""),
        };
        Self::new(
            FaultKind::Unreadable,
            file,
            Place::File,
            found,
            "a readable file",
        )
    }

    /// A file that cannot be written.
    #[must_use]
    pub fn unwritable(file: &Path, error: &dyn fmt::Display) -> Self {
        Self::new(
            FaultKind::Unwritable,
            file,
            Place::File,
            format!("\"{error}\""),
            "a place to write to",
        )
    }

    /// A file whose extension no reader claims.
    #[must_use]
    pub fn unknown_extension(file: &Path, expected: &str) -> Self {
        let found = file
            .extension()
            .map_or("no extension".to_owned(), |e| format!("extension {e:?}"));
        Self::new(
            FaultKind::UnknownFormat,
            file,
            Place::File,
            found,
            format!("one of {expected}"),
        )
    }
}

/// Opens a file for reading and gives its size in bytes; folders, pipes and devices are refused before they are opened, because
/// opening or reading one may never end.
///
/// # Errors
/// [`FormatError`] of kind `Unreadable`.
pub fn open(path: &Path) -> Result<(std::fs::File, u64), FormatError> {
    let unreadable = |error: std::io::Error| FormatError::unreadable(path, &error);
    ordinary(path, &std::fs::metadata(path).map_err(unreadable)?)?;
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    ordinary(path, &metadata)?;
    Ok((file, metadata.len()))
}

fn ordinary(path: &Path, metadata: &std::fs::Metadata) -> Result<(), FormatError> {
    if metadata.is_dir() {
        return Err(FormatError::unreadable(
            path,
            &std::io::ErrorKind::IsADirectory.into(),
        ));
    }
    if metadata.is_file() {
        return Ok(());
    }
    Err(FormatError::new(
        FaultKind::Unreadable,
        path,
        Place::File,
        "a pipe, a device or another special file",
        "an ordinary file",
    ))
}

/// A TOML or JSON file is never larger than this, bytes.
const LONGEST_TEXT: u64 = 64 << 20;

/// Reads a text file whole.
///
/// # Errors
/// [`FormatError`]: unreadable, larger than 64 MiB, not UTF-8 (with the byte).
pub fn read_text(path: &Path) -> Result<String, FormatError> {
    use std::io::Read;
    let (file, size) = open(path)?;
    let mut bytes = Vec::new();
    file.take(LONGEST_TEXT + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| FormatError::unreadable(path, &e))?;
    if bytes.len() as u64 > LONGEST_TEXT {
        let found = format!("a file of {size} bytes");
        let expected = format!("a text of at most {LONGEST_TEXT} bytes");
        return Err(FormatError::new(
            FaultKind::BadValue,
            path,
            Place::File,
            found,
            expected,
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let place = Place::Byte(error.utf8_error().valid_up_to() as u64);
        FormatError::new(
            FaultKind::BadValue,
            path,
            place,
            "bytes that are not UTF-8",
            "a text in UTF-8",
        )
    })
}

/// A piece of a file fit for a message: printable, at most 40 characters, in quotes.
#[must_use]
pub fn quoted(bytes: &[u8]) -> String {
    quoted_up_to(40, bytes)
}

/// As [`quoted`], of so many characters.
pub(super) fn quoted_up_to(most: usize, bytes: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(bytes)
        .chars()
        .take(most + 1)
        .map(|c| if c.is_control() { '?' } else { c })
        .collect();
    match text.char_indices().nth(most) {
        Some((cut, _)) => format!("\"{}...\"", &text[..cut]),
        None => format!("\"{text}\""),
    }
}
