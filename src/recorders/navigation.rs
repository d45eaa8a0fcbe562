//! One trajectory of the vessel's reference point from what a recorder has of attitude, positions and heave.

use nalgebra::Vector3;

use super::collect::{Recorded, most_frequent};
use crate::formats::recorder::{Installation, Position};
use crate::formats::records::TrajectoryRecords;
use crate::geometry::ellipsoid::{Geodetic, ecef_from_level};
use crate::geometry::{Ellipsoid, rotation};
use crate::observe::Trajectory;
use crate::stats::median;
use crate::units::wrap_angle;

/// Where the heights come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heights {
    /// Above the ellipsoid, from the positions.
    Ellipsoid,
    /// The heave above a water level of height zero; the tide is left to the lines.
    Heave,
}

/// How a trajectory is put together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Where the heights come from.
    pub heights: Heights,
    /// Longest interval of attitude that is bridged, seconds.
    pub max_gap_s: f64,
    /// Ellipsoid of the positions.
    pub ellipsoid: Ellipsoid,
    /// Whether [`Heights::Heave`] would do as well, for what is said where no position has a height.
    pub heave_serves: bool,
}

/// What navigation lacks, and what would supply it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lacking {
    /// What is missing.
    pub what: String,
    /// What would supply it.
    pub supplied_by: String,
}

fn lacking(what: &str, supplied_by: &str) -> Lacking {
    Lacking {
        what: what.to_owned(),
        supplied_by: supplied_by.to_owned(),
    }
}

/// A trajectory, and in words what was done to make it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Navigation {
    /// Poses of the reference point, one at each sample of attitude.
    pub records: TrajectoryRecords,
    /// The positions between which its own were interpolated.
    pub fixes: Option<Fixes>,
    /// What was done.
    pub notes: Vec<String>,
}

/// Positions of the reference point as they were recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixes {
    /// Seconds.
    pub time_s: Vec<f64>,
    /// Radians.
    pub latitude_rad: Vec<f64>,
    /// Radians.
    pub longitude_rad: Vec<f64>,
    /// Above the ellipsoid, metres; zeros where none is recorded.
    pub height_m: Vec<f64>,
    /// Whether the heights between them follow the heave, and have its noise as well.
    pub with_heave: bool,
}

/// Positions further apart than this do not carry the waves: the heave does, seconds.
const WAVES_S: f64 = 0.3;

/// Puts the trajectory together: attitude of the sensor in use, the position of the reference point at each of its samples.
///
/// # Errors
/// [`Lacking`] with everything that is missing.
pub fn navigation(recorded: &Recorded, wanted: &Wanted) -> Result<Navigation, Vec<Lacking>> {
    let missing = missing(recorded, wanted);
    if !missing.is_empty() {
        return Err(missing);
    }
    let attitude = recorded.attitude_over_time(wanted.max_gap_s);
    let mut notes = vec![];
    let track = Track::new(recorded, &attitude, wanted);
    if track.interval_s > WAVES_S {
        notes.push(format!(
            "positions {:.2} s apart are interpolated between; an SBET follows the boat more closely",
            track.interval_s
        ));
    }
    let heave = Heave::new(recorded);
    let by_heave = wanted.heights == Heights::Heave || track.interval_s > WAVES_S;
    if by_heave && heave.is_some() {
        notes.push("heights between positions follow the recorded heave".to_owned());
    }
    notes.extend(delays(recorded));
    let heave = heave.filter(|_| by_heave);
    let records = records(&attitude, &track, heave.as_ref(), wanted.heights);
    if records.is_empty() {
        let what = "positions at the times of the attitude";
        return Err(vec![lacking(what, "files of one recording")]);
    }
    let fixes = Some(track.fixes(heave.is_some()));
    Ok(Navigation {
        records,
        fixes,
        notes,
    })
}

fn missing(recorded: &Recorded, wanted: &Wanted) -> Vec<Lacking> {
    let other = "an SBET, a NovAtel log, POS MV groups or a CSV as [trajectory] path";
    let mut all = vec![];
    if recorded.attitude.is_empty() {
        all.push(lacking("attitude", other));
    } else if recorded.headings.is_empty()
        && recorded.attitude.iter().all(|a| a.heading_rad.is_none())
    {
        all.push(lacking("heading", other));
    }
    if recorded.positions.is_empty() {
        all.push(lacking("positions", other));
    } else if wanted.heights == Heights::Ellipsoid
        && recorded.positions.iter().all(|p| p.height_m.is_none())
    {
        let what = "heights above the ellipsoid (no position states one)";
        let by = "an SBET as [trajectory] path, or [trajectory] heights = \"heave\": heave above the water level, the tide under [tide] or in line_height_sigma_m";
        all.push(lacking(what, if wanted.heave_serves { by } else { other }));
    }
    if wanted.heights == Heights::Heave && recorded.attitude.iter().all(|a| a.heave_m.is_none()) {
        all.push(lacking("heave", "[trajectory] heights = \"ellipsoid\""));
    }
    all
}

/// Delays that the installation record states: not applied, for some recorders have done so.
fn delays(recorded: &Recorded) -> Vec<String> {
    let Some(installation) = recorded.installations.first() else {
        return vec![];
    };
    let sensors = [
        ("motion sensor", installation.motion_sensor()),
        ("position sensor", installation.position_sensor()),
    ];
    let said = |(what, sensor): &(&str, Option<&crate::formats::recorder::Mounted>)| {
        let delay_s = sensor.filter(|s| s.delay_s != 0.0)?.delay_s;
        Some(format!(
            "the installation record states a delay of {delay_s} s of the {what}; its times are taken as they stand, and a delay that the recorder has not applied shows as latency"
        ))
    };
    sensors.iter().filter_map(said).collect()
}

/// Positions of the reference point over time.
struct Track {
    time_s: Vec<f64>,
    places: Vec<Geodetic>,
    interval_s: f64,
    longest_s: f64,
}

impl Track {
    fn new(recorded: &Recorded, attitude: &Trajectory, wanted: &Wanted) -> Self {
        let mut positions = best(recorded, wanted.heights);
        positions.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        positions.dedup_by(|b, a| b.time_s == a.time_s);
        let (mut time_s, mut places) = (vec![], vec![]);
        for position in &positions {
            let arm_m = arm_m(recorded.installations.first(), position);
            let Some(place) = reference_point(position, &arm_m, attitude, wanted.ellipsoid) else {
                continue;
            };
            time_s.push(position.time_s);
            places.push(place);
        }
        unwrap_longitudes(&mut places);
        let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let interval_s = median(&mut steps).unwrap_or(0.0);
        Self {
            time_s,
            places,
            interval_s,
            longest_s: wanted.max_gap_s.max(2.5 * interval_s),
        }
    }

    fn fixes(&self, with_heave: bool) -> Fixes {
        let column = |of: fn(&Geodetic) -> f64| self.places.iter().map(of).collect();
        Fixes {
            time_s: self.time_s.clone(),
            latitude_rad: column(|place| place.latitude_rad),
            longitude_rad: column(|place| place.longitude_rad),
            height_m: column(|place| place.height_m),
            with_heave,
        }
    }

    /// Linear between two positions; `None` outside and in a gap.
    fn at(&self, time_s: f64) -> Option<Geodetic> {
        let after = self.time_s.partition_point(|t| *t < time_s);
        if self.time_s.get(after) == Some(&time_s) {
            return self.places.get(after).copied();
        }
        let before = after.checked_sub(1)?;
        let (begin_s, end_s) = (self.time_s[before], *self.time_s.get(after)?);
        let share = (time_s - begin_s) / (end_s - begin_s);
        let (a, b) = (&self.places[before], &self.places[after]);
        let between = |a: f64, b: f64| a + share * (b - a);
        (end_s - begin_s <= self.longest_s).then(|| Geodetic {
            latitude_rad: between(a.latitude_rad, b.latitude_rad),
            longitude_rad: between(a.longitude_rad, b.longitude_rad),
            height_m: between(a.height_m, b.height_m),
        })
    }
}

/// The positions of one sensor: of those with heights (where they are wanted) the sensor with the most, the reference point before any
/// other of as many.
fn best(recorded: &Recorded, heights: Heights) -> Vec<Position> {
    let fits = |p: &&Position| heights == Heights::Heave || p.height_m.is_some();
    let of = |at_reference: bool| -> Vec<Position> {
        let all = recorded.positions.iter().filter(fits);
        let all: Vec<&Position> = all.filter(|p| p.at_reference == at_reference).collect();
        let sensor = most_frequent(all.iter().map(|p| p.sensor));
        let own = all.into_iter().filter(|p| Some(p.sensor) == sensor);
        own.copied().collect()
    };
    let (at_reference, at_sensor) = (of(true), of(false));
    if at_sensor.len() > at_reference.len() {
        at_sensor
    } else {
        at_reference
    }
}

/// Moves a trajectory from a point of the body (right, forward, up of the reference point, metres) to the reference point.
#[must_use]
pub fn at_reference(
    mut records: TrajectoryRecords,
    arm_m: &Vector3<f64>,
    ellipsoid: Ellipsoid,
) -> TrajectoryRecords {
    if *arm_m == Vector3::zeros() {
        return records;
    }
    for k in 0..records.len() {
        let (roll, pitch, heading) = (
            records.roll_rad[k],
            records.pitch_rad[k],
            records.heading_rad[k],
        );
        let point = Geodetic {
            latitude_rad: records.latitude_rad[k],
            longitude_rad: records.longitude_rad[k],
            height_m: records.height_m[k],
        };
        let offset_m = rotation::from_attitude(roll, pitch, heading) * arm_m;
        let place = shifted(&point, &offset_m, ellipsoid);
        records.latitude_rad[k] = place.latitude_rad;
        records.longitude_rad[k] = place.longitude_rad;
        records.height_m[k] = place.height_m;
    }
    records
}

/// A place without an offset (east, north, up, metres).
fn shifted(point: &Geodetic, offset_m: &Vector3<f64>, ellipsoid: Ellipsoid) -> Geodetic {
    let mut place = ellipsoid.to_geocentric(point);
    place.coordinates -= ecef_from_level(point).matrix * offset_m;
    ellipsoid.to_geodetic(&place)
}

/// Where a position's sensor stands in the vessel's frame, metres.
fn arm_m(installation: Option<&Installation>, position: &Position) -> Vector3<f64> {
    let Some(installation) = installation.filter(|_| !position.at_reference) else {
        return Vector3::zeros();
    };
    let named = format!("P{}", position.sensor);
    let mut sensors = installation.position_sensors.iter();
    let sensor = if installation.attitude_is_turned {
        let own = sensors.find(|sensor| sensor.name == named);
        own.or_else(|| installation.position_sensor())
    } else {
        // what a raw motion sensor says of its place is the place of the motion sensor
        installation.motion_sensor()
    };
    sensor.map_or_else(Vector3::zeros, |sensor| sensor.mounting.lever_arm_m)
}

/// A sensor's position moved to the reference point; `None` without attitude at its time, where that is needed.
fn reference_point(
    position: &Position,
    arm_m: &Vector3<f64>,
    attitude: &Trajectory,
    ellipsoid: Ellipsoid,
) -> Option<Geodetic> {
    let sensor = Geodetic {
        latitude_rad: position.latitude_rad,
        longitude_rad: position.longitude_rad,
        height_m: position.height_m.unwrap_or(0.0),
    };
    if *arm_m == Vector3::zeros() {
        return Some(sensor);
    }
    let pose = attitude.pose_at(position.time_s).ok()?;
    Some(shifted(&sensor, &(pose.rotation * arm_m), ellipsoid))
}

fn unwrap_longitudes(places: &mut [Geodetic]) {
    for k in 1..places.len() {
        let before = places[k - 1].longitude_rad;
        places[k].longitude_rad = before + wrap_angle(places[k].longitude_rad - before);
    }
}

/// Heave of the reference point over time.
struct Heave(Vec<(f64, f64)>);

impl Heave {
    fn new(recorded: &Recorded) -> Option<Self> {
        let sensor = most_frequent(recorded.attitude.iter().map(|a| a.sensor))?;
        let of_sensor = recorded.attitude.iter().filter(|a| a.sensor == sensor);
        let mut samples: Vec<(f64, f64)> = of_sensor
            .filter_map(|a| Some((a.time_s, a.heave_m?)))
            .collect();
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        (!samples.is_empty()).then_some(Self(samples))
    }

    /// Linear, held at the ends.
    fn at(&self, time_s: f64) -> f64 {
        let after = self.0.partition_point(|sample| sample.0 < time_s);
        let last = self.0.len() - 1;
        let (before, after) = (after.saturating_sub(1), after.min(last));
        let ((begin_s, begin_m), (end_s, end_m)) = (self.0[before], self.0[after]);
        if end_s > begin_s && before < last {
            let share = ((time_s - begin_s) / (end_s - begin_s)).clamp(0.0, 1.0);
            begin_m + share * (end_m - begin_m)
        } else {
            begin_m
        }
    }
}

/// One record at each sample of attitude that has a position.
fn records(
    attitude: &Trajectory,
    track: &Track,
    heave: Option<&Heave>,
    heights: Heights,
) -> TrajectoryRecords {
    // heights at the positions without their heave: what is left is slow
    let slow = heave
        .filter(|_| heights == Heights::Ellipsoid)
        .map(|heave| {
            let calm = |(time_s, place): (&f64, &Geodetic)| Geodetic {
                height_m: place.height_m - heave.at(*time_s),
                ..*place
            };
            Track {
                time_s: track.time_s.clone(),
                places: track.time_s.iter().zip(&track.places).map(calm).collect(),
                ..*track
            }
        });
    let track = slow.as_ref().unwrap_or(track);
    let mut out = TrajectoryRecords::default();
    for (time_s, matrix) in attitude.times_s().iter().zip(attitude.attitudes()) {
        let Some(place) = track.at(*time_s) else {
            continue;
        };
        let lift_m = heave.map_or(0.0, |heave| heave.at(*time_s));
        let base_m = match heights {
            Heights::Ellipsoid => place.height_m,
            Heights::Heave => 0.0,
        };
        let (roll, pitch, heading) = rotation::to_attitude(matrix);
        out.time_s.push(*time_s);
        out.latitude_rad.push(place.latitude_rad);
        out.longitude_rad.push(place.longitude_rad);
        out.height_m.push(base_m + lift_m);
        out.roll_rad.push(roll);
        out.pitch_rad.push(pitch);
        out.heading_rad.push(heading);
    }
    out
}
