//! A seabed survey file as types.

use serde::{Deserialize, Serialize};

use super::super::config::SeabedConfig;
use super::super::reference::PatchConfig;
use super::super::scene::{InsNoise, Line, Priors, SonarNoise};
use crate::geometry::Ellipsoid;
use crate::survey::sections::{MountingAngles, Origin};
use crate::units::radians;

/// A survey file. Written as JSON or TOML again it shows every value as it took effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeabedSurveyFile {
    /// Name for reports.
    pub name: String,
    /// Always `seabed`.
    pub procedure: String,
    /// The frame of the computation.
    pub site: SiteSection,
    /// The INS.
    pub trajectory: TrajectorySection,
    /// The water.
    pub sound_speed: SoundSpeedSection,
    /// The sonar.
    pub multibeam: MultibeamSection,
    /// The joint path.
    #[serde(default)]
    pub seabed: SeabedConfig,
    /// The reference path.
    #[serde(default)]
    pub reference: PatchConfig,
    /// The lines.
    pub line: Vec<LineSection>,
}

/// `[site]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SiteSection {
    /// Ellipsoid of the trajectory's positions.
    #[serde(default)]
    pub ellipsoid: Ellipsoid,
    /// Origin of the local frame: east, north, up.
    pub origin: Origin,
    /// Height of the water level in that frame, metres; 0.
    #[serde(default)]
    pub water_level_m: f64,
    /// Tide or datum: one offset of each line, metres, one sigma; 0.03.
    #[serde(default = "line_height_sigma_m")]
    pub line_height_sigma_m: f64,
}

fn line_height_sigma_m() -> f64 {
    0.03
}

/// `[trajectory]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrajectorySection {
    /// Path of the trajectory.
    pub path: String,
    /// White noise of the position per record and axis, metres.
    pub position_sigma_m: f64,
    /// Drift of east and north, metres.
    pub position_drift_sigma_m: f64,
    /// Drift of the height, metres.
    pub height_drift_sigma_m: f64,
    /// Correlation time of both, seconds.
    pub drift_correlation_time_s: f64,
    /// White noise of roll and pitch per record, degrees.
    pub roll_pitch_sigma_deg: f64,
    /// Drift of roll and pitch, degrees; none.
    #[serde(default)]
    pub roll_pitch_drift_sigma_deg: f64,
    /// Its correlation time, seconds; 120.
    #[serde(default = "correlation_time_s")]
    pub roll_pitch_correlation_time_s: f64,
    /// White noise of the heading per record, degrees.
    pub heading_sigma_deg: f64,
    /// Drift of the heading, degrees; none.
    #[serde(default)]
    pub heading_drift_sigma_deg: f64,
    /// Its correlation time, seconds; 120.
    #[serde(default = "correlation_time_s")]
    pub heading_correlation_time_s: f64,
    /// Longest interval that is interpolated, seconds; 1.
    #[serde(default = "max_gap_s")]
    pub max_gap_s: f64,
}

fn correlation_time_s() -> f64 {
    120.0
}

fn max_gap_s() -> f64 {
    1.0
}

/// `[sound_speed]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoundSpeedSection {
    /// Path of the profile.
    pub profile: String,
    /// Relative error of the profile at 20 m, growing linearly from the transducer, one sigma; 0 holds it.
    #[serde(default)]
    pub profile_sigma: f64,
}

/// `[multibeam]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultibeamSection {
    /// Path of the soundings.
    pub path: String,
    /// Lever arm in the body (right, forward, up), metres.
    pub lever_arm_m: [f64; 3],
    /// Its standard deviation, metres; 0.005, 0.005, 0.01. The one upwards is inseparable from the heights of the lines and is held.
    #[serde(default = "lever_arm_sigma_m")]
    pub lever_arm_sigma_m: [f64; 3],
    /// Nominal mounting angles, degrees.
    pub mounting_deg: MountingAngles,
    /// Range noise, metres, one sigma.
    pub range_sigma_m: f64,
    /// Across-track angle noise at the middle, degrees, one sigma.
    pub angle_sigma_deg: f64,
    /// Its growth to the outer beams: `sigma (1 + growth (|a| / 60 deg)^3)`; 0.
    #[serde(default)]
    pub angle_sigma_growth: f64,
    /// Soundings further out are not used, degrees; 65.
    #[serde(default = "max_angle_deg")]
    pub max_angle_deg: f64,
}

fn lever_arm_sigma_m() -> [f64; 3] {
    [0.005, 0.005, 0.01]
}

fn max_angle_deg() -> f64 {
    65.0
}

/// `[[line]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineSection {
    /// Name for reports.
    pub name: String,
    /// Begin, seconds on the trajectory's clock.
    pub start_s: f64,
    /// End, seconds.
    pub end_s: f64,
}

impl SeabedSurveyFile {
    /// Settings of the joint path, the widest beam included.
    #[must_use]
    pub fn config(&self, seed: u64) -> SeabedConfig {
        SeabedConfig {
            max_angle_deg: self.multibeam.max_angle_deg,
            seed,
            ..self.seabed.clone()
        }
    }

    /// What the INS claims, in radians.
    #[must_use]
    pub fn ins(&self) -> InsNoise {
        let t = &self.trajectory;
        InsNoise {
            position_m: t.position_sigma_m,
            position_drift_m: t.position_drift_sigma_m,
            height_drift_m: t.height_drift_sigma_m,
            position_correlation_s: t.drift_correlation_time_s,
            roll_pitch_rad: radians(t.roll_pitch_sigma_deg),
            roll_pitch_drift_rad: radians(t.roll_pitch_drift_sigma_deg),
            roll_pitch_correlation_s: t.roll_pitch_correlation_time_s,
            heading_rad: radians(t.heading_sigma_deg),
            heading_drift_rad: radians(t.heading_drift_sigma_deg),
            heading_correlation_s: t.heading_correlation_time_s,
        }
    }

    /// What the sonar claims, in radians.
    #[must_use]
    pub fn sonar(&self) -> SonarNoise {
        let m = &self.multibeam;
        SonarNoise {
            range_m: m.range_sigma_m,
            angle_rad: radians(m.angle_sigma_deg),
            angle_growth: m.angle_sigma_growth,
        }
    }

    /// What is known beforehand.
    #[must_use]
    pub fn priors(&self) -> Priors {
        let [right, forward, _] = self.multibeam.lever_arm_sigma_m;
        Priors {
            range_scale: self.seabed.range_scale_sigma,
            heave_scale: self.seabed.heave_scale_sigma,
            heave_lag_s: self.seabed.heave_lag_sigma_s,
            lever_arm_m: [right, forward],
            deep_sound_speed: self.sound_speed.profile_sigma,
            line_height_m: self.site.line_height_sigma_m,
        }
    }

    /// The lines.
    #[must_use]
    pub fn lines(&self) -> Vec<Line> {
        let one = |l: &LineSection| Line {
            name: l.name.clone(),
            start_s: l.start_s,
            end_s: l.end_s,
        };
        self.line.iter().map(one).collect()
    }
}
