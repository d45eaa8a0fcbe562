//! What only a rail calibration has in its result.

use serde::{Deserialize, Serialize};

use crate::results::Parameter;

/// Everything beside the solutions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailDetails {
    /// Name of the standard profile.
    pub rail: String,
    /// Positions of the table.
    pub positions: u64,
    /// Range of the table's turns about the vertical and about the lateral axis, degrees.
    pub turned_deg: [f64; 2],
}

/// What only the reference path has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailReferenceDetails {
    /// How each profiler's angles came about.
    pub steps: Vec<RailReferenceSteps>,
}

/// What only the joint path has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailJointDetails {
    /// Everything that was estimated along: table, seat, rail, pivot.
    pub nuisance: Vec<Parameter>,
}

/// How the reference path found one profiler's angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailReferenceSteps {
    /// Its name.
    pub profiler: String,
    /// Turn of the level profile about the rail's axis after the coarse fit, degrees.
    pub coarse_roll_deg: f64,
    /// The same after the fine fit.
    pub fine_roll_deg: f64,
    /// Hausdorff distance of the 1:20 points over the turns about the vertical.
    pub heading_sweep: Vec<HausdorffStep>,
    /// Hausdorff distance of the R20 points over the turns about the lateral axis.
    pub pitch_sweep: Vec<HausdorffStep>,
    /// RMS distance of the level profile from the standard profile after the fine fit, metres.
    pub fine_rms_m: f64,
    /// The same after compensating the coordinates (claim 10) and fitting again.
    pub compensated_rms_m: f64,
}

/// Hausdorff distance at one position of the table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HausdorffStep {
    /// Heading or pitch of the INS against the rail, degrees.
    pub turn_deg: f64,
    /// Distance, metres.
    pub distance_m: f64,
}
