//! The sequential path against the joint one, in the joint one's metric.

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};

use super::super::run::PoolOutcome;
use super::residuals::{Model, Residuals, Sums};
use super::solutions::angles_deg;
use crate::calibrate::metric;
use crate::observe::Mounting;
use crate::results::{Comparison, Difference, ResidualRms, SixValues, Solutions};

/// Sequential minus joint; `None` unless both may be used.
pub fn compare(
    outcome: &PoolOutcome,
    solutions: &Solutions,
    residuals: &Residuals,
) -> Option<Comparison> {
    let (Some(sequential), Some(joint)) = (&solutions.sequential, &solutions.joint) else {
        return None;
    };
    if !sequential.usable || !joint.usable {
        return None;
    }
    let (from, to) = (residuals.models.joint?, residuals.models.sequential?);
    let covariance = outcome.joint.as_ref()?.covariance;
    let d = difference(&from.mounting, &to.mounting);
    let (chi_square, _, p_value) = metric::chi_square(
        &DVector::from_column_slice(d.as_slice()),
        &DMatrix::from_column_slice(6, 6, covariance.as_slice()),
    )?;
    Some(Comparison {
        reference: "joint".to_owned(),
        difference: Difference {
            correction_deg: angles_deg(&d.fixed_rows::<3>(0).into_owned()),
            lever_arm_m: [d[3], d[4], d[5]],
        },
        in_joint_sigmas: in_sigmas(&d, &covariance),
        chi_square,
        p_value,
        residual_rms_m: rms(outcome, residuals, &from, &to)?,
    })
}

/// Rotation vector (radians, body frame) and lever arm (metres) from one mounting to another.
fn difference(from: &Mounting, to: &Mounting) -> Vector6<f64> {
    let (turn, arm) = (to.correction_from(from), to.lever_arm_m - from.lever_arm_m);
    Vector6::new(turn.x, turn.y, turn.z, arm.x, arm.y, arm.z)
}

/// Each difference in one sigma; 0 where the parameter was held.
fn in_sigmas(d: &Vector6<f64>, covariance: &Matrix6<f64>) -> SixValues {
    let v = |i: usize| {
        let variance = covariance[(i, i)];
        if variance > 0.0 {
            d[i] / variance.sqrt()
        } else {
            0.0
        }
    };
    SixValues {
        pitch: v(0),
        roll: v(1),
        yaw: v(2),
        lx: v(3),
        ly: v(4),
        lz: v(5),
    }
}

fn rms(
    outcome: &PoolOutcome,
    residuals: &Residuals,
    joint: &Model,
    sequential: &Model,
) -> Option<ResidualRms> {
    let of = |model: &Model| {
        let mut all = Sums::default();
        residuals
            .sums(outcome, model)
            .iter()
            .for_each(|face| all.merge(face));
        all.rms()
    };
    Some(ResidualRms {
        sequential: of(sequential)?,
        joint: of(joint)?,
        joint_simple: residuals.models.joint_simple.as_ref().and_then(of),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_parameter_differs_by_nothing() {
        let covariance = Matrix6::from_diagonal(&Vector6::new(1.0, 4.0, 9.0, 0.01, 0.04, 0.0));
        let sigmas = in_sigmas(&Vector6::repeat(2.0), &covariance);
        assert_eq!((sigmas.roll, sigmas.lz), (1.0, 0.0));
    }
}
