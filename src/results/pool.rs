//! The result of a pool calibration: the whole of `result.json`.

use super::{Comparison, JointSolution, Provenance, SequentialSolution, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the layout of `result.json`.
pub const SCHEMA: u32 = 1;

/// A pool calibration by both paths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoolResult {
    /// Layout version, [`SCHEMA`].
    pub schema: u32,
    /// Always `pool`.
    pub procedure: String,
    /// Program, seed, inputs and configuration.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Whether the deciding solution may be used: the joint one where it ran, else the sequential one. `false` goes with exit code 1.
    pub usable: bool,
    /// Why the result is not usable; `None` when it is.
    #[serde(default)]
    pub reason: Option<String>,
    /// Whether the result may be used, with everything that speaks against it.
    #[serde(default)]
    pub verdict: Verdict,
    /// Observations read, used and rejected.
    pub counts: Counts,
    /// The target's pose as refined from the laser points; `None` when the target was not found.
    pub target_pose: Option<TargetPose>,
    /// One entry per path that ran.
    pub solutions: Solutions,
    /// The paths against each other; `None` unless both are there.
    pub comparison: Option<Comparison>,
}

/// The solutions of the paths that ran.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Solutions {
    /// Reference path: angles, then offsets (patent CN105425246B steps 3 and 4).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sequential: Option<SequentialSolution>,
    /// Rigorous joint adjustment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<JointSolution>,
    /// Joint adjustment on the scanner's planes taken as error-free, without trajectory drift: for research.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_simple: Option<JointSolution>,
}

/// Counts of both sensors' observations.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Multibeam soundings.
    pub soundings: SensorCounts,
    /// Laser returns.
    pub returns: SensorCounts,
}

/// Counts of one sensor's observations; `read` is `used` and all of `rejected`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorCounts {
    /// Read from the file.
    pub read: u64,
    /// Entered the final adjustment.
    pub used: u64,
    /// Left out, by reason.
    pub rejected: BTreeMap<String, u64>,
}

/// What was added to the target's pose of the survey file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TargetPose {
    /// Origin: refined minus given, metres, axes of the target frame as given.
    pub offset_m: [f64; 3],
    /// Azimuth of the target's +Y axis: refined minus given, degrees, clockwise.
    pub azimuth_correction_deg: f64,
}
