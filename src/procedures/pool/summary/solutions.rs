//! The outcome of one path as it stands in a result.

use nalgebra::DMatrix;
use serde_json::json;

use super::super::joint::JointOutcome;
use super::super::run::{PoolInput, PoolOutcome};
use super::super::verdict::Refusal;
use crate::adjust::{self, BlockId, Limits, Unit};
use crate::calibrate::solution::{Mounted, matrices, own_names, own_unknown, parameter};
use crate::observe::{self, ArrayMountings};
use crate::results::{Iteration, Parameter, Solution, Status};

/// Name of the sensor whose mounting is sought.
pub const SENSOR: &str = "multibeam";

/// The reference path.
pub fn reference(outcome: &PoolOutcome, input: &PoolInput) -> Solution {
    match &outcome.sequential {
        Some(Ok(found)) => found.solution(arrays_of(input)),
        Some(Err(error)) => no_reference(input, error.to_string()),
        None => no_reference(input, not_run(outcome)),
    }
}

/// The two arrays of the sounder before the calibration, where it has two.
fn arrays_of<'i>(input: &'i PoolInput) -> Option<&'i ArrayMountings> {
    let arrays = input.campaign.soundings.arrays.as_ref();
    arrays.map(|arrays| &arrays.mountings)
}

fn no_reference(input: &PoolInput, message: String) -> Solution {
    let config = input.sequential;
    Solution {
        details: json!({ "variant": config.variant.in_words(config.repeated), "passes": [] }),
        ..Solution::without_result(Status::Refused, message)
    }
}

fn not_run(outcome: &PoolOutcome) -> String {
    outcome
        .refusal
        .as_ref()
        .map_or_else(|| "did not run".to_owned(), ToString::to_string)
}

/// A joint path; refused with the run's reason where it did not come to run.
pub fn joint(joint: Option<&JointOutcome>, outcome: &PoolOutcome, input: &PoolInput) -> Solution {
    let Some(joint) = joint else {
        return Solution::without_result(Status::Refused, not_run(outcome));
    };
    let convergence = iterations(joint);
    let quality = super::quality::quality_of(joint, outcome, input);
    if let Some(refusal) = Refusal::of_joint(joint, input) {
        let status = match joint.solution.status {
            adjust::Status::RankDeficient { .. } => Status::RankDeficient,
            _ => Status::Refused,
        };
        return Solution {
            convergence,
            quality,
            ..Solution::without_result(status, refusal.to_string())
        };
    }
    let (status, message) = ending(joint);
    let own = own(joint, outcome.scene.extras);
    let covariance = covariance(joint);
    let mounted = Mounted {
        name: SENSOR,
        rotation: (
            &joint.mounting.rotation,
            &outcome.scene.campaign.sonar.rotation,
        ),
        lever_arm_m: Some((
            joint.mounting.lever_arm_m,
            outcome.scene.campaign.sonar.lever_arm_m,
        )),
        covariance: Some(&covariance),
        arrays: arrays_of(input),
    };
    let mut parameters = mounted.parameters("");
    parameters.extend(extra(joint).into_iter().map(|e| e.parameter(joint)));
    let names: Vec<String> = own.iter().map(|p| p.name.clone()).collect();
    let details = own_names(&names);
    parameters.extend(own);
    let (covariance, correlation) = matrices(&covariance);
    Solution {
        status,
        usable: true,
        message,
        mountings: vec![mounted.result()],
        parameters,
        covariance,
        correlation,
        convergence,
        quality,
        details,
    }
}

fn ending(joint: &JointOutcome) -> (Status, String) {
    match (&joint.solution.status, joint.stable) {
        (adjust::Status::Stalled, _) => (
            Status::Stalled,
            "no step lowers the cost any more".to_owned(),
        ),
        (_, false) => (
            Status::Stalled,
            format!(
                "after {} rounds some soundings still change their face",
                joint.rounds.len()
            ),
        ),
        _ => (Status::Converged, String::new()),
    }
}

fn iterations(joint: &JointOutcome) -> Vec<Iteration> {
    let numbered = joint.rounds.iter().enumerate();
    numbered
        .map(|(k, round)| Iteration {
            outer: k as u32 + 1,
            inner: round.inner as u32,
            cost: round.cost,
            largest_step_in_sigma: round.largest_step_in_sigma,
            reassigned: round.reassigned as u64,
        })
        .collect()
}

/// Covariance of the mounting's six and of the further parameters.
fn covariance(joint: &JointOutcome) -> DMatrix<f64> {
    let columns = joint.columns();
    let cofactor = &joint.solution.cofactor;
    DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
        cofactor[(columns[i], columns[j])]
    })
}

/// A parameter beside the six of the mounting.
struct Extra {
    id: BlockId,
    name: &'static str,
    positive: &'static str,
    unit: Unit,
    limit: f64,
}

/// Latency and range scale, where they are sought.
fn extra(joint: &JointOutcome) -> Vec<Extra> {
    let limits = Limits::default();
    let latency = joint.blocks.latency.map(|id| Extra {
        id,
        name: "latency",
        positive: "stamped too late",
        unit: Unit::Second,
        limit: limits.second,
    });
    let scale = joint.blocks.range_scale.map(|id| Extra {
        id,
        name: "range_scale",
        positive: "measured too short",
        unit: Unit::One,
        limit: limits.one,
    });
    latency.into_iter().chain(scale).collect()
}

/// The caller's own unknowns, in their own units.
fn own(joint: &JointOutcome, extras: &[observe::Extra]) -> Vec<Parameter> {
    let x = &joint.solution.estimate.parameters;
    let one = |(extra, id): (&observe::Extra, &BlockId)| {
        let (value, column) = (x.euclidean(*id)[0], x.offset(*id));
        let sigma = joint.solution.cofactor[(column, column)].sqrt();
        own_unknown((&extra.name, &extra.unit), extra.prior_sigma, value, sigma)
    };
    extras.iter().zip(&joint.blocks.extras).map(one).collect()
}

impl Extra {
    /// With its verdict: a parameter that the data do not determine has no value.
    fn parameter(&self, joint: &JointOutcome) -> Parameter {
        let x = &joint.solution.estimate.parameters;
        let column = x.offset(self.id);
        let sigma = joint.solution.cofactor[(column, column)].sqrt();
        let found = parameter(self.name, self.unit, x.euclidean(self.id)[0], Some(sigma));
        let positive = self.positive.to_owned();
        if sigma <= self.limit {
            return Parameter { positive, ..found };
        }
        Parameter {
            positive,
            value: None,
            correction: None,
            sigma: None,
            determined: false,
            note: "not observable in this survey".to_owned(),
            ..found
        }
    }
}
