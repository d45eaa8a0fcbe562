//! The sequential path against the joint one, in the joint one's metric.

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::super::run::PoolOutcome;
use super::residuals::{Model, Residuals, Sums};
use super::solutions::angles_deg;
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
    let (chi_square, p_value) = test(&d, &covariance)?;
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

/// `d^T C^-1 d` over the parameters that were not held, and the probability of a larger value.
fn test(d: &Vector6<f64>, covariance: &Matrix6<f64>) -> Option<(f64, f64)> {
    let free: Vec<usize> = (0..6).filter(|&i| covariance[(i, i)] > 0.0).collect();
    let sigma = |i: usize| covariance[(free[i], free[i])].sqrt();
    let n = free.len();
    let correlation = DMatrix::from_fn(n, n, |i, j| {
        covariance[(free[i], free[j])] / (sigma(i) * sigma(j))
    });
    let scaled = DVector::from_fn(n, |i, _| d[free[i]] / sigma(i));
    let chi_square = scaled.dot(&correlation.cholesky()?.solve(&scaled));
    let p_value = ChiSquared::new(n as f64).ok()?.sf(chi_square);
    Some((chi_square, p_value))
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

    /// 12.591587 is the 95 % point of chi-square on 6 degrees of freedom (NIST handbook, table 1.3.6.7.4: 12.592).
    #[test]
    fn the_test_has_six_degrees_of_freedom_and_five_with_one_held() {
        let mut covariance = Matrix6::from_diagonal(&Vector6::new(1.0, 4.0, 9.0, 0.01, 0.04, 0.25));
        (covariance[(0, 4)], covariance[(4, 0)]) = (0.1, 0.1);
        let mut d = Vector6::zeros();
        d[1] = 2.0 * 12.591587_f64.sqrt();
        let (chi, p) = test(&d, &covariance).expect("regular");
        assert!(
            (chi - 12.591587).abs() < 1e-9 && (p - 0.05).abs() < 1e-6,
            "{chi} {p}"
        );
        covariance[(5, 5)] = 0.0;
        d[1] = 2.0 * 11.070498_f64.sqrt();
        let (_, p) = test(&d, &covariance).expect("regular");
        assert!((p - 0.05).abs() < 1e-6, "{p}");
        assert_eq!(in_sigmas(&d, &covariance).lz, 0.0);
    }
}
