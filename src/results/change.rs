//! What became of a vessel's mountings between two calibrations: `boresight compare --json`.

use serde::{Deserialize, Serialize};

/// Two calibrations of the same mountings, compared with both covariances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Layout version.
    pub schema: u32,
    /// The parameters that both calibrations determined.
    pub parameters: Vec<ParameterChange>,
    /// `d^T (C_before + C_after)^-1 d` of all of them.
    pub chi_square: f64,
    /// Their number.
    pub degrees_of_freedom: u64,
    /// Probability of a larger value where nothing changed.
    pub p_value: f64,
    /// Error probability of the whole comparison: half of it for all parameters together, half for the single ones.
    pub significance: f64,
    /// Whether something changed by more than both uncertainties explain.
    pub changed: bool,
    /// Sentences that the reader should know, without a full stop.
    pub notes: Vec<String>,
}

/// One parameter, after minus before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterChange {
    /// Such as `roll` or `left yaw`.
    pub name: String,
    /// `deg` or `m`.
    pub unit: String,
    /// The change; of angles the component of the turn between the two mountings in the body frame.
    pub change: f64,
    /// Its sigma, from both covariances.
    pub sigma: f64,
    /// The change in its sigmas.
    pub in_sigmas: f64,
    /// Two-sided probability of a larger one where nothing changed.
    pub p_value: f64,
    /// Whether it is significant by itself.
    pub changed: bool,
}
