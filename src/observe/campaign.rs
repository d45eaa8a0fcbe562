//! Everything that was observed, and how the sensors were believed to be mounted.

use super::{GeodeticTrajectory, LaserScan, Mounting, MountingSigma, SoundSpeed, Soundings};

/// One survey's observations in memory, before any calibration.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// The INS trajectory.
    pub trajectory: GeodeticTrajectory,
    /// The laser returns.
    pub laser: LaserScan,
    /// The soundings.
    pub soundings: Soundings,
    /// The scanner's (calibrated) mounting.
    pub scanner: Mounting,
    /// Uncertainty of the scanner's calibration; `None` means that it is taken as free of error, and said to be.
    pub scanner_sigma: Option<MountingSigma>,
    /// The multibeam's nominal mounting: what is to be corrected.
    pub sonar: Mounting,
    /// Sound speed, where the soundings are travel times.
    pub sound_speed: Option<SoundSpeed>,
    /// Height of the water level in the target frame, metres.
    pub water_level_m: f64,
}
