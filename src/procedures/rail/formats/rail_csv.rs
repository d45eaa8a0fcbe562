//! Tables of a rail calibration: profiles `time_s,profiler,y_m,z_m` (profilers counted from 1) and positions
//! `from_s,to_s,heading_deg,pitch_deg`; its attitude record is an [`attitude_csv`](crate::formats::attitude_csv).
//!
//! Profiles come as Parquet too, see [`super::read_profiles`]; both are checked by the same lines.

use std::io::{Read, Write};
use std::path::Path;

use super::super::observed::{ProfilePoints, TableRecord};
use crate::formats::attitude_csv::Layout;
use crate::formats::error::{FaultKind, FormatError, open};
use crate::formats::rows::Rows;
use crate::formats::table::{Limits, Table};
use crate::formats::week;
use crate::formats::whole::write_whole;
use crate::units::{degrees, radians};

// LAYOUT

pub(super) const PROFILES: [&str; 4] = ["time_s", "profiler", "y_m", "z_m"];
const TABLE: [&str; 4] = ["from_s", "to_s", "heading_deg", "pitch_deg"];

/// Profilers see less than a few metres; larger numbers are millimetres.
const COORDINATE: Limits = Limits {
    min: -10.0,
    max: 10.0,
    expected: "metres from -10 to 10",
};
const TILT: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "degrees from -90 to 90",
};
const TURN: Limits = Limits {
    min: -360.0,
    max: 360.0,
    expected: "degrees from -360 to 360",
};

/// Attitude of the measuring beam's INS on its table.
pub const BEAM: Layout = Layout {
    limits: [TURN, TILT, TURN],
    decimals: 7,
};

// READ

/// Reads a profiles CSV of so many profilers.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, an unknown profiler, times that descend.
pub fn read_profiles(path: &Path, profilers: usize) -> Result<ProfilePoints, FormatError> {
    let (file, size) = open(path)?;
    read_profiles_from(path, file, size, profilers)
}

/// Reads profiles of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read_profiles`].
pub fn read_profiles_from(
    file: &Path,
    source: impl Read,
    size: u64,
    profilers: usize,
) -> Result<ProfilePoints, FormatError> {
    profiles(Table::open(file, source, size, &PROFILES, &[])?, profilers)
}

/// Checks and takes every row of a table with the columns [`PROFILES`].
pub(super) fn profiles(
    mut table: impl Rows,
    profilers: usize,
) -> Result<ProfilePoints, FormatError> {
    let mut points = ProfilePoints::default();
    table.each(None, |table| {
        let time_s = table.time(0, points.time_s.last().copied(), false)?;
        let profiler = table.count(1)?;
        if profiler == 0 || profiler as usize > profilers {
            let expected = format!("a profiler of the survey file, 1 to {profilers}");
            return Err(table.bad_value(1, &expected));
        }
        let (y_m, z_m) = (table.number(2, &COORDINATE)?, table.number(3, &COORDINATE)?);
        points.time_s.push(time_s);
        points.profiler.push(profiler - 1);
        points.y_m.push(y_m);
        points.z_m.push(z_m);
        Ok(())
    })?;
    Ok(points)
}

/// Reads a table of positions.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, positions that end before they begin or overlap.
pub fn read_table(path: &Path) -> Result<TableRecord, FormatError> {
    let (file, size) = open(path)?;
    let mut table = Table::open(path, file, size, &TABLE, &[])?;
    let mut record = TableRecord::default();
    table.each(None, |table| {
        let from_s = table.time(0, record.to_s.last().copied(), true)?;
        let to_s = week::following(Some(from_s), table.number(1, &Limits::FINITE)?);
        if !(to_s > from_s) {
            let found = format!("{to_s} with from_s {from_s}");
            return Err(table.fault(FaultKind::Order, 1, found, "a later time than from_s"));
        }
        let (heading, pitch) = (table.number(2, &TURN)?, table.number(3, &TILT)?);
        record.from_s.push(from_s);
        record.to_s.push(to_s);
        record.heading_rad.push(radians(heading));
        record.pitch_rad.push(radians(pitch));
        Ok(())
    })?;
    Ok(record)
}

// WRITE

/// Writes a profiles CSV: coordinates to 10 nanometres.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write_profiles(path: &Path, points: &ProfilePoints) -> Result<(), FormatError> {
    write_whole(path, |out| -> std::io::Result<()> {
        writeln!(out, "{}", PROFILES.join(","))?;
        for k in 0..points.len() {
            let (time_s, profiler) = (points.time_s[k], points.profiler[k] + 1);
            let (y, z) = (points.y_m[k], points.z_m[k]);
            writeln!(out, "{time_s},{profiler},{y:.8},{z:.8}")?;
        }
        Ok(())
    })
}

/// Writes a table of positions: angles to 1e-7 degrees.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write_table(path: &Path, record: &TableRecord) -> Result<(), FormatError> {
    write_whole(path, |out| -> std::io::Result<()> {
        writeln!(out, "{}", TABLE.join(","))?;
        for k in 0..record.len() {
            let [heading, pitch] = [record.heading_rad[k], record.pitch_rad[k]].map(degrees);
            writeln!(
                out,
                "{},{},{heading:.7},{pitch:.7}",
                record.from_s[k], record.to_s[k]
            )?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        let read = read_profiles_from(Path::new("p.csv"), text.as_bytes(), text.len() as u64, 2);
        read.expect_err("a fault").to_string()
    }

    #[test]
    fn a_fault_names_line_and_column() {
        let head = "time_s,profiler,y_m,z_m\n";
        let unknown = refused(&format!("{head}0,3,0.1,0.1\n"));
        assert!(
            unknown.contains("line 2, column profiler") && unknown.contains("1 to 2"),
            "{unknown}"
        );
        assert!(refused(&format!("{head}0,1,100.5,0.1\n")).contains("metres"));
        assert!(refused(&format!("{head}1,1,0,0\n0,1,0,0\n")).contains("ascending"));
        assert!(refused("time_s,profiler,y_mm,z_m\n").contains("nearest column: y_mm"));
        assert!(refused(head).contains("nothing else"));
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().expect("folder");
        let points = ProfilePoints {
            time_s: vec![0.5, 0.5],
            profiler: vec![0, 1],
            y_m: vec![0.01234567, -0.2],
            z_m: vec![-0.3, 0.25],
        };
        let path = folder.path().join("p.csv");
        write_profiles(&path, &points).expect("written");
        assert_eq!(read_profiles(&path, 2).expect("read"), points);
        let table = TableRecord {
            from_s: vec![0.0, 3.0],
            to_s: vec![1.0, 4.0],
            heading_rad: vec![radians(1.5), radians(-2.0)],
            pitch_rad: vec![0.0, radians(0.25)],
        };
        write_table(&path, &table).expect("written");
        assert_eq!(read_table(&path).expect("read"), table);
        std::fs::write(&path, "from_s,to_s,heading_deg,pitch_deg\n2,1,0,0\n").expect("written");
        assert!(
            read_table(&path)
                .expect_err("a fault")
                .to_string()
                .contains("later time")
        );
    }
}
