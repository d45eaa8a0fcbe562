//! Errors of the trajectory's records, gathered over both sensors, and what they sum to.

use crate::math;
use nalgebra::{Matrix6, Matrix6x3, Vector6};

use super::influence::square;

/// What the errors of each trajectory record do.
#[derive(Clone, Debug)]
pub struct Records {
    /// Times of the records, seconds.
    pub times_s: Vec<f64>,
    /// By position along the target's axes, per metre.
    pub position: Vec<Matrix6x3<f64>>,
    /// By roll, pitch, heading, per radian.
    pub attitude: Vec<Matrix6x3<f64>>,
}

impl Records {
    /// Covariance of white position noise, per squared metre.
    #[must_use]
    pub fn white_position(&self) -> Matrix6<f64> {
        self.position.iter().map(|c| c * c.transpose()).sum()
    }

    /// Covariance of white roll and pitch noise, per squared radian.
    #[must_use]
    pub fn white_level(&self) -> Matrix6<f64> {
        let one = |c: &Matrix6x3<f64>| {
            square(&c.column(0).into_owned()) + square(&c.column(1).into_owned())
        };
        self.attitude.iter().map(one).sum()
    }

    /// Covariance of white heading noise, per squared radian.
    #[must_use]
    pub fn white_heading(&self) -> Matrix6<f64> {
        let one = |c: &Matrix6x3<f64>| square(&c.column(2).into_owned());
        self.attitude.iter().map(one).sum()
    }

    /// Covariance of a Gauss-Markov position drift along each axis, per squared metre.
    #[must_use]
    pub fn position_drift(&self, tau_s: f64) -> Matrix6<f64> {
        let axis =
            |i: usize| gauss_markov(&self.times_s, tau_s, |k| self.position[k].column(i).into());
        (0..3).map(axis).sum()
    }

    /// Covariance of a Gauss-Markov heading error, per squared radian.
    #[must_use]
    pub fn heading_drift(&self, tau_s: f64) -> Matrix6<f64> {
        gauss_markov(&self.times_s, tau_s, |k| self.attitude[k].column(2).into())
    }
}

/// `sum_ij c_i c_j^T exp(-|t_i - t_j| / tau)` in one pass: `before_j = (before_(j-1) + c_(j-1)) exp(-dt / tau)`.
pub fn gauss_markov(
    times_s: &[f64],
    tau_s: f64,
    column: impl Fn(usize) -> Vector6<f64>,
) -> Matrix6<f64> {
    let mut sum = Matrix6::zeros();
    let mut before = Vector6::zeros();
    for (k, time_s) in times_s.iter().enumerate() {
        if k > 0 {
            before *= math::exp(-(time_s - times_s[k - 1]) / tau_s);
        }
        let c = column(k);
        let cross = before * c.transpose();
        sum += square(&c) + cross + cross.transpose();
        before += c;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> (Vec<f64>, Vec<Vector6<f64>>) {
        let times = (0..60).map(|k| f64::from(k) * 0.7 + f64::from(k % 7) * 0.05);
        let column = |k: i32| Vector6::from_fn(|i, _| math::sin(f64::from(k) * (0.3 + i as f64)));
        (times.collect(), (0..60).map(column).collect())
    }

    #[test]
    fn the_recursion_gives_the_double_sum() {
        let (times, columns) = columns();
        let mut expected = Matrix6::zeros();
        for (t, a) in times.iter().zip(&columns) {
            for (s, b) in times.iter().zip(&columns) {
                expected += a * b.transpose() * math::exp(-(t - s).abs() / 8.0);
            }
        }
        let found = gauss_markov(&times, 8.0, |k| columns[k]);
        assert!((found - expected).amax() < 1e-11 * expected.amax());
    }

    /// Without end a drift is one constant error, in no time it is white.
    #[test]
    fn slow_and_fast_drifts_are_constant_and_white() {
        let (times, columns) = columns();
        let slow = gauss_markov(&times, 1e12, |k| columns[k]);
        let sum: Vector6<f64> = columns.iter().sum();
        assert!((slow - square(&sum)).amax() < 1e-6);
        let fast = gauss_markov(&times, 1e-3, |k| columns[k]);
        let white: Matrix6<f64> = columns.iter().map(square).sum();
        assert!((fast - white).amax() < 1e-12);
    }
}
