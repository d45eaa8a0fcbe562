//! Our georeferencing with the installation values against the sounder's own points: a check of every sign on the way.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::collect::{Recorded, most_frequent};
use crate::formats::FormatError;
use crate::formats::recorder::{
    Array, BeamSample, Installation, Origin, Ping, Position, Solution, table,
};
use crate::georef::rays::Layers;
use crate::georef::two_arrays::ArrayPair;
use crate::math;
use crate::observe::{Mounting, SoundSpeedProfile, Trajectory};
use crate::units::wrap_angle;

/// Longest interval of attitude that is bridged, seconds.
const MAX_GAP_S: f64 = 1.0;

/// What may be chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choice {
    /// Add the offsets of the elements within a head to its place; they made the one real file at hand worse.
    pub inner_offsets: bool,
    /// Leave out the way that the boat makes while the sound is in the water.
    pub standing: bool,
}

/// How well the two agree; right, forward, up in the level frame turned to the solution's heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Pings compared.
    pub pings: usize,
    /// Beams compared.
    pub beams: usize,
    /// Beams without attitude at both their times, without a ray or without a direction.
    pub left_out: usize,
    /// Mean of ours minus the sounder's, metres.
    pub mean_m: Vector3<f64>,
    /// Root mean square of ours minus the sounder's, metres.
    pub rms_m: Vector3<f64>,
    /// Mean depth of the sounder's points below where they are counted from, metres.
    pub depth_m: f64,
}

/// Sums of differences.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: usize,
    sum: Vector3<f64>,
    squares: Vector3<f64>,
    depth_m: f64,
}

impl Sums {
    fn add(&mut self, difference: &Vector3<f64>, depth_m: f64) {
        self.count += 1;
        self.depth_m += depth_m;
        self.sum += difference;
        self.squares += difference.component_mul(difference);
    }
}

/// Reads a file and georeferences every beam that both sides hold valid. `None` when the file lacks what that needs.
///
/// # Errors
/// [`FormatError`] when it cannot be read or no reader knows it.
pub fn of_file(path: &Path, choice: Choice) -> Result<Option<Agreement>, FormatError> {
    let mut recorded = Recorded::default();
    table::read(path, &mut recorded)?;
    Ok(against_own_solution(&recorded, choice))
}

/// Georeferences every beam that both sides hold valid, and compares. `None` when the file lacks what that needs:
/// an installation record, attitude, a sound-speed profile, pings and solutions.
#[must_use]
pub fn against_own_solution(recorded: &Recorded, choice: Choice) -> Option<Agreement> {
    let profile = recorded.profiles.first()?;
    let profile = SoundSpeedProfile {
        depth_m: profile.depth_m.clone(),
        speed_m_s: profile.speed_m_s.clone(),
    };
    let scene = Scene {
        installation: recorded.installations.first()?,
        attitude: recorded.attitude_over_time(MAX_GAP_S),
        water: Layers::new(&profile).ok()?,
        way: Way::new(if choice.standing {
            &[]
        } else {
            &recorded.positions
        }),
        choice,
    };
    let key = |number, head, time_s: f64| (number, head, (1e3 * time_s).round() as i64);
    let own: HashMap<_, &Solution> = recorded
        .solutions
        .iter()
        .map(|s| (key(s.number, s.head, s.time_s), s))
        .collect();
    let (mut sums, mut found) = (Sums::default(), Agreement::default());
    for ping in &recorded.pings {
        let Some(own) = own.get(&key(ping.number, ping.head, ping.time_s)) else {
            continue;
        };
        found.pings += usize::from(scene.compare(ping, own, &mut sums, &mut found.left_out));
    }
    let n = (sums.count > 0).then_some(sums.count as f64)?;
    found.beams = sums.count;
    found.depth_m = sums.depth_m / n;
    found.mean_m = sums.sum / n;
    found.rms_m = (sums.squares / n).map(f64::sqrt);
    Some(found)
}

/// What stays the same from ping to ping.
struct Scene<'r> {
    installation: &'r Installation,
    attitude: Trajectory,
    water: Layers,
    way: Way,
    choice: Choice,
}

/// Way of the boat over ground between two moments, from its positions.
struct Way {
    time_s: Vec<f64>,
    east_north_m: Vec<Vector3<f64>>,
}

/// Positions at least so far to either side give the speed, seconds.
const SPEED_OVER_S: f64 = 0.5;
/// Mean radius of the earth, metres.
const EARTH_M: f64 = 6_371_000.0;

impl Way {
    fn new(positions: &[Position]) -> Self {
        let sensor = most_frequent(positions.iter().map(|p| p.sensor));
        let mut own: Vec<&Position> = positions
            .iter()
            .filter(|p| Some(p.sensor) == sensor)
            .collect();
        own.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let first = own.first().copied().copied().unwrap_or_default();
        let place = |p: &&Position| {
            let east =
                wrap_angle(p.longitude_rad - first.longitude_rad) * math::cos(first.latitude_rad);
            Vector3::new(east, p.latitude_rad - first.latitude_rad, 0.0) * EARTH_M
        };
        Self {
            time_s: own.iter().map(|p| p.time_s).collect(),
            east_north_m: own.iter().map(place).collect(),
        }
    }

    /// From `begin_s` to `end_s`, east, north, metres; nothing where the speed is not known.
    fn of(&self, begin_s: f64, end_s: f64) -> Vector3<f64> {
        let before = self
            .time_s
            .partition_point(|t| *t <= begin_s - SPEED_OVER_S);
        let after = self.time_s.partition_point(|t| *t < begin_s + SPEED_OVER_S);
        let before = before.saturating_sub(1);
        let after = after.min(self.time_s.len().saturating_sub(1));
        let (Some(from_s), Some(to_s)) = (self.time_s.get(before), self.time_s.get(after)) else {
            return Vector3::zeros();
        };
        let apart_m = self.east_north_m[after] - self.east_north_m[before];
        if to_s - from_s < SPEED_OVER_S || to_s - from_s > 10.0 {
            return Vector3::zeros();
        }
        apart_m * ((end_s - begin_s) / (to_s - from_s))
    }
}

/// The arrays of a ping and where its solution is counted from.
struct Arrays {
    transmitter: Mounting,
    receiver: Mounting,
}

impl Scene<'_> {
    /// Compares one ping; whether any of its beams could be.
    fn compare(&self, ping: &Ping, own: &Solution, sums: &mut Sums, left_out: &mut usize) -> bool {
        let before = sums.count;
        let Some(arrays) = self.arrays(ping.head) else {
            return false;
        };
        for (beam, point) in ping.beams.iter().zip(&own.points) {
            // three zeros were never written: no sounding strikes the reference point
            let written = point.right_forward_up_m != Vector3::zeros();
            if !(beam.valid && point.valid && written) {
                continue;
            }
            match self.point(ping, own, &arrays, beam) {
                Some(ours) => {
                    let own = point.right_forward_up_m;
                    sums.add(&(ours - own), -own.z);
                }
                None => *left_out += 1,
            }
        }
        sums.count > before
    }

    fn arrays(&self, head: u32) -> Option<Arrays> {
        let place = |array: &Array, part: usize| {
            let Mounting {
                rotation,
                lever_arm_m,
            } = array.mounted.mounting;
            let inner_m = rotation * array.inner_m[part];
            let wanted = if self.choice.inner_offsets { 1.0 } else { 0.0 };
            Mounting {
                rotation,
                lever_arm_m: lever_arm_m + inner_m * wanted,
            }
        };
        Some(Arrays {
            transmitter: place(self.installation.transmitter(head)?, 0),
            receiver: place(self.installation.receiver(head)?, 1),
        })
    }

    /// Our point of a beam in the axes of the solution.
    fn point(
        &self,
        ping: &Ping,
        own: &Solution,
        arrays: &Arrays,
        beam: &BeamSample,
    ) -> Option<Vector3<f64>> {
        let sector = ping.sectors.get(usize::from(beam.sector))?;
        let sent_s = ping.time_s + sector.delay_s;
        let at_transmission = self.attitude.pose_at(sent_s).ok()?.rotation;
        let at_reception = self
            .attitude
            .pose_at(sent_s + beam.two_way_s)
            .ok()?
            .rotation;
        let pair = ArrayPair {
            attitude_at_transmission: at_transmission,
            attitude_at_reception: at_reception,
            transmitter: arrays.transmitter.rotation,
            receiver: arrays.receiver.rotation,
        };
        let way_m = |time_s: f64| self.way.of(ping.time_s, time_s);
        let sender_m = at_transmission * arrays.transmitter.lever_arm_m + way_m(sent_s);
        let listener_m =
            at_reception * arrays.receiver.lever_arm_m + way_m(sent_s + beam.two_way_s);
        let range_m = 0.5 * beam.two_way_s * ping.head_speed_m_s;
        let angles = (sector.tilt_rad, beam.angle_rad);
        let direction = pair.from_between(angles, &(listener_m - sender_m), range_m)?;
        let depth_m = own.array_depth_m.max(0.0);
        let launch = (direction, ping.head_speed_m_s);
        let chord = self
            .water
            .chord(depth_m, launch, 0.5 * beam.two_way_s)
            .ok()?;
        let from_reference = (sender_m + listener_m) * 0.5 + chord;
        let at_ping = self.attitude.pose_at(ping.time_s).ok()?.rotation;
        let begin_m = self.begin(own.origin, &at_ping, &sender_m);
        Some(turned(own.heading_rad) * (from_reference - begin_m))
    }

    /// Where the solution is counted from, seen from the reference point in the level frame, metres.
    fn begin(
        &self,
        origin: Origin,
        at_ping: &Matrix3<f64>,
        sender_m: &Vector3<f64>,
    ) -> Vector3<f64> {
        match origin {
            Origin::ReferencePoint => Vector3::zeros(),
            Origin::PositionSensorAndArray => {
                let sensor = self.installation.position_sensor();
                let arm_m = sensor.map_or(Vector3::zeros(), |s| s.mounting.lever_arm_m);
                let sensor_m = at_ping * arm_m;
                Vector3::new(sensor_m.x, sensor_m.y, sender_m.z)
            }
        }
    }
}

/// East, north, up into right, forward, up of a heading.
fn turned(heading_rad: f64) -> Matrix3<f64> {
    let (sin, cos) = math::sin_cos(heading_rad);
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}
