//! The reference path against the joint one, in the joint one's metric.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Vector6};

use super::super::run::PoolOutcome;
use super::super::ties::PlacedBy;
use super::residuals::{Residuals, Sums};
use crate::calibrate::solution::{MOUNTING_PARAMETERS, compared};
use crate::observe::Mounting;
use crate::results::{Comparison, Solutions};

/// Reference minus joint; `None` unless both may be used.
pub fn compare(
    outcome: &PoolOutcome,
    solutions: &Solutions,
    residuals: &Residuals,
) -> Option<Comparison> {
    let (reference, joint) = (solutions.reference.as_ref()?, solutions.joint.as_ref()?);
    if !reference.usable || !joint.usable {
        return None;
    }
    let (from, to) = (residuals.models.joint?, residuals.models.reference?);
    let covariance = outcome.joint.as_ref()?.covariance;
    let d = difference(&from.sensor.mounting, &to.sensor.mounting);
    let named = MOUNTING_PARAMETERS.map(|(name, unit, _)| (name.to_owned(), unit));
    let covariance = DMatrix::from_column_slice(6, 6, covariance.as_slice());
    compared(named, d.as_slice(), &covariance)
}

/// Rotation vector (radians, body frame) and lever arm (metres) from one mounting to another.
fn difference(from: &Mounting, to: &Mounting) -> Vector6<f64> {
    let (turn, arm) = (to.correction_from(from), to.lever_arm_m - from.lever_arm_m);
    Vector6::new(turn.x, turn.y, turn.z, arm.x, arm.y, arm.z)
}

/// RMS of the used soundings' distances from their faces, metres, the same soundings for every path.
pub fn residual_rms_m(outcome: &PoolOutcome, residuals: &Residuals) -> BTreeMap<String, f64> {
    let of = |model: Option<PlacedBy>| {
        let mut all = Sums::default();
        let faces = residuals.sums(outcome, &model?);
        faces.iter().for_each(|face| all.merge(face));
        all.rms()
    };
    let models = &residuals.models;
    let named = [
        ("reference", models.reference),
        ("joint", models.joint),
        ("joint_simple", models.joint_simple),
    ];
    named
        .into_iter()
        .filter_map(|(name, model)| Some((name.to_owned(), of(model)?)))
        .collect()
}
