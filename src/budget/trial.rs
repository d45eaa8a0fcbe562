//! One trial without files: simulate under a seed, calibrate by both paths, compare with the truth.

use nalgebra::{Matrix3, Matrix6, Vector3};

use crate::adjust::BlockId;
use crate::geometry::rotation;
use crate::observe::Mounting;
use crate::procedures::pool::config::Variant;
use crate::procedures::pool::joint::JointOutcome;
use crate::procedures::pool::sequential::{Outcome, SequentialError};
use crate::procedures::pool::{
    JointConfig, Method, PoolInput, PoolOutcome, SequentialConfig, calibrate_with,
    calibrate_with_true_ties,
};
use crate::results::Status;
use crate::simulate::{Scenario, Truth, simulate};

/// How trials are calibrated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Configuration {
    /// The reference path; the projected variant of the same runs beside it.
    pub sequential: SequentialConfig,
    /// The joint path.
    pub joint: JointConfig,
    /// Whether observations are only tied to the face that they truly struck, as nobody could outside a simulation.
    pub true_ties: bool,
}

impl Configuration {
    /// The reference path with its projected variant, which has a derivative.
    #[must_use]
    pub fn projected(&self) -> SequentialConfig {
        SequentialConfig {
            variant: Variant::Projected,
            ..self.sequential.clone()
        }
    }
}

/// A path's error against the truth: `log(R R_true^T)` (pitch, roll, yaw; radians) and lever arm (lx, ly, lz; metres), body frame.
pub type Error6 = [f64; 6];

/// What the joint path said.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTrial {
    /// Estimate minus truth.
    pub error: Error6,
    /// The covariance it reported, rad and m.
    pub covariance: Matrix6<f64>,
    /// Its variance factor, where it was judged.
    pub variance_factor: Option<f64>,
    /// Latency and range scale, where they were unknowns. A ledger does not keep them.
    pub optional: Vec<OptionalError>,
}

/// Error of an optional unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionalError {
    /// `latency` (seconds) or `range_scale`.
    pub name: &'static str,
    /// Estimate minus truth.
    pub error: f64,
    /// The standard deviation that was reported.
    pub sigma: f64,
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
    fn new(code: &str, text: &dyn std::fmt::Display) -> Self {
        let text = text.to_string().replace(['\n', '\r'], " ");
        let code = code.to_owned();
        Self { code, text }
    }
}

/// One seed's outcome. Nothing is selected: a path without a usable result says why.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Seed of the simulation and of RANSAC.
    pub seed: u64,
    /// The joint path.
    pub joint: Result<JointTrial, Reason>,
    /// The reference path as configured (literal by default).
    pub sequential: Result<Error6, Reason>,
    /// Its projected variant.
    pub projected: Result<Error6, Reason>,
}

/// Runs one trial.
#[must_use]
pub fn trial(scenario: &Scenario, configuration: &Configuration, seed: u64) -> Trial {
    let survey = match simulate(scenario, seed) {
        Ok(survey) => survey,
        Err(error) => return Trial::without(seed, &Reason::new("not_simulated", &error)),
    };
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &configuration.sequential,
        joint: &configuration.joint,
        seed,
    };
    let further = [configuration.projected()];
    let outcome = if configuration.true_ties {
        calibrate_with_true_ties(&input, &survey.struck, &further)
    } else {
        calibrate_with(&input, &further, &|_| {})
    };
    match outcome {
        Ok(outcome) => Trial::of(seed, &outcome, &survey.truth),
        Err(error) => Trial::without(seed, &Reason::new("not_run", &error)),
    }
}

impl Trial {
    fn without(seed: u64, reason: &Reason) -> Self {
        Self {
            seed,
            joint: Err(reason.clone()),
            sequential: Err(reason.clone()),
            projected: Err(reason.clone()),
        }
    }

    fn of(seed: u64, outcome: &PoolOutcome, truth: &Truth) -> Self {
        let refusal = outcome.refusal.as_ref();
        let refused = refusal.map_or_else(
            || Reason::new("not_run", &"the path did not run"),
            |r| Reason::new(r.code(), r),
        );
        let joint = outcome.joint.as_ref().filter(|_| refusal.is_none());
        let reference = |path: Option<&Result<Outcome, SequentialError>>| {
            path.map_or_else(|| Err(refused.clone()), |p| reference(p, truth))
        };
        Self {
            seed,
            joint: joint
                .map(|j| of_joint(j, truth))
                .ok_or_else(|| refused.clone()),
            sequential: reference(outcome.sequential.as_ref()),
            projected: reference(outcome.further.first()),
        }
    }
}

fn of_joint(joint: &JointOutcome, truth: &Truth) -> JointTrial {
    JointTrial {
        error: errors(&joint.mounting, truth),
        covariance: joint.covariance,
        variance_factor: joint.variance_factor(),
        optional: optional(joint, truth),
    }
}

fn optional(joint: &JointOutcome, truth: &Truth) -> Vec<OptionalError> {
    let x = &joint.solution.estimate.parameters;
    let unknowns = [
        ("latency", joint.blocks.latency, truth.latency_s),
        ("range_scale", joint.blocks.range_scale, truth.range_scale),
    ];
    let one = |(name, id, truth): (&'static str, Option<BlockId>, f64)| {
        let (id, column) = (id?, x.offset(id?));
        Some(OptionalError {
            name,
            error: x.euclidean(id)[0] - truth,
            sigma: joint.solution.cofactor[(column, column)].sqrt(),
        })
    };
    unknowns.into_iter().filter_map(one).collect()
}

/// A stalled end counts as usable, being out of passes does not.
fn reference(path: &Result<Outcome, SequentialError>, truth: &Truth) -> Result<Error6, Reason> {
    match path {
        Ok(found) if found.end.status() == Status::OutOfIterations => {
            Err(Reason::new("out_of_passes", &found.end.message()))
        }
        Ok(found) => Ok(errors(&found.mounting, truth)),
        Err(error) => Err(Reason::new("sequential", error)),
    }
}

/// Estimate minus truth: pitch, roll, yaw (radians), lx, ly, lz (metres), left perturbation in the body frame.
#[must_use]
pub fn errors(found: &Mounting, truth: &Truth) -> Error6 {
    let r = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let turn = rotation::log(&(found.rotation * r.transpose()));
    let arm = found.lever_arm_m - Vector3::from(truth.lever_arm_m);
    [turn.x, turn.y, turn.z, arm.x, arm.y, arm.z]
}
