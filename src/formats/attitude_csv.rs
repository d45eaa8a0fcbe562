//! Attitude CSV: `time_s,roll_deg,pitch_deg,heading_deg`; roll positive starboard down, pitch bow up, heading clockwise.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FormatError, open};
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::units::{degrees, radians};

// LAYOUT

const COLUMNS: [&str; 4] = ["time_s", "roll_deg", "pitch_deg", "heading_deg"];
const ROLL: Limits = Limits {
    min: -180.0,
    max: 180.0,
    expected: "an angle from -180 to 180 deg",
};
const PITCH: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "an angle from -90 to 90 deg",
};
const HEADING: Limits = Limits {
    min: -360.0,
    max: 360.0,
    expected: "a heading from -360 to 360 deg",
};

/// Columns of an attitude file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AttitudeRecords {
    /// Time, seconds, strictly ascending.
    pub time_s: Vec<f64>,
    /// Roll, pitch, heading, radians.
    pub angles_rad: Vec<[f64; 3]>,
}

// READ

/// Reads an attitude file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that do not strictly ascend.
pub fn read(path: &Path) -> Result<AttitudeRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads an attitude file of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
) -> Result<AttitudeRecords, FormatError> {
    let mut table = Table::open(file, source, size, &COLUMNS, &[])?;
    let mut records = AttitudeRecords::default();
    while table.next_row()? {
        let time_s = table.number(0, &Limits::FINITE)?;
        table.check_order(0, records.time_s.last().copied(), time_s, true)?;
        records.time_s.push(time_s);
        let angle = |column, limits| table.number(column, limits).map(radians);
        let angles = [angle(1, &ROLL)?, angle(2, &PITCH)?, angle(3, &HEADING)?];
        records.angles_rad.push(angles);
    }
    if records.time_s.is_empty() {
        return Err(table.no_rows());
    }
    Ok(records)
}

// WRITE

/// Writes an attitude file: time as it is, angles to 1e-8 deg.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, records: &AttitudeRecords) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, records))
}

/// Writes an attitude file into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, records: &AttitudeRecords) -> std::io::Result<()> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    for (time_s, angles) in records.time_s.iter().zip(&records.angles_rad) {
        let [roll, pitch, heading] = angles.map(degrees);
        writeln!(out, "{time_s},{roll:.8},{pitch:.8},{heading:.8}")?;
    }
    Ok(())
}
