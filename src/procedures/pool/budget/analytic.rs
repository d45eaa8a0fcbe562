//! The error budget by propagation: bias and covariance of the six parameters from every source, by both paths, without a trial.
//!
//! The scenario is simulated once without any error, both paths are linearised on it ([`crate::procedures::pool::influence`]), and
//! each source is propagated ([`super::influence`]). What happens comes from the scenario (values, sigmas, the factors of its
//! `[sources]`), how observations weigh from what the survey claims. `docs/error-budget-theory.md` has the equations, what is not
//! predicted, and how well it agrees with Monte Carlo.

use nalgebra::{Matrix6, Vector3, Vector6};
use thiserror::Error;

use super::propagate::Budget;
use crate::adjust::AdjustError;
use crate::observe::Mounting;
use crate::procedures::pool::config::{JointConfig, Planes, SequentialConfig};
use crate::procedures::pool::influence::{self, difference};
use crate::procedures::pool::joint;
use crate::procedures::pool::sequential::SequentialError;
use crate::procedures::pool::{Method, PoolError, PoolInput, PoolOutcome, calibrate};
use crate::simulate::{Scenario, SimulateError, Source, Sources, simulate};
use crate::watch::Unwatched;

/// What one source does to pitch, roll, yaw (rad), lx, ly, lz (m).
#[allow(
    clippy::large_enum_variant,
    reason = "a few dozen of them, mostly of the large kind"
)]
#[derive(Clone, Debug, PartialEq)]
pub enum Prediction {
    /// To first order.
    Linear {
        /// Mean error.
        bias: Vector6<f64>,
        /// Covariance of the error about its mean.
        covariance: Matrix6<f64>,
    },
    /// It acts in this scenario, but has no derivative.
    NotPredicted {
        /// Why.
        reason: &'static str,
    },
}

/// One path's budget.
#[derive(Clone, Debug, PartialEq)]
pub struct PathBudget {
    /// Every source, in the order of [`Source::ALL`].
    pub sources: Vec<(Source, Prediction)>,
    /// Error of the path in data free of errors: the method's own.
    pub method_bias: Vector6<f64>,
    /// Mean error of all predicted sources and the method together.
    pub bias: Vector6<f64>,
    /// Covariance of all predicted sources together.
    pub covariance: Matrix6<f64>,
}

/// The budget of a scenario by propagation. Order of every vector: pitch, roll, yaw (rad), lx, ly, lz (m).
#[derive(Clone, Debug)]
pub struct Analytic {
    /// The joint path.
    pub joint: PathBudget,
    /// The reference path in its projected variant, or why it does not run.
    pub sequential: Result<PathBudget, SequentialError>,
    /// Covariance that the joint path claims before any data: its cofactors with the sigmas of the survey.
    pub claimed: Matrix6<f64>,
    /// Cramer-Rao bound: cofactors of the rigorous model under least squares with the standard deviations that really act;
    /// `None` where a noise-free observation leaves none.
    pub bound: Option<Matrix6<f64>>,
    /// Soundings that the joint path ties.
    pub soundings: usize,
    /// Laser returns that it ties.
    pub returns: usize,
}

impl Analytic {
    /// Bound by variance of each parameter, 1 at best (bias aside); `None` without a bound.
    #[must_use]
    pub fn efficiency(&self, path: &PathBudget) -> Option<Vector6<f64>> {
        let bound = self.bound?.diagonal();
        Some(bound.component_div(&path.covariance.diagonal()))
    }
}

/// Why there is no budget.
#[derive(Debug, Error)]
pub enum AnalyticError {
    /// The scenario cannot be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// The calibration cannot be run.
    #[error(transparent)]
    Pool(#[from] PoolError),
    /// The engine refuses.
    #[error("adjustment: {0}")]
    Adjust(#[from] AdjustError),
    /// There is no result to propagate to.
    #[error(
        "error budget: {scenario}: the calibration to be propagated ends without a result: {reason}"
    )]
    Refused {
        /// Name of the scenario.
        scenario: String,
        /// What the calibration says.
        reason: String,
    },
    /// The joint path takes the scanner's planes as free of error, so that its adjustment has no derivative by the returns.
    #[error(
        "error budget: joint.planes = \"fixed\" found, expected \"adjusted\" for analytic propagation"
    )]
    FixedPlanes,
}

/// The budget of a scenario with the default configuration of both paths.
///
/// # Errors
/// [`AnalyticError`].
pub fn analytic(scenario: &Scenario) -> Result<Analytic, AnalyticError> {
    analytic_with(
        scenario,
        &SequentialConfig::default(),
        &JointConfig::default(),
    )
}

/// The budget of a scenario. Of the sequential configuration the variant is not used: only the projected one has a derivative.
///
/// # Errors
/// [`AnalyticError`].
pub fn analytic_with(
    scenario: &Scenario,
    sequential: &SequentialConfig,
    joint: &JointConfig,
) -> Result<Analytic, AnalyticError> {
    if joint.planes == Planes::Fixed {
        return Err(AnalyticError::FixedPlanes);
    }
    let perfect = Scenario {
        sources: Sources::none(),
        ..scenario.clone()
    };
    let survey = simulate(&perfect, perfect.seed)?;
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Joint,
        sequential,
        joint,
        seed: perfect.seed,
        extras: &[],
    };
    propagated(scenario, &input, Some(survey.reality.sonar))
}

/// The budget of a survey as it was observed: what the sources claimed in its file do to its own calibration. Both paths are
/// linearised at what they found in the observations; their difference from the truth, which nobody knows, is not in it.
///
/// `claimed` is the survey in a scenario's words: its sigmas are used, its passes are not.
///
/// # Errors
/// [`AnalyticError`].
pub fn of_survey(claimed: &Scenario, input: &PoolInput) -> Result<Analytic, AnalyticError> {
    if input.joint.planes == Planes::Fixed {
        return Err(AnalyticError::FixedPlanes);
    }
    propagated(claimed, input, None)
}

/// Calibrates, and propagates every source of the scenario; without a `truth` each path's own result stands for it.
fn propagated(
    scenario: &Scenario,
    input: &PoolInput,
    truth: Option<Mounting>,
) -> Result<Analytic, AnalyticError> {
    let joint = input.joint;
    let outcome = calibrate(input, &Unwatched)?;
    let Some(found) = outcome.joint.as_ref().filter(|_| outcome.refusal.is_none()) else {
        let refusal = outcome.refusal.as_ref().map(ToString::to_string);
        return Err(AnalyticError::Refused {
            scenario: scenario.name.clone(),
            reason: refusal.unwrap_or_default(),
        });
    };
    let budget = Budget {
        scenario,
        scene: &outcome.scene,
        truth: truth.unwrap_or(found.mounting),
        normals: normals(&outcome),
    };
    let method_bias = |path: &Mounting| truth.map_or_else(Vector6::zeros, |t| difference(path, &t));
    let claimed = influence::joint(&outcome.scene, found, joint, [1.0; 2])?;
    let tail = budget.tail(&claimed.pulls, joint::options(joint).kernel);
    let shrunk = influence::joint(&outcome.scene, found, joint, tail.map(|t| t.part))?;
    let sequential = influence::sequential(input, &outcome)
        .map(|s| budget.path(&s.pulls, [1.0; 2], method_bias(&s.mounting)));
    let own_bias = method_bias(&found.mounting);
    let joint_budget = budget.path(&shrunk.pulls, tail.map(|t| t.inflation), own_bias);
    let truth = budget.true_noise(input.campaign);
    let (soundings, returns) = (claimed.pulls.soundings.len(), claimed.pulls.returns.len());
    let parameters = budget.true_priors(found);
    let mut scene = outcome.scene;
    scene.campaign = &truth;
    let bound = influence::cofactor(&scene, found, parameters, joint).ok();
    Ok(Analytic {
        joint: joint_budget,
        sequential,
        claimed: claimed.covariance,
        bound,
        soundings,
        returns,
    })
}

/// Normal of every face's group as the scanner saw it, as designed where it saw too little.
fn normals(outcome: &PoolOutcome) -> Vec<Option<Vector3<f64>>> {
    let target = outcome.scene.target;
    let seen = |group: usize| Some(outcome.planes[group]?.fit.plane.normal);
    let normal = |group: usize| seen(group).unwrap_or(target.groups[group].normal);
    let faces = target.faces.iter();
    faces.map(|f| Some(normal(f.group))).collect()
}
