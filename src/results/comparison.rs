//! The paths against each other.

use super::{Angles, SixValues};
use serde::{Deserialize, Serialize};

/// Sequential minus joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The solution whose covariance is the measure, `joint`.
    pub reference: String,
    /// Sequential minus reference.
    pub difference: Difference,
    /// The difference in one sigma of the reference, which is not the sigma of the difference.
    pub in_joint_sigmas: SixValues,
    /// The difference in the metric of the reference's covariance, 6 degrees of freedom.
    pub chi_square: f64,
    /// Probability of a larger value by chance.
    pub p_value: f64,
    /// RMS of the soundings' distances from their faces.
    pub residual_rms_m: ResidualRms,
}

/// A difference of two mountings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Rotation vector in the body frame, degrees.
    pub correction_deg: Angles,
    /// Lever arm, body frame, metres.
    pub lever_arm_m: [f64; 3],
}

/// RMS of the used soundings' residuals along the faces' normals, metres, the same soundings for every path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualRms {
    /// Reference path.
    pub sequential: f64,
    /// Joint path.
    pub joint: f64,
    /// Simple joint path, where it ran.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_simple: Option<f64>,
}
