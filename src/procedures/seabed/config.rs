//! Settings of the seabed calibration.

use crate::calibrate::verdict::VerdictConfig;
use crate::survey::limits::{ABOVE, Limits, limits};
use crate::survey::schema::Kind;
use crate::survey::section::section;

const PART: Limits = limits(0.0, 0.1, "a number from 0 to 0.1");
const DEGREES: Limits = limits(ABOVE, 180.0, "degrees above 0 and up to 180");

section! {
    #[settings]
    /// `[seabed]`: the joint path.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SeabedConfig {
        /// Whether a latency of the soundings is estimated.
        latency: bool = or (true), Kind::Flag;
        /// Whether a range scale is estimated within its prior; it absorbs errors of its kind and is never reported as determined.
        range_scale: bool = or (true), Kind::Flag;
        /// Prior of the range scale; 0 holds it.
        range_scale_sigma: f64 = or (0.005), Kind::Number(PART);
        /// Prior of the heave channel's scale; 0 holds it.
        heave_scale_sigma: f64 = or (0.05), Kind::Number(limits(0.0, 1.0, "a number from 0 to 1"));
        /// Prior of the heave channel's lag, seconds; 0 holds it.
        heave_lag_sigma_s: f64 = or (0.02), Kind::Number(limits(0.0, 1.0, "seconds from 0 to 1"));
        /// Side of a tile, metres, for 15 m of water and less; longer in proportion where it is deeper.
        tile_m: f64 = or (7.0), Kind::Number(limits(1.0, 100.0, "metres from 1 to 100"));
        /// Most soundings in a tile.
        soundings_per_tile: usize = or (60), Kind::Count(limits(16.0, 256.0, "16 to 256"));
        /// Most tiles.
        max_tiles: usize = or (1500), Kind::Count(limits(20.0, 100_000.0, "20 to 100000"));
        /// Most passes of the fine phase.
        max_passes: usize = or (16), Kind::Count(limits(6.0, 100.0, "6 to 100"));
        /// Soundings with a larger standardised residual are dropped.
        reject_sigmas: f64 = or (4.5), Kind::Number(limits(4.0, 1000.0, "sigmas from 4 (a narrower limit makes the standard deviations too small) to 1000"));
        /// An angle whose standard deviation exceeds this (degrees) is refused.
        max_sigma_deg: f64 = or (1.0), Kind::Number(DEGREES);
        /// Pitch or yaw is refused when its standard deviation from the relief alone exceeds this (degrees): the rest is as true as the heave.
        max_relief_sigma_deg: f64 = or (0.3), Kind::Number(DEGREES);
    }
}

/// What the joint path is told besides the survey.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSettings {
    /// `[seabed]`.
    pub seabed: SeabedConfig,
    /// Soundings further out than this are not used, degrees.
    pub max_angle_deg: f64,
    /// `[verdict]`.
    pub verdict: VerdictConfig,
    /// Seed of the draws; that of the calibration.
    pub seed: u64,
}
