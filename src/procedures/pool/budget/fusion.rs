//! Information of several passes put together.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Matrix6};

use crate::procedures::pool::joint::Information;

/// Nobody expects a mounting to be wrong by more: radians and metres. Keeps a covariance finite where nothing is determined.
const VAGUE: (f64, f64) = (0.35, 3.0);
/// Added to the scaled diagonal, so that rounding does not make a determined matrix indefinite.
const RIDGE: f64 = 1e-14;

/// Information of several passes, over the union of their parameters by name; priors count once.
#[derive(Clone, Debug, Default)]
pub struct Fusion {
    columns: Vec<String>,
    observed: DMatrix<f64>,
    prior: BTreeMap<(usize, usize), f64>,
    /// Passes put together.
    pub passes: usize,
}

impl Fusion {
    /// With one more pass.
    #[must_use]
    pub fn with(&self, information: &Information) -> Self {
        let mut sum = self.clone();
        sum.add(information);
        sum
    }

    /// Adds a pass.
    pub fn add(&mut self, information: &Information) {
        self.add_times(information, 1.0);
    }

    /// Adds a pass that is sailed so many times.
    pub fn add_times(&mut self, information: &Information, times: f64) {
        let names = information.columns.iter();
        let places: Vec<usize> = names.map(|name| self.column(name)).collect();
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                self.observed[(a, b)] += times * information.observed[(i, j)];
                let prior = information.prior[(i, j)];
                if prior != 0.0 {
                    self.prior.insert((a, b), prior);
                }
            }
        }
        self.passes += 1;
    }

    fn column(&mut self, name: &str) -> usize {
        if let Some(known) = self.columns.iter().position(|c| c == name) {
            return known;
        }
        self.columns.push(name.to_owned());
        let n = self.columns.len();
        self.observed = std::mem::take(&mut self.observed).resize(n, n, 0.0);
        n - 1
    }

    /// Covariance of the six parameters (pitch, roll, yaw in rad; lx, ly, lz in m), everything else eliminated.
    #[must_use]
    pub fn covariance(&self) -> Matrix6<f64> {
        let whole = self.with_priors();
        let scale = whole
            .diagonal()
            .map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
        let scaled = DMatrix::from_fn(whole.nrows(), whole.ncols(), |i, j| {
            let ridge = if i == j { RIDGE } else { 0.0 };
            whole[(i, j)] / (scale[i] * scale[j]) + ridge
        });
        match scaled.cholesky().map(|c| c.inverse()) {
            Some(inverse) if inverse.nrows() >= 6 => {
                Matrix6::from_fn(|i, j| inverse[(i, j)] / (scale[i] * scale[j]))
            }
            _ => Matrix6::from_diagonal_element(f64::INFINITY),
        }
    }

    fn with_priors(&self) -> DMatrix<f64> {
        let mut whole = self.observed.clone();
        for (&place, value) in &self.prior {
            whole[place] += value;
        }
        for i in 0..6.min(whole.nrows()) {
            let sigma = if i < 3 { VAGUE.0 } else { VAGUE.1 };
            whole[(i, i)] += sigma.powi(-2);
        }
        whole
    }
}

/// Standard deviations of a covariance.
#[must_use]
pub fn sigmas(covariance: &Matrix6<f64>) -> [f64; 6] {
    std::array::from_fn(|i| covariance[(i, i)].sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Six parameters and one nuisance `n` that is seen through the first: `n` known to `prior`.
    fn pass(nuisance: &str, prior: f64) -> Information {
        let mut columns: Vec<String> = (0..6).map(|i| format!("p{i}")).collect();
        columns.push(nuisance.to_owned());
        let mut observed = DMatrix::identity(7, 7) * 1e6;
        // one observation of p0 + n with weight 1e6
        (observed[(6, 6)], observed[(0, 6)], observed[(6, 0)]) = (1e6, 1e6, 1e6);
        let mut priors = DMatrix::zeros(7, 7);
        priors[(6, 6)] = prior;
        Information {
            columns,
            observed,
            prior: priors,
            soundings: 100,
            returns: 100,
        }
    }

    /// A variance with the vague prior of the first parameters beside it.
    fn with_vague(variance: f64) -> f64 {
        1.0 / (1.0 / variance + VAGUE.0.powi(-2))
    }

    /// By hand: p0 + n is seen N times with sigma 1 mm, n is known to 2 mm: variance of p0 = 1e-6 / N + 4e-6, the others' 1e-6 / N.
    #[test]
    fn a_shared_prior_counts_once_and_information_adds() {
        let mut sum = Fusion::default();
        for n in 1..=3 {
            sum.add(&pass("n", 2.5e5));
            let c = sum.covariance();
            let each = 1e-6 / f64::from(n);
            assert_relative_eq!(c[(0, 0)], with_vague(each + 4e-6), max_relative = 1e-9);
            assert_relative_eq!(c[(5, 5)], each, max_relative = 1e-5);
        }
        assert_eq!(sum.passes, 3);
    }

    /// Two nuisances of their own are averaged: variance of p0 = (1e-6 + 4e-6) / 2.
    #[test]
    fn nuisances_of_different_names_are_different_parameters() {
        let sum = Fusion::default()
            .with(&pass("a", 2.5e5))
            .with(&pass("b", 2.5e5));
        let variance = sum.covariance()[(0, 0)];
        assert_relative_eq!(variance, with_vague(2.5e-6), max_relative = 1e-9);
    }

    #[test]
    fn nothing_sailed_is_nothing_known() {
        assert!(Fusion::default().covariance()[(0, 0)].is_infinite());
    }
}
