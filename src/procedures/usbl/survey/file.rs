//! A USBL survey file as types; what is not given takes the default named here.

use serde::{Deserialize, Serialize};

use super::super::observed::{AngleModel, AttitudeNoise, DatumSigma, FixNoise};
use super::keys::{SIGMA_DEG, SIGMA_DEG_OR_NONE, SIGMA_M};
use crate::calibrate::verdict::VerdictConfig;
use crate::formats::Invalid;
use crate::geometry::Ellipsoid;
use crate::procedures::usbl::{JointConfig, ReferenceConfig};
use crate::survey::limits::{
    ABOVE, DURATION, ELLIPSOID, INVALID, OFFSET_S, OUTSIDE, SPEED, limits,
};
use crate::survey::schema::Kind;
use crate::survey::section::section;
use crate::survey::sections::{MountingAngles, OutsideRule};
use crate::units::radians;

section! {
    /// A survey file. Written as JSON or TOML again it shows every value as it took effect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct UsblFile {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// `usbl`.
        procedure: UsblProcedure = required, Kind::OneOf(&["usbl"]);
        /// The surveyed points.
        control: ControlSection = required, Kind::Table(ControlSection::KEYS);
        /// The fixes.
        fixes: FixesSection = required, Kind::Table(FixesSection::KEYS);
        /// The attitude sensor.
        attitude: AttitudeSection = required, Kind::Table(AttitudeSection::KEYS);
        /// The transducer.
        transducer: TransducerSection = or (TransducerSection::default()), Kind::Table(TransducerSection::KEYS);
        /// The water; without it rays are straight, at the speed that the device used.
        sound_speed: WaterSection = or (WaterSection::default()), Kind::Table(WaterSection::KEYS);
        /// The reference path.
        reference: ReferenceConfig = or (ReferenceConfig::default()), Kind::Table(ReferenceConfig::KEYS);
        /// The joint path.
        joint: JointConfig = or (JointConfig::default()), Kind::Table(JointConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
    }
}

/// The procedure of such a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UsblProcedure {
    /// Ultra-short baseline.
    Usbl,
}

section! {
    /// `[control]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ControlSection {
        /// Path of the control points.
        path: String = required, Kind::Text;
        /// Ellipsoid of geocentric and geodetic coordinates; WGS84.
        ellipsoid: Ellipsoid = or (Ellipsoid::default()), ELLIPSOID;
        /// Deflection of the vertical and tilt of the control, about east and north each, degrees; 0.
        tilt_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
        /// Orientation of the control, degrees; 0.
        azimuth_sigma_deg: f64 = or (0.0), Kind::Number(SIGMA_DEG_OR_NONE);
    }
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

section! {
    /// `[fixes]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct FixesSection {
        /// Path of the fixes.
        path: String = required, Kind::Text;
        /// Constant range noise, metres.
        range_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Proportional range noise, parts per million; 0.
        range_sigma_ppm: f64 = or (0.0), Kind::Number(limits(0.0, 1e5, "parts per million from 0 to 100000"));
        /// Angle noise at broadside, degrees.
        angle_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// How it depends on the direction; direction-cosine.
        angle_model: AngleModel = or (AngleModel::default()), Kind::OneOf(&["direction-cosine", "isotropic"]);
        /// Speed with which the device made ranges of travel times, m/s; needed for ranges and coordinates.
        #[serde(skip_serializing_if = "Option::is_none")]
        nominal_speed_m_s: Option<f64> = or (None), Kind::Number(SPEED);
        /// Delay of the beacon's answer that is still in two-way travel times, seconds; 0.
        turnaround_s: f64 = or (0.0), Kind::Number(limits(0.0, 10.0, "seconds from 0 to 10"));
        /// Added to the time stamps, seconds; 0.
        time_offset_s: f64 = or (0.0), Kind::Number(OFFSET_S);
        /// Rows with impossible values: an error, or up to 5 % of them left out and counted; error.
        #[serde(skip_serializing_if = "Invalid::is_usual")]
        invalid: Invalid = or (Invalid::default()), INVALID;
    }
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

section! {
    /// `[attitude]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct AttitudeSection {
        /// Path of the attitude record.
        path: String = required, Kind::Text;
        /// Noise of roll and pitch per record, degrees.
        roll_pitch_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG_OR_NONE);
        /// Noise of heading per record, degrees.
        heading_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG_OR_NONE);
        /// Correlation time of that noise where it wanders (Gauss-Markov), seconds; 0: it is white.
        attitude_correlation_time_s: f64 = or (0.0), Kind::Number(limits(0.0, 1e6, "seconds from 0 to 1000000"));
        /// Longest interval that is interpolated, seconds; 1.
        max_gap_s: f64 = or (1.0), Kind::Number(DURATION);
        /// What to do with fixes that have no attitude; error.
        outside: OutsideRule = or (OutsideRule::default()), OUTSIDE;
        /// Added to the time stamps, seconds; 0.
        time_offset_s: f64 = or (0.0), Kind::Number(OFFSET_S);
    }
}

impl AttitudeSection {
    /// The noise in radians.
    #[must_use]
    pub fn noise(&self) -> AttitudeNoise {
        AttitudeNoise {
            roll_pitch_rad: radians(self.roll_pitch_sigma_deg),
            heading_rad: radians(self.heading_sigma_deg),
            correlation_time_s: self.attitude_correlation_time_s,
        }
    }
}

section! {
    #[settings]
    /// `[transducer]`.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct TransducerSection {
        /// Nominal mounting on the attitude sensor; none.
        mounting_deg: MountingAngles = or (MountingAngles::default()), Kind::Table(MountingAngles::KEYS);
        /// Depth of its centre below the water level, metres; needed with a profile.
        #[serde(skip_serializing_if = "Option::is_none")]
        depth_m: Option<f64> = or (None), Kind::Number(limits(ABOVE, 11_000.0, "metres above 0 and up to 11000"));
    }
}

section! {
    #[settings]
    /// `[sound_speed]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct WaterSection {
        /// One speed everywhere, m/s.
        #[serde(skip_serializing_if = "Option::is_none")]
        speed_m_s: Option<f64> = or (None), Kind::Number(SPEED);
        /// Path of the profile.
        #[serde(skip_serializing_if = "Option::is_none")]
        profile: Option<String> = or (None), Kind::Text;
        /// Standard deviation of a constant error of the speed, m/s; 0.
        sigma_m_s: f64 = or (0.0), Kind::Number(limits(0.0, 100.0, "metres per second from 0 to 100"));
    }
}
