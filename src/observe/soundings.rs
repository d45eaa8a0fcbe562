//! Soundings of a multibeam echo sounder: one row per beam of each ping.

use super::{ArrayMountings, Mounting};

/// What a sounding measured along its beam.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundingRange {
    /// Slant range, metres.
    Metres(Vec<f64>),
    /// Two-way travel time, seconds; needs a sound speed.
    TwoWayTravelTime(Vec<f64>),
}

impl SoundingRange {
    /// The column, whatever its unit.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Metres(values) | Self::TwoWayTravelTime(values) => values,
        }
    }
}

/// A-priori noise of the soundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarNoise {
    /// Range, metres, one sigma.
    pub range_m: f64,
    /// Across-track beam angle, radians, one sigma.
    pub across_rad: f64,
    /// Along-track beam angle, radians, one sigma.
    pub along_rad: f64,
}

/// What soundings of a transmit and a receive array have besides: each is sent at one moment and heard at another.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundingArrays {
    /// Nominal mountings of the two arrays.
    pub mountings: ArrayMountings,
    /// The one nominal mounting that stands for both: as it is corrected, both are.
    pub nominal: Mounting,
    /// Sound speed at the head that the beam former used for each sounding, metres per second; 0 where it is the water's.
    pub head_speed_m_s: Vec<f32>,
}

/// Soundings in columns of equal length, in order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Soundings {
    /// Time of the ping (of two arrays: of this sounding's transmission) on the trajectory's clock, seconds, not descending.
    pub time_s: Vec<f64>,
    /// Ping number.
    pub ping: Vec<u32>,
    /// Beam number within the ping.
    pub beam: Vec<u32>,
    /// Across-track angle (of two arrays: against the receive array), radians, positive to starboard.
    pub across_rad: Vec<f64>,
    /// Along-track angle (of two arrays: tilt of the transmitted cone), radians, elevation out of the across plane, positive forward.
    pub along_rad: Vec<f64>,
    /// Ranges or travel times.
    pub range: SoundingRange,
    /// A-priori noise.
    pub noise: SonarNoise,
    /// Where a transmit and a receive array stand each on its own; always with travel times.
    pub arrays: Option<SoundingArrays>,
}

impl Soundings {
    /// Number of soundings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sounding.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }
}
