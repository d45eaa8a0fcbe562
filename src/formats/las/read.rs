//! LAS and LAZ into columns.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::laz::{Fault, Points, RawPoint};
use super::raw::{self, Header};
use crate::formats::error::{FaultKind, FormatError, Place, open};
use crate::formats::faults::{Faults, Invalid};
use crate::formats::laser_csv::{A_RETURN, reserve};
use crate::formats::records::LaserRecords;

/// Reads a LAS or LAZ file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, truncated, damaged, no GPS time, a value impossible.
pub fn read(path: &Path, invalid: Invalid) -> Result<LaserRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, BufReader::with_capacity(1 << 16, file), size, invalid)
}

/// As [`read`], for points that need no time: where the file has none, all times are 0.
///
/// # Errors
/// As [`read`].
pub fn read_untimed(path: &Path, invalid: Invalid) -> Result<LaserRecords, FormatError> {
    let (file, size) = open(path)?;
    let mut source = BufReader::with_capacity(1 << 16, file);
    let (header, points) = raw::check(path, &mut source, size)?;
    all(path, (source, size), &header, points, invalid)
}

/// Reads a LAS or LAZ of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    mut source: impl Read + Seek,
    size: u64,
    invalid: Invalid,
) -> Result<LaserRecords, FormatError> {
    let (header, points) = raw::check(file, &mut source, size)?;
    if !header.has_gps_time() {
        let found = format!("point format {}, which has no GPS time", header.format);
        let expected = "a point format with GPS time (1, 3 to 10)";
        return Err(FormatError::new(
            FaultKind::BadValue,
            file,
            Place::Header,
            found,
            expected,
        ));
    }
    all(file, (source, size), &header, points, invalid)
}

/// Reads every point, checks each, puts them in order.
fn all(
    file: &Path,
    (source, size): (impl Read + Seek, u64),
    header: &Header,
    points: raw::Points,
    invalid: Invalid,
) -> Result<LaserRecords, FormatError> {
    let mut faults = Faults::of(file);
    let mut number = 0;
    let mut records = LaserRecords::default();
    reserve(&mut records, header.points.min(1 << 24) as usize);
    let mut take = |point| {
        let taken = append((file, number), header, point, &mut records);
        number += 1;
        faults.row(taken)
    };
    match points {
        raw::Points::Plain => plain(file, source, header, &mut take)?,
        raw::Points::Compressed(items, chunks) => {
            let begin = (u64::from(header.offset_to_points), size);
            let mut points = Points::begin(source, begin, items, chunks)
                .map_err(|fault| damaged(file, 0, fault))?;
            for k in 0..header.points {
                take(points.point().map_err(|fault| damaged(file, k, fault))?)?;
            }
        }
    }
    records.notes.extend(faults.end(Some(invalid))?);
    records.tidy();
    Ok(records)
}

fn plain(
    file: &Path,
    mut source: impl Read + Seek,
    header: &Header,
    take: &mut impl FnMut(RawPoint) -> Result<(), FormatError>,
) -> Result<(), FormatError> {
    let unreadable = |e| FormatError::unreadable(file, &e);
    let begin = SeekFrom::Start(header.offset_to_points.into());
    source.seek(begin).map_err(unreadable)?;
    let mut raw = vec![0; header.point_bytes.into()];
    for _ in 0..header.points {
        source.read_exact(&mut raw).map_err(unreadable)?;
        take(RawPoint::of(&raw, header.time_at()))?;
    }
    Ok(())
}

fn damaged(file: &Path, point: u64, fault: Fault) -> FormatError {
    let found = match fault {
        Fault::Io(error) => return FormatError::unreadable(file, &error),
        Fault::End => "the end of the compressed points",
        Fault::Damaged => "compressed bytes that contradict each other",
    };
    FormatError::new(
        FaultKind::Truncated,
        file,
        Place::Point(point),
        found,
        "points as the header describes them: the file is damaged",
    )
}

/// Appends a point after checking it.
fn append(
    (file, number): (&Path, u64),
    header: &Header,
    point: RawPoint,
    records: &mut LaserRecords,
) -> Result<(), FormatError> {
    let time_s = f64::from_bits(point.time as u64);
    let bad = |found: String, expected: &str| {
        let place = Place::Point(number);
        FormatError::new(FaultKind::BadValue, file, place, found, expected)
    };
    if !time_s.is_finite() {
        return Err(bad(format!("time {time_s}"), "a finite time"));
    }
    let xyz = [0, 1, 2].map(|k| header.scale[k] * f64::from(point.xyz[k]) + header.offset[k]);
    if let Some(k) = xyz.iter().position(|v| !(v.abs() <= 2e7)) {
        let found = format!("{} = {}", ["x", "y", "z"][k], xyz[k]);
        return Err(bad(found, "a coordinate within 20000 km"));
    }
    if xyz == [0.0; 3] {
        return Err(bad("0,0,0".to_owned(), A_RETURN));
    }
    let [x, y, z] = xyz;
    records.time_s.push(time_s);
    records.x_m.push(x);
    records.y_m.push(y);
    records.z_m.push(z);
    Ok(())
}
