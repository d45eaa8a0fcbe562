//! A USBL survey file as types; what is not given takes the default named here.

use serde::{Deserialize, Serialize};

use crate::geometry::Ellipsoid;
use crate::observe::usbl::{AngleModel, AttitudeNoise, DatumSigma, FixNoise};
use crate::procedures::usbl::{JointConfig, ReferenceConfig};
use crate::survey::sections::{MountingAngles, OutsideRule};
use crate::units::radians;

/// A survey file. Written as JSON or TOML again it shows every value as it took effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UsblFile {
    /// Name for reports.
    pub name: String,
    /// `usbl`.
    pub procedure: UsblProcedure,
    /// The surveyed points.
    pub control: ControlSection,
    /// The fixes.
    pub fixes: FixesSection,
    /// The attitude sensor.
    pub attitude: AttitudeSection,
    /// The transducer.
    #[serde(default)]
    pub transducer: TransducerSection,
    /// The water; without it rays are straight, at the speed that the device used.
    #[serde(default)]
    pub sound_speed: WaterSection,
    /// The reference path.
    #[serde(default)]
    pub reference: ReferenceConfig,
    /// The joint path.
    #[serde(default)]
    pub joint: JointConfig,
}

/// The procedure of such a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UsblProcedure {
    /// Ultra-short baseline.
    Usbl,
}

/// `[control]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlSection {
    /// Path of the control points.
    pub path: String,
    /// Ellipsoid of geocentric and geodetic coordinates; WGS84.
    #[serde(default)]
    pub ellipsoid: Ellipsoid,
    /// Deflection of the vertical and tilt of the control, about east and north each, degrees; 0.
    #[serde(default)]
    pub tilt_sigma_deg: f64,
    /// Orientation of the control, degrees; 0.
    #[serde(default)]
    pub azimuth_sigma_deg: f64,
}

impl ControlSection {
    /// The datum's uncertainty in radians.
    #[must_use]
    pub fn datum(&self) -> DatumSigma {
        DatumSigma {
            tilt_rad: radians(self.tilt_sigma_deg),
            azimuth_rad: radians(self.azimuth_sigma_deg),
        }
    }
}

/// `[fixes]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixesSection {
    /// Path of the fixes.
    pub path: String,
    /// Constant range noise, metres.
    pub range_sigma_m: f64,
    /// Proportional range noise, parts per million; 0.
    #[serde(default)]
    pub range_sigma_ppm: f64,
    /// Angle noise at broadside, degrees.
    pub angle_sigma_deg: f64,
    /// How it depends on the direction; direction-cosine.
    #[serde(default)]
    pub angle_model: AngleModel,
    /// Speed with which the device made ranges of travel times, m/s; needed for ranges and coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_speed_m_s: Option<f64>,
    /// Delay of the beacon's answer that is still in two-way travel times, seconds; 0.
    #[serde(default)]
    pub turnaround_s: f64,
    /// Added to the stamps, seconds; 0.
    #[serde(default)]
    pub time_offset_s: f64,
}

impl FixesSection {
    /// The noise in SI and radians.
    #[must_use]
    pub fn noise(&self) -> FixNoise {
        FixNoise {
            range_m: self.range_sigma_m,
            range_relative: self.range_sigma_ppm * 1e-6,
            angle_rad: radians(self.angle_sigma_deg),
            model: self.angle_model,
        }
    }
}

/// `[attitude]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttitudeSection {
    /// Path of the attitude record.
    pub path: String,
    /// White noise of roll and pitch per record, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// White noise of heading per record, degrees.
    pub heading_sigma_deg: f64,
    /// Longest interval that is interpolated, seconds; 1.
    #[serde(default = "one_second")]
    pub max_gap_s: f64,
    /// What to do with fixes that have no attitude; error.
    #[serde(default)]
    pub outside: OutsideRule,
    /// Added to the stamps, seconds; 0.
    #[serde(default)]
    pub time_offset_s: f64,
}

fn one_second() -> f64 {
    1.0
}

impl AttitudeSection {
    /// The noise in radians.
    #[must_use]
    pub fn noise(&self) -> AttitudeNoise {
        AttitudeNoise {
            roll_pitch_rad: radians(self.roll_pitch_sigma_deg),
            heading_rad: radians(self.heading_sigma_deg),
        }
    }
}

/// `[transducer]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TransducerSection {
    /// Nominal mounting on the attitude sensor; none.
    pub mounting_deg: MountingAngles,
    /// Depth of its centre below the water level, metres; needed with a profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_m: Option<f64>,
}

/// `[sound_speed]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaterSection {
    /// One speed everywhere, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// Path of the profile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// Standard deviation of a constant error of the speed, m/s; 0.
    pub sigma_m_s: f64,
}
