//! Robust kernels, in sigmas.
//!
//! `rho(r)` replaces `r^2 / 2`; iteratively reweighted least squares uses `weight = rho'(r) / r` (Huber & Ronchetti, *Robust
//! Statistics*, 2009, ch. 7; Zhang, "Parameter estimation techniques", 1997, table 1).

use crate::math;
use crate::stats::normal_means;

/// What a standardised residual costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Kernel {
    /// `r^2 / 2`.
    #[default]
    LeastSquares,
    /// Quadratic to `k` sigmas, linear beyond. 1.345 has 95 % efficiency on normal residuals.
    Huber {
        /// Bend (sigmas).
        k: f64,
    },
    /// `k^2/2 ln(1 + (r/k)^2)`. 2.385 has 95 % efficiency.
    Cauchy {
        /// Width (sigmas).
        k: f64,
    },
    /// Biweight, no influence beyond `k` sigmas. 4.685 has 95 % efficiency.
    Tukey {
        /// Cut (sigmas).
        k: f64,
    },
    /// `r^2 / (2 (1 + (r/k)^2))`.
    GemanMcClure {
        /// Width (sigmas).
        k: f64,
    },
}

impl Kernel {
    /// Cost of a residual of `r` sigmas.
    #[inline]
    pub fn rho(self, r: f64) -> f64 {
        match self {
            Kernel::LeastSquares => 0.5 * r * r,
            Kernel::Huber { k } if r.abs() <= k => 0.5 * r * r,
            Kernel::Huber { k } => k * (r.abs() - 0.5 * k),
            Kernel::Cauchy { k } => 0.5 * k * k * math::ln_1p((r / k).powi(2)),
            Kernel::Tukey { k } if r.abs() >= k => k * k / 6.0,
            Kernel::Tukey { k } => k * k / 6.0 * (1.0 - (1.0 - (r / k).powi(2)).powi(3)),
            Kernel::GemanMcClure { k } => 0.5 * r * r / (1.0 + (r / k).powi(2)),
        }
    }

    /// Weight `rho'(r) / r`, one at zero.
    #[inline]
    pub fn weight(self, r: f64) -> f64 {
        match self {
            Kernel::LeastSquares => 1.0,
            Kernel::Huber { k } => (k / r.abs()).min(1.0),
            Kernel::Cauchy { k } => 1.0 / (1.0 + (r / k).powi(2)),
            Kernel::Tukey { k } if r.abs() >= k => 0.0,
            Kernel::Tukey { k } => (1.0 - (r / k).powi(2)).powi(2),
            Kernel::GemanMcClure { k } => (1.0 + (r / k).powi(2)).powi(-2),
        }
    }

    /// Influence `psi = rho'(r)`.
    #[inline]
    pub fn influence(self, r: f64) -> f64 {
        self.weight(r) * r
    }

    /// Slope of the influence, `rho''(r)`; may be negative beyond the bend.
    #[inline]
    pub fn slope(self, r: f64) -> f64 {
        match self {
            Kernel::LeastSquares => 1.0,
            Kernel::Huber { k } => f64::from(u8::from(r.abs() <= k)),
            Kernel::Cauchy { k } => (1.0 - (r / k).powi(2)) / (1.0 + (r / k).powi(2)).powi(2),
            Kernel::Tukey { k } if r.abs() >= k => 0.0,
            Kernel::Tukey { k } => (1.0 - (r / k).powi(2)) * (1.0 - 5.0 * (r / k).powi(2)),
            Kernel::GemanMcClure { k } => {
                (1.0 - 3.0 * (r / k).powi(2)) / (1.0 + (r / k).powi(2)).powi(3)
            }
        }
    }

    /// Part of the sum of squares of normal residuals with this standard deviation (sigmas) that `weight(r) r^2` keeps, by the midpoint
    /// rule: one for least squares, less for a kernel. Weighted sums of squares are divided by it, so that a variance factor of one means
    /// the stated noise under every kernel.
    pub fn kept_of_normal(self, deviation: f64) -> f64 {
        if self.is_least_squares() {
            return 1.0;
        }
        let [kept] = normal_means(10.0, 4000, |r| [self.weight(deviation * r) * r * r]);
        kept
    }

    /// Whether it is plain least squares.
    pub fn is_least_squares(self) -> bool {
        self == Kernel::LeastSquares
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use statrs::distribution::{Continuous, ContinuousCDF, Normal};

    const ALL: [Kernel; 5] = [
        Kernel::LeastSquares,
        Kernel::Huber { k: 1.345 },
        Kernel::Cauchy { k: 2.385 },
        Kernel::Tukey { k: 4.685 },
        Kernel::GemanMcClure { k: 3.0 },
    ];

    /// Every kernel: zero at zero, even, growing, weight = rho'/r, slope = rho'', weight one at zero.
    #[test]
    fn conformance() {
        let h = 1e-5;
        for kernel in ALL {
            assert_abs_diff_eq!(kernel.rho(0.0), 0.0);
            assert_abs_diff_eq!(kernel.weight(0.0), 1.0);
            for i in 1..80 {
                let r = 0.0987 * f64::from(i);
                assert_abs_diff_eq!(kernel.rho(r), kernel.rho(-r));
                assert!(
                    kernel.rho(r + 0.01) >= kernel.rho(r),
                    "{kernel:?} falls at {r}"
                );
                let first = (kernel.rho(r + h) - kernel.rho(r - h)) / (2.0 * h);
                assert_abs_diff_eq!(kernel.weight(r), first / r, epsilon = 1e-8);
                let second = (kernel.influence(r + h) - kernel.influence(r - h)) / (2.0 * h);
                assert_abs_diff_eq!(kernel.slope(r), second, epsilon = 1e-6);
            }
        }
    }

    /// Huber's in closed form: `2 Phi(k) - 1 - 2 k phi(k)` from inside the bend and `2 k phi(k)` from beyond.
    #[test]
    fn squares_of_normal_residuals() {
        let normal = Normal::standard();
        for k in [0.5, 1.345, 2.0, 4.0] {
            let inside = 2.0 * normal.cdf(k) - 1.0 - 2.0 * k * normal.pdf(k);
            let beyond = 2.0 * k * normal.pdf(k);
            let found = Kernel::Huber { k: 0.5 * k }.kept_of_normal(0.5);
            assert_abs_diff_eq!(found, inside + beyond, epsilon = 1e-6);
        }
        assert_abs_diff_eq!(Kernel::LeastSquares.kept_of_normal(0.7), 1.0);
    }

    /// Textbook efficiencies on normal residuals, by midpoint integration: 95 % at the customary constants.
    #[test]
    fn customary_constants_have_95_percent_efficiency() {
        for kernel in &ALL[1..4] {
            let (mut square, mut slope) = (0.0, 0.0);
            for i in 0..200_000 {
                let r = -10.0 + 1e-4 * (f64::from(i) + 0.5);
                let mass = math::exp(-0.5 * r * r) / (2.0 * std::f64::consts::PI).sqrt() * 1e-4;
                square += mass * kernel.influence(r).powi(2);
                slope += mass * kernel.slope(r);
            }
            assert_abs_diff_eq!(slope * slope / square, 0.95, epsilon = 2e-3);
        }
    }
}
