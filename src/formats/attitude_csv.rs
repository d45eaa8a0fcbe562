//! Attitude CSV: `time_s,roll_deg,pitch_deg,heading_deg`; roll positive starboard down, pitch bow up, heading clockwise.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FormatError, open};
use super::rows::Rows;
use super::table::{Limits, Table};
use super::trajectory_csv::{HEADING, PITCH, ROLL};
use super::whole::write_whole;
use crate::observe::AttitudeRecord;
use crate::units::{degrees, radians};

// LAYOUT

const COLUMNS: [&str; 4] = ["time_s", "roll_deg", "pitch_deg", "heading_deg"];

/// What a procedure's attitude files hold.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Roll, pitch and heading that are possible, degrees.
    pub limits: [Limits; 3],
    /// Decimals of a degree that are written.
    pub decimals: usize,
}

/// Of a vessel's attitude sensor.
pub const VESSEL: Layout = Layout {
    limits: [ROLL, PITCH, HEADING],
    decimals: 8,
};

// READ

/// Reads an attitude file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that do not strictly ascend.
pub fn read(path: &Path, layout: &Layout) -> Result<AttitudeRecord, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size, layout)
}

/// Reads an attitude file of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
    layout: &Layout,
) -> Result<AttitudeRecord, FormatError> {
    let mut table = Table::open(file, source, size, &COLUMNS, &[])?;
    let mut record = AttitudeRecord::default();
    let [roll, pitch, heading] = &layout.limits;
    table.each(None, |table| {
        let time_s = table.time(0, record.time_s.last().copied(), true)?;
        let angle = |column, limits| table.number(column, limits).map(radians);
        let angles = (angle(1, roll)?, angle(2, pitch)?, angle(3, heading)?);
        record.time_s.push(time_s);
        record.roll_rad.push(angles.0);
        record.pitch_rad.push(angles.1);
        record.heading_rad.push(angles.2);
        Ok(())
    })?;
    Ok(record)
}

// WRITE

/// Writes an attitude file: time as it is, angles with the layout's decimals.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, record: &AttitudeRecord, layout: &Layout) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, record, layout))
}

/// Writes an attitude file into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(
    out: &mut impl Write,
    record: &AttitudeRecord,
    layout: &Layout,
) -> std::io::Result<()> {
    let n = layout.decimals;
    writeln!(out, "{}", COLUMNS.join(","))?;
    for (time_s, angles) in record.time_s.iter().zip(record.angles_rad()) {
        let [roll, pitch, heading] = angles.map(degrees);
        writeln!(out, "{time_s},{roll:.n$},{pitch:.n$},{heading:.n$}")?;
    }
    Ok(())
}
