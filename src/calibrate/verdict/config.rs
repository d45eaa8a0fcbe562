//! The `[verdict]` section of a survey file.

use serde::{Deserialize, Serialize};

/// Codes of the findings that `accept` may name.
pub const CODES: &[&str] = &[
    "latency",
    "range_scale",
    "range_offset",
    "beam_angle_scale",
    "sound_speed_gradient",
    "laser_latency",
    "laser_range_offset",
    "scanner_mounting",
    "attitude_scale",
    "attitude_offset",
    "mounting_of_pass",
    "datum_of_pass",
    "face_offset",
    "prior",
    "variance_factor",
    "noise",
    "trajectory",
    "pass",
    "face",
    "size",
    "share",
];

/// Limits of the verdict, and findings that the surveyor accepts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VerdictConfig {
    /// Codes of findings that do not take "usable" away.
    pub accept: Vec<String>,
    /// Smallest variance factor that is let pass.
    pub least_variance_factor: f64,
    /// Largest one.
    pub most_variance_factor: f64,
    /// A correction of the mounting beyond this is suspicious, degrees.
    pub max_correction_deg: f64,
    /// A correction of the lever arm beyond this is suspicious, metres.
    pub max_correction_m: f64,
    /// A prior that moves by more of its own standard deviations contradicts the data.
    pub max_prior_sigmas: f64,
    /// Below this share of its observations a sensor has not been understood.
    pub least_share: f64,
    /// Below this share there is something to look at.
    pub good_share: f64,
}

impl Default for VerdictConfig {
    fn default() -> Self {
        VerdictConfig {
            accept: vec![],
            least_variance_factor: 0.75,
            most_variance_factor: 1.25,
            max_correction_deg: 10.0,
            max_correction_m: 0.5,
            max_prior_sigmas: 5.0,
            least_share: 0.5,
            good_share: 0.8,
        }
    }
}
