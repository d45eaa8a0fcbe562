//! A seabed scenario: the bed, the boat, what goes wrong, the truth, the lines.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::super::config::SeabedConfig;
use super::super::reference::PatchConfig;
use super::super::survey::file::{SiteSection, TrajectorySection};
use crate::survey::problem::{Problem, SurveyError};
use crate::survey::reading::typed;
use crate::survey::sections::MountingAngles;

/// The built-in scenario.
pub const DEMO: &str = include_str!("../../../../models/scenarios/seabed.toml");

/// A scenario file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeabedScenario {
    /// Name for reports.
    pub name: String,
    /// Always `seabed`.
    pub procedure: String,
    /// Seed of the random numbers; 1.
    #[serde(default = "one")]
    pub seed: u64,
    /// The frame, as in a survey file.
    pub site: SiteSection,
    /// The seabed.
    pub bed: Bed,
    /// The boat in the waves.
    pub motion: Motion,
    /// What the INS claims and really does; `path` is the file that is written.
    pub trajectory: TrajectorySection,
    /// Records of the trajectory per second.
    pub trajectory_rate_hz: f64,
    /// Sound speed, one figure, metres per second.
    pub sound_speed_m_s: f64,
    /// The sonar.
    pub multibeam: Multibeam,
    /// What is wrong besides noise.
    #[serde(default)]
    pub errors: Errors,
    /// The lines.
    pub line: Vec<Course>,
    /// Settings of the joint path.
    #[serde(default)]
    pub seabed: SeabedConfig,
    /// Settings of the reference path.
    #[serde(default)]
    pub reference: PatchConfig,
}

fn one() -> u64 {
    1
}

/// `[bed]`: a slope with a random field on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bed {
    /// Depth at the origin, metres.
    pub depth_m: f64,
    /// Slope, degrees, falling towards `azimuth_deg`.
    #[serde(default)]
    pub slope_deg: f64,
    /// Where the slope falls to, degrees from north.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Standard deviation of the relief, metres.
    pub relief_m: f64,
    /// Its correlation length, metres.
    pub length_m: f64,
    /// Amplitude of ripples, metres.
    #[serde(default)]
    pub ripple_m: f64,
    /// Their length, metres.
    #[serde(default = "ripple_length_m")]
    pub ripple_length_m: f64,
}

fn ripple_length_m() -> f64 {
    3.0
}

/// `[motion]`: standard deviations about the mean and the typical period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Roll, degrees.
    pub roll_deg: f64,
    /// Pitch, degrees.
    pub pitch_deg: f64,
    /// Yaw about the course, degrees.
    pub yaw_deg: f64,
    /// Heave, metres.
    pub heave_m: f64,
    /// Typical period, seconds.
    pub period_s: f64,
}

/// `[multibeam]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Multibeam {
    /// True lever arm, which is also the nominal one, metres.
    pub lever_arm_m: [f64; 3],
    /// Nominal mounting angles, degrees.
    pub mounting_deg: MountingAngles,
    /// Truth: correction of the mounting about the body axes, degrees.
    pub correction_deg: Turn,
    /// Range noise, metres.
    pub range_sigma_m: f64,
    /// Angle noise at the middle, degrees.
    pub angle_sigma_deg: f64,
    /// Its growth outwards.
    #[serde(default)]
    pub angle_sigma_growth: f64,
    /// Pings per second.
    pub ping_rate_hz: f64,
    /// Beams of a ping.
    pub beams: u32,
    /// Half the swath, degrees.
    pub half_swath_deg: f64,
}

/// A small rotation about the body axes, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// About x.
    pub pitch: f64,
    /// About y.
    pub roll: f64,
    /// About z.
    pub yaw: f64,
}

/// `[errors]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Errors {
    /// Stamps of the soundings are late, seconds.
    pub latency_s: f64,
    /// True range over measured range, minus 1.
    pub range_scale: f64,
    /// Measured heave over true heave, minus 1.
    pub heave_scale: f64,
    /// Part of the soundings that are gross errors, half of them in clusters of eight.
    pub gross: f64,
}

/// `[[line]]`: from where to where, east and north of the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Course {
    /// Name.
    pub name: String,
    /// Begin, metres.
    pub from_m: [f64; 2],
    /// End, metres.
    pub to_m: [f64; 2],
    /// Speed, metres per second.
    pub speed_m_s: f64,
}

/// Reads a scenario.
///
/// # Errors
/// [`SurveyError`] with what is wrong with it.
pub fn parse_scenario(file: &Path, text: &str) -> Result<SeabedScenario, SurveyError> {
    let scenario: SeabedScenario = typed(file, text)?;
    let positive = [
        ("trajectory_rate_hz", scenario.trajectory_rate_hz),
        ("sound_speed_m_s", scenario.sound_speed_m_s),
        ("[bed] depth_m", scenario.bed.depth_m),
        ("[bed] length_m", scenario.bed.length_m),
        ("[bed] ripple_length_m", scenario.bed.ripple_length_m),
        ("[motion] period_s", scenario.motion.period_s),
        ("[multibeam] ping_rate_hz", scenario.multibeam.ping_rate_hz),
        ("[multibeam] beams", f64::from(scenario.multibeam.beams)),
    ];
    let speeds = scenario
        .line
        .iter()
        .map(|l| ("[[line]] speed_m_s", l.speed_m_s));
    let problems: Vec<Problem> = positive
        .into_iter()
        .chain(speeds)
        .filter(|(_, value)| !(*value > 0.0 && value.is_finite()))
        .map(|(key, value)| Problem::new(file, key, value.to_string(), "a positive number"))
        .collect();
    crate::survey::problem::none_of(problems)?;
    Ok(scenario)
}
