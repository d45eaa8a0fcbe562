//! A procedure on trial: one simulated survey calibrated by both paths, its errors known.

use nalgebra::DMatrix;
use serde::Serialize;

use crate::results::{NamedParameter, NamedSource};

/// Which sources act in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acting {
    /// All that the scenario has.
    All,
    /// None.
    None,
    /// The one of this place in [`Tried::sources`] alone.
    Only(usize),
}

/// What the joint path said in a trial, in the units of [`Tried::parameters`].
#[derive(Clone, Debug, PartialEq)]
pub struct JointSaid {
    /// Estimate minus truth.
    pub error: Vec<f64>,
    /// The covariance it reported.
    pub covariance: DMatrix<f64>,
    /// Its variance factor.
    pub variance_factor: Option<f64>,
}

/// One trial; a path without a usable result says why.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTrial {
    /// The joint path.
    pub joint: Result<JointSaid, String>,
    /// Estimate minus truth of the reference path; NaN for a parameter that it does not determine.
    pub reference: Result<Vec<f64>, String>,
}

/// A calibration that can be tried on simulated surveys.
pub trait Tried: Sync {
    /// `usbl`, `rail`.
    fn procedure(&self) -> &'static str;

    /// Name of the scenario.
    fn scenario(&self) -> &str;

    /// The parameters, in the order of all vectors.
    fn parameters(&self) -> Vec<NamedParameter>;

    /// The sources that act in the scenario.
    fn sources(&self) -> Vec<NamedSource>;

    /// Simulates under a seed and calibrates by both paths.
    fn trial(&self, seed: u64, acting: Acting) -> NamedTrial;
}

/// A source's key in a scenario.
#[must_use]
pub fn word(source: &impl Serialize) -> String {
    let value = serde_json::to_value(source).ok();
    let word = value.as_ref().and_then(|value| value.as_str());
    word.unwrap_or_default().to_owned()
}
