//! What an ultra-short baseline calibration observes: surveyed beacons and transducer, acoustic fixes, attitude.
//!
//! Frames: the *level* frame is east, north, up at the surveyed transducer; the transducer's own frame u is x right, y forward,
//! z up; the attitude sensor's body b likewise.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::math;
use crate::observe::{SoundSpeed, Trajectory};

/// A point that the total station surveyed.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlPoint {
    /// Name as in the control file.
    pub name: String,
    /// Position in the level frame, metres.
    pub position_m: Vector3<f64>,
    /// Covariance of the position, square metres.
    pub covariance_m2: Matrix3<f64>,
}

/// What a beacon is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It enters the calibration.
    Common,
    /// It only checks the result and never enters.
    Check,
}

/// A beacon on the bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Beacon {
    /// Where it stands.
    pub point: ControlPoint,
    /// What it is used for.
    pub role: Role,
}

/// How the noise of a fix's direction depends on the direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AngleModel {
    /// The phase differences along x and y have constant noise, so the direction cosines have: the angle's standard deviation
    /// grows as one over the sine of the angle to the baseline.
    #[default]
    DirectionCosine,
    /// The same noise at right angles to the line of sight in every direction.
    Isotropic,
}

/// A-priori noise of the fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixNoise {
    /// Constant part of the range noise, metres.
    pub range_m: f64,
    /// Part of the range noise proportional to the range (1e-6 is one part per million).
    pub range_relative: f64,
    /// Noise of each angle at broadside, radians.
    pub angle_rad: f64,
    /// How it depends on the direction.
    pub model: AngleModel,
}

impl FixNoise {
    /// Standard deviation of a range, metres.
    #[must_use]
    pub fn range_at(&self, range_m: f64) -> f64 {
        math::hypot(self.range_m, self.range_relative * range_m)
    }

    /// The two vectors in the transducer frame along which the direction was measured: a component of the unit direction along
    /// each has the noise [`Self::angle_rad`], independent of the other and of the range.
    #[must_use]
    pub fn axes(&self, direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
        match self.model {
            AngleModel::DirectionCosine => [Vector3::x(), Vector3::y()],
            AngleModel::Isotropic => {
                let first = Vector3::ith_axis(direction.iamin())
                    .cross(direction)
                    .normalize();
                [first, direction.cross(&first)]
            }
        }
    }
}

/// Acoustic fixes in columns of equal length, ascending in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixes {
    /// Time, seconds.
    pub time_s: Vec<f64>,
    /// Index into the campaign's beacons.
    pub beacon: Vec<u32>,
    /// One-way travel time, seconds.
    pub travel_time_s: Vec<f64>,
    /// Direction of arrival: unit vector from the transducer to where the beacon seems to be, transducer frame.
    pub direction: Vec<Vector3<f64>>,
    /// Sound speed that expresses travel times as ranges, metres per second.
    pub speed_m_s: f64,
    /// A-priori noise.
    pub noise: FixNoise,
}

impl Fixes {
    /// Number of fixes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Fixes of one beacon.
    #[must_use]
    pub fn of_beacon(&self, beacon: u32) -> usize {
        self.beacon.iter().filter(|b| **b == beacon).count()
    }
}

/// Noise of the attitude sensor: white per record, or wandering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeNoise {
    /// Roll and pitch, radians.
    pub roll_pitch_rad: f64,
    /// Heading, radians.
    pub heading_rad: f64,
    /// Time after which two errors have forgotten each other (Gauss-Markov), seconds; 0 for white noise.
    pub correlation_time_s: f64,
}

/// What nothing in the data can tell from the mounting: a constant turn between the attitude sensor's level frame and the
/// total station's (deflection of the vertical, orientation of the control, constant error of the sensor).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DatumSigma {
    /// About east and north, radians each.
    pub tilt_rad: f64,
    /// About the vertical, radians.
    pub azimuth_rad: f64,
}

/// Everything that a calibration is made from.
#[derive(Clone, Debug)]
pub struct UsblCampaign {
    /// The transducer's centre as surveyed: the origin of the level frame.
    pub transducer: ControlPoint,
    /// The beacons.
    pub beacons: Vec<Beacon>,
    /// The fixes.
    pub fixes: Fixes,
    /// The attitude sensor's record; its positions are zero.
    pub attitude: Trajectory,
    /// Noise of the attitude.
    pub attitude_noise: AttitudeNoise,
    /// Nominal rotation from the transducer frame into the body, `R_u^b`.
    pub nominal: Matrix3<f64>,
    /// The water.
    pub sound_speed: SoundSpeed,
    /// Relative standard deviation of the sound speed (true range = measured x (1 + scale)); 0 where it is taken as exact.
    pub sound_speed_relative: f64,
    /// Depth of the surveyed transducer below the water level, metres.
    pub transducer_depth_m: f64,
    /// Constant turn between the two level frames.
    pub datum: DatumSigma,
}
