//! Soundings CSV: `time_s,ping,beam,across_angle_deg,along_angle_deg` and `range_m` or `two_way_travel_time_s`.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, open};
use super::records::SoundingRecords;
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::observe::{SoundingRange, Soundings};
use crate::units::{degrees, radians};

// LAYOUT

const REQUIRED: [&str; 5] = [
    "time_s",
    "ping",
    "beam",
    "across_angle_deg",
    "along_angle_deg",
];
const RANGES: [&str; 2] = ["range_m", "two_way_travel_time_s"];
const ANGLE: Limits = Limits {
    min: -180.0,
    max: 180.0,
    expected: "an angle from -180 to 180 deg",
};
const ALONG: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "an angle from -90 to 90 deg",
};
const RANGE: Limits = Limits {
    min: f64::MIN_POSITIVE,
    max: 20_000.0,
    expected: "a range above 0 m and up to 20000 m (is it in millimetres?)",
};
/// The two-way time over 20 km of slow water.
const TRAVEL_TIME: Limits = Limits {
    min: f64::MIN_POSITIVE,
    max: 30.0,
    expected: "a travel time above 0 s and up to 30 s (seconds, not milliseconds)",
};

// READ

/// Reads a soundings CSV.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that descend, angles in radians.
pub fn read(path: &Path) -> Result<SoundingRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads a soundings CSV of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
) -> Result<SoundingRecords, FormatError> {
    let mut table = Table::open(file, source, size, &REQUIRED, &RANGES)?;
    let (column, limits) = range_column(&table)?;
    let (mut records, mut range) = (empty(), vec![]);
    while table.next_row()? {
        if records.is_empty() {
            reserve(&mut records, &mut range, table.expected_rows());
        }
        let time_s = table.time(0, records.time_s.last().copied(), false)?;
        records.time_s.push(time_s);
        records.ping.push(table.count(1)?);
        records.beam.push(table.count(2)?);
        records.across_rad.push(radians(table.number(3, &ANGLE)?));
        records.along_rad.push(radians(table.number(4, &ALONG)?));
        range.push(table.number(column, limits)?);
    }
    if records.is_empty() {
        return Err(table.no_rows());
    }
    check_angle_unit(&table, &records)?;
    records.range = if column == 5 {
        SoundingRange::Metres(range)
    } else {
        SoundingRange::TwoWayTravelTime(range)
    };
    Ok(records)
}

/// Which of the two range columns is there.
fn range_column<R: Read>(table: &Table<R>) -> Result<(usize, &'static Limits), FormatError> {
    match (table.has(5), table.has(6)) {
        (true, false) => Ok((5, &RANGE)),
        (false, true) => Ok((6, &TRAVEL_TIME)),
        (false, false) => Err(table.missing(&RANGES)),
        (true, true) => Err(table.fault(
            FaultKind::BadValue,
            5,
            format!("both {} and {}", RANGES[0], RANGES[1]),
            "one of them",
        )),
    }
}

fn empty() -> SoundingRecords {
    SoundingRecords {
        time_s: vec![],
        ping: vec![],
        beam: vec![],
        across_rad: vec![],
        along_rad: vec![],
        range: SoundingRange::Metres(vec![]),
    }
}

fn reserve(records: &mut SoundingRecords, range: &mut Vec<f64>, rows: usize) {
    records.time_s.reserve(rows);
    records.ping.reserve(rows);
    records.beam.reserve(rows);
    records.across_rad.reserve(rows);
    records.along_rad.reserve(rows);
    range.reserve(rows);
}

/// Beams a ping must have before its swath says anything about the unit.
const MANY_BEAMS: usize = 16;

/// Refuses across angles that are all within a right angle in radians although pings of many beams fan out with them:
/// no multibeam has a swath of three degrees.
fn check_angle_unit<R: Read>(
    table: &Table<R>,
    records: &SoundingRecords,
) -> Result<(), FormatError> {
    let widest = records
        .across_rad
        .iter()
        .fold(0.0_f64, |a, x| a.max(x.abs()));
    let widest = degrees(widest);
    let beams = records
        .ping
        .chunk_by(|a, b| a == b)
        .map(<[u32]>::len)
        .max()
        .unwrap_or(0);
    if !(0.05..=1.6).contains(&widest) || beams < MANY_BEAMS {
        return Ok(());
    }
    let found =
        format!("angles within {widest:.3} over pings of up to {beams} beams, which are radians");
    Err(table.fault(
        FaultKind::WrongUnit,
        3,
        found,
        "degrees, positive to starboard",
    ))
}

// WRITE

/// Writes a soundings CSV: time as it is, angles to 1e-7 deg, ranges to 1 micrometre, travel times to 1 nanosecond.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, soundings: &Soundings) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, soundings))
}

/// Writes a soundings CSV into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, soundings: &Soundings) -> std::io::Result<()> {
    let (name, decimals) = match soundings.range {
        SoundingRange::Metres(_) => (RANGES[0], 6),
        SoundingRange::TwoWayTravelTime(_) => (RANGES[1], 9),
    };
    writeln!(out, "{},{name}", REQUIRED.join(","))?;
    for (k, range) in soundings.range.values().iter().enumerate() {
        writeln!(
            out,
            "{},{},{},{:.7},{:.7},{range:.decimals$}",
            soundings.time_s[k],
            soundings.ping[k],
            soundings.beam[k],
            degrees(soundings.across_rad[k]),
            degrees(soundings.along_rad[k]),
        )?;
    }
    Ok(())
}
