//! A pool survey file as types; what is not given takes the default named here.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::keys::{
    COORDINATE, LASER_TIMES, LEVER_ARM, RANGE_SIGMA_M, SIGMA_DEG, SIGMA_DEG_OR_NONE, SIGMA_M,
    SIGMA_M_OR_NONE,
};
use super::large::LargePoolConfig;
use crate::calibrate::verdict::VerdictConfig;
use crate::formats::Invalid;
use crate::geometry::Ellipsoid;
use crate::geometry::ellipsoid::TargetPose;
use crate::observe::{
    ArrayMountings, LaserCoordinates, LaserNoise, MountingSigma, SonarNoise, SoundingArrays,
    TrajectoryNoise,
};
use crate::procedures::pool::{JointConfig, SequentialConfig};
use crate::survey::limits::{
    DURATION, ELLIPSOID, HEAD, INVALID, LEAP_S, OFFSET_S, OUTSIDE, SPEED, TIMES, TURN, WEEK,
};
use crate::survey::schema::Kind;
use crate::survey::section::section;
use crate::survey::sections::{MountingAngles, Origin, OutsideRule, UtmZone};
use crate::units::radians;

section! {
    /// A survey file. Written as JSON or TOML again it shows every value as it took effect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SurveyFile {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// `pool`.
        procedure: Procedure = required, Kind::OneOf(&["pool"]);
        /// The target and where it is believed to stand.
        target: TargetSection = required, Kind::Table(TargetSection::KEYS);
        /// The INS.
        trajectory: TrajectorySection = required, Kind::Table(TrajectorySection::KEYS);
        /// The laser scanner.
        lidar: LidarSection = required, Kind::Table(LidarSection::KEYS);
        /// The multibeam.
        multibeam: MultibeamSection = required, Kind::Table(MultibeamSection::KEYS);
        /// The water, needed for travel times.
        #[serde(skip_serializing_if = "Option::is_none")]
        sound_speed: Option<SoundSpeedSection> = or (None), Kind::Table(SoundSpeedSection::KEYS);
        /// The reference path.
        sequential: SequentialConfig = or (SequentialConfig::default()), Kind::Table(SequentialConfig::KEYS);
        /// The joint path.
        joint: JointConfig = or (JointConfig::default()), Kind::Table(JointConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
        /// Surveys with long trajectories.
        #[serde(skip_serializing_if = "Option::is_none")]
        large: Option<LargePoolConfig> = or (None), Kind::Table(LargePoolConfig::KEYS);
    }
}

/// Procedures that are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Procedure {
    /// Multibeam against a target that a scanner sees too.
    Pool,
}

section! {
    /// `[target]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct TargetSection {
        /// Path of the target file.
        model: String = required, Kind::Text;
        /// Ellipsoid of every geodetic coordinate; WGS84.
        ellipsoid: Ellipsoid = or (Ellipsoid::default()), ELLIPSOID;
        /// Believed origin of the target frame.
        origin: Origin = required, Kind::Table(Origin::KEYS);
        /// Believed azimuth of the +Y axis, degrees.
        azimuth_deg: f64 = required, Kind::Number(TURN);
        /// Height of the water level in the target frame, metres; 0.
        water_level_m: f64 = or (0.0), Kind::Number(COORDINATE);
    }
}

impl TargetSection {
    /// The pose that the surveyor believes the target to have.
    #[must_use]
    pub fn pose(&self) -> TargetPose {
        TargetPose {
            ellipsoid: self.ellipsoid,
            origin: self.origin.geodetic(),
            azimuth_rad: radians(self.azimuth_deg),
        }
    }
}

section! {
    /// `[trajectory]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct TrajectorySection {
        /// Path of the trajectory: an SBET or a CSV with the columns `time_s`, `latitude_deg`, `longitude_deg`, `height_m`, `roll_deg`,
        /// `pitch_deg`, `heading_deg`. With recorder files it may be left out: then their own navigation is used.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<String> = or (None), Kind::Text;
        /// What the times of `path` are where the soundings are a recorder's (UTC): the same, on the GPS scale, or seconds of the week or
        /// of the day on either. They stay as they are: the soundings are put on this clock.
        #[serde(skip_serializing_if = "Option::is_none")]
        time: Option<String> = or (None), TIMES;
        /// GPS week of seconds of the week; without it the week of the soundings.
        #[serde(skip_serializing_if = "Option::is_none")]
        week: Option<u32> = or (None), WEEK;
        /// GPS minus UTC, seconds; without it that of the soundings' date.
        #[serde(skip_serializing_if = "Option::is_none")]
        leap_seconds: Option<f64> = or (None), LEAP_S;
        /// Place of the point that `path` gives the positions of, in the body (right, forward, up), metres; 0.
        #[serde(skip_serializing_if = "is_none_m")]
        lever_arm_m: [f64; 3] = or ([0.0; 3]), Kind::Triple(LEVER_ARM);
        /// White position noise per record and axis, metres.
        position_sigma_m: f64 = required, Kind::Number(SIGMA_M_OR_NONE);
        /// Gauss-Markov position drift per axis, metres; 0.
        position_drift_sigma_m: f64 = or (0.0), Kind::Number(SIGMA_M_OR_NONE);
        /// Correlation time of the drift, seconds; 60.
        drift_correlation_time_s: f64 = or (60.0), Kind::Number(DURATION);
        /// White roll and pitch noise per record, degrees.
        roll_pitch_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG_OR_NONE);
        /// White heading noise per record, degrees.
        heading_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG_OR_NONE);
        /// Gauss-Markov heading error, degrees; 0.
        heading_drift_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
        /// Longest interval that is interpolated, seconds; 1.
        max_gap_s: f64 = or (1.0), Kind::Number(DURATION);
        /// What to do with observations without a position; error.
        outside: OutsideRule = or (OutsideRule::default()), OUTSIDE;
        /// Added to the time stamps, seconds; 0.
        time_offset_s: f64 = or (0.0), Kind::Number(OFFSET_S);
        /// Rows with impossible values: an error, or up to 5 % of them left out and counted; error.
        #[serde(skip_serializing_if = "Invalid::is_usual")]
        invalid: Invalid = or (Invalid::default()), INVALID;
    }
}

impl TrajectorySection {
    /// The noise in SI and radians.
    #[must_use]
    pub fn noise(&self) -> TrajectoryNoise {
        TrajectoryNoise {
            position_m: self.position_sigma_m,
            position_drift_m: self.position_drift_sigma_m,
            drift_correlation_time_s: self.drift_correlation_time_s,
            roll_pitch_rad: radians(self.roll_pitch_sigma_deg),
            heading_rad: radians(self.heading_sigma_deg),
            heading_drift_rad: radians(self.heading_drift_sigma_deg),
        }
    }
}

/// Whether a lever arm is none.
fn is_none_m(arm_m: &[f64; 3]) -> bool {
    *arm_m == [0.0; 3]
}

/// `coordinates` of laser points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CoordinatesName {
    /// The scanner's frame.
    #[default]
    Sensor,
    /// The target frame of the believed pose.
    Target,
    /// Earth-centred, earth-fixed.
    Geocentric,
    /// UTM with ellipsoidal heights.
    Utm,
}

section! {
    /// `[lidar]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct LidarSection {
        /// Path of the points: LAS, LAZ or a CSV with the columns `time_s`, `x_m`, `y_m`, `z_m`.
        path: String = required, Kind::Text;
        /// Frame of the points; sensor.
        coordinates: CoordinatesName = or (CoordinatesName::default()), Kind::OneOf(&["sensor", "target", "geocentric", "utm"]);
        /// What the times of `path` are where the soundings are a recorder's, as under `[trajectory]`, or `gps-adjusted` (GPS seconds less
        /// 1e9, as LAS has them); without it those of the trajectory.
        #[serde(skip_serializing_if = "Option::is_none")]
        time: Option<String> = or (None), LASER_TIMES;
        /// Zone of UTM coordinates.
        #[serde(skip_serializing_if = "Option::is_none")]
        utm_zone: Option<UtmZone> = or (None), Kind::UtmZone;
        /// Scanner origin in the body (right, forward, up), metres; needed in the sensor frame, else zero.
        lever_arm_m: [f64; 3] = or ([0.0; 3]), Kind::Triple(LEVER_ARM);
        /// Mounting angles; needed in the sensor frame, else zero.
        mounting_deg: MountingAngles = or (MountingAngles::default()), Kind::Table(MountingAngles::KEYS);
        /// Range noise, metres; needed in the sensor frame, else zero.
        range_sigma_m: f64 = or (0.0), Kind::Number(RANGE_SIGMA_M);
        /// Angle noise in the scanner's plane, degrees; needed in the sensor frame, else zero.
        angle_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
        /// Noise of georeferenced points, metres; needed outside the sensor frame, else zero.
        point_sigma_m: f64 = or (0.0), Kind::Number(SIGMA_M);
        /// Uncertainty of the mounting about the body's x, y, z axes (pitch, roll, yaw), degrees.
        #[serde(skip_serializing_if = "Option::is_none")]
        mounting_sigma_deg: Option<[f64; 3]> = or (None), Kind::Triple(SIGMA_DEG);
        /// Uncertainty of the lever arm, metres.
        #[serde(skip_serializing_if = "Option::is_none")]
        lever_arm_sigma_m: Option<[f64; 3]> = or (None), Kind::Triple(SIGMA_M);
        /// Added to the time stamps, seconds; 0.
        time_offset_s: f64 = or (0.0), Kind::Number(OFFSET_S);
        /// Rows with impossible values: an error, or up to 5 % of them left out and counted; error.
        #[serde(skip_serializing_if = "Invalid::is_usual")]
        invalid: Invalid = or (Invalid::default()), INVALID;
    }
}

impl LidarSection {
    /// Frame of the points after reading: UTM becomes geocentric.
    #[must_use]
    pub fn frame(&self) -> LaserCoordinates {
        match self.coordinates {
            CoordinatesName::Sensor => LaserCoordinates::Sensor,
            CoordinatesName::Target => LaserCoordinates::Target,
            CoordinatesName::Geocentric | CoordinatesName::Utm => LaserCoordinates::Geocentric,
        }
    }

    /// The zone of UTM coordinates, where the points have such.
    #[must_use]
    pub fn zone(&self) -> Option<i8> {
        let zone = self.utm_zone.as_ref().and_then(UtmZone::number);
        zone.filter(|_| self.coordinates == CoordinatesName::Utm)
    }

    /// The noise in SI and radians.
    #[must_use]
    pub fn noise(&self) -> LaserNoise {
        LaserNoise {
            range_m: self.range_sigma_m,
            angle_rad: radians(self.angle_sigma_deg),
            point_m: self.point_sigma_m,
        }
    }

    /// Uncertainty of the scanner's calibration, if it is given.
    #[must_use]
    pub fn mounting_sigma(&self) -> Option<MountingSigma> {
        let (angles, arm) = (self.mounting_sigma_deg?, self.lever_arm_sigma_m?);
        Some(MountingSigma {
            rotation_rad: Vector3::from(angles).map(radians),
            lever_arm_m: Vector3::from(arm),
        })
    }
}

section! {
    /// `[multibeam]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct MultibeamSection {
        /// Path of the soundings: a recorder's file, a folder of recorder files, or a CSV with the columns `time_s`, `ping`, `beam`,
        /// `across_angle_deg`, `along_angle_deg` and `range_m` or `two_way_travel_time_s`.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<String> = or (None), Kind::Text;
        /// Several recorder files instead.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        paths: Vec<String> = or (vec![]), Kind::Texts;
        /// Which head is calibrated where the files have more: its serial number in recorder files, in a CSV what stands in the column
        /// `head`.
        #[serde(skip_serializing_if = "Option::is_none")]
        head: Option<u32> = or (None), HEAD;
        /// Nominal sonar origin in the body (right, forward, up), metres. With recorder files this and the angles may be left out: then the
        /// installation record says them.
        lever_arm_m: [f64; 3] = required, Kind::Triple(LEVER_ARM);
        /// Nominal mounting angles.
        mounting_deg: MountingAngles = required, Kind::Table(MountingAngles::KEYS);
        /// Of two arrays: lever arm of the receive array, where it is not that of the transmit array.
        #[serde(skip_serializing_if = "Option::is_none")]
        receiver_lever_arm_m: Option<[f64; 3]> = or (None), Kind::Triple(LEVER_ARM);
        /// Of two arrays: nominal mounting angles of the receive array, where they are not those of the transmit array. Both get one
        /// correction.
        #[serde(skip_serializing_if = "Option::is_none")]
        receiver_mounting_deg: Option<MountingAngles> = or (None), Kind::Table(MountingAngles::KEYS);
        /// Range noise, metres.
        range_sigma_m: f64 = required, Kind::Number(RANGE_SIGMA_M);
        /// Across-track angle noise, degrees.
        angle_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Along-track angle noise, degrees; 0.
        along_angle_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
        /// Added to the time stamps, seconds; 0.
        time_offset_s: f64 = or (0.0), Kind::Number(OFFSET_S);
        /// Rows with impossible values: an error, or up to 5 % of them left out and counted; error.
        #[serde(skip_serializing_if = "Invalid::is_usual")]
        invalid: Invalid = or (Invalid::default()), INVALID;
    }
}

impl MultibeamSection {
    /// Soundings of two arrays whose beam formers used these sound speeds.
    #[must_use]
    pub fn of_arrays(&self, head_speed_m_s: &[f64]) -> SoundingArrays {
        let mountings = self.arrays();
        SoundingArrays {
            nominal: mountings.together(),
            mountings,
            head_speed_m_s: head_speed_m_s.iter().map(|speed| *speed as f32).collect(),
        }
    }

    /// Nominal mountings of a transmit and a receive array.
    #[must_use]
    pub fn arrays(&self) -> ArrayMountings {
        let receiver = self.receiver_mounting_deg.unwrap_or(self.mounting_deg);
        let arm_m = self.receiver_lever_arm_m.unwrap_or(self.lever_arm_m);
        ArrayMountings {
            transmitter: self.mounting_deg.mounting(self.lever_arm_m),
            receiver: receiver.mounting(arm_m),
        }
    }

    /// The noise in SI and radians.
    #[must_use]
    pub fn noise(&self) -> SonarNoise {
        SonarNoise {
            range_m: self.range_sigma_m,
            across_rad: radians(self.angle_sigma_deg),
            along_rad: radians(self.along_angle_sigma_deg),
        }
    }
}

section! {
    /// `[sound_speed]`: one of the two.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct SoundSpeedSection {
        /// One speed everywhere, metres per second.
        #[serde(skip_serializing_if = "Option::is_none")]
        speed_m_s: Option<f64> = or (None), Kind::Number(SPEED);
        /// Path of a profile.
        #[serde(skip_serializing_if = "Option::is_none")]
        profile: Option<String> = or (None), Kind::Text;
    }
}
