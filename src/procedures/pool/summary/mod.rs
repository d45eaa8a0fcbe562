//! A pool calibration's outcome as plain results: `result.json` and the samples of the report's pictures.
//!
//! | file | what |
//! |---|---|
//! | [`result`] | the whole [`Calibration`], its counts and the target's pose |
//! | `solutions` | an outcome of one path as its solution |
//! | `quality` | what the engine says of an adjustment, with names and in words |
//! | `comparison` | the paths against each other |
//! | [`residuals`] | distances of the soundings from the planes under each path's mounting |
//! | [`samples()`] | decimated points for the pictures |
//! | [`page()`] | the report's own section: the samples packed, and the scripts that draw them |

mod comparison;
mod page;
mod quality;
pub mod residuals;
mod sample_types;
mod samples;
mod solutions;

pub use page::{packed_page, page, true_values};
pub use sample_types::{
    FaceSample, FaceStatistics, PerPath, ReportSamples, ReturnSample, SoundingSample,
};
pub use samples::samples;
pub use solutions::SENSOR;

use std::collections::BTreeMap;

use serde::Serialize;

use super::config::{Drift, JointConfig, Planes};
use super::run::{Method, PoolInput, PoolOutcome};
use super::ties::{Reason, TieSet};
use crate::calibrate::conventions;
use crate::results::{Calibration, Provenance, SCHEMA, SensorCounts, Solutions};
use residuals::Residuals;

/// Observations that were read but dropped before the calibration (no position; `outside = "drop"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Soundings.
    pub soundings: u64,
    /// Laser returns.
    pub returns: u64,
}

/// What only a pool calibration has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoolDetails {
    /// The target's pose as refined from the laser points; `None` when the target was not found.
    pub target_pose: Option<TargetPose>,
}

/// What was added to the target's pose of the survey file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TargetPose {
    /// Origin: refined minus given, metres, axes of the target frame as given.
    pub offset_m: [f64; 3],
    /// Azimuth of the target's +Y axis: refined minus given, degrees, clockwise.
    pub azimuth_correction_deg: f64,
}

/// The outcome as `result.json` gives it; `notes` come from reading the survey.
///
/// # Errors
/// None for details made here; `serde_json` does not promise it.
pub fn result(
    outcome: &PoolOutcome,
    input: &PoolInput,
    dropped: Dropped,
    notes: &[String],
    provenance: Provenance,
) -> serde_json::Result<Calibration> {
    let residuals = Residuals::of(outcome);
    let solutions = solutions(outcome, input);
    let reason = reason(outcome, &solutions);
    let usable = reason.is_none();
    Ok(Calibration {
        schema: SCHEMA,
        procedure: "pool".to_owned(),
        provenance,
        usable,
        reason,
        verdict: outcome.verdict(),
        counts: counts(outcome, &residuals.ties, dropped),
        comparison: usable
            .then(|| comparison::compare(outcome, &solutions, &residuals))
            .flatten(),
        residual_rms_m: comparison::residual_rms_m(outcome, &residuals),
        notes: notes.iter().chain(&outcome.scene.notes).cloned().collect(),
        details: serde_json::to_value(PoolDetails {
            target_pose: target_pose(outcome),
        })?,
        conventions: conventions::deciding(&solutions, usable),
        solutions,
    })
}

/// One entry per path that was asked for, whether it came to run or not.
fn solutions(outcome: &PoolOutcome, input: &PoolInput) -> Solutions {
    let joint = input.method != Method::Reference;
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
        reference: (input.method != Method::Joint).then(|| solutions::reference(outcome, input)),
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
    match (&solutions.joint, &solutions.reference) {
        (Some(joint), _) => (!joint.usable).then(|| joint.message.clone()),
        (None, Some(reference)) => (!reference.usable).then(|| reference.message.clone()),
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

fn counts(
    outcome: &PoolOutcome,
    soundings: &TieSet,
    dropped: Dropped,
) -> BTreeMap<String, SensorCounts> {
    let campaign = outcome.scene.campaign;
    let returns = sensor_counts(campaign.laser.len(), returns_of(outcome), dropped.returns);
    let soundings = sensor_counts(campaign.soundings.len(), soundings, dropped.soundings);
    BTreeMap::from([
        ("soundings".to_owned(), soundings),
        ("returns".to_owned(), returns),
    ])
}

/// Rows with no verdict at all, because the calibration ended before they were looked at, are counted as such.
fn sensor_counts(rows: usize, ties: &TieSet, dropped: u64) -> SensorCounts {
    let used = ties.len() as u64;
    let mut by_reason = ties.rejected();
    if ties.is_blank() {
        by_reason.insert(Reason::NotLookedAt, rows as u64);
    }
    *by_reason.entry(Reason::OutsideTrajectory).or_default() += dropped;
    let mut rejected: BTreeMap<String, u64> = by_reason
        .into_iter()
        .map(|(reason, n)| (reason.name().to_owned(), n))
        .collect();
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
