//! Acoustic fixes: `time_s,beacon` and where the beacon seems to be, in the transducer's frame (x right, y forward, z up).
//!
//! The header says how: `x_m,y_m,z_m`; or a range (`range_m`, `travel_time_s` one way, or `two_way_travel_time_s`) with two
//! angles. Angles: `bearing_deg,depression_deg` (bearing clockwise from +y towards +x, depression below the x-y plane), or
//! `x_angle_deg,y_angle_deg` (between the line of sight and the +x and +y baselines, 0 to 180; the beacon is below).

use crate::math;
use std::io::{Read, Write};
use std::path::Path;

use nalgebra::Vector3;

use crate::formats::error::{FormatError, open};
use crate::formats::faults::Invalid;
use crate::formats::rows::Rows;
use crate::formats::table::{Limits, Table};
use crate::formats::whole::write_whole;

// LAYOUT

const REQUIRED: [&str; 2] = ["time_s", "beacon"];
const OPTIONAL: [&str; 10] = [
    "x_m",
    "y_m",
    "z_m",
    "range_m",
    "travel_time_s",
    "two_way_travel_time_s",
    "bearing_deg",
    "depression_deg",
    "x_angle_deg",
    "y_angle_deg",
];
const PLACE: Limits = Limits {
    min: -12_000.0,
    max: 12_000.0,
    expected: "metres within 12000",
};
const RANGE: Limits = Limits {
    min: 1e-6,
    max: 12_000.0,
    expected: "a range above 0 and up to 12000 m",
};
const TIME: Limits = Limits {
    min: 1e-9,
    max: 30.0,
    expected: "a travel time above 0 and up to 30 s",
};
const BEARING: Limits = Limits {
    min: -360.0,
    max: 360.0,
    expected: "a bearing from -360 to 360 deg",
};
const DEPRESSION: Limits = Limits {
    min: -90.0,
    max: 90.0,
    expected: "a depression from -90 to 90 deg, positive below the transducer's x-y plane",
};
const BASELINE: Limits = Limits {
    min: 0.0,
    max: 180.0,
    expected: "an angle to a baseline from 0 to 180 deg",
};

/// How far a beacon is, by the device's own quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeKind {
    /// Metres, made with the device's own sound speed.
    Metres,
    /// Seconds, one way.
    OneWay,
    /// Seconds, both ways.
    TwoWay,
}

/// How its direction stands in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionKind {
    /// Within Cartesian coordinates.
    Cartesian,
    /// Bearing and depression.
    BearingDepression,
    /// Angles to the baselines.
    Baselines,
}

/// Columns of a fixes file.
#[derive(Clone, Debug, PartialEq)]
pub struct FixRecords {
    /// Time, seconds, ascending.
    pub time_s: Vec<f64>,
    /// Name of the beacon.
    pub beacon: Vec<String>,
    /// What [`Self::range`] is.
    pub range_kind: RangeKind,
    /// How directions stand in the file.
    pub direction_kind: DirectionKind,
    /// Metres or seconds.
    pub range: Vec<f64>,
    /// Unit direction in the transducer frame.
    pub direction: Vec<Vector3<f64>>,
    /// Line of each fix in its file, counted from 1; empty where there is no file.
    pub line: Vec<u64>,
    /// What was done to the fixes on reading, in words.
    pub notes: Vec<String>,
}

// READ

/// Reads a fixes file.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, columns missing, values impossible, times that descend.
pub fn read(path: &Path, invalid: Invalid) -> Result<FixRecords, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size, invalid)
}

/// Reads a fixes file of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
    invalid: Invalid,
) -> Result<FixRecords, FormatError> {
    let mut table = Table::open(file, source, size, &REQUIRED, &OPTIONAL)?;
    let (range_kind, direction_kind) = kinds(&table)?;
    let mut records = FixRecords {
        time_s: vec![],
        beacon: vec![],
        range_kind,
        direction_kind,
        range: vec![],
        direction: vec![],
        line: vec![],
        notes: vec![],
    };
    let left_out = table.each(Some(invalid), |table| {
        let beacon = table.text(1)?;
        if beacon.is_empty() {
            return Err(table.bad_value(1, "the name of a beacon"));
        }
        let (range, direction) = place(table, &records)?;
        let time_s = table.time(0, records.time_s.last().copied(), false)?;
        records.beacon.push(beacon.to_owned());
        records.time_s.push(time_s);
        records.range.push(range);
        records.direction.push(direction);
        records.line.push(table.line());
        Ok(())
    })?;
    records.notes.extend(left_out);
    Ok(records)
}

fn kinds<R: Read>(table: &Table<R>) -> Result<(RangeKind, DirectionKind), FormatError> {
    if (2..5).all(|column| table.has(column)) {
        return Ok((RangeKind::Metres, DirectionKind::Cartesian));
    }
    let ranges = [
        (5, RangeKind::Metres),
        (6, RangeKind::OneWay),
        (7, RangeKind::TwoWay),
    ];
    let range = ranges.into_iter().find(|(column, _)| table.has(*column));
    let range = range.ok_or_else(|| {
        table.missing(&[
            "x_m,y_m,z_m",
            "range_m",
            "travel_time_s",
            "two_way_travel_time_s",
        ])
    })?;
    if table.has(8) && table.has(9) {
        return Ok((range.1, DirectionKind::BearingDepression));
    }
    if table.has(10) && table.has(11) {
        return Ok((range.1, DirectionKind::Baselines));
    }
    Err(table.missing(&["bearing_deg,depression_deg", "x_angle_deg,y_angle_deg"]))
}

fn place<R: Read>(
    table: &Table<R>,
    records: &FixRecords,
) -> Result<(f64, Vector3<f64>), FormatError> {
    if records.direction_kind == DirectionKind::Cartesian {
        let number = |column| table.number(column, &PLACE);
        let place = Vector3::new(number(2)?, number(3)?, number(4)?);
        let range_m = place.norm();
        return if range_m > 0.0 {
            Ok((range_m, place / range_m))
        } else {
            Err(table.bad_value(2, "a place other than the transducer's own"))
        };
    }
    let range = match records.range_kind {
        RangeKind::Metres => table.number(5, &RANGE)?,
        RangeKind::OneWay => table.number(6, &TIME)?,
        RangeKind::TwoWay => table.number(7, &TIME)?,
    };
    let angle = |column, limits| table.number(column, limits).map(f64::to_radians);
    if records.direction_kind == DirectionKind::BearingDepression {
        let (bearing, depression) = (angle(8, &BEARING)?, angle(9, &DEPRESSION)?);
        let ((sb, cb), (sd, cd)) = (math::sin_cos(bearing), math::sin_cos(depression));
        return Ok((range, Vector3::new(cd * sb, cd * cb, -sd)));
    }
    let (u, v) = (
        math::cos(angle(10, &BASELINE)?),
        math::cos(angle(11, &BASELINE)?),
    );
    let rest = 1.0 - u * u - v * v;
    if rest < -1e-9 {
        let expected = "angles to two baselines at right angles: cos^2 x + cos^2 y at most 1";
        return Err(table.bad_value(10, expected));
    }
    Ok((range, Vector3::new(u, v, -rest.max(0.0).sqrt()).normalize()))
}

// WRITE

/// Writes a fixes file: lengths to 1 micrometre, times to 0.1 nanosecond, angles to 1e-8 deg.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, records: &FixRecords) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, records))
}

/// Writes a fixes file into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, records: &FixRecords) -> std::io::Result<()> {
    let range = match records.range_kind {
        RangeKind::Metres => OPTIONAL[3],
        RangeKind::OneWay => OPTIONAL[4],
        RangeKind::TwoWay => OPTIONAL[5],
    };
    match records.direction_kind {
        DirectionKind::Cartesian => writeln!(out, "time_s,beacon,x_m,y_m,z_m")?,
        DirectionKind::BearingDepression => {
            writeln!(out, "time_s,beacon,{range},bearing_deg,depression_deg")?;
        }
        DirectionKind::Baselines => writeln!(out, "time_s,beacon,{range},x_angle_deg,y_angle_deg")?,
    }
    for k in 0..records.time_s.len() {
        let (d, r) = (records.direction[k], records.range[k]);
        let decimals = if records.range_kind == RangeKind::Metres {
            6
        } else {
            10
        };
        write!(out, "{},{}", records.time_s[k], records.beacon[k])?;
        match records.direction_kind {
            DirectionKind::Cartesian => {
                writeln!(out, ",{:.6},{:.6},{:.6}", r * d.x, r * d.y, r * d.z)?;
            }
            DirectionKind::BearingDepression => {
                let (bearing, depression) = (
                    math::atan2(d.x, d.y),
                    math::atan2(-d.z, math::hypot(d.x, d.y)),
                );
                let (b, e) = (bearing.to_degrees(), depression.to_degrees());
                writeln!(out, ",{r:.decimals$},{b:.8},{e:.8}")?;
            }
            DirectionKind::Baselines => {
                let (a, b) = (math::acos(d.x).to_degrees(), math::acos(d.y).to_degrees());
                writeln!(out, ",{r:.decimals$},{a:.8},{b:.8}")?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(range_kind: RangeKind, direction_kind: DirectionKind) -> FixRecords {
        let direction = Vector3::new(0.3, -0.5, -0.8).normalize();
        FixRecords {
            time_s: vec![1.0, 1.5],
            beacon: vec!["B1".to_owned(), "B 2".to_owned()],
            range_kind,
            direction_kind,
            range: vec![0.0123, 7.5],
            direction: vec![direction, -Vector3::z()],
            line: vec![],
            notes: vec![],
        }
    }

    fn read_back(text: &[u8]) -> Result<FixRecords, FormatError> {
        read_from(
            Path::new("fixes.csv"),
            text,
            text.len() as u64,
            Invalid::Error,
        )
    }

    #[test]
    fn every_form_comes_back() {
        for direction in [
            DirectionKind::BearingDepression,
            DirectionKind::Baselines,
            DirectionKind::Cartesian,
        ] {
            for range in [RangeKind::Metres, RangeKind::OneWay, RangeKind::TwoWay] {
                if direction == DirectionKind::Cartesian && range != RangeKind::Metres {
                    continue;
                }
                let mut given = records(range, direction);
                if direction == DirectionKind::Cartesian {
                    given.range[0] = 12.3;
                }
                let mut text = vec![];
                write_to(&mut text, &given).expect("written");
                let found = read_back(&text).expect("read");
                assert_eq!((found.range_kind, found.direction_kind), (range, direction));
                assert_eq!(found.beacon, given.beacon);
                for k in 0..2 {
                    // 1 micrometre of 7.5 m, or 1e-8 deg
                    assert!((found.direction[k] - given.direction[k]).norm() < 3e-7);
                    assert!((found.range[k] - given.range[k]).abs() < 2e-6);
                }
            }
        }
    }

    /// By hand: bearing 90 degrees is to the right, depression 90 degrees straight down; the same by the baselines.
    #[test]
    fn the_angles_mean_what_the_convention_says() {
        let text = b"time_s,beacon,range_m,bearing_deg,depression_deg\n1,B,5,90,0\n2,B,5,0,30\n3,B,5,0,90\n";
        let found = read_back(text).expect("read").direction;
        assert!((found[0] - Vector3::x()).norm() < 1e-15);
        assert!((found[1] - Vector3::new(0.0, 0.75_f64.sqrt(), -0.5)).norm() < 1e-15);
        assert!((found[2] + Vector3::z()).norm() < 1e-15);
        let text = b"time_s,beacon,range_m,x_angle_deg,y_angle_deg\n1,B,5,90,60\n";
        let found = read_back(text).expect("read").direction;
        assert!((found[0] - Vector3::new(0.0, 0.5, -(0.75_f64.sqrt()))).norm() < 1e-15);
    }

    #[test]
    fn impossible_angles_are_named() {
        let text = b"time_s,beacon,range_m,x_angle_deg,y_angle_deg\n1,B,5,30,40\n";
        let message = read_back(text).expect_err("a fault").to_string();
        assert!(message.contains("line 2, column x_angle_deg"), "{message}");
        let text = b"time_s,beacon,range_m,bearing_deg\n1,B,5,30\n";
        let message = read_back(text).expect_err("a fault").to_string();
        assert!(message.contains("depression_deg"), "{message}");
    }
}
