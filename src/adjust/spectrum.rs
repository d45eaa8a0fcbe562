//! The reduced system of the parameters in its own axes.
//!
//! Columns are scaled to unit length and the system is rotated to its singular axes: `min |Sigma V^T y + c|^2`, `y = scale x`.
//! Damped steps, covariance, rank and weak directions are then one-liners.

use crate::math;
use crate::math::dense::product;
use nalgebra::{DMatrix, DVector};

use super::error::AdjustError;

/// What a linearised problem leaves for the free columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Reduced {
    /// Triangular factor of the whitened Jacobian, and the residuals in the same axes.
    Root {
        /// Factor, by rows of the rotated problem.
        factor: DMatrix<f64>,
        /// Residuals.
        residuals: Vec<f64>,
    },
    /// Normal equations.
    Normal {
        /// Normal matrix, states eliminated.
        matrix: DMatrix<f64>,
        /// Gradient, states eliminated.
        gradient: Vec<f64>,
        /// Diagonal before elimination: tells how many digits the elimination has cost.
        before: Vec<f64>,
    },
}

impl Reduced {
    /// Length of each column: the square root of its information.
    pub(super) fn lengths(&self) -> Vec<f64> {
        match self {
            Reduced::Root { factor, .. } => {
                factor.column_iter().map(|column| column.norm()).collect()
            }
            Reduced::Normal { matrix, .. } => matrix
                .diagonal()
                .iter()
                .map(|d| d.max(0.0).sqrt())
                .collect(),
        }
    }

    /// Whether every number is finite.
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Reduced::Root { factor, residuals } => {
                factor.iter().chain(residuals).all(|x| x.is_finite())
            }
            Reduced::Normal {
                matrix, gradient, ..
            } => matrix.iter().chain(gradient).all(|x| x.is_finite()),
        }
    }

    /// Information of the free columns, states eliminated.
    pub(super) fn information(&self) -> DMatrix<f64> {
        match self {
            Reduced::Root { factor, .. } => factor.tr_mul(factor),
            Reduced::Normal { matrix, .. } => matrix.clone(),
        }
    }

    /// Gradient of the cost by the free columns, states eliminated.
    pub(super) fn gradient(&self) -> DVector<f64> {
        match self {
            Reduced::Root { factor, residuals } => {
                factor.tr_mul(&DVector::from_column_slice(residuals))
            }
            Reduced::Normal { gradient, .. } => DVector::from_column_slice(gradient),
        }
    }

    /// The system in its axes, columns scaled by `scale` (zeros count as one).
    pub(super) fn spectrum(&self, scale: &[f64]) -> Result<Spectrum, AdjustError> {
        let scale = scale.iter().map(|length| non_zero(*length)).collect();
        match self {
            Reduced::Root { factor, residuals } => Spectrum::of_root(factor, residuals, scale),
            Reduced::Normal {
                matrix,
                gradient,
                before,
            } => Spectrum::of_normal(matrix, gradient, before, scale),
        }
    }
}

/// A linear least-squares system in its singular axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spectrum {
    /// What each column was divided by.
    pub scale: Vec<f64>,
    /// Right singular vectors by columns, in scaled parameters.
    pub axes: DMatrix<f64>,
    /// Singular values beside the axes.
    pub singular: Vec<f64>,
    /// Right-hand side along the axes; zero where the axis is undetermined.
    pub coefficients: Vec<f64>,
    /// Singular values not above this are zero to rounding.
    pub threshold: f64,
}

impl Spectrum {
    fn of_root(r: &DMatrix<f64>, z: &[f64], scale: Vec<f64>) -> Result<Self, AdjustError> {
        let n = r.ncols();
        let scaled = DMatrix::from_fn(r.nrows(), n, |i, j| r[(i, j)] / scale[j]);
        let svd = jacobi(scaled)?;
        let threshold = 10.0 * n as f64 * f64::EPSILON * largest(&svd.singular);
        let z = DMatrix::from_column_slice(z.len(), 1, z);
        let along = svd.stretched.tr_mul(&z);
        let coefficient = |i: usize| {
            if svd.singular[i] > threshold {
                along[i] / svd.singular[i]
            } else {
                0.0
            }
        };
        let coefficients = (0..n).map(coefficient).collect();
        Ok(Spectrum {
            scale,
            axes: svd.axes,
            singular: svd.singular,
            coefficients,
            threshold,
        })
    }

    fn of_normal(
        normal: &DMatrix<f64>,
        gradient: &[f64],
        before: &[f64],
        scale: Vec<f64>,
    ) -> Result<Self, AdjustError> {
        let n = normal.ncols();
        let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        let eigen = jacobi(scaled)?;
        let loss = (0..n)
            .map(|j| before[j] / (scale[j] * scale[j]))
            .fold(1.0, f64::max);
        let threshold = (10.0 * n as f64 * f64::EPSILON * loss * largest(&eigen.singular)).sqrt();
        let singular: Vec<f64> = eigen.singular.iter().map(|value| value.sqrt()).collect();
        let gradient = DMatrix::from_fn(n, 1, |j, _| gradient[j] / scale[j]);
        let along = eigen.axes.tr_mul(&gradient);
        let coefficient = |i: usize| {
            if singular[i] > threshold {
                along[i] / singular[i]
            } else {
                0.0
            }
        };
        let coefficients = (0..n).map(coefficient).collect();
        Ok(Spectrum {
            scale,
            axes: eigen.axes,
            singular,
            coefficients,
            threshold,
        })
    }

    /// Number of free columns.
    pub(super) fn size(&self) -> usize {
        self.scale.len()
    }

    /// Levenberg-Marquardt step: minimises `|J x + r|^2 + damping |scale x|^2`. Undetermined axes do not move.
    pub(super) fn step(&self, damping: f64) -> Vec<f64> {
        let along = |i: usize| match self.singular[i] {
            s if s > self.threshold => -s * self.coefficients[i] / (s * s + damping),
            _ => 0.0,
        };
        self.unscaled(&(0..self.size()).map(along).collect::<Vec<_>>())
    }

    /// `-(J^T J + damping scale^2)^-1 gradient`. Undetermined axes do not move.
    pub(super) fn respond(&self, gradient: &[f64], damping: f64) -> Vec<f64> {
        let n = self.size();
        let scaled = DMatrix::from_fn(n, 1, |j, _| gradient[j] / self.scale[j]);
        let along = self.axes.tr_mul(&scaled);
        let respond = |i: usize| match self.singular[i] {
            s if s > self.threshold => -along[i] / (s * s + damping),
            _ => 0.0,
        };
        self.unscaled(&(0..n).map(respond).collect::<Vec<_>>())
    }

    /// Length of a step in the scale of the columns.
    pub(super) fn length(&self, step: &[f64]) -> f64 {
        step.iter()
            .zip(&self.scale)
            .map(|(step, scale)| (step * scale).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    /// Fall of `|J x + r|^2 / 2` that the linear model promises for this damping.
    pub(super) fn promise(&self, damping: f64) -> f64 {
        let kept = |s: f64| damping / (s * s + damping);
        let fall = |(s, c): (&f64, &f64)| {
            if *s > self.threshold {
                0.5 * c * c * (1.0 - kept(*s).powi(2))
            } else {
                0.0
            }
        };
        self.singular.iter().zip(&self.coefficients).map(fall).sum()
    }

    /// Cofactors of the free columns. Undetermined axes enter with the variance of the threshold: huge, not missing.
    pub(super) fn cofactor(&self) -> DMatrix<f64> {
        let n = self.size();
        let floor = self.threshold.max(f64::MIN_POSITIVE.sqrt());
        let half = DMatrix::from_fn(n, n, |j, i| {
            self.axes[(j, i)] / (self.singular[i].max(floor) * self.scale[j])
        });
        product(&half, &half.transpose())
    }

    /// Axes that are undetermined, in scaled parameters.
    pub(super) fn undetermined(&self) -> Vec<Vec<f64>> {
        let axes = (0..self.size()).filter(|&i| self.singular[i] <= self.threshold);
        axes.map(|i| self.axes.column(i).iter().copied().collect())
            .collect()
    }

    fn unscaled(&self, along: &[f64]) -> Vec<f64> {
        let y = &self.axes * DMatrix::from_column_slice(along.len(), 1, along);
        y.iter()
            .zip(&self.scale)
            .map(|(y, scale)| y / scale)
            .collect()
    }
}

fn non_zero(length: f64) -> f64 {
    if length > 0.0 { length } else { 1.0 }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// `A V = U Sigma` with orthogonal `V`.
struct Jacobi {
    stretched: DMatrix<f64>,
    axes: DMatrix<f64>,
    singular: Vec<f64>,
}

/// One-sided Jacobi (Hestenes) singular value decomposition: small singular values keep their relative digits under column
/// scaling (Demmel & Veselić, "Jacobi's method is more accurate than QR", 1992).
fn jacobi(mut a: DMatrix<f64>) -> Result<Jacobi, AdjustError> {
    let n = a.ncols();
    let mut axes = DMatrix::identity(n, n);
    for _ in 0..60 {
        if !sweep(&mut a, &mut axes) {
            let singular = (0..n).map(|j| a.column(j).norm()).collect();
            return Ok(Jacobi {
                stretched: a,
                axes,
                singular,
            });
        }
    }
    Err(AdjustError::NoDecomposition { size: n })
}

/// Rotates every pair of columns once; whether any was not yet orthogonal to rounding.
fn sweep(a: &mut DMatrix<f64>, axes: &mut DMatrix<f64>) -> bool {
    let tolerance = f64::EPSILON * a.nrows().max(8) as f64;
    let mut rotated = false;
    for p in 0..a.ncols() {
        for q in p + 1..a.ncols() {
            let (pp, qq, pq) = (
                a.column(p).norm_squared(),
                a.column(q).norm_squared(),
                a.column(p).dot(&a.column(q)),
            );
            if pq.abs() <= tolerance * pp.sqrt() * qq.sqrt() || pq.abs() < f64::MIN_POSITIVE {
                continue;
            }
            rotated = true;
            let zeta = (qq - pp) / (2.0 * pq);
            let t = zeta.signum() / (zeta.abs() + math::hypot(zeta, 1.0));
            rotate(a, p, q, t);
            rotate(axes, p, q, t);
        }
    }
    rotated
}

fn rotate(m: &mut DMatrix<f64>, p: usize, q: usize, t: f64) {
    let c = 1.0 / math::hypot(t, 1.0);
    let rows = m.nrows();
    let (before, from_q) = m.as_mut_slice().split_at_mut(q * rows);
    let column_p = before[p * rows..].iter_mut().take(rows);
    for (at_p, at_q) in column_p.zip(from_q) {
        let (x, y) = (*at_p, *at_q);
        *at_p = c * (x - t * y);
        *at_q = c * (y + t * x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn example() -> (DMatrix<f64>, Vec<f64>) {
        let j = DMatrix::from_row_slice(
            4,
            3,
            &[
                1.0, 2e3, 0.1, -0.5, 1e3, 0.3, 2.0, -3e3, 0.2, 0.7, 500.0, -0.4,
            ],
        );
        (j, vec![0.3, -1.0, 0.5, 2.0])
    }

    fn own(factor: DMatrix<f64>, residuals: Vec<f64>) -> Spectrum {
        let reduced = Reduced::Root { factor, residuals };
        reduced.spectrum(&reduced.lengths()).unwrap()
    }

    #[test]
    fn root_and_normal_agree_with_the_textbook() {
        let (j, r) = example();
        let rhs = DMatrix::from_column_slice(4, 1, &r);
        let normal = j.tr_mul(&j);
        let inverse = normal.clone().try_inverse().unwrap();
        let expected = -(&inverse * j.tr_mul(&rhs));
        let gradient: Vec<f64> = j.tr_mul(&rhs).iter().copied().collect();
        let diagonal: Vec<f64> = normal.diagonal().iter().copied().collect();
        let root = Reduced::Root {
            factor: j.clone(),
            residuals: r,
        };
        let summed = Reduced::Normal {
            matrix: normal,
            gradient,
            before: diagonal,
        };
        for reduced in [root, summed] {
            let spectrum = reduced.spectrum(&reduced.lengths()).unwrap();
            for (found, expected) in spectrum.step(0.0).iter().zip(expected.iter()) {
                assert_relative_eq!(found, expected, max_relative = 1e-11);
            }
            assert_relative_eq!(spectrum.cofactor(), inverse, max_relative = 1e-10);
            let fall = 0.5 * (rhs.norm_squared() - (&j * &expected + &rhs).norm_squared());
            assert_relative_eq!(spectrum.promise(0.0), fall, max_relative = 1e-11);
        }
    }

    #[test]
    fn damped_step_solves_the_damped_normal_equations() {
        let (j, r) = example();
        let spectrum = own(j.clone(), r.clone());
        let mut normal = j.tr_mul(&j);
        for i in 0..3 {
            normal[(i, i)] *= 1.5;
        }
        let expected =
            -(normal.try_inverse().unwrap() * j.tr_mul(&DMatrix::from_column_slice(4, 1, &r)));
        for (found, expected) in spectrum.step(0.5).iter().zip(expected.iter()) {
            assert_relative_eq!(found, expected, max_relative = 1e-12);
        }
    }

    #[test]
    fn a_missing_direction_is_named_and_does_not_move() {
        let j = DMatrix::from_row_slice(3, 2, &[1.0, 2.0, 2.0, 4.0, -1.0, -2.0]);
        let spectrum = own(j, vec![1.0; 3]);
        let missing = spectrum.undetermined();
        assert_eq!(missing.len(), 1);
        assert_relative_eq!(missing[0][0] * missing[0][1], -0.5, epsilon = 1e-12);
        assert!(spectrum.step(0.0).iter().all(|x| x.abs() < 1.0));
        assert!(spectrum.cofactor()[(0, 0)] > 1e20);
    }
}
