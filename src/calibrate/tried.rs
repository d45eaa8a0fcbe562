//! A procedure on trial: simulated surveys calibrated by every path, their errors known; and what the procedure can say of its
//! error sources without a trial.

use std::path::Path;

use nalgebra::DMatrix;
use serde::Serialize;

use super::vary::{Point, VaryError};
use crate::adjust::Unit;
use crate::results::{CovarianceOrigin, SourceDescription, SwathResult};
use crate::simulate::switches::{Factors, Sourced};

/// Which sources act in a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acting {
    /// All that the scenario has.
    All,
    /// None.
    None,
    /// The one of this place in [`Tried::sources`] alone.
    Only(usize),
    /// All, each observation tied to what it truly struck, as nobody could outside a simulation ([`Tried::knows_true_ties`]).
    AllWithTrueTies,
}

impl Acting {
    /// The factors of a scenario's sources in such a trial; `source` tells the one of a place in [`Tried::sources`].
    #[must_use]
    pub fn factors<S: Sourced>(self, own: &Factors<S>, source: impl Fn(usize) -> S) -> Factors<S> {
        match self {
            Self::All | Self::AllWithTrueTies => own.clone(),
            Self::None => Factors::none(),
            Self::Only(place) => {
                let source = source(place);
                Factors::none().with(source, own.factor(source))
            }
        }
    }
}

/// A parameter that the procedure seeks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SoughtParameter {
    /// Its name.
    pub name: String,
    /// Unit of its error in a trial.
    pub unit: Unit,
}

/// One way to calibrate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TriedPath {
    /// Its key in results and files of trials: `joint`, `reference`.
    pub name: &'static str,
    /// Its variant as configured, such as `literal`; or empty.
    pub variant: String,
}

/// What a path said in a trial, in SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Said {
    /// Estimate minus truth.
    pub error: Vec<f64>,
    /// The covariance that it reported, if it reports one.
    pub covariance: Option<DMatrix<f64>>,
    /// Its variance factor, where it was judged.
    pub variance_factor: Option<f64>,
}

/// Whether a scenario with these faults can be simulated, in the words of [`Tried::check`].
///
/// # Errors
/// All of them.
pub fn faultless(faults: &[String]) -> Result<(), String> {
    if faults.is_empty() {
        return Ok(());
    }
    Err(format!("scenario: {}", faults.join("; ")))
}

/// Why a path gave nothing usable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// One word, for counting.
    pub code: String,
    /// In words.
    pub text: String,
}

impl Reason {
    /// On one line, so that a ledger holds it as one record.
    #[must_use]
    pub fn new(code: &str, text: &dyn std::fmt::Display) -> Self {
        let text = text.to_string().replace(['\n', '\r'], " ");
        let code = code.to_owned();
        Self { code, text }
    }

    /// With a code made of the words themselves; figures, which differ from trial to trial, are not part of it.
    #[must_use]
    pub fn of_words(text: &dyn std::fmt::Display) -> Self {
        let text = text.to_string();
        let words = text.split(|c: char| !c.is_alphabetic());
        let code: Vec<String> = words
            .filter(|word| !word.is_empty())
            .map(str::to_lowercase)
            .collect();
        Self::new(&code.join("_"), &text)
    }
}

/// One seed's outcome. Nothing is selected: a path without a usable result says why.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Seed of the simulation and of whatever the calibration draws.
    pub seed: u64,
    /// Every path, in the order of [`Tried::paths`].
    pub paths: Vec<Result<Said, Reason>>,
}

/// A calibration that can be tried on simulated surveys.
pub trait Tried: Sync {
    /// Name of the procedure.
    fn procedure(&self) -> &'static str;

    /// Name of the scenario.
    fn scenario(&self) -> &str;

    /// The scenario as it takes effect but for its seed, for its digest.
    fn content(&self) -> Vec<u8>;

    /// Whether it can be simulated.
    ///
    /// # Errors
    /// What stands against it.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// The configuration of all paths as it takes effect.
    fn configuration(&self) -> serde_json::Value;

    /// The parameters, in the order of all vectors.
    fn parameters(&self) -> Vec<SoughtParameter>;

    /// The paths; the first one is the joint adjustment, which reports a covariance.
    fn paths(&self) -> Vec<TriedPath>;

    /// The sources that act in the scenario.
    fn sources(&self) -> Vec<SourceDescription>;

    /// Whether trials can be run at all: of a survey that was observed nobody knows the truth.
    fn has_truth(&self) -> bool {
        true
    }

    /// Whether the simulation knows what each observation struck ([`Acting::AllWithTrueTies`]).
    fn knows_true_ties(&self) -> bool {
        false
    }

    /// Simulates under a seed and calibrates by all paths.
    fn trial(&self, seed: u64, acting: Acting) -> Trial;

    /// The same calibration on the scenario with other values.
    ///
    /// # Errors
    /// [`VaryError`]: an unknown key, or a value that makes the scenario impossible.
    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError>;

    /// Whether sources can be propagated without a trial.
    fn has_derivatives(&self) -> bool {
        false
    }

    /// Every source through the derivatives of the paths; `None` where the procedure has no such derivatives.
    fn propagated(&self) -> Option<Result<Propagated, String>> {
        None
    }

    /// What each path's calibration means for a sounding; `None` where the procedure takes no soundings.
    fn swath(&self, _known: Vec<PathCovariance>, _depths_m: &[f64]) -> Option<SwathResult> {
        None
    }

    /// Sentences that the reader of the budget should know.
    fn notes(&self) -> Vec<String> {
        vec![]
    }
}

/// What propagation says, in SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Propagated {
    /// The paths that have derivatives.
    pub paths: Vec<PropagatedPath>,
    /// Cramer-Rao bound: variances of any unbiased path.
    pub bound: Option<Vec<f64>>,
    /// Why a path is missing.
    pub notes: Vec<String>,
}

/// One path by propagation.
#[derive(Clone, Debug, PartialEq)]
pub struct PropagatedPath {
    /// As in [`Tried::paths`].
    pub name: &'static str,
    /// Error without any source.
    pub method_bias: Vec<f64>,
    /// What each source that acts does, or why it cannot be said.
    pub sources: Vec<(String, Result<Moved, &'static str>)>,
    /// Mean error of everything together.
    pub bias: Vec<f64>,
    /// Covariance of everything together.
    pub covariance: DMatrix<f64>,
}

/// What one source does.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Mean error.
    pub bias: Vec<f64>,
    /// Variance about it.
    pub variance: Vec<f64>,
}

/// Covariance of a path's calibration, in SI units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct PathCovariance {
    /// As in [`Tried::paths`].
    pub name: String,
    /// Where it is from.
    pub origin: CovarianceOrigin,
    /// The covariance.
    pub covariance: DMatrix<f64>,
}

/// A source's key in a scenario.
#[must_use]
pub fn word(source: &impl Serialize) -> String {
    let value = serde_json::to_value(source).ok();
    let word = value.as_ref().and_then(|value| value.as_str());
    word.unwrap_or_default().to_owned()
}

/// The last part of a path, as inputs are named in results.
#[must_use]
pub fn name_of(file: &Path) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str());
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_that_differ_in_figures_have_one_code() {
        let [a, b] =
            ["yaw: 0.3 deg,\n2 fixes", "yaw: 1.7 deg,\n11 fixes"].map(|t| Reason::of_words(&t));
        assert_eq!(a.code, "yaw_deg_fixes");
        assert_eq!(a.code, b.code);
        assert_eq!(a.text, "yaw: 0.3 deg, 2 fixes");
    }
}
