//! Trajectory CSV: `time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg`, and velocities where known.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, open};
use super::faults::Invalid;
use super::records::TrajectoryRecords;
use super::rows::Rows;
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::math;
use crate::observe::GeodeticTrajectory;
use crate::units::{degrees, radians};

// LAYOUT

const REQUIRED: [&str; 7] = [
    "time_s",
    "latitude_deg",
    "longitude_deg",
    "height_m",
    "roll_deg",
    "pitch_deg",
    "heading_deg",
];
const OPTIONAL: [&str; 3] = ["velocity_east_m_s", "velocity_north_m_s", "velocity_up_m_s"];
/// Latitudes that are possible.
pub const LATITUDE: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "a latitude from -90 to 90 deg",
};
/// Longitudes that are possible.
pub const LONGITUDE: Limits = Limits {
    min: -360.0,
    max: 360.0,
    expected: "a longitude from -360 to 360 deg",
};
/// Heights above the ellipsoid that are possible.
pub const HEIGHT: Limits = Limits {
    min: -12_000.0,
    max: 100_000.0,
    expected: "an ellipsoidal height from -12000 to 100000 m",
};
/// Rolls that are possible.
pub const ROLL: Limits = Limits {
    min: -180.0,
    max: 180.0,
    expected: "an angle from -180 to 180 deg",
};
/// Pitches that are possible.
pub const PITCH: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "an angle from -90 to 90 deg",
};
/// Headings that are possible.
pub const HEADING: Limits = Limits {
    min: -360.0,
    max: 360.0,
    expected: "a heading from -360 to 360 deg",
};
const SPEED: Limits = Limits {
    min: -1000.0,
    max: 1000.0,
    expected: "a velocity within 1000 m/s",
};

// READ

/// Reads a trajectory CSV.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, times that do not strictly ascend.
pub fn read(path: &Path, invalid: Invalid) -> Result<TrajectoryRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size, invalid)
}

/// Reads a trajectory CSV of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
    invalid: Invalid,
) -> Result<TrajectoryRecords, FormatError> {
    let mut table = Table::open(file, source, size, &REQUIRED, &OPTIONAL)?;
    let mut records = TrajectoryRecords {
        velocity_m_s: (7..10).all(|c| table.has(c)).then(Vec::new),
        ..TrajectoryRecords::default()
    };
    let left_out = table.each(Some(invalid), |table| {
        if records.is_empty() {
            reserve(&mut records, table.expected_rows());
        }
        push_row(table, &mut records)
    })?;
    records.notes.extend(left_out);
    check_heading_unit(&table, &records)?;
    Ok(records)
}

fn reserve(records: &mut TrajectoryRecords, rows: usize) {
    for column in [
        &mut records.time_s,
        &mut records.latitude_rad,
        &mut records.longitude_rad,
        &mut records.height_m,
        &mut records.roll_rad,
        &mut records.pitch_rad,
        &mut records.heading_rad,
    ] {
        column.reserve(rows);
    }
}

fn push_row<R: Read>(table: &Table<R>, records: &mut TrajectoryRecords) -> Result<(), FormatError> {
    let angle = |column, limits| table.number(column, limits).map(radians);
    let (latitude, longitude) = (angle(1, &LATITUDE)?, angle(2, &LONGITUDE)?);
    let height_m = table.number(3, &HEIGHT)?;
    let (roll, pitch, heading) = (angle(4, &ROLL)?, angle(5, &PITCH)?, angle(6, &HEADING)?);
    let time_s = table.time(0, records.time_s.last().copied(), true)?;
    if let Some(velocity) = &mut records.velocity_m_s {
        let speed = |column| table.number(column, &SPEED);
        velocity.push([speed(7)?, speed(8)?, speed(9)?]);
    }
    records.time_s.push(time_s);
    records.latitude_rad.push(latitude);
    records.longitude_rad.push(longitude);
    records.height_m.push(height_m);
    records.roll_rad.push(roll);
    records.pitch_rad.push(pitch);
    records.heading_rad.push(heading);
    Ok(())
}

/// Slowest motion whose direction is compared with the heading, metres per second.
const MOVING_M_S: f64 = 0.2;

/// Refuses headings that are within a turn in radians, contradict the direction of motion as degrees (ahead or astern)
/// and follow it as radians, in nine of ten moving records.
fn check_heading_unit<R: Read>(
    table: &Table<R>,
    records: &TrajectoryRecords,
) -> Result<(), FormatError> {
    let in_file: Vec<f64> = records.heading_rad.iter().copied().map(degrees).collect();
    if in_file.iter().any(|h| h.abs() > std::f64::consts::TAU) {
        return Ok(());
    }
    let (mut moving, mut follow) = (0_usize, 0_usize);
    for (k, heading) in in_file.iter().enumerate().skip(1) {
        let Some(course_rad) = course(records, k) else {
            continue;
        };
        moving += 1;
        let as_degrees = math::sin(course_rad - records.heading_rad[k]).abs();
        let as_radians = math::cos(course_rad - heading);
        follow += usize::from(as_degrees > 0.5 && as_radians > 0.9);
    }
    if moving < 10 || follow * 10 < moving * 9 {
        return Ok(());
    }
    let found = format!(
        "headings of at most {:.3} that follow the direction of motion only when read as radians",
        in_file.iter().fold(0.0_f64, |a, h| a.max(h.abs()))
    );
    Err(table.fault(
        FaultKind::WrongUnit,
        6,
        found,
        "degrees, clockwise from north",
    ))
}

/// Direction of motion from the record before, radians from north; `None` at rest.
fn course(records: &TrajectoryRecords, k: usize) -> Option<f64> {
    let radius_m = 6_371_000.0;
    let step_s = records.time_s[k] - records.time_s[k - 1];
    let north = radius_m * (records.latitude_rad[k] - records.latitude_rad[k - 1]);
    let east = radius_m
        * (records.longitude_rad[k] - records.longitude_rad[k - 1])
        * math::cos(records.latitude_rad[k]);
    (math::hypot(north, east) > MOVING_M_S * step_s).then(|| math::atan2(east, north))
}

// WRITE

/// Writes a trajectory CSV: time as it is, positions to 0.1 micrometre (1e-12 deg), heights to 1 micrometre, angles to 1e-8 deg,
/// velocities (three more columns, where there are any) to 1 micrometre per second.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, trajectory: &GeodeticTrajectory) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, trajectory))
}

/// Writes a trajectory CSV into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, trajectory: &GeodeticTrajectory) -> std::io::Result<()> {
    write!(out, "{}", REQUIRED.join(","))?;
    if trajectory.velocity_m_s.is_some() {
        write!(out, ",{}", OPTIONAL.join(","))?;
    }
    writeln!(out)?;
    for k in 0..trajectory.time_s.len() {
        write!(
            out,
            "{},{:.12},{:.12},{:.6},{:.8},{:.8},{:.8}",
            trajectory.time_s[k],
            degrees(trajectory.latitude_rad[k]),
            degrees(trajectory.longitude_rad[k]),
            trajectory.height_m[k],
            degrees(trajectory.roll_rad[k]),
            degrees(trajectory.pitch_rad[k]),
            degrees(trajectory.heading_rad[k]),
        )?;
        if let Some(velocity) = &trajectory.velocity_m_s {
            let [east, north, up] = velocity[k];
            write!(out, ",{east:.6},{north:.6},{up:.6}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}
