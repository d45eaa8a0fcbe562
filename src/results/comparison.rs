//! The reference solution against the joint one.

use serde::{Deserialize, Serialize};

/// Reference minus joint, parameter by parameter and together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// One entry per parameter that both paths determine.
    pub differences: Vec<Difference>,
    /// All differences together in the metric of the joint solution's covariance.
    pub chi_square: f64,
    /// Its degrees of freedom: the number of parameters compared that were not held.
    pub degrees_of_freedom: u32,
    /// Probability of a larger value by chance.
    pub p_value: f64,
}

impl Comparison {
    /// The parameter that differs most, in sigmas of the joint solution.
    #[must_use]
    pub fn largest(&self) -> Option<&Difference> {
        let size = |d: &&Difference| d.in_joint_sigmas.abs();
        self.differences
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))
    }
}

/// The reference solution minus the joint one, for one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// The parameter's name.
    pub name: String,
    /// Unit of the difference.
    pub unit: String,
    /// Reference minus joint; for angles the rotation between the two mountings, body frame.
    pub difference: f64,
    /// The same in one sigma of the joint solution, which is not the sigma of the difference; 0 where the parameter was held.
    pub in_joint_sigmas: f64,
}
