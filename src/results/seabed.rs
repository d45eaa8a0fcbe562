//! The result of a seabed calibration, in the named form of schema 2.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Provenance, Verdict};

/// The whole of `result.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeabedResult {
    /// Layout version: 2.
    pub schema: u32,
    /// Always `seabed`.
    pub procedure: String,
    /// Program, seed, inputs and configuration.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Whether the deciding solution may be used.
    pub usable: bool,
    /// Why not; `None` when it may.
    pub reason: Option<String>,
    /// The verdict and everything that speaks against the result.
    pub verdict: Verdict,
    /// Soundings by what became of them.
    pub counts: BTreeMap<String, u64>,
    /// One entry per path that was asked for.
    pub solutions: SeabedSolutions,
    /// Sentences that the reader should know.
    pub notes: Vec<String>,
    /// Tracks, pairs, the field, every pass, every step of the patch test.
    pub details: serde_json::Value,
}

/// The solutions of the paths that ran.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SeabedSolutions {
    /// The classical patch test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<SeabedSolution>,
    /// The joint adjustment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<SeabedSolution>,
}

/// What one path found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SeabedSolution {
    /// `converged`, `out_of_iterations` or `refused`.
    pub status: String,
    /// Whether pitch, roll and yaw may be used.
    pub usable: bool,
    /// The end in words.
    pub message: String,
    /// The parameters.
    pub parameters: Vec<SeabedParameter>,
    /// Covariance in the parameters' order: rad, m, s, 1. `None` for a path that has none.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// The sonar's mounting; empty unless all three angles are determined.
    pub mountings: Vec<SeabedMounting>,
}

/// One parameter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SeabedParameter {
    /// Its name.
    pub name: String,
    /// Unit of its figures: `deg`, `m`, `s`, or `1`.
    pub unit: String,
    /// What the calibration changes; for angles components of `log(R R_nominal^T)` in the body frame. `None` when refused.
    pub correction: Option<f64>,
    /// One sigma.
    pub sigma: Option<f64>,
    /// One sigma from the relief alone.
    pub relief_sigma: Option<f64>,
    /// One sigma from the boat's motion alone.
    pub motion_sigma: Option<f64>,
    /// Whether the path determined it; held ones it did not.
    pub determined: bool,
    /// What the reader should know.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// The sonar's mounting before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeabedMounting {
    /// `multibeam`.
    pub name: String,
    /// Sonar into body, by rows.
    pub rotation_matrix: [[f64; 3]; 3],
    /// The same before.
    pub nominal_rotation_matrix: [[f64; 3]; 3],
    /// Roll, pitch, heading of a survey file, degrees.
    pub mounting_deg: BTreeMap<String, f64>,
    /// Lever arm, metres.
    pub lever_arm_m: [f64; 3],
    /// The same before.
    pub nominal_lever_arm_m: [f64; 3],
}
