//! A rail survey file as types.

use nalgebra::{Vector2, Vector3};

use super::super::observed::{AttitudeNoise, Profiler, Stand};
use super::keys::{NAMES, PLACE, SIGMA_DEG, SIGMA_M, SIGMA_M_OR_NONE};
use crate::calibrate::large::LargeConfig;
use crate::calibrate::verdict::VerdictConfig;
use crate::procedures::rail::{RailJointConfig, RailReferenceConfig};
use crate::survey::limits::limits;
use crate::survey::schema::Kind;
use crate::survey::section::section;
use crate::survey::sections::MountingAngles;
use crate::units::radians;

section! {
    /// A survey file. Written as JSON or TOML again it shows every value as it took effect.
    #[derive(Clone, Debug, PartialEq)]
    pub struct RailSurveyFile {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// Always `rail`.
        procedure: String = required, Kind::OneOf(NAMES);
        /// The rail.
        rail: RailSection = required, Kind::Table(RailSection::KEYS);
        /// The profiles.
        profiles: ProfilesSection = required, Kind::Table(ProfilesSection::KEYS);
        /// The INS.
        attitude: AttitudeSection = required, Kind::Table(AttitudeSection::KEYS);
        /// The table.
        table: TableSection = required, Kind::Table(TableSection::KEYS);
        /// The profilers, in the order of their numbers in the profiles file.
        profiler: Vec<ProfilerSection> = required, Kind::Tables(ProfilerSection::KEYS);
        /// The reference path.
        reference: RailReferenceConfig = or (RailReferenceConfig::default()), Kind::Table(RailReferenceConfig::KEYS);
        /// The joint path.
        joint: RailJointConfig = or (RailJointConfig::default()), Kind::Table(RailJointConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
        /// Surveys with long trajectories.
        #[serde(skip_serializing_if = "Option::is_none")]
        large: Option<LargeConfig> = or (None), Kind::Table(LargeConfig::KEYS);
    }
}

section! {
    /// `[rail]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct RailSection {
        /// Path of the model file.
        model: String = required, Kind::Text;
        /// Orientation of the rail in the INS' level frame, degrees; zero.
        orientation_deg: MountingAngles = or (MountingAngles::default()), Kind::Table(MountingAngles::KEYS);
        /// Its uncertainty about the level axes x, y, z, degrees, constant errors of the INS included.
        orientation_sigma_deg: [f64; 3] = required, Kind::Triple(SIGMA_DEG);
        /// How far each element of the rail lies off the standard profile, metres, one sigma; 0.
        profile_sigma_m: f64 = or (0.0), Kind::Number(SIGMA_M_OR_NONE);
    }
}

section! {
    /// `[profiles]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ProfilesSection {
        /// Path of the profiles file: Parquet if it ends in `.parquet`, else CSV.
        path: String = required, Kind::Text;
    }
}

section! {
    /// `[attitude]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct AttitudeSection {
        /// Path of the attitude file.
        path: String = required, Kind::Text;
        /// White noise of roll and pitch per record, degrees.
        roll_pitch_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// White noise of heading per record, degrees.
        heading_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
    }
}

section! {
    /// `[table]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct TableSection {
        /// Path of the table of positions.
        path: String = required, Kind::Text;
        /// Each angle, per position, degrees, one sigma.
        angle_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Tilt of the vertical axis, degrees, one sigma.
        level_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Zero of the turn about the vertical against the rail's heading, degrees, one sigma.
        zero_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Seat of the beam about each axis, degrees, one sigma.
        seating_sigma_deg: f64 = required, Kind::Number(SIGMA_DEG);
        /// Centre of rotation in the body (right, forward, up), metres.
        pivot_body_m: [f64; 3] = required, Kind::Triple(PLACE);
        /// Its uncertainty per axis, metres.
        pivot_body_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Centre of rotation in the rail's cross-section (x, z), metres.
        pivot_rail_m: [f64; 2] = required, Kind::Pair(PLACE);
        /// Its uncertainty per axis, metres.
        pivot_rail_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// How far the lateral axis may lie before or behind the vertical one, metres, one sigma; 0: they meet.
        axes_gap_sigma_m: f64 = or (0.0), Kind::Number(limits(0.0, 1.0, "metres from 0 to 1"));
    }
}

section! {
    /// `[[profiler]]`.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ProfilerSection {
        /// Name for reports.
        name: String = required, Kind::Text;
        /// Nominal lever arm in the body (right, forward, up), metres.
        lever_arm_m: [f64; 3] = required, Kind::Triple(PLACE);
        /// Nominal mounting angles, degrees.
        mounting_deg: MountingAngles = required, Kind::Table(MountingAngles::KEYS);
        /// Noise of the lateral coordinate, metres, one sigma.
        lateral_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Noise of the other coordinate, metres, one sigma.
        vertical_sigma_m: f64 = required, Kind::Number(SIGMA_M);
        /// Uncertainty of the lever arm along the rail, metres, one sigma.
        along_sigma_m: f64 = required, Kind::Number(SIGMA_M);
    }
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
            axes_gap_sigma_m: t.axes_gap_sigma_m,
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
