//! Reading named columns of numbers of a Parquet file: in any order, extra columns ignored, names in letters of either case.
//!
//! Columns of type `FLOAT`, `DOUBLE`, `INT32` and `INT64` are read, required or optional; a null is refused. Memory holds the named
//! columns of one row group as `f64` and one page. Counts and sizes in the file are held against the file's size and the row group's
//! rows before they are believed.

mod chunk;
mod pages;
mod schema;
mod source;

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};

use super::error::{FaultKind, FormatError, Place, open, quoted, quoted_up_to};
use super::rows::Rows;
use super::table::Limits;
use chunk::{Chunk, Stop, caught};
use schema::Column;

/// Rows that a file of any size may hold; a larger one, one per byte.
const ROWS: u64 = 1_000_000;

/// What begins and ends a Parquet file.
const MAGIC: &[u8] = b"PAR1";

/// Named columns being read row by row.
pub struct Columns {
    file: PathBuf,
    size: u64,
    source: File,
    metadata: ParquetMetaData,
    columns: Vec<Column>,
    /// The current row group's values by column.
    values: Vec<Vec<f64>>,
    /// Row groups begun.
    groups: usize,
    /// Rows of the row groups before the current one.
    before: u64,
    /// Rows begun of the current row group.
    row: usize,
}

// OPEN

impl Columns {
    /// Opens a file and finds the columns of these names.
    ///
    /// # Errors
    /// [`FormatError`]: no Parquet file, a damaged one, a column missing, there twice, or not of numbers, more rows than the file
    /// can hold.
    pub fn open(path: &Path, names: &[&'static str]) -> Result<Self, FormatError> {
        let (mut file, size) = open(path)?;
        check_magic(path, &mut file, size)?;
        let metadata = caught(|| ParquetMetaDataReader::new().parse_and_finish(&file))
            .map_err(|error| damage(path, Place::Header, &error))?;
        check_rows(path, &metadata, size)?;
        let schema = metadata.file_metadata().schema_descr();
        let columns = names
            .iter()
            .map(|name| schema::find(path, schema, name))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            file: path.to_owned(),
            size,
            values: vec![vec![]; columns.len()],
            columns,
            source: file,
            metadata,
            groups: 0,
            before: 0,
            row: 0,
        })
    }
}

fn check_magic(path: &Path, file: &mut File, size: u64) -> Result<(), FormatError> {
    let fault = |kind, found: String, expected: &str| {
        Err(FormatError::new(kind, path, Place::File, found, expected))
    };
    if size == 0 {
        return fault(
            FaultKind::Empty,
            "an empty file".to_owned(),
            "a Parquet file",
        );
    }
    let unreadable = |error: std::io::Error| FormatError::unreadable(path, &error);
    let mut first = vec![];
    file.by_ref()
        .take(12)
        .read_to_end(&mut first)
        .map_err(unreadable)?;
    if first.starts_with(b"PARE") {
        return fault(
            FaultKind::UnknownFormat,
            "an encrypted Parquet file".to_owned(),
            "one that is not",
        );
    }
    if !first.starts_with(MAGIC) {
        let found = format!("{} at its beginning", quoted(&first));
        return fault(
            FaultKind::UnknownFormat,
            found,
            "a Parquet file, which begins with PAR1",
        );
    }
    let mut last = vec![];
    file.seek(SeekFrom::Start(size.saturating_sub(4)))
        .map_err(unreadable)?;
    file.read_to_end(&mut last).map_err(unreadable)?;
    if size < 12 || last != MAGIC {
        let found = "no footer and PAR1 at its end".to_owned();
        return fault(FaultKind::Truncated, found, "a whole Parquet file");
    }
    Ok(())
}

/// The footer must not promise more than the file can hold.
fn check_rows(path: &Path, metadata: &ParquetMetaData, size: u64) -> Result<(), FormatError> {
    let groups = metadata.row_groups();
    let most = ROWS.max(size);
    let rows = groups.iter().try_fold(0_u64, |sum, group| {
        sum.checked_add(u64::try_from(group.num_rows()).ok()?)
    });
    if rows.is_some_and(|rows| rows <= most) {
        return Ok(());
    }
    let found = format!(
        "{} rows in {size} bytes",
        rows.map_or("impossibly many".to_owned(), |rows| rows.to_string())
    );
    let expected = format!("at most {most} rows in a file of that size");
    Err(FormatError::new(
        FaultKind::BadValue,
        path,
        Place::Header,
        found,
        expected,
    ))
}

/// What the decoder said, as a fault.
fn damage(path: &Path, place: Place, error: &ParquetError) -> FormatError {
    let said = error.to_string();
    let said = said.strip_prefix("Parquet error: ").unwrap_or(&said);
    let kind = match error {
        ParquetError::EOF(_) => FaultKind::Truncated,
        _ => FaultKind::BadValue,
    };
    let found = format!("damage ({})", quoted_up_to(160, said.as_bytes()));
    FormatError::new(
        kind,
        path,
        place,
        found,
        "a Parquet file that can be decoded",
    )
}

// READ

impl Columns {
    fn rows(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// Reads the next row group; `false` when there is none.
    fn next_group(&mut self) -> Result<bool, FormatError> {
        self.before += self.rows() as u64;
        self.row = 0;
        let group = self.groups;
        if group >= self.metadata.num_row_groups() {
            self.values.iter_mut().for_each(Vec::clear);
            return Ok(false);
        }
        self.groups += 1;
        let read = |column| self.read_chunk(group, column);
        self.values = self.columns.iter().map(read).collect::<Result<_, _>>()?;
        Ok(true)
    }

    /// All values of a column in a row group.
    fn read_chunk(&self, group: usize, column: &Column) -> Result<Vec<f64>, FormatError> {
        let chunk = Chunk {
            source: &self.source,
            size: self.size,
            metadata: &self.metadata,
            group,
            column,
        };
        chunk.values().map_err(|stop| {
            let place = Place::Group {
                group: group + 1,
                column: column.name.to_owned(),
            };
            match stop {
                Stop::Null(row) => FormatError::new(
                    FaultKind::BadValue,
                    &self.file,
                    self.place(row, column.name),
                    "null",
                    "a number",
                ),
                Stop::Fault(kind, found, expected) => {
                    FormatError::new(kind, &self.file, place, found, expected)
                }
                Stop::Damage(error) => damage(&self.file, place, &error),
            }
        })
    }

    /// A row of the current row group, counted from 0.
    fn place(&self, row: usize, column: &str) -> Place {
        Place::Row {
            row: self.before + row as u64 + 1,
            column: column.to_owned(),
        }
    }

    /// The value in a column of this row.
    fn value(&self, column: usize) -> f64 {
        let values = &self.values[column];
        values
            .get(self.row.wrapping_sub(1))
            .copied()
            .unwrap_or(f64::NAN)
    }
}

impl Rows for Columns {
    fn file(&self) -> &Path {
        &self.file
    }

    fn next_row(&mut self) -> Result<bool, FormatError> {
        while self.row >= self.rows() {
            if !self.next_group()? {
                return Ok(false);
            }
        }
        self.row += 1;
        Ok(true)
    }

    fn number(&self, column: usize, limits: &Limits) -> Result<f64, FormatError> {
        let value = self.value(column);
        if limits.contain(value) {
            return Ok(value);
        }
        Err(self.bad_value(column, limits.expected))
    }

    fn count(&self, column: usize) -> Result<u32, FormatError> {
        let value = self.value(column);
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            return Ok(value as u32);
        }
        Err(self.bad_value(column, "a whole number from 0 to 4294967295"))
    }

    fn fault(&self, kind: FaultKind, column: usize, found: String, expected: &str) -> FormatError {
        let place = self.place(self.row.saturating_sub(1), self.columns[column].name);
        FormatError::new(kind, &self.file, place, found, expected)
    }

    fn bad_value(&self, column: usize, expected: &str) -> FormatError {
        let found = self.value(column).to_string();
        self.fault(FaultKind::BadValue, column, found, expected)
    }

    fn no_rows(&self) -> FormatError {
        FormatError::new(
            FaultKind::Empty,
            &self.file,
            Place::File,
            "columns without a row",
            "at least one row",
        )
    }
}
