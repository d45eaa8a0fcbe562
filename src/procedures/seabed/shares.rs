//! What each source of errors has in the covariance of the parameters, without a trial.
//!
//! The estimate errs by `N^-1 (J' P e - Q x)`: e the noise of the soundings, x what the priors with information Q hold at zero (drift of
//! the INS, heights of the lines, lever arm, ...). Each has its own part of the covariance, exact to first order; what is left of the
//! whole when those of the priors and of the INS's white noise are taken off is the sonar's.

use super::model::COUNT;
use super::normal::Solved;
use super::shared::{Covariance, Parameters, SharedNoise};
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
    pub held: [Parameters; COUNT],
}

impl Shares {
    /// From the inverse of the normal matrix, the parameters' priors and the noise of the INS.
    #[must_use]
    pub fn new(
        states: &States,
        prior: &[f64; COUNT],
        solved: &Solved,
        noise: &SharedNoise,
    ) -> Self {
        let column = |unknown: usize| Parameters::from_fn(|p, _| solved.inverse[p][unknown]);
        let held: [Parameters; COUNT] = std::array::from_fn(|k| -column(k) * prior[k]);
        let (mut drift, mut heights) = (Covariance::zeros(), Covariance::zeros());
        states.each_information(|row, other, information| {
            let (a, b) = (column(COUNT + row), column(COUNT + other));
            let both = if row == other {
                a * a.transpose()
            } else {
                a * b.transpose() + b * a.transpose()
            };
            let part = if states.is_height(row) {
                &mut heights
            } else {
                &mut drift
            };
            *part += both * information;
        });
        let whole = Covariance::from_fn(|a, b| solved.covariance(a, b)) + noise.extra;
        let mut sonar = whole - noise.all - drift - heights;
        for k in (0..COUNT).filter(|k| prior[*k] > 0.0) {
            sonar -= held[k] * held[k].transpose() / prior[k];
        }
        Self {
            sonar,
            white: noise.all,
            drift,
            heights,
            held,
        }
    }
}
