//! Checks of observations that need more than their own file: frames, clocks, gaps.

use std::ops::Range;
use std::path::Path;

use super::file::{CoordinatesName, SurveyFile};
use crate::formats::{LaserRecords, SoundingRecords, TrajectoryRecords};
use crate::geometry::utm::{Utm, UtmError};
use crate::geometry::{Ellipsoid, Geodetic};
use crate::math;
use crate::observe::{GeodeticTrajectory, Room, SoundingFile, SoundingRange};
use crate::survey::clock::{Times, Verdict, judge};
use crate::survey::problem::Problem;
use crate::units::degrees;

/// Greatest distance from the scanner or from the target that a return can have, metres.
const FARTHEST_M: f64 = 20_000.0;
/// Geocentric distances on and near the earth's surface, metres.
const EARTH_M: std::ops::RangeInclusive<f64> = 6.3e6..=6.5e6;

/// Adds a clock offset to a column.
pub(super) fn shift(time_s: &mut [f64], offset_s: f64) {
    if offset_s != 0.0 {
        for t in time_s {
            *t += offset_s;
        }
    }
}

/// The trajectory as a whole: enough records, and latitudes that are not radians by mistake.
pub(super) fn trajectory_problem(
    file: &Path,
    records: &TrajectoryRecords,
    survey: &SurveyFile,
) -> Option<Problem> {
    if records.len() < 2 {
        let found = format!("{} record", records.len());
        return Some(Problem::new(
            file,
            "whole file",
            found,
            "at least two records",
        ));
    }
    let origin = survey.target.pose().origin;
    let (latitude, longitude) = (records.latitude_rad[0], records.longitude_rad[0]);
    let away = |a: f64, b: f64| (a - b).abs().to_degrees();
    let far = away(latitude, origin.latitude_rad) > 1.0;
    let in_file = (degrees(latitude), degrees(longitude));
    let near_as_radians =
        away(in_file.0, origin.latitude_rad) < 0.5 && away(in_file.1, origin.longitude_rad) < 0.5;
    (far && near_as_radians).then(|| {
        let found = format!("{}, {}, which are radians", in_file.0, in_file.1);
        Problem::new(
            file,
            "first record, latitude and longitude",
            found,
            "degrees",
        )
    })
}

/// The first return that cannot be in the frame that the survey file names.
pub(super) fn laser_problem(
    file: &Path,
    records: &LaserRecords,
    frame: CoordinatesName,
) -> Option<Problem> {
    let fits = |k: usize| {
        let (x, y, z) = (records.x_m[k], records.y_m[k], records.z_m[k]);
        let distance_m = math::hypot(math::hypot(x, y), z);
        match frame {
            CoordinatesName::Sensor => distance_m > 0.0 && distance_m <= FARTHEST_M,
            CoordinatesName::Target => distance_m <= FARTHEST_M,
            CoordinatesName::Geocentric => EARTH_M.contains(&distance_m),
            CoordinatesName::Utm => {
                (1e5..=9e5).contains(&x) && (0.0..=1e7).contains(&y) && z.abs() <= 12_000.0
            }
        }
    };
    let k = (0..records.len()).find(|&k| !fits(k))?;
    let expected = match frame {
        CoordinatesName::Sensor => "a range above 0 m and up to 20000 m (coordinates = \"sensor\")",
        CoordinatesName::Target => "a point within 20000 m of the target's origin",
        CoordinatesName::Geocentric => "6300 to 6500 km from the earth's centre",
        CoordinatesName::Utm => {
            "an easting of 100000 to 900000 m, a northing of 0 to 10000000 m, a height within 12000 m"
        }
    };
    let found = format!(
        "x, y, z = {}, {}, {}",
        records.x_m[k], records.y_m[k], records.z_m[k]
    );
    Some(Problem::new(
        file,
        format!("return {}", k + 1),
        found,
        expected,
    ))
}

/// UTM coordinates of returns become geocentric ones, in place.
pub(super) fn to_geocentric(
    file: &Path,
    records: &mut LaserRecords,
    ellipsoid: Ellipsoid,
    zone: i8,
) -> Result<(), Problem> {
    let (x_m, y_m, z_m) = (&mut records.x_m, &mut records.y_m, &mut records.z_m);
    Utm::new(ellipsoid, zone)
        .and_then(|utm| utm.to_geodetic_in_place(x_m, y_m))
        .map_err(|error| no_place(file, &error))?;
    for ((x, y), z) in x_m.iter_mut().zip(y_m.iter_mut()).zip(z_m) {
        let place = Geodetic {
            latitude_rad: *y,
            longitude_rad: *x,
            height_m: *z,
        };
        let point = ellipsoid.to_geocentric(&place).coordinates;
        (*x, *y, *z) = (point.x, point.y, point.z);
    }
    Ok(())
}

fn no_place(file: &Path, error: &UtmError) -> Problem {
    let place = match error {
        UtmError::Outside { row, .. } => format!("return {}", row + 1),
        UtmError::Zone { .. } => "whole file".to_owned(),
    };
    Problem::new(
        file,
        place,
        error.to_string(),
        "UTM coordinates of this zone",
    )
}

/// Judges the returns' times, and drops those without a position if that is wanted; their number.
pub(super) fn place_laser(
    file: &Path,
    records: &mut LaserRecords,
    trajectory: &GeodeticTrajectory,
) -> Result<usize, Problem> {
    let rows = lost_rows(file, &records.time_s[..], trajectory)?;
    for column in [
        &mut records.time_s,
        &mut records.x_m,
        &mut records.y_m,
        &mut records.z_m,
    ] {
        remove(column, &rows);
    }
    Ok(count(&rows))
}

/// As [`place_laser`], for soundings.
pub(super) fn place_soundings(
    file: &Path,
    records: &mut SoundingRecords,
    trajectory: &GeodeticTrajectory,
) -> Result<usize, Problem> {
    let rows = lost_rows(file, &records.time_s[..], trajectory)?;
    let (SoundingRange::Metres(range) | SoundingRange::TwoWayTravelTime(range)) =
        &mut records.range;
    for column in [
        &mut records.time_s,
        &mut records.across_rad,
        &mut records.along_rad,
        range,
    ] {
        remove(column, &rows);
    }
    remove(&mut records.ping, &rows);
    remove(&mut records.beam, &rows);
    remove(&mut records.head, &rows);
    if let Some(arrays) = &mut records.arrays {
        remove(&mut arrays.delay_s, &rows);
        remove(&mut arrays.head_speed_m_s, &rows);
    }
    Ok(count(&rows))
}

/// Soundings of two arrays become those of their transmission: the delay of each goes into its time, and they are put in order again.
pub(super) fn to_transmission(records: &mut SoundingRecords) {
    let Some(arrays) = &mut records.arrays else {
        return;
    };
    for (time_s, delay_s) in records.time_s.iter_mut().zip(&mut arrays.delay_s) {
        *time_s += std::mem::take(delay_s);
    }
    if records.time_s.is_sorted() {
        return;
    }
    let mut order: Vec<usize> = (0..records.time_s.len()).collect();
    order.sort_by(|a, b| records.time_s[*a].total_cmp(&records.time_s[*b]));
    *records = records.rows(&order);
}

/// The soundings of one head.
pub(super) fn of_head(records: &SoundingRecords, head: u32) -> SoundingRecords {
    let own = |k: &usize| records.head[*k] == head;
    let rows: Vec<usize> = (0..records.head.len()).filter(own).collect();
    records.rows(&rows)
}

/// As [`place_laser`], for soundings in a file without name.
pub(super) fn place_streamed(
    file: &Path,
    streamed: &mut SoundingFile,
    trajectory: &GeodeticTrajectory,
    room: &Room,
) -> Result<usize, Problem> {
    let rows = lost_rows(file, streamed, trajectory)?;
    if !rows.is_empty() {
        let kept = streamed.without(&rows, room);
        *streamed = kept.map_err(|e| no_room(Path::new(&e.folder), &e.refused()))?;
    }
    Ok(count(&rows))
}

/// Why soundings could not be kept in a file.
pub(super) fn no_room(folder: &Path, found: &str) -> Problem {
    Problem::new(
        folder,
        "folder for what exceeds memory",
        found,
        "room for the soundings; free space there, name another folder as [large] spill, or raise [large] observations_memory_mb",
    )
}

fn count(rows: &[Range<usize>]) -> usize {
    rows.iter().map(Range::len).sum()
}

fn lost_rows<T: Times + ?Sized>(
    file: &Path,
    times: &T,
    trajectory: &GeodeticTrajectory,
) -> Result<Vec<Range<usize>>, Problem> {
    let (max_gap_s, outside) = (trajectory.max_gap_s, trajectory.outside);
    match judge(&trajectory.time_s, max_gap_s, outside, times) {
        Verdict::Keep => Ok(vec![]),
        Verdict::Drop(rows) => Ok(rows),
        Verdict::Refuse { found, expected } => Err(Problem::new(file, "times", found, expected)),
    }
}

/// Removes rows (ascending ranges) from a column.
fn remove<T>(column: &mut Vec<T>, rows: &[Range<usize>]) {
    if rows.is_empty() {
        return;
    }
    let (mut row, mut run) = (0, 0);
    column.retain(|_| {
        run += usize::from(rows.get(run).is_some_and(|r| r.end <= row));
        let hit = rows.get(run).is_some_and(|r| r.contains(&row));
        row += 1;
        !hit
    });
    column.shrink_to_fit();
}
