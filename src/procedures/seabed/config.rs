//! Settings of the seabed calibration.

use serde::{Deserialize, Serialize};

/// `[seabed]`: the joint path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SeabedConfig {
    /// Whether a latency of the soundings is sought.
    pub latency: bool,
    /// Whether a range scale is sought within its prior; it is never reported as determined.
    pub range_scale: bool,
    /// Prior of the range scale.
    pub range_scale_sigma: f64,
    /// Prior of the heave channel's scale; 0 holds it.
    pub heave_scale_sigma: f64,
    /// Prior of the heave channel's lag, seconds; 0 holds it.
    pub heave_lag_sigma_s: f64,
    /// Side of a tile, metres, for 15 m of depth; longer in proportion where it is deeper.
    pub tile_m: f64,
    /// Most soundings of a tile.
    pub soundings_per_tile: usize,
    /// Most tiles.
    pub max_tiles: usize,
    /// Most passes of the fine phase.
    pub max_passes: usize,
    /// Soundings with a larger standardised residual are dropped.
    pub reject_sigmas: f64,
    /// Soundings further out than this are not used, degrees; stands in `[multibeam]`.
    #[serde(skip)]
    pub max_angle_deg: f64,
    /// Largest standard deviation of a determined angle, degrees.
    pub max_sigma_deg: f64,
    /// Largest standard deviation of pitch and yaw from the relief alone, degrees.
    pub max_relief_sigma_deg: f64,
    /// Seed of the draws; that of the calibration.
    #[serde(skip)]
    pub seed: u64,
}

impl Default for SeabedConfig {
    fn default() -> Self {
        Self {
            latency: true,
            range_scale: true,
            range_scale_sigma: 0.005,
            heave_scale_sigma: 0.05,
            heave_lag_sigma_s: 0.02,
            tile_m: 7.0,
            soundings_per_tile: 60,
            max_tiles: 600,
            max_passes: 10,
            reject_sigmas: 4.5,
            max_angle_deg: 65.0,
            max_sigma_deg: 1.0,
            max_relief_sigma_deg: 0.3,
            seed: 1,
        }
    }
}
