//! LAS and LAZ into columns.

use std::io::{BufReader, Read, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use las::reader::{LazParallelism, ReaderOptions};
use las::{PointData, PointDataBuilder};

use super::raw::{self, Header};
use crate::formats::error::{FaultKind, FormatError, Place, open};
use crate::formats::laser_csv::reserve;
use crate::formats::records::LaserRecords;

/// Bytes of points decoded at a time.
const CHUNK_BYTES: u64 = 4 << 20;

/// Reads a LAS or LAZ file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, truncated, no GPS time, a value impossible, times that descend.
pub fn read(path: &Path) -> Result<LaserRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, BufReader::with_capacity(1 << 18, file), size)
}

/// Reads a LAS or LAZ of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    mut source: impl Read + Seek + Send + Sync + 'static,
    size: u64,
) -> Result<LaserRecords, FormatError> {
    let header = raw::check(file, &mut source, size)?;
    // the decoder asserts on corrupt compressed bytes: an error of the file, not of the program
    catch_unwind(AssertUnwindSafe(|| decode(file, source, &header))).unwrap_or_else(|_| {
        Err(corrupt(
            file,
            0,
            "compressed bytes that contradict each other",
        ))
    })
}

fn corrupt(file: &Path, point: u64, found: impl Into<String>) -> FormatError {
    FormatError::new(
        FaultKind::Truncated,
        file,
        Place::Point(point),
        found,
        "points as the header describes them: the file is damaged",
    )
}

/// One thread: other files are read beside this one, and the decoder's threads trust the chunk table's sizes.
fn decode(
    file: &Path,
    source: impl Read + Seek + Send + Sync + 'static,
    header: &Header,
) -> Result<LaserRecords, FormatError> {
    let damaged = |point: u64, error: las::Error| corrupt(file, point, format!("\"{error}\""));
    let options = ReaderOptions::default().with_laz_parallelism(LazParallelism::No);
    let mut reader = las::Reader::with_options(source, options).map_err(|e| damaged(0, e))?;
    let mut chunk = PointDataBuilder::new().for_header(reader.header()).build();
    let points_at_a_time = (CHUNK_BYTES / u64::from(header.point_bytes)).max(1);
    let mut records = LaserRecords::default();
    reserve(&mut records, header.points.min(1 << 24) as usize);
    loop {
        let before = records.len() as u64;
        let count = reader
            .fill_points(points_at_a_time, &mut chunk)
            .map_err(|e| damaged(before, e))?;
        if count == 0 {
            break;
        }
        append(file, &chunk, &mut records)?;
    }
    Ok(records)
}

/// Appends a chunk's columns after checking them.
fn append(file: &Path, chunk: &PointData, records: &mut LaserRecords) -> Result<(), FormatError> {
    let begin = records.len();
    let times = chunk
        .gps_time()
        .ok_or_else(|| corrupt(file, begin as u64, "points without GPS time"))?;
    records.time_s.extend(times);
    records.x_m.extend(chunk.x());
    records.y_m.extend(chunk.y());
    records.z_m.extend(chunk.z());
    let mut before = begin
        .checked_sub(1)
        .map_or(f64::NEG_INFINITY, |k| records.time_s[k]);
    for (k, &time_s) in records.time_s.iter().enumerate().skip(begin) {
        if !time_s.is_finite() {
            return Err(bad(
                file,
                k,
                FaultKind::BadValue,
                format!("time {time_s}"),
                "a finite time",
            ));
        }
        if time_s < before {
            let found = format!("time {time_s} after {before}");
            return Err(bad(
                file,
                k,
                FaultKind::Order,
                found,
                "points in order of GPS time",
            ));
        }
        before = time_s;
    }
    for (name, column) in [
        ("x", &records.x_m),
        ("y", &records.y_m),
        ("z", &records.z_m),
    ] {
        if let Some(k) = (begin..column.len()).find(|&k| !(column[k].abs() <= 2e7)) {
            let found = format!("{name} = {}", column[k]);
            return Err(bad(
                file,
                k,
                FaultKind::BadValue,
                found,
                "a coordinate within 20000 km",
            ));
        }
    }
    Ok(())
}

fn bad(file: &Path, k: usize, kind: FaultKind, found: String, expected: &str) -> FormatError {
    FormatError::new(kind, file, Place::Point(k as u64), found, expected)
}
