//! Laser CSV: `time_s,x_m,y_m,z_m`.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, open};
use super::faults::Invalid;
use super::records::LaserRecords;
use super::rows::Rows;
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

/// What scanners write 0,0,0 instead of.
pub(super) const A_RETURN: &str = "a return; 0,0,0 stands for none";

// READ

/// Reads a laser CSV.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that descend.
pub fn read(path: &Path, invalid: Invalid) -> Result<LaserRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size, invalid)
}

/// Reads a laser CSV of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
    invalid: Invalid,
) -> Result<LaserRecords, FormatError> {
    let mut table = Table::open(file, source, size, &COLUMNS, &[])?;
    let mut records = LaserRecords::default();
    let left_out = table.each(Some(invalid), |table| {
        if records.is_empty() {
            reserve(&mut records, table.expected_rows());
        }
        let coordinate = |column| table.number(column, &COORDINATE);
        let (x, y, z) = (coordinate(1)?, coordinate(2)?, coordinate(3)?);
        if (x, y, z) == (0.0, 0.0, 0.0) {
            return Err(table.fault(FaultKind::BadValue, 1, "0,0,0".to_owned(), A_RETURN));
        }
        let time_s = table.time(0, records.time_s.last().copied(), false)?;
        records.time_s.push(time_s);
        records.x_m.push(x);
        records.y_m.push(y);
        records.z_m.push(z);
        Ok(())
    })?;
    records.notes.extend(left_out);
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
