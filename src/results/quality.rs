//! Quality figures of an adjustment ([`crate::adjust::assess`]).

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What every adjustment reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Weighted sum of squares by redundancy, a priori 1.
    pub variance_factor: f64,
    /// Conditions + priors - unknowns.
    pub degrees_of_freedom: u64,
    /// Chi-square test of the variance factor.
    pub global_test: GlobalTest,
    /// Observations by kind.
    pub groups: Vec<GroupQuality>,
    /// Every prior that entered as an observation.
    pub priors: Vec<Prior>,
    /// How well the observations control each other.
    pub reliability: Reliability,
    /// What the data determine.
    pub observability: Observability,
}

/// Two-sided test of the variance factor against 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GlobalTest {
    /// The variance factor tested.
    pub statistic: f64,
    /// Lower bound of the interval.
    pub lower: f64,
    /// Upper bound of the interval.
    pub upper: f64,
    /// Probability outside the interval, both sides together.
    pub significance: f64,
    /// Whether the statistic lies inside.
    pub passed: bool,
    /// A tolerance of the variance factor about 1 that matters in practice, where one was set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub practical_tolerance: Option<f64>,
    /// Why the test is void (variance components), empty when it is not.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub void_because: String,
}

/// One kind of observation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupQuality {
    /// Such as `multibeam range`.
    pub name: String,
    /// How many.
    pub observations: u64,
    /// Sum of their redundancy numbers.
    pub redundancy: f64,
    /// Estimated factor of the variance stated in the survey file; `None` when not separable and held at 1.
    pub variance_component: Option<f64>,
    /// One sigma of the component; `None` with it.
    pub standard_deviation: Option<f64>,
    /// Why it was held, or empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// A prior that entered as an observation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// What it holds.
    pub name: String,
    /// One sigma.
    pub standard_deviation: f64,
    /// Unit of the sigma.
    pub unit: String,
}

/// Reliability figures after Baarda.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reliability {
    /// Mean of the conditions' redundancy numbers, 0 to 1.
    pub mean_redundancy_number: f64,
    /// The smallest one.
    pub smallest_redundancy_number: f64,
    /// Power of the test that the minimal detectable biases refer to.
    pub power: f64,
    /// Its significance, for one test.
    pub significance: f64,
    /// Data snooping at one test's and at the family's significance.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tests: Vec<SnoopingTest>,
    /// Conditions with the largest normalised residuals, largest first.
    pub worst: Vec<WorstObservation>,
}

/// Data snooping at one level of significance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SnoopingTest {
    /// `single test` or `family-wise`.
    pub name: String,
    /// Its significance.
    pub significance: f64,
    /// |w| above which a condition is flagged.
    pub critical_value: f64,
    /// Non-centrality `delta0` at the stated power.
    pub non_centrality: f64,
    /// Conditions above the critical value.
    pub flagged: u64,
}

/// One suspicious condition. Range and angles of a sounding share it, so the faulty one of them cannot be named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstObservation {
    /// Such as `ping 211 beam 97`.
    pub observation: String,
    /// Normalised residual, in sigmas.
    pub w: f64,
    /// Smallest misfit found with the stated power, metres along the face's normal.
    pub minimal_detectable_bias_m: f64,
    /// What a misfit of that size does to the parameters, by field name (`yaw_deg`, `ly_m`); small ones left out.
    pub effect: BTreeMap<String, f64>,
}

/// What the data determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observability {
    /// Of the scaled normal matrix of all unknowns but the states.
    pub condition_number: f64,
    /// Its rank.
    pub rank: u32,
    /// Its size: the rank when everything is determined.
    #[serde(default)]
    pub unknowns: u32,
    /// Weakly determined directions, weakest first.
    pub weak: Vec<WeakDirection>,
}

/// A weakly determined combination of parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WeakDirection {
    /// One sigma along it, in the scaled parameters.
    pub sigma: f64,
    /// Its components by parameter, unit vector in the scaled parameters; small ones left out.
    pub combination: BTreeMap<String, f64>,
    /// In words, with what would help.
    pub text: String,
}
