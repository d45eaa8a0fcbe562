//! A pool survey file as types; what is not given takes the default named here.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::calibrate::verdict::VerdictConfig;
use crate::geometry::Ellipsoid;
use crate::geometry::ellipsoid::TargetPose;
use crate::observe::{LaserCoordinates, LaserNoise, MountingSigma, SonarNoise, TrajectoryNoise};
use crate::procedures::pool::{JointConfig, SequentialConfig};
use crate::survey::sections::{MountingAngles, Origin, OutsideRule, UtmZone};
use crate::units::radians;

/// A survey file. Written as JSON or TOML again it shows every value as it took effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurveyFile {
    /// Name for reports.
    pub name: String,
    /// Which calibration.
    pub procedure: Procedure,
    /// The target and where it is believed to stand.
    pub target: TargetSection,
    /// The INS.
    pub trajectory: TrajectorySection,
    /// The laser scanner.
    pub lidar: LidarSection,
    /// The multibeam.
    pub multibeam: MultibeamSection,
    /// The water, needed for travel times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sound_speed: Option<SoundSpeedSection>,
    /// The reference path.
    #[serde(default)]
    pub sequential: SequentialConfig,
    /// The joint path.
    #[serde(default)]
    pub joint: JointConfig,
    /// Limits of the verdict, and findings that the surveyor accepts.
    #[serde(default)]
    pub verdict: VerdictConfig,
}

/// Procedures that are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Procedure {
    /// Multibeam against a target that a scanner sees too.
    Pool,
}

/// `[target]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetSection {
    /// Path of the target file.
    pub model: String,
    /// Ellipsoid of every geodetic coordinate; WGS84.
    #[serde(default)]
    pub ellipsoid: Ellipsoid,
    /// Believed origin of the target frame.
    pub origin: Origin,
    /// Believed azimuth of the +Y axis, degrees.
    pub azimuth_deg: f64,
    /// Height of the water level in the target frame, metres; 0.
    #[serde(default)]
    pub water_level_m: f64,
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

/// `[trajectory]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrajectorySection {
    /// Path of the trajectory file.
    pub path: String,
    /// White position noise per record and axis, metres.
    pub position_sigma_m: f64,
    /// Gauss-Markov position drift per axis, metres; 0.
    #[serde(default)]
    pub position_drift_sigma_m: f64,
    /// Correlation time of the drift, seconds; 60.
    #[serde(default = "sixty_seconds")]
    pub drift_correlation_time_s: f64,
    /// White roll and pitch noise per record, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// White heading noise per record, degrees.
    pub heading_sigma_deg: f64,
    /// Gauss-Markov heading error, degrees; 0.
    #[serde(default)]
    pub heading_drift_sigma_deg: f64,
    /// Longest interval that is interpolated, seconds; 1.
    #[serde(default = "one_second")]
    pub max_gap_s: f64,
    /// What to do with observations that have no position; error.
    #[serde(default)]
    pub outside: OutsideRule,
    /// Added to the stamps, seconds; 0.
    #[serde(default)]
    pub time_offset_s: f64,
}

fn sixty_seconds() -> f64 {
    60.0
}

fn one_second() -> f64 {
    1.0
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

/// `[lidar]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LidarSection {
    /// Path of the points.
    pub path: String,
    /// Frame of the points; sensor.
    #[serde(default)]
    pub coordinates: CoordinatesName,
    /// Zone of UTM coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub utm_zone: Option<UtmZone>,
    /// Scanner origin in the body (right, forward, up), metres; needed in the sensor frame, else zero.
    #[serde(default)]
    pub lever_arm_m: [f64; 3],
    /// Mounting angles; needed in the sensor frame, else zero.
    #[serde(default)]
    pub mounting_deg: MountingAngles,
    /// Range noise, metres; needed in the sensor frame, else zero.
    #[serde(default)]
    pub range_sigma_m: f64,
    /// Angle noise in the scanner's plane, degrees; needed in the sensor frame, else zero.
    #[serde(default)]
    pub angle_sigma_deg: f64,
    /// Noise of georeferenced points, metres; needed outside the sensor frame, else zero.
    #[serde(default)]
    pub point_sigma_m: f64,
    /// Uncertainty of the mounting about the body's x, y, z axes (pitch, roll, yaw), degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mounting_sigma_deg: Option<[f64; 3]>,
    /// Uncertainty of the lever arm, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lever_arm_sigma_m: Option<[f64; 3]>,
    /// Added to the stamps, seconds; 0.
    #[serde(default)]
    pub time_offset_s: f64,
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

/// `[multibeam]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultibeamSection {
    /// Path of the soundings.
    pub path: String,
    /// Nominal sonar origin in the body (right, forward, up), metres.
    pub lever_arm_m: [f64; 3],
    /// Nominal mounting angles.
    pub mounting_deg: MountingAngles,
    /// Range noise, metres.
    pub range_sigma_m: f64,
    /// Across-track angle noise, degrees.
    pub angle_sigma_deg: f64,
    /// Along-track angle noise, degrees; 0.
    #[serde(default)]
    pub along_angle_sigma_deg: f64,
    /// Added to the stamps, seconds; 0.
    #[serde(default)]
    pub time_offset_s: f64,
}

impl MultibeamSection {
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

/// `[sound_speed]`: one of the two.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoundSpeedSection {
    /// One speed everywhere, metres per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// Path of a profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
}
