//! Parameters that are named, for procedures whose number of parameters the data decide.

use serde::{Deserialize, Serialize};

/// One parameter of a solution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Such as `roll` or `left head yaw`.
    pub name: String,
    /// Unit of all values, `1` for a ratio.
    pub unit: String,
    /// What was known before, where something was.
    pub nominal: Option<f64>,
    /// Estimate; `None` when not determined.
    pub value: Option<f64>,
    /// One sigma; `None` when not determined or where the path has none.
    pub standard_deviation: Option<f64>,
    /// What the reader should know, empty without.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// Two paths' parameters against each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterComparison {
    /// The solution whose covariance is the measure.
    pub reference: String,
    /// One entry per parameter that both paths determine.
    pub differences: Vec<ParameterDifference>,
    /// The differences in the metric of the reference's covariance.
    pub chi_square: f64,
    /// Its degrees of freedom: the number of parameters compared.
    pub degrees_of_freedom: u32,
    /// Probability of a larger value by chance.
    pub p_value: f64,
}

/// The other path minus the reference, for one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterDifference {
    /// The parameter's name.
    pub name: String,
    /// Unit of the difference.
    pub unit: String,
    /// Other minus reference.
    pub difference: f64,
    /// The same in one sigma of the reference, which is not the sigma of the difference.
    pub in_reference_sigmas: f64,
}
