//! A difference of two solutions in the metric of a covariance.

use crate::stats::ChiSquare;
use nalgebra::{DMatrix, DVector};

/// `d^T C^-1 d` over the parameters that were not held (variance above 0), their number, and the probability of a larger value.
///
/// The covariance is scaled to unit diagonal first, so that units do not matter. `None` where it is singular.
#[must_use]
pub fn chi_square(d: &DVector<f64>, covariance: &DMatrix<f64>) -> Option<(f64, usize, f64)> {
    let free: Vec<usize> = (0..d.len()).filter(|&i| covariance[(i, i)] > 0.0).collect();
    let sigma = |i: usize| covariance[(free[i], free[i])].sqrt();
    let n = free.len();
    let correlation = DMatrix::from_fn(n, n, |i, j| {
        covariance[(free[i], free[j])] / (sigma(i) * sigma(j))
    });
    let scaled = DVector::from_fn(n, |i, _| d[free[i]] / sigma(i));
    let chi_square = scaled.dot(&correlation.cholesky()?.solve(&scaled));
    let p_value = ChiSquare::new(n as f64)?.above(chi_square);
    Some((chi_square, n, p_value))
}

/// Correlations of a covariance; a held parameter (variance 0) has none.
#[must_use]
pub fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        match (i == j, scale > 0.0) {
            (true, _) => 1.0,
            (false, true) => covariance[(i, j)] / scale,
            (false, false) => 0.0,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 12.591587 and 11.070498 are the 95 % points of chi-square on 6 and 5 degrees of freedom (NIST handbook, table 1.3.6.7.4:
    /// 12.592 and 11.070).
    #[test]
    fn the_degrees_of_freedom_are_the_parameters_that_were_not_held() {
        let variances = DVector::from_vec(vec![1.0, 4.0, 9.0, 0.01, 0.04, 0.25]);
        let mut covariance = DMatrix::from_diagonal(&variances);
        (covariance[(0, 4)], covariance[(4, 0)]) = (0.1, 0.1);
        let mut d = DVector::zeros(6);
        d[1] = 2.0 * 12.591587_f64.sqrt();
        let (chi, n, p) = chi_square(&d, &covariance).expect("regular");
        assert!(
            (chi - 12.591587).abs() < 1e-9 && n == 6 && (p - 0.05).abs() < 1e-6,
            "{chi} {n} {p}"
        );
        covariance[(5, 5)] = 0.0;
        d[1] = 2.0 * 11.070498_f64.sqrt();
        let (_, n, p) = chi_square(&d, &covariance).expect("regular");
        assert!(n == 5 && (p - 0.05).abs() < 1e-6, "{n} {p}");
    }

    #[test]
    fn a_held_parameter_correlates_with_nothing() {
        let mut c = DMatrix::identity(6, 6) * 4.0;
        (c[(0, 1)], c[(1, 0)]) = (2.0, 2.0);
        c[(5, 5)] = 0.0;
        let r = correlation(&c);
        assert_eq!((r[(0, 1)], r[(5, 5)], r[(5, 0)]), (0.5, 1.0, 0.0));
    }
}
