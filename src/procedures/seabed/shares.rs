//! What each source of errors has in the covariance of the parameters, without a trial.
//!
//! The estimate errs by `N^-1 (J' P e - Q x)`: e the noise of the soundings, x what the priors with information Q hold at zero (drift of
//! the INS, heights of the lines, lever arm, ...). Each has its own part of the covariance, exact to first order; what is left of the
//! whole when those of the priors and of the INS's white noise are taken off is the sonar's.

use super::normal::Solved;
use super::shared::{Covariance, Parameters, SharedNoise, add_square};
use super::states::States;

/// Covariances of the parameters, source by source.
#[derive(Clone, Debug)]
pub struct Shares {
    /// Noise of range and angle, as the relief lets it through.
    pub sonar: Covariance,
    /// White noise of the INS.
    pub white: Covariance,
    /// Drift of the INS.
    pub drift: Covariance,
    /// Heights of the lines.
    pub heights: Covariance,
    /// Change of the parameters with the true value of each parameter that a prior holds at zero.
    pub held: Vec<Parameters>,
}

impl Shares {
    /// From the inverse of the normal matrix, the parameters' priors and the noise of the INS.
    #[must_use]
    pub fn new(states: &States, prior: &[f64], solved: &Solved, noise: &SharedNoise) -> Self {
        let count = prior.len();
        let column = |unknown: usize| Parameters::from_fn(count, |p, _| solved.inverse[p][unknown]);
        let held: Vec<Parameters> = (0..count).map(|k| -column(k) * prior[k]).collect();
        let nothing = || Covariance::zeros(count, count);
        let (mut drift, mut heights) = (nothing(), nothing());
        states.each_information(|row, other, information| {
            let part = if states.is_height(row) {
                &mut heights
            } else {
                &mut drift
            };
            let (a, b) = (column(count + row), column(count + other));
            if row == other {
                add_square(part, &a, information);
            } else {
                add_both(part, &a, &b, information);
            }
        });
        let whole =
            Covariance::from_fn(count, count, |a, b| solved.covariance(a, b)) + &noise.extra;
        let mut sonar = whole - &noise.all - &drift - &heights;
        for k in (0..count).filter(|k| prior[*k] > 0.0) {
            let mut part = nothing();
            add_square(&mut part, &held[k], 1.0);
            sonar -= part / prior[k];
        }
        Self {
            sonar,
            white: noise.all.clone(),
            drift,
            heights,
            held,
        }
    }
}

/// Adds `factor (a b' + b a')` to a covariance.
fn add_both(sum: &mut Covariance, a: &Parameters, b: &Parameters, factor: f64) {
    for column in 0..b.len() {
        for row in 0..a.len() {
            sum[(row, column)] += (a[row] * b[column] + b[row] * a[column]) * factor;
        }
    }
}
