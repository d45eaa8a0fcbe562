//! SBET (smoothed best estimate of trajectory): 17 little-endian doubles a record, 136 bytes, no header.
//!
//! Checked on a real file against its own differenced positions and its laser points: true heading = platform heading - wander,
//! and the velocity is in the wander frame with x north, y **west**, z up:
//! `N = vx cos w - vy sin w`, `W = vx sin w + vy cos w`.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::io::{BufReader, Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, Place, open};
use super::records::TrajectoryRecords;
use super::week;
use super::whole::write_whole;
use crate::math;
use crate::observe::GeodeticTrajectory;
use crate::units::wrap_angle;

// LAYOUT

/// Mirror of one record.
pub mod raw {
    /// Bytes of a record.
    pub const RECORD_BYTES: usize = 136;

    /// The 17 doubles in their order.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Record {
        /// GPS seconds of the week.
        pub time_s: f64,
        /// Latitude, radians.
        pub latitude_rad: f64,
        /// Longitude, radians.
        pub longitude_rad: f64,
        /// Height, metres, ellipsoidal.
        pub height_m: f64,
        /// Velocity in the wander frame: north, west, up, metres per second.
        pub velocity_m_s: [f64; 3],
        /// Roll, radians.
        pub roll_rad: f64,
        /// Pitch, radians.
        pub pitch_rad: f64,
        /// Platform heading, radians: true heading plus wander.
        pub platform_heading_rad: f64,
        /// Wander angle, radians.
        pub wander_rad: f64,
        /// Acceleration of the body, metres per second squared.
        pub acceleration_m_s2: [f64; 3],
        /// Angular rate of the body, radians per second.
        pub rate_rad_s: [f64; 3],
    }

    impl Record {
        /// From the bytes of a record.
        #[must_use]
        pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Self {
            let mut d = [0.0; 17];
            for (value, chunk) in d.iter_mut().zip(bytes.as_chunks::<8>().0) {
                *value = f64::from_le_bytes(*chunk);
            }
            Self {
                time_s: d[0],
                latitude_rad: d[1],
                longitude_rad: d[2],
                height_m: d[3],
                velocity_m_s: [d[4], d[5], d[6]],
                roll_rad: d[7],
                pitch_rad: d[8],
                platform_heading_rad: d[9],
                wander_rad: d[10],
                acceleration_m_s2: [d[11], d[12], d[13]],
                rate_rad_s: [d[14], d[15], d[16]],
            }
        }

        /// The bytes of the record.
        #[must_use]
        pub fn to_bytes(&self) -> [u8; RECORD_BYTES] {
            let [vx, vy, vz] = self.velocity_m_s;
            let [ax, ay, az] = self.acceleration_m_s2;
            let [wx, wy, wz] = self.rate_rad_s;
            let doubles = [
                self.time_s,
                self.latitude_rad,
                self.longitude_rad,
                self.height_m,
                vx,
                vy,
                vz,
                self.roll_rad,
                self.pitch_rad,
                self.platform_heading_rad,
                self.wander_rad,
                ax,
                ay,
                az,
                wx,
                wy,
                wz,
            ];
            let mut bytes = [0; RECORD_BYTES];
            for (chunk, value) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(doubles) {
                *chunk = value.to_le_bytes();
            }
            bytes
        }
    }
}
use raw::{RECORD_BYTES, Record};

/// Velocity east, north, up of a record.
fn east_north_up(record: &Record) -> [f64; 3] {
    let (sin, cos) = math::sin_cos(record.wander_rad);
    let [x, y, up] = record.velocity_m_s;
    let (north, west) = (x * cos - y * sin, x * sin + y * cos);
    [-west, north, up]
}

/// The inverse of [`east_north_up`].
fn wander_frame([east, north, up]: [f64; 3], wander_rad: f64) -> [f64; 3] {
    let (sin, cos) = math::sin_cos(wander_rad);
    [north * cos - east * sin, -north * sin - east * cos, up]
}

// READ

/// Reads an SBET file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, truncated, an impossible value, times that do not strictly ascend.
pub fn read(path: &Path) -> Result<TrajectoryRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads an SBET of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
) -> Result<TrajectoryRecords, FormatError> {
    let count = check_size(file, size)?;
    let mut source = BufReader::with_capacity(1 << 18, source);
    let mut records = TrajectoryRecords {
        velocity_m_s: Some(vec![]),
        ..TrajectoryRecords::default()
    };
    let mut bytes = [0; RECORD_BYTES];
    for k in 0..count {
        source
            .read_exact(&mut bytes)
            .map_err(|e| FormatError::unreadable(file, &e))?;
        let mut record = Record::from_bytes(&bytes);
        record.time_s = week::following(records.time_s.last().copied(), record.time_s);
        check_record(file, k, &record, records.time_s.last().copied())?;
        push(&mut records, &record);
    }
    Ok(records)
}

/// The number of records, if the size is a multiple of theirs.
fn check_size(file: &Path, size: u64) -> Result<u64, FormatError> {
    let (count, rest) = (size / RECORD_BYTES as u64, size % RECORD_BYTES as u64);
    if size == 0 {
        let expected = format!("records of {RECORD_BYTES} bytes");
        return Err(FormatError::new(
            FaultKind::Empty,
            file,
            Place::File,
            "an empty file",
            expected,
        ));
    }
    if rest == 0 {
        return Ok(count);
    }
    let place = Place::Record {
        record: count,
        byte: count * RECORD_BYTES as u64,
    };
    let found = format!("{rest} bytes before the end of the file");
    let expected = format!("{RECORD_BYTES}: the file is truncated, or no SBET");
    Err(FormatError::new(
        FaultKind::Truncated,
        file,
        place,
        found,
        expected,
    ))
}

fn check_record(
    file: &Path,
    k: u64,
    record: &Record,
    before_s: Option<f64>,
) -> Result<(), FormatError> {
    let place = Place::Record {
        record: k,
        byte: k * RECORD_BYTES as u64,
    };
    if let Some((found, expected)) = impossible(record) {
        return Err(FormatError::new(
            FaultKind::BadValue,
            file,
            place,
            found,
            expected,
        ));
    }
    match before_s {
        Some(before) if record.time_s <= before => Err(FormatError::new(
            FaultKind::Order,
            file,
            place,
            format!("time {} after {before}", record.time_s),
            "strictly ascending times",
        )),
        _ => Ok(()),
    }
}

/// The first value of a record that cannot be, and what can.
fn impossible(record: &Record) -> Option<(String, &'static str)> {
    let [vx, vy, vz] = record.velocity_m_s;
    let checks = [
        ("time", record.time_s, f64::MAX, "a finite time"),
        (
            "latitude",
            record.latitude_rad,
            FRAC_PI_2,
            "radians within pi/2",
        ),
        (
            "longitude",
            record.longitude_rad,
            TAU,
            "radians within 2 pi",
        ),
        ("height", record.height_m, 1e5, "metres within 100 km"),
        ("velocity x", vx, 1e3, "within 1000 m/s"),
        ("velocity y", vy, 1e3, "within 1000 m/s"),
        ("velocity z", vz, 1e3, "within 1000 m/s"),
        ("roll", record.roll_rad, TAU, "radians within 2 pi"),
        ("pitch", record.pitch_rad, FRAC_PI_2, "radians within pi/2"),
        (
            "platform heading",
            record.platform_heading_rad,
            2.0 * TAU,
            "radians within 4 pi",
        ),
        (
            "wander angle",
            record.wander_rad,
            TAU,
            "radians within 2 pi",
        ),
    ];
    checks
        .into_iter()
        .find(|(_, value, limit, _)| !(value.abs() <= *limit))
        .map(|(name, value, _, expected)| (format!("{name} = {value}"), expected))
}

fn push(records: &mut TrajectoryRecords, record: &Record) {
    records.time_s.push(record.time_s);
    records.latitude_rad.push(record.latitude_rad);
    records.longitude_rad.push(record.longitude_rad);
    records.height_m.push(record.height_m);
    records.roll_rad.push(record.roll_rad);
    records.pitch_rad.push(record.pitch_rad);
    let heading_rad = record.platform_heading_rad - record.wander_rad;
    records.heading_rad.push(wrap_angle(heading_rad));
    if let Some(velocity) = &mut records.velocity_m_s {
        velocity.push(east_north_up(record));
    }
}

// WRITE

/// Writes an SBET with one wander angle (radians) for all records; accelerations and rates are zero.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`, also when the trajectory has no velocities: an SBET must hold them.
pub fn write(
    path: &Path,
    trajectory: &GeodeticTrajectory,
    wander_rad: f64,
) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, trajectory, wander_rad))
}

/// Writes an SBET into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`, and `InvalidInput` without velocities.
pub fn write_to(
    out: &mut impl Write,
    trajectory: &GeodeticTrajectory,
    wander_rad: f64,
) -> std::io::Result<()> {
    let Some(velocity) = &trajectory.velocity_m_s else {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "a trajectory without velocities, which an SBET must hold",
        ));
    };
    for (k, velocity) in velocity.iter().enumerate() {
        let record = Record {
            time_s: trajectory.time_s[k],
            latitude_rad: trajectory.latitude_rad[k],
            longitude_rad: trajectory.longitude_rad[k],
            height_m: trajectory.height_m[k],
            velocity_m_s: wander_frame(*velocity, wander_rad),
            roll_rad: trajectory.roll_rad[k],
            pitch_rad: trajectory.pitch_rad[k],
            platform_heading_rad: wrap_angle(trajectory.heading_rad[k] + wander_rad),
            wander_rad,
            ..Record::default()
        };
        out.write_all(&record.to_bytes())?;
    }
    Ok(())
}
