//! All streams of a file in columns, for work that needs them together.

use nalgebra::{Matrix3, Vector3};

use crate::formats::recorder::{
    Attitude, Installation, Ping, Position, Profile, Sink, Solution, WaterHeight,
};
use crate::geometry::rotation;
use crate::observe::Trajectory;

/// What a file says, kept. Memory grows with the file.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// Installation records.
    pub installations: Vec<Installation>,
    /// Attitude of the sensor in use.
    pub attitude: Vec<Attitude>,
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
    /// Records out of order are sorted; of two at one time the first is kept. Where the file's attitude has no heading, that of the
    /// record before is held. Attitude that is still the sensor's own is turned by the sensor's mounting.
    #[must_use]
    pub fn attitude_over_time(&self, max_gap_s: f64) -> Trajectory {
        let mut samples = self.attitude.clone();
        samples.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        samples.dedup_by(|b, a| b.time_s == a.time_s);
        let mut heading_rad = 0.0;
        let sensor_from_body = self.sensor_from_body();
        let mut turned = |a: &Attitude| {
            heading_rad = a.heading_rad.unwrap_or(heading_rad);
            rotation::from_attitude(a.roll_rad, a.pitch_rad, heading_rad) * sensor_from_body
        };
        let matrices = samples.iter().map(&mut turned).collect();
        let time_s: Vec<f64> = samples.iter().map(|a| a.time_s).collect();
        let nowhere = vec![Vector3::zeros(); time_s.len()];
        Trajectory::new(time_s, nowhere, matrices, None, max_gap_s)
    }

    /// The motion sensor's mounting, turned round, where the recorded attitude is the sensor's own.
    fn sensor_from_body(&self) -> Matrix3<f64> {
        let raw = self.installations.iter().find(|i| !i.attitude_is_turned);
        let sensor = raw.and_then(Installation::motion_sensor);
        sensor.map_or_else(Matrix3::identity, |s| s.mounting.rotation.transpose())
    }
}
