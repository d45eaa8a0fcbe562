//! A rail survey file as types.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::observe::{AttitudeNoise, Profiler, Stand};
use crate::procedures::rail::{RailJointConfig, RailReferenceConfig};
use crate::survey::sections::MountingAngles;
use crate::units::radians;

/// A survey file. Written as JSON or TOML again it shows every value as it took effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailSurveyFile {
    /// Name for reports.
    pub name: String,
    /// Always `rail`.
    pub procedure: String,
    /// The rail.
    pub rail: RailSection,
    /// The profiles.
    pub profiles: ProfilesSection,
    /// The INS.
    pub attitude: AttitudeSection,
    /// The table.
    pub table: TableSection,
    /// The profilers, in the order of their numbers in the profiles file.
    pub profiler: Vec<ProfilerSection>,
    /// The reference path.
    #[serde(default)]
    pub reference: RailReferenceConfig,
    /// The joint path.
    #[serde(default)]
    pub joint: RailJointConfig,
}

/// `[rail]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailSection {
    /// Path of the model file.
    pub model: String,
    /// Orientation of the rail in the INS' level frame, degrees; zero.
    #[serde(default)]
    pub orientation_deg: MountingAngles,
    /// Its uncertainty about the level axes x, y, z, degrees, constant errors of the INS included.
    pub orientation_sigma_deg: [f64; 3],
    /// How far each element of the rail lies off the standard profile, metres, one sigma; 0.
    #[serde(default)]
    pub profile_sigma_m: f64,
}

/// `[profiles]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfilesSection {
    /// Path of the profiles file: Parquet if it ends in `.parquet`, else CSV.
    pub path: String,
}

/// `[attitude]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttitudeSection {
    /// Path of the attitude file.
    pub path: String,
    /// White noise of roll and pitch per record, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// White noise of heading per record, degrees.
    pub heading_sigma_deg: f64,
}

/// `[table]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSection {
    /// Path of the table of positions.
    pub path: String,
    /// Each angle, per position, degrees, one sigma.
    pub angle_sigma_deg: f64,
    /// Tilt of the vertical axis, degrees, one sigma.
    pub level_sigma_deg: f64,
    /// Zero of the turn about the vertical against the rail's heading, degrees, one sigma.
    pub zero_sigma_deg: f64,
    /// Seat of the beam about each axis, degrees, one sigma.
    pub seating_sigma_deg: f64,
    /// Centre of rotation in the body (right, forward, up), metres.
    pub pivot_body_m: [f64; 3],
    /// Its uncertainty per axis, metres.
    pub pivot_body_sigma_m: f64,
    /// Centre of rotation in the rail's cross-section (x, z), metres.
    pub pivot_rail_m: [f64; 2],
    /// Its uncertainty per axis, metres.
    pub pivot_rail_sigma_m: f64,
}

/// `[[profiler]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfilerSection {
    /// Name for reports.
    pub name: String,
    /// Nominal lever arm in the body (right, forward, up), metres.
    pub lever_arm_m: [f64; 3],
    /// Nominal mounting angles, degrees.
    pub mounting_deg: MountingAngles,
    /// Noise of the lateral coordinate, metres, one sigma.
    pub lateral_sigma_m: f64,
    /// Noise of the other coordinate, metres, one sigma.
    pub vertical_sigma_m: f64,
    /// Uncertainty of the lever arm along the rail, metres, one sigma.
    pub along_sigma_m: f64,
}

impl RailSurveyFile {
    /// What is known of the stand, in SI and radians.
    #[must_use]
    pub fn stand(&self) -> Stand {
        let (t, r) = (&self.table, &self.rail);
        let o = &r.orientation_deg;
        Stand {
            table_sigma_rad: radians(t.angle_sigma_deg),
            level_sigma_rad: radians(t.level_sigma_deg),
            zero_sigma_rad: radians(t.zero_sigma_deg),
            seating_sigma_rad: radians(t.seating_sigma_deg),
            pivot_body_m: Vector3::from(t.pivot_body_m),
            pivot_body_sigma_m: t.pivot_body_sigma_m,
            pivot_rail_m: Vector2::from(t.pivot_rail_m),
            pivot_rail_sigma_m: t.pivot_rail_sigma_m,
            rail_attitude_rad: [o.roll, o.pitch, o.heading].map(radians),
            rail_attitude_sigma_rad: Vector3::from(r.orientation_sigma_deg).map(radians),
            profile_sigma_m: r.profile_sigma_m,
        }
    }

    /// The INS' noise, in radians.
    #[must_use]
    pub fn attitude_noise(&self) -> AttitudeNoise {
        AttitudeNoise {
            roll_pitch_rad: radians(self.attitude.roll_pitch_sigma_deg),
            heading_rad: radians(self.attitude.heading_sigma_deg),
        }
    }

    /// The profilers.
    #[must_use]
    pub fn profilers(&self) -> Vec<Profiler> {
        let one = |p: &ProfilerSection| Profiler {
            name: p.name.clone(),
            nominal: p.mounting_deg.mounting(p.lever_arm_m),
            lateral_sigma_m: p.lateral_sigma_m,
            vertical_sigma_m: p.vertical_sigma_m,
            along_sigma_m: p.along_sigma_m,
        };
        self.profiler.iter().map(one).collect()
    }
}
