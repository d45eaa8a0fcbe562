//! A pool calibration's outcome as plain results: `result.json` and the samples of the report's pictures.
//!
//! | file | what |
//! |---|---|
//! | [`result`] | the whole [`PoolResult`], its counts and the target's pose |
//! | `solutions` | an outcome of one path as its solution |
//! | `quality` | what the engine says of an adjustment, with names and in words |
//! | `comparison` | the paths against each other |
//! | [`residuals`] | distances of the soundings from the planes under each path's mounting |
//! | [`samples()`] | decimated points for the pictures |

mod comparison;
mod quality;
pub mod residuals;
mod samples;
mod solutions;

pub use samples::samples;

use super::config::{Drift, JointConfig, Planes};
use super::run::{Method, PoolInput, PoolOutcome};
use super::ties::TieSet;
use crate::results::{Counts, PoolResult, Provenance, SCHEMA, SensorCounts, Solutions, TargetPose};
use residuals::Residuals;

/// Reason under which observations without a position are counted.
pub const NO_POSITION: &str = "outside the trajectory";

/// Observations that were read but dropped before the calibration (no position; `outside = "drop"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Soundings.
    pub soundings: u64,
    /// Laser returns.
    pub returns: u64,
}

/// The outcome as `result.json` gives it.
#[must_use]
pub fn result(
    outcome: &PoolOutcome,
    input: &PoolInput,
    dropped: Dropped,
    provenance: Provenance,
) -> PoolResult {
    let residuals = Residuals::of(outcome);
    let solutions = solutions(outcome, input);
    let reason = reason(outcome, &solutions);
    let comparison = if reason.is_none() {
        comparison::compare(outcome, &solutions, &residuals)
    } else {
        None
    };
    PoolResult {
        schema: SCHEMA,
        procedure: "pool".to_owned(),
        provenance,
        usable: reason.is_none(),
        reason,
        verdict: outcome.verdict(),
        counts: counts(outcome, &residuals.ties, dropped),
        target_pose: target_pose(outcome),
        solutions,
        comparison,
    }
}

/// One entry per path that was asked for, whether it came to run or not.
fn solutions(outcome: &PoolOutcome, input: &PoolInput) -> Solutions {
    let joint = input.method != Method::Sequential;
    let simple = JointConfig {
        planes: Planes::Fixed,
        drift: Drift::Off,
        ..input.joint.clone()
    };
    let simple = PoolInput {
        joint: &simple,
        ..input.clone()
    };
    Solutions {
        sequential: (input.method != Method::Joint).then(|| solutions::sequential(outcome, input)),
        joint: joint.then(|| solutions::joint(outcome.joint.as_ref(), outcome, input)),
        joint_simple: (joint && input.joint.simple)
            .then(|| solutions::joint(outcome.simple.as_ref(), outcome, &simple)),
    }
}

/// Why there is no usable result; the joint path decides where it was asked for.
fn reason(outcome: &PoolOutcome, solutions: &Solutions) -> Option<String> {
    if let Some(refusal) = &outcome.refusal {
        return Some(refusal.to_string());
    }
    match (&solutions.joint, &solutions.sequential) {
        (Some(joint), _) => (!joint.usable).then(|| joint.message.clone()),
        (None, Some(sequential)) => (!sequential.usable).then(|| sequential.message.clone()),
        (None, None) => Some("no path was asked for".to_owned()),
    }
}

/// Ties of the returns: those of the joint path where it ran.
fn returns_of<'o>(outcome: &'o PoolOutcome) -> &'o TieSet {
    outcome
        .joint
        .as_ref()
        .map_or(&outcome.returns, |joint| &joint.returns)
}

fn counts(outcome: &PoolOutcome, soundings: &TieSet, dropped: Dropped) -> Counts {
    let campaign = outcome.scene.campaign;
    Counts {
        soundings: sensor_counts(campaign.soundings.len(), soundings, dropped.soundings),
        returns: sensor_counts(campaign.laser.len(), returns_of(outcome), dropped.returns),
    }
}

/// Rows with no verdict at all, because the calibration ended before they were looked at, are counted as such.
fn sensor_counts(rows: usize, ties: &TieSet, dropped: u64) -> SensorCounts {
    let used = ties.ties.len() as u64;
    let judged = used + ties.rejected.values().sum::<u64>();
    let mut rejected: std::collections::BTreeMap<String, u64> = ties
        .rejected
        .iter()
        .map(|(reason, n)| ((*reason).to_owned(), *n))
        .collect();
    *rejected.entry(NO_POSITION.to_owned()).or_default() += dropped;
    *rejected.entry("not looked at".to_owned()).or_default() +=
        (rows as u64).saturating_sub(judged);
    rejected.retain(|_, n| *n > 0);
    SensorCounts {
        read: rows as u64 + dropped,
        used,
        rejected,
    }
}

fn target_pose(outcome: &PoolOutcome) -> Option<TargetPose> {
    let scene = &outcome.scene;
    let found = scene.laser_near > 0 && outcome.rough.is_some();
    found.then(|| TargetPose {
        offset_m: scene.origin_shift_m.into(),
        azimuth_correction_deg: scene.azimuth_shift_rad.to_degrees(),
    })
}
