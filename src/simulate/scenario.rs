//! What a scenario file says: a survey file's keys plus what only a simulator needs to know.
//!
//! Angles in degrees, lengths in metres, times in seconds; angles of mountings and corrections as in the conventions page.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, Deserializer};

use super::motion::MotionModel;
use super::sectors::Sectors;
use super::sources::Sources;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::{Ellipsoid, Geodetic};
use crate::observe::{ArrayMountings, Mounting};
use crate::target::TargetModel;

/// A scenario: the truth and everything that stands between it and the observations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name for reports and folders.
    pub name: String,
    /// Seed of every random stream, unless the caller gives another.
    #[serde(default = "one")]
    pub seed: u64,
    /// The target and where it stands.
    pub target: TargetScene,
    /// The basin around it.
    #[serde(default)]
    pub basin: Basin,
    /// The INS.
    pub trajectory: Ins,
    /// The laser scanner.
    pub lidar: Lidar,
    /// The multibeam.
    pub multibeam: Multibeam,
    /// The water.
    #[serde(default)]
    pub sound_speed: Option<Water>,
    /// What a calibration has to find.
    pub truth: Corrections,
    /// How the boat moves about its course.
    #[serde(default)]
    pub motion: MotionModel,
    /// The courses, in order of time.
    pub pass: Vec<Pass>,
    /// Observations that are no observations of the target.
    #[serde(default)]
    pub disturbance: Disturbance,
    /// Factors of the error sources.
    #[serde(default)]
    pub sources: Sources,
}

/// The target, its true pose, and what the surveyor believes of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetScene {
    /// Its design.
    pub model: TargetModel,
    /// Ellipsoid of the coordinates.
    #[serde(default)]
    pub ellipsoid: Ellipsoid,
    /// True origin of the target frame.
    pub origin: Origin,
    /// True azimuth of the +Y axis, degrees.
    pub azimuth_deg: f64,
    /// Water level in the target frame, metres.
    #[serde(default)]
    pub water_level_m: f64,
    /// Believed minus true origin, along the true target axes, metres.
    #[serde(default)]
    pub prior_offset_m: [f64; 3],
    /// Believed minus true azimuth, degrees.
    #[serde(default)]
    pub prior_turn_deg: f64,
    /// Random part of the prior offset, per axis, metres, one sigma.
    #[serde(default)]
    pub prior_offset_sigma_m: f64,
    /// Random part of the prior turn, degrees, one sigma.
    #[serde(default)]
    pub prior_turn_sigma_deg: f64,
    /// Roughness of all faces along their normals, white per observation, metres, one sigma.
    #[serde(default)]
    pub roughness_sigma_m: f64,
}

impl TargetScene {
    /// The true pose.
    #[must_use]
    pub fn pose(&self) -> TargetPose {
        TargetPose {
            ellipsoid: self.ellipsoid,
            origin: Geodetic {
                latitude_rad: self.origin.latitude_deg.to_radians(),
                longitude_rad: self.origin.longitude_deg.to_radians(),
                height_m: self.origin.height_m,
            },
            azimuth_rad: self.azimuth_deg.to_radians(),
        }
    }
}

/// A geodetic position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Ellipsoidal height, metres.
    pub height_m: f64,
}

/// Floor and walls of the pool.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Basin {
    /// Height of the floor in the target frame, metres; no floor where it is not given.
    #[serde(default)]
    pub floor_m: Option<f64>,
    /// Endless planes other than the floor.
    #[serde(default)]
    pub wall: Vec<PlaneModel>,
}

/// An endless plane in the target frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneModel {
    /// A point of the plane, metres.
    pub point_m: [f64; 3],
    /// Its normal, of any length.
    pub normal: [f64; 3],
}

/// The INS and its noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ins {
    /// Records per second.
    #[serde(default = "hundred")]
    pub rate_hz: f64,
    /// White position noise per record and axis, metres.
    pub position_sigma_m: f64,
    /// Gauss-Markov position drift per axis, metres.
    #[serde(default)]
    pub position_drift_sigma_m: f64,
    /// Correlation time of the drifts, seconds.
    #[serde(default = "sixty")]
    pub drift_correlation_time_s: f64,
    /// White roll and pitch noise per record, degrees.
    #[serde(default)]
    pub roll_pitch_sigma_deg: f64,
    /// White heading noise per record, degrees.
    #[serde(default)]
    pub heading_sigma_deg: f64,
    /// Slow heading error, degrees.
    #[serde(default)]
    pub heading_drift_sigma_deg: f64,
    /// Whether velocities are recorded.
    #[serde(default)]
    pub velocity: bool,
    /// Longest interval that is interpolated, seconds.
    #[serde(default = "unit")]
    pub max_gap_s: f64,
}

/// Angles of a mounting, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Angles {
    /// Roll.
    #[serde(default)]
    pub roll: f64,
    /// Pitch.
    #[serde(default)]
    pub pitch: f64,
    /// Heading.
    #[serde(default)]
    pub heading: f64,
}

/// A correction about the body axes, degrees: pitch about x, roll about y, yaw about z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// About x (right).
    #[serde(default)]
    pub pitch: f64,
    /// About y (forward).
    #[serde(default)]
    pub roll: f64,
    /// About z (up).
    #[serde(default)]
    pub yaw: f64,
}

/// A line scanner that turns in its own x-z plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lidar {
    /// Lever arm in the body frame, metres.
    pub lever_arm_m: [f64; 3],
    /// Mounting as the survey knows it, degrees.
    pub mounting_deg: Angles,
    /// Range noise, metres, one sigma.
    pub range_sigma_m: f64,
    /// Angle noise in the scanner's plane, degrees, one sigma.
    #[serde(default)]
    pub angle_sigma_deg: f64,
    /// Lines per second.
    #[serde(default = "twenty")]
    pub line_rate_hz: f64,
    /// Shots per line.
    #[serde(default = "four_hundred")]
    pub points_per_line: u32,
    /// First angle from the scanner's x axis, positive to +z, degrees.
    #[serde(default = "minus_55")]
    pub from_deg: f64,
    /// Last angle, degrees.
    #[serde(default = "plus_55")]
    pub to_deg: f64,
    /// Part of a line's time in which it shoots.
    #[serde(default = "four_fifths")]
    pub duty: f64,
    /// Longest range, metres.
    #[serde(default = "hundred")]
    pub max_range_m: f64,
    /// Uncertainty of the scanner's own mounting about the body axes x, y, z, degrees.
    #[serde(default)]
    pub mounting_sigma_deg: [f64; 3],
    /// Uncertainty of the scanner's own lever arm, metres.
    #[serde(default)]
    pub lever_arm_sigma_m: [f64; 3],
    /// True minus known mounting, in addition to the random part.
    #[serde(default)]
    pub mounting_error_deg: Turn,
    /// True minus known lever arm, in addition to the random part, metres.
    #[serde(default)]
    pub lever_arm_error_m: [f64; 3],
}

/// What the multibeam records along a beam.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Recorded {
    /// Slant ranges, metres.
    #[default]
    Range,
    /// Two-way travel times, seconds.
    TravelTime,
}

/// A multibeam with equiangular beams in its own x-z plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Multibeam {
    /// Nominal lever arm in the body frame, metres.
    pub lever_arm_m: [f64; 3],
    /// Nominal mounting, degrees.
    pub mounting_deg: Angles,
    /// Range noise, metres, one sigma.
    pub range_sigma_m: f64,
    /// Across-track angle noise, degrees, one sigma.
    pub angle_sigma_deg: f64,
    /// Along-track angle noise, degrees, one sigma.
    #[serde(default)]
    pub along_angle_sigma_deg: f64,
    /// Factor of the angle noise at the outermost beam; grows with the square of the angle (the survey does not know of it).
    #[serde(default = "unit")]
    pub outer_beam_factor: f64,
    /// Pings per second.
    #[serde(default = "fifteen")]
    pub ping_rate_hz: f64,
    /// Beams per ping.
    #[serde(default = "beams")]
    pub beams: u32,
    /// Across-track angle of the first beam, positive to starboard, degrees.
    #[serde(default = "minus_70")]
    pub from_deg: f64,
    /// Across-track angle of the last beam, degrees.
    #[serde(default = "plus_70")]
    pub to_deg: f64,
    /// Longest range, metres.
    #[serde(default = "fifty")]
    pub max_range_m: f64,
    /// What is recorded.
    #[serde(default)]
    pub records: Recorded,
    /// A transmit and a receive array instead of one head: what is sent at one moment is heard at another, and travel times are
    /// recorded. Recorder files have it always.
    #[serde(default)]
    pub arrays: Option<Arrays>,
}

/// `[multibeam.arrays]`: the transmit array has the lever arm and the mounting of the section above.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arrays {
    /// Nominal mounting of the receive array, degrees; that of the transmit array where it is not given.
    #[serde(default)]
    pub receiver_mounting_deg: Option<Angles>,
    /// From the transmit to the receive array in the body, metres.
    #[serde(default)]
    pub receiver_offset_m: [f64; 3],
    /// Transmit sectors of a swath.
    #[serde(default = "single")]
    pub sectors: u32,
    /// Tilt from one sector to the next, degrees.
    #[serde(default)]
    pub sector_tilt_deg: f64,
    /// Delay from one sector to the next, seconds.
    #[serde(default)]
    pub sector_delay_s: f64,
}

impl Default for Arrays {
    fn default() -> Self {
        Self {
            receiver_mounting_deg: None,
            receiver_offset_m: [0.0; 3],
            sectors: 1,
            sector_tilt_deg: 0.0,
            sector_delay_s: 0.0,
        }
    }
}

impl Arrays {
    /// The sectors.
    #[must_use]
    pub fn sectors(&self) -> Sectors {
        Sectors {
            count: self.sectors,
            tilt_deg: self.sector_tilt_deg,
            delay_s: self.sector_delay_s,
        }
    }
}

impl Angles {
    /// The mounting with these angles and a lever arm (metres).
    #[must_use]
    pub fn mounting(&self, lever_arm_m: [f64; 3]) -> Mounting {
        let [roll, pitch, heading] = [self.roll, self.pitch, self.heading].map(f64::to_radians);
        Mounting::from_angles(roll, pitch, heading, Vector3::from(lever_arm_m))
    }
}

impl Multibeam {
    /// Nominal mountings of the two arrays, where there are two.
    #[must_use]
    pub fn array_mountings(&self) -> Option<ArrayMountings> {
        let arrays = self.arrays?;
        let receiver = arrays.receiver_mounting_deg.unwrap_or(self.mounting_deg);
        let arm_m = |k: usize| self.lever_arm_m[k] + arrays.receiver_offset_m[k];
        Some(ArrayMountings {
            transmitter: self.mounting_deg.mounting(self.lever_arm_m),
            receiver: receiver.mounting(std::array::from_fn(arm_m)),
        })
    }

    /// The nominal mounting; of two arrays the one that stands for both.
    #[must_use]
    pub fn nominal(&self) -> Mounting {
        let arrays = self.array_mountings();
        let alone = || self.mounting_deg.mounting(self.lever_arm_m);
        arrays.map_or_else(alone, |arrays| arrays.together())
    }
}

/// The water as the survey knows it, and what it does not know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// One speed, metres per second.
    #[serde(default)]
    pub speed_m_s: Option<f64>,
    /// Samples of (depth below the water level in metres, speed in metres per second).
    #[serde(default)]
    pub profile: Vec<[f64; 2]>,
    /// True minus known gradient, 1/s (metres per second per metre of depth).
    #[serde(default)]
    pub gradient_error_1_s: f64,
    /// Random part of the gradient error, one sigma.
    #[serde(default)]
    pub gradient_sigma_1_s: f64,
}

/// What a calibration has to find.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corrections {
    /// `log(R R_nominal^T)` of the multibeam's true mounting.
    #[serde(default)]
    pub correction_deg: Turn,
    /// True minus nominal lever arm of the multibeam, metres.
    #[serde(default)]
    pub lever_arm_correction_m: [f64; 3],
    /// Stamp minus measurement epoch, seconds.
    #[serde(default)]
    pub latency_s: f64,
    /// Random part of the latency, one sigma.
    #[serde(default)]
    pub latency_sigma_s: f64,
    /// Jitter of the stamps, per ping, one sigma, seconds.
    #[serde(default)]
    pub latency_jitter_s: f64,
    /// True range = measured x (1 + scale).
    #[serde(default)]
    pub range_scale: f64,
    /// Random part of the scale, one sigma.
    #[serde(default)]
    pub range_scale_sigma: f64,
}

/// A straight course along the target's Y axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// Distance of the INS from the wall's front face, metres.
    pub distance_m: f64,
    /// Y where the pass begins, metres.
    pub from_m: f64,
    /// Y where it ends, metres; less than `from_m` for a course along -Y.
    pub to_m: f64,
    /// Speed over ground, metres per second.
    pub speed_m_s: f64,
    /// Heading minus course, degrees.
    #[serde(default)]
    pub crab_deg: f64,
    /// Time without records before the pass, seconds (not before the first).
    #[serde(default = "twenty")]
    pub gap_s: f64,
}

/// Observations that are no observations of the target.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// Part of the soundings with a gross range error.
    #[serde(default)]
    pub gross_fraction: f64,
    /// Largest gross error, metres; uniform on both sides.
    #[serde(default = "three")]
    pub gross_range_m: f64,
    /// Part of the beams with an echo from the water column.
    #[serde(default)]
    pub sonar_clutter_fraction: f64,
    /// Part of the scanner's returns that come from spray or dust before the target.
    #[serde(default)]
    pub laser_clutter_fraction: f64,
    /// Part of both sensors' observations that are reflected once more and come late.
    #[serde(default)]
    pub multipath_fraction: f64,
    /// Longest delay of such, metres of range; uniform from 0.
    #[serde(default = "two")]
    pub multipath_delay_m: f64,
    /// Solid boxes that stand or pass by; both sensors see them.
    #[serde(default)]
    pub body: Vec<BodyModel>,
}

/// A box along the target's axes, at rest or moving.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyModel {
    /// Length along X, Y, Z, metres.
    pub size_m: [f64; 3],
    /// Centre in the target frame at `time_s`, metres.
    pub centre_m: [f64; 3],
    /// Velocity, metres per second.
    #[serde(default)]
    pub velocity_m_s: [f64; 3],
    /// Time since the begin of the first pass, seconds.
    #[serde(default)]
    pub time_s: f64,
}

impl Scenario {
    /// Reads a scenario from TOML text in which the target's model stands in full (no paths); whose scenario it is is not asked.
    ///
    /// # Errors
    /// What the TOML reader found, with its line and column.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        let mut root = DeTable::parse(text)?;
        root.get_mut().remove("procedure");
        Self::deserialize(Deserializer::from(root))
    }
}

/// What the TOML reader found wrong with a scenario; of an unknown key also which known one is nearest.
#[must_use]
pub fn complaint(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let (Some(found), true) = (quoted.next(), message.starts_with("unknown")) else {
        return message.to_owned();
    };
    let nearness = |known: &&str| strsim::jaro_winkler(found, known);
    let nearest = quoted.max_by(|a, b| nearness(a).total_cmp(&nearness(b)));
    let hint = nearest.map_or_else(String::new, |known| {
        format!(", the nearest known one is \"{known}\"")
    });
    format!("unknown key \"{found}\"{hint}")
}

fn one() -> u64 {
    1
}
fn single() -> u32 {
    1
}
fn unit() -> f64 {
    1.0
}
fn two() -> f64 {
    2.0
}
fn three() -> f64 {
    3.0
}
fn fifteen() -> f64 {
    15.0
}
fn twenty() -> f64 {
    20.0
}
fn fifty() -> f64 {
    50.0
}
fn sixty() -> f64 {
    60.0
}
fn hundred() -> f64 {
    100.0
}
fn four_fifths() -> f64 {
    0.8
}
fn minus_55() -> f64 {
    -55.0
}
fn plus_55() -> f64 {
    55.0
}
fn minus_70() -> f64 {
    -70.0
}
fn plus_70() -> f64 {
    70.0
}
fn four_hundred() -> u32 {
    400
}
fn beams() -> u32 {
    256
}
