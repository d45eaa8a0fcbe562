//! The reference path against the joint one, in the joint one's metric.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};

use super::super::run::PoolOutcome;
use super::super::ties::PlacedBy;
use super::residuals::{Residuals, Sums};
use crate::calibrate::metric;
use crate::calibrate::quality::readable;
use crate::calibrate::solution::MOUNTING_PARAMETERS;
use crate::observe::Mounting;
use crate::results::{Comparison, Difference, Solutions};

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
    let (chi_square, free, p_value) = metric::chi_square(
        &DVector::from_column_slice(d.as_slice()),
        &DMatrix::from_column_slice(6, 6, covariance.as_slice()),
    )?;
    Some(Comparison {
        differences: named(&d, &covariance),
        chi_square,
        degrees_of_freedom: free as u32,
        p_value,
    })
}

/// Rotation vector (radians, body frame) and lever arm (metres) from one mounting to another.
fn difference(from: &Mounting, to: &Mounting) -> Vector6<f64> {
    let (turn, arm) = (to.correction_from(from), to.lever_arm_m - from.lever_arm_m);
    Vector6::new(turn.x, turn.y, turn.z, arm.x, arm.y, arm.z)
}

/// Each difference by its name, also in one sigma; 0 where the parameter was held.
fn named(d: &Vector6<f64>, covariance: &Matrix6<f64>) -> Vec<Difference> {
    let one = |(i, (name, unit, _)): (usize, (&str, _, &str))| {
        let variance = covariance[(i, i)];
        let (difference, unit) = readable(d[i], unit);
        let in_joint_sigmas = if variance > 0.0 {
            d[i] / variance.sqrt()
        } else {
            0.0
        };
        Difference {
            name: name.to_owned(),
            unit: unit.to_owned(),
            difference,
            in_joint_sigmas,
        }
    };
    MOUNTING_PARAMETERS
        .into_iter()
        .enumerate()
        .map(one)
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_parameter_differs_by_nothing() {
        let covariance = Matrix6::from_diagonal(&Vector6::new(1.0, 4.0, 9.0, 0.01, 0.04, 0.0));
        let all = named(&Vector6::repeat(2.0), &covariance);
        assert_eq!((all[1].in_joint_sigmas, all[5].in_joint_sigmas), (1.0, 0.0));
        assert_eq!(
            (&*all[1].unit, all[1].difference),
            ("deg", 2_f64.to_degrees())
        );
    }
}
