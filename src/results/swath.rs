//! What a calibration's uncertainty means for soundings across the swath, against the orders of IHO S-44.

use serde::{Deserialize, Serialize};

use super::BudgetPath;

/// Uncertainty of soundings at 95 %, by path and depth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SwathResult {
    /// The standard that the orders are of.
    pub standard: String,
    /// What is assumed.
    pub assumptions: String,
    /// Depths, with the limits of every order at each.
    pub limits: Vec<SwathLimits>,
    /// Each path with its covariance.
    pub paths: Vec<PathSwath>,
}

/// Limits of the orders at a depth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SwathLimits {
    /// Depth below the sonar.
    pub depth_m: f64,
    /// The orders, the strictest first.
    pub orders: Vec<OrderLimit>,
}

/// An order's limits at a depth, 95 %.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrderLimit {
    /// Its name.
    pub order: String,
    /// Horizontal.
    pub horizontal_m: f64,
    /// Vertical.
    pub vertical_m: f64,
}

/// Where a calibration's covariance is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CovarianceOrigin {
    /// Mean of what the path reported in the trials.
    Reported,
    /// Errors of the trials about zero, the bias included.
    Errors,
    /// Propagated through the derivatives, the bias included.
    Propagated,
    /// Predicted from one linearisation of each pass, without trials.
    Predicted,
}

/// The swath under one path's calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathSwath {
    /// Which.
    pub path: BudgetPath,
    /// Where the covariance is from.
    pub origin: CovarianceOrigin,
    /// Covariance of pitch, roll, yaw (rad), lx, ly, lz (m).
    pub covariance: [[f64; 6]; 6],
    /// Depths in ascending order.
    pub depths: Vec<SwathDepth>,
}

/// The swath at a depth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SwathDepth {
    /// Depth below the sonar.
    pub depth_m: f64,
    /// Beams from port to starboard.
    pub beams: Vec<SwathBeam>,
}

/// One beam.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SwathBeam {
    /// Angle from the vertical, positive to starboard.
    pub angle_deg: f64,
    /// What the calibration adds.
    pub calibration: Uncertainty95,
    /// INS and sonar alone.
    pub sensors: Uncertainty95,
    /// All together.
    pub total: Uncertainty95,
    /// The strictest order that the total keeps.
    pub order: Option<String>,
}

/// Uncertainty at 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Uncertainty95 {
    /// Horizontal.
    pub horizontal_m: f64,
    /// Vertical.
    pub vertical_m: f64,
}
