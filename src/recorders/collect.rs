//! All streams of a file in columns, for work that needs them together.

use nalgebra::{Matrix3, Vector3};

use crate::formats::recorder::{
    Attitude, Heading, Installation, Ping, Position, Profile, Sink, Solution, WaterHeight,
};
use crate::geometry::rotation;
use crate::observe::Trajectory;
use crate::units::wrap_angle;

/// What a file says, kept. Memory grows with the file.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// Installation records.
    pub installations: Vec<Installation>,
    /// Attitude of the sensor in use.
    pub attitude: Vec<Attitude>,
    /// Headings that came without roll and pitch.
    pub headings: Vec<Heading>,
    /// Positions of the sensor in use.
    pub positions: Vec<Position>,
    /// Heights of the water level.
    pub water_heights: Vec<WaterHeight>,
    /// Sound-speed profiles.
    pub profiles: Vec<Profile>,
    /// Pings.
    pub pings: Vec<Ping>,
    /// The sounder's own solutions.
    pub solutions: Vec<Solution>,
}

impl Sink for Recorded {
    fn installation(&mut self, record: &Installation) {
        self.installations.push(record.clone());
    }
    fn attitude(&mut self, record: &Attitude) {
        if !record.passive {
            self.attitude.push(*record);
        }
    }
    fn heading(&mut self, record: &Heading) {
        self.headings.push(*record);
    }
    fn position(&mut self, record: &Position) {
        if !record.passive {
            self.positions.push(*record);
        }
    }
    fn water_height(&mut self, record: &WaterHeight) {
        self.water_heights.push(*record);
    }
    fn profile(&mut self, record: &Profile) {
        self.profiles.push(record.clone());
    }
    fn ping(&mut self, record: &Ping) {
        self.pings.push(record.clone());
    }
    fn solution(&mut self, record: &Solution) {
        self.solutions.push(record.clone());
    }
}

impl Recorded {
    /// Attitude over time, at the place of the sensor: no positions in it. Gaps of more than `max_gap_s` are not bridged.
    ///
    /// Records out of order are sorted; of two at one time the first is kept. Where the file's attitude has no heading it is
    /// interpolated among the headings that came alone, else that of the record before is held. Attitude that is still the sensor's own
    /// is turned by the sensor's mounting. Of several sensors that are all in use, the one with the most records is taken.
    #[must_use]
    pub fn attitude_over_time(&self, max_gap_s: f64) -> Trajectory {
        let sensor = most_frequent(self.attitude.iter().map(|a| a.sensor));
        let of_sensor = self.attitude.iter().filter(|a| Some(a.sensor) == sensor);
        let mut samples: Vec<Attitude> = of_sensor.copied().collect();
        samples.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        samples.dedup_by(|b, a| b.time_s == a.time_s);
        let headings = unwrapped(&self.headings);
        let mut held_rad = 0.0;
        let sensor_from_body = self.sensor_from_body();
        let mut turned = |a: &Attitude| {
            let known = a.heading_rad.or_else(|| interpolated(&headings, a.time_s));
            held_rad = known.unwrap_or(held_rad);
            rotation::from_attitude(a.roll_rad, a.pitch_rad, held_rad) * sensor_from_body
        };
        let matrices = samples.iter().map(&mut turned).collect();
        let time_s: Vec<f64> = samples.iter().map(|a| a.time_s).collect();
        let nowhere = vec![Vector3::zeros(); time_s.len()];
        Trajectory::new(time_s, nowhere, matrices, None, max_gap_s)
    }

    /// The sound-speed profiles of at least two depths in order of time, each once.
    #[must_use]
    pub fn casts(&self) -> Vec<&Profile> {
        let usable = |p: &&Profile| p.depth_m.len() >= 2;
        let mut all: Vec<&Profile> = self.profiles.iter().filter(usable).collect();
        all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        all.dedup_by(|b, a| a.depth_m == b.depth_m && a.speed_m_s == b.speed_m_s);
        all
    }

    /// The motion sensor's mounting, turned round, where the recorded attitude is the sensor's own.
    fn sensor_from_body(&self) -> Matrix3<f64> {
        let raw = self.installations.iter().find(|i| !i.attitude_is_turned);
        let sensor = raw.and_then(Installation::motion_sensor);
        sensor.map_or_else(Matrix3::identity, |s| s.mounting.rotation.transpose())
    }
}

/// The number that occurs most often, the smallest of equals.
pub(super) fn most_frequent(numbers: impl Iterator<Item = u8>) -> Option<u8> {
    let mut counts = [0usize; 256];
    for number in numbers {
        counts[usize::from(number)] += 1;
    }
    let most = counts.iter().max().filter(|c| **c > 0)?;
    counts.iter().position(|c| c == most).map(|k| k as u8)
}

/// Headings in order of time without jumps of a full turn.
fn unwrapped(headings: &[Heading]) -> Vec<Heading> {
    let mut sorted = headings.to_vec();
    sorted.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    for k in 1..sorted.len() {
        let before = sorted[k - 1].heading_rad;
        sorted[k].heading_rad = before + wrap_angle(sorted[k].heading_rad - before);
    }
    sorted
}

/// Linear between two headings, the nearest outside; `None` without any.
fn interpolated(headings: &[Heading], time_s: f64) -> Option<f64> {
    let after = headings.partition_point(|h| h.time_s < time_s);
    let (first, last) = (headings.first()?, headings.last()?);
    if after == 0 || after == headings.len() {
        let nearest = if after == 0 { first } else { last };
        return Some(nearest.heading_rad);
    }
    let (a, b) = (headings[after - 1], headings[after]);
    let share = (time_s - a.time_s) / (b.time_s - a.time_s);
    Some(a.heading_rad + share * (b.heading_rad - a.heading_rad))
}
