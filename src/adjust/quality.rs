//! What every adjustment reports (mathematics section 6).
#![allow(missing_docs)]

use nalgebra::DMatrix;

use super::error::AdjustError;
use super::problem::Problem;
use super::solve::Solution;

#[derive(Debug, Clone, PartialEq)]
pub struct QualityOptions {
    pub test_alpha: f64,
    pub power: f64,
    pub family_alpha: f64,
    pub worst: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Quality {
    pub global: GlobalTest,
    pub groups: Vec<GroupQuality>,
    pub worst: Vec<ConditionQuality>,
    pub correlation: DMatrix<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct GlobalTest {
    pub omega: f64,
    pub degrees_of_freedom: f64,
    pub variance_factor: f64,
    pub interval: (f64, f64),
    pub passed: bool,
    pub void: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct GroupQuality {
    pub group: u16,
    pub conditions: usize,
    pub redundancy: f64,
    pub omega: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ConditionQuality {
    pub source: usize,
    pub condition: usize,
    pub redundancy: f64,
    pub normalised: f64,
    pub detectable_bias: f64,
}

/// Judges a solution.
///
/// # Errors
/// See [`AdjustError`].
pub fn assess(
    _problem: &Problem,
    _solution: &Solution,
    _options: &QualityOptions,
) -> Result<Quality, AdjustError> {
    todo!()
}
