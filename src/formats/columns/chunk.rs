//! One column of one row group, decoded to numbers.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};
use parquet::file::serialized_reader::SerializedPageReader;

use super::pages::CheckedPages;
use super::schema::{Column, word};
use super::source::BoundedPages;
use crate::formats::error::FaultKind;

/// Values decoded at a time.
const BATCH: usize = 8192;

/// Bytes that a page may have besides 16 for each row of its row group: 8 for the value, the rest for levels and encodings.
const PAGE: u64 = 1 << 20;

/// Why a column chunk gave no numbers.
pub(super) enum Stop {
    /// A null at this row of the row group, counted from 0.
    Null(usize),
    /// What was found, what was expected.
    Fault(FaultKind, String, String),
    /// What the decoder said.
    Damage(ParquetError),
}

impl From<ParquetError> for Stop {
    fn from(error: ParquetError) -> Self {
        Self::Damage(error)
    }
}

/// One column of one row group.
pub(super) struct Chunk<'c> {
    pub(super) source: &'c File,
    /// Of the file, bytes.
    pub(super) size: u64,
    pub(super) metadata: &'c ParquetMetaData,
    /// Counted from 0.
    pub(super) group: usize,
    pub(super) column: &'c Column,
}

impl Chunk<'_> {
    /// Its values, one for each row.
    pub(super) fn values(&self) -> Result<Vec<f64>, Stop> {
        let group = self.metadata.row_group(self.group);
        let rows = group.num_rows() as usize;
        let chunk = group.columns().get(self.column.leaf).ok_or_else(|| {
            let expected = "the column in every row group".to_owned();
            Stop::Fault(FaultKind::BadValue, "nothing".to_owned(), expected)
        })?;
        check_range(chunk, self.size)?;
        check_codec(chunk)?;
        let values = caught(|| self.decode(chunk, rows))?;
        if values.len() == rows {
            return Ok(values);
        }
        let found = match values.len() {
            n if n > rows => format!("more than {rows} values"),
            n => format!("{n} values"),
        };
        let expected = format!("{rows}, as many as rows");
        Err(Stop::Fault(FaultKind::BadValue, found, expected))
    }

    fn decode(&self, chunk: &ColumnChunkMetaData, rows: usize) -> Result<Vec<f64>, Stop> {
        let source = BoundedPages {
            file: self.source.try_clone().map_err(ParquetError::from)?,
            most: PAGE + 16 * rows as u64,
        };
        let pages = SerializedPageReader::new(Arc::new(source), chunk, rows, None)?;
        let schema = self.metadata.file_metadata().schema_descr();
        let descriptor = schema.column(self.column.leaf);
        let pages = CheckedPages::new(Box::new(pages), &descriptor);
        let unsigned = self.column.unsigned;
        match get_column_reader(descriptor, Box::new(pages)) {
            ColumnReader::DoubleColumnReader(r) => numbers(r, rows, |v| v),
            ColumnReader::FloatColumnReader(r) => numbers(r, rows, f64::from),
            ColumnReader::Int32ColumnReader(r) if unsigned => {
                numbers(r, rows, |v| f64::from(v.cast_unsigned()))
            }
            ColumnReader::Int32ColumnReader(r) => numbers(r, rows, f64::from),
            ColumnReader::Int64ColumnReader(r) if unsigned => {
                numbers(r, rows, |v| v.cast_unsigned() as f64)
            }
            ColumnReader::Int64ColumnReader(r) => numbers(r, rows, |v| v as f64),
            _ => Err(ParquetError::General("no column of numbers".to_owned()).into()),
        }
    }
}

/// The parquet crate (60.1) indexes past the end of a damaged page of byte streams, and may do so elsewhere: its panic becomes a fault
/// of the file. Nothing that it held is used afterwards.
pub(super) fn caught<T, E: From<ParquetError>>(
    decode: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        let said = "compressed data that cannot be decoded".to_owned();
        Err(ParquetError::General(said).into())
    })
}

/// The chunk's bytes lie in the file.
fn check_range(chunk: &ColumnChunkMetaData, size: u64) -> Result<(), Stop> {
    let data = chunk.data_page_offset();
    let start = chunk.dictionary_page_offset().unwrap_or(data);
    let length = chunk.compressed_size();
    let range = u64::try_from(start).ok().zip(u64::try_from(length).ok());
    match range.and_then(|(start, length)| start.checked_add(length)) {
        Some(end) if end <= size => Ok(()),
        _ => {
            let found = format!("{length} bytes from byte {start} in a file of {size}");
            let expected = "a place within the file".to_owned();
            Err(Stop::Fault(FaultKind::Truncated, found, expected))
        }
    }
}

fn check_codec(chunk: &ColumnChunkMetaData) -> Result<(), Stop> {
    match chunk.compression() {
        Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::ZSTD(_) => Ok(()),
        other => {
            let found = format!("compression {}", word(&other));
            let expected = "no compression, SNAPPY or ZSTD".to_owned();
            Err(Stop::Fault(FaultKind::UnknownFormat, found, expected))
        }
    }
}

/// The values of a column chunk as numbers: up to a batch more than `rows`, so that too many are noticed.
fn numbers<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    number: impl Fn(T::T) -> f64,
) -> Result<Vec<f64>, Stop> {
    let mut found = vec![];
    let (mut values, mut levels) = (Vec::with_capacity(BATCH), Vec::with_capacity(BATCH));
    while found.len() <= rows {
        levels.clear();
        let (records, present, _) =
            reader.read_records(BATCH, Some(&mut levels), None, &mut values)?;
        if present < records {
            let null = levels.iter().position(|level| *level == 0);
            return Err(Stop::Null(found.len() + null.unwrap_or(0)));
        }
        if records == 0 {
            break;
        }
        found.extend(values.drain(..).map(&number));
    }
    Ok(found)
}
