//! Laser CSV: `time_s,x_m,y_m,z_m`.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FormatError, open};
use super::records::LaserRecords;
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::observe::LaserScan;

// LAYOUT

const COLUMNS: [&str; 4] = ["time_s", "x_m", "y_m", "z_m"];
/// Geocentric coordinates and UTM northings are the largest that occur.
const COORDINATE: Limits = Limits {
    min: -2e7,
    max: 2e7,
    expected: "a coordinate within 20000 km",
};

// READ

/// Reads a laser CSV.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that descend.
pub fn read(path: &Path) -> Result<LaserRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads a laser CSV of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(file: &Path, source: impl Read, size: u64) -> Result<LaserRecords, FormatError> {
    let mut table = Table::open(file, source, size, &COLUMNS, &[])?;
    let mut records = LaserRecords::default();
    while table.next_row()? {
        if records.is_empty() {
            reserve(&mut records, table.expected_rows());
        }
        let time_s = table.time(0, records.time_s.last().copied(), false)?;
        records.time_s.push(time_s);
        records.x_m.push(table.number(1, &COORDINATE)?);
        records.y_m.push(table.number(2, &COORDINATE)?);
        records.z_m.push(table.number(3, &COORDINATE)?);
    }
    if records.is_empty() {
        return Err(table.no_rows());
    }
    records.tidy();
    Ok(records)
}

/// Makes room in every column.
pub(super) fn reserve(records: &mut LaserRecords, rows: usize) {
    records.time_s.reserve(rows);
    records.x_m.reserve(rows);
    records.y_m.reserve(rows);
    records.z_m.reserve(rows);
}

// WRITE

/// Writes a laser CSV: time as it is, coordinates to 10 micrometres.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, scan: &LaserScan) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, scan))
}

/// Writes a laser CSV into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, scan: &LaserScan) -> std::io::Result<()> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    for k in 0..scan.len() {
        let (x, y, z) = (scan.x_m[k], scan.y_m[k], scan.z_m[k]);
        writeln!(out, "{},{x:.5},{y:.5},{z:.5}", scan.time_s[k])?;
    }
    Ok(())
}
