//! The seabed of one tile as a plane plus a random field (collocation), and what the field says of heights and slopes.
//!
//! `z = F b + s + e`, covariance of s Matern 3/2 `K = sigma^2 (1 + d) exp(-d)`, `d = sqrt(3) |x - x'| / length`, noise `D`;
//! `C = K + D`, `P = C^-1 - C^-1 F (F' C^-1 F)^-1 F' C^-1`, `alpha = P z`.

use super::reml::CLAIMED;
use crate::math;
use crate::math::dense::product;
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

/// Parameters of the random field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Standard deviation of the relief about a tile's plane, metres.
    pub sigma_m: f64,
    /// Correlation length, metres.
    pub length_m: f64,
    /// Factor on the claimed noise of range and angle.
    pub noise_factor: f64,
}

impl Field {
    /// Whether the soundings have the noise that is claimed of them, to a quarter; nothing where that was not told and the claim is held.
    #[must_use]
    pub fn noise_is_as_claimed(&self) -> Option<bool> {
        (self.noise_factor != CLAIMED).then(|| (0.8..=1.25).contains(&self.noise_factor))
    }
}

/// Noise of one sounding's height condition, apart from the field's noise factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Range and angle, square metres; scaled by the factor squared.
    pub sonar_m2: f64,
    /// White noise of the INS, square metres; not scaled.
    pub ins_m2: f64,
}

impl Noise {
    fn variance_m2(&self, field: &Field) -> f64 {
        field.noise_factor * field.noise_factor * self.sonar_m2 + self.ins_m2
    }
}

/// Most soundings that a tile loses as gross errors before the field is estimated from it.
const MOST_GROSS: usize = 10;

/// The points of a tile about its centre, metres, and their noise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// Places, metres.
    pub at_m: Vec<Vector3<f64>>,
    /// Noise of each.
    pub noise: Vec<Noise>,
}

impl Points {
    /// Least-squares plane `z = a + b x + c y`; flat where there is none.
    #[must_use]
    pub fn plane(&self) -> Vector3<f64> {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for p in &self.at_m {
            let row = Vector3::new(1.0, p.x, p.y);
            normal += row * row.transpose();
            right += row * p.z;
        }
        let solved = normal.cholesky().map(|factor| factor.solve(&right));
        solved.unwrap_or_else(Vector3::zeros)
    }

    fn design(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.at_m.len(), 3, |i, j| match j {
            0 => 1.0,
            1 => self.at_m[i].x,
            _ => self.at_m[i].y,
        })
    }

    fn heights(&self) -> DVector<f64> {
        DVector::from_iterator(self.at_m.len(), self.at_m.iter().map(|p| p.z))
    }

    /// Covariance of the field and, for each pair, `exp(-d) a^2 sigma^2`: the slope covariance is that times the separation.
    fn covariances(&self, field: &Field) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = self.at_m.len();
        let (rate, variance) = (3f64.sqrt() / field.length_m, field.sigma_m * field.sigma_m);
        let mut heights = DMatrix::zeros(n, n);
        let mut slopes = DMatrix::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let (a, b) = (&self.at_m[i], &self.at_m[j]);
                let d = rate * math::hypot(a.x - b.x, a.y - b.y);
                let decay = variance * math::exp(-d);
                heights[(i, j)] = decay * (1.0 + d);
                heights[(j, i)] = heights[(i, j)];
                slopes[(i, j)] = decay * rate * rate;
                slopes[(j, i)] = slopes[(i, j)];
            }
        }
        (heights, slopes)
    }

    /// Twice the negative logarithm of the restricted likelihood, without its constant; `None` where the matrices are singular.
    #[must_use]
    pub fn restricted_deviance(&self, field: &Field) -> Option<f64> {
        let (mut covariance, _) = self.covariances(field);
        for (k, noise) in self.noise.iter().enumerate() {
            covariance[(k, k)] += noise.variance_m2(field);
        }
        let factor = covariance.cholesky()?;
        let lower = factor.l_dirty();
        let (mut design, mut heights) = (self.design(), self.heights());
        lower.solve_lower_triangular_mut(&mut design);
        lower.solve_lower_triangular_mut(&mut heights);
        let normal = design.tr_mul(&design).cholesky()?;
        let right = design.tr_mul(&heights);
        let fitted = right.dot(&normal.solve(&right));
        let log = |m: &DMatrix<f64>| 2.0 * m.diagonal().iter().map(|x| math::ln(*x)).sum::<f64>();
        Some(log(lower) + log(normal.l_dirty()) + heights.norm_squared() - fitted)
    }

    /// Everything the adjustment needs of the tile; `None` where the matrices are singular.
    #[must_use]
    pub fn collocate(&self, field: &Field) -> Option<Collocation> {
        let (heights_cov, slopes_cov) = self.covariances(field);
        let mut covariance = heights_cov.clone();
        for (k, noise) in self.noise.iter().enumerate() {
            covariance[(k, k)] += noise.variance_m2(field);
        }
        let inverse = covariance.cholesky()?.inverse();
        let (design, z) = (self.design(), self.heights());
        let weighted = &inverse * &design;
        let small = design.tr_mul(&weighted).cholesky()?.inverse();
        let plane = &small * weighted.tr_mul(&z);
        let projected = &weighted * &small;
        let precision = inverse - product(&projected, &weighted.transpose());
        let alpha = &precision * &z;
        let relief = &heights_cov * &alpha;
        let (slopes, trace) = self.slopes(&slopes_cov, &precision, &alpha);
        let plane_slope = Vector2::new(plane[1], plane[2]);
        Some(Collocation {
            omega: z.dot(&alpha),
            slopes: slopes.into_iter().map(|s| plane_slope + s).collect(),
            plane_slope,
            weighted,
            precision,
            alpha,
            relief,
            trace,
        })
    }

    /// Without those whose residual under this field exceeds `limit` sigmas: the worst goes, the others are judged again.
    #[must_use]
    pub fn without_gross(mut self, field: &Field, limit: f64) -> Self {
        for _ in 0..MOST_GROSS.min(self.at_m.len() / 4) {
            let Some(found) = self.collocate(field) else {
                break;
            };
            let size = |k: usize| found.standardised(k).abs();
            let worst = (0..self.at_m.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
            let Some(worst) = worst.filter(|k| size(*k) > limit) else {
                break;
            };
            self.at_m.remove(worst);
            self.noise.remove(worst);
        }
        self
    }

    /// Slopes of the relief at each point, and the trace vector `g_k = sum_j P_kj dK_kj`.
    fn slopes(
        &self,
        slopes_cov: &DMatrix<f64>,
        precision: &DMatrix<f64>,
        alpha: &DVector<f64>,
    ) -> (Vec<Vector2<f64>>, Vec<Vector2<f64>>) {
        let n = self.at_m.len();
        let one = |k: usize| {
            let (mut slope, mut trace) = (Vector2::zeros(), Vector2::zeros());
            for j in 0..n {
                let apart = (self.at_m[k] - self.at_m[j]).xy() * -slopes_cov[(j, k)];
                slope += apart * alpha[j];
                trace += apart * precision[(j, k)];
            }
            (slope, trace)
        };
        (0..n).map(one).unzip()
    }
}

/// The collocation of one tile.
#[derive(Clone, Debug)]
pub struct Collocation {
    /// C^-1 F: soundings by the plane's three coefficients.
    pub weighted: DMatrix<f64>,
    /// P.
    pub precision: DMatrix<f64>,
    /// P z.
    pub alpha: DVector<f64>,
    /// K alpha: height of the relief over the plane at each point, metres.
    pub relief: DVector<f64>,
    /// Slopes of plane and relief at each point, east and north.
    pub slopes: Vec<Vector2<f64>>,
    /// Slopes of the plane.
    pub plane_slope: Vector2<f64>,
    /// Derivative of half the log determinant with each point's place.
    pub trace: Vec<Vector2<f64>>,
    /// z' P z.
    pub omega: f64,
}

impl Collocation {
    /// Normalised residual of a point: `alpha / sqrt(P_kk)`.
    #[must_use]
    pub fn standardised(&self, k: usize) -> f64 {
        self.alpha[k] / self.precision[(k, k)].sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Points {
        let at = |k: usize| {
            let (x, y) = (1.7 * (k % 5) as f64 - 3.0, 1.3 * (k / 5) as f64 - 3.0);
            let wobble = 0.05 * math::sin(1.3 * x + 0.4 * y) + 0.02 * ((k * 31) % 7) as f64 / 7.0;
            Vector3::new(x + 0.1 * wobble, y, -14.0 + 0.1 * x - 0.05 * y + wobble)
        };
        let noise = Noise {
            sonar_m2: 2.5e-4,
            ins_m2: 1e-5,
        };
        Points {
            at_m: (0..25).map(at).collect(),
            noise: vec![noise; 25],
        }
    }

    const FIELD: Field = Field {
        sigma_m: 0.06,
        length_m: 3.0,
        noise_factor: 1.1,
    };

    /// The score of the likelihood by differences: heights move by `dz`, places by `dx`.
    #[test]
    fn score_is_the_derivative_of_the_likelihood() {
        let points = points();
        let found = points.collocate(&FIELD).expect("regular");
        let (dz, dx) = (
            |k: usize| 0.3 - 0.1 * k as f64 * 0.07,
            |k: usize| 0.2 * math::sin(k as f64 * 0.9),
        );
        let moved = |by: f64| {
            let mut moved = points.clone();
            for (k, p) in moved.at_m.iter_mut().enumerate() {
                p.z += by * dz(k);
                p.x += by * dx(k);
            }
            // the factor log |F'F| makes the restricted likelihood independent of the scale of the plane's basis
            let design = moved.design();
            let basis = math::ln((design.tr_mul(&design)).determinant());
            moved.restricted_deviance(&FIELD).expect("regular") - basis
        };
        let step = 1e-5;
        let by_differences = -0.5 * (moved(step) - moved(-step)) / (2.0 * step);
        let mut score = 0.0;
        for k in 0..25 {
            let column = dz(k) - found.slopes[k].x * dx(k);
            score -= column * found.alpha[k] + found.trace[k].x * dx(k);
        }
        assert!(
            (score - by_differences).abs() < 0.02 * by_differences.abs(),
            "{score} {by_differences}"
        );
    }

    #[test]
    fn the_gross_one_goes_and_the_others_stay() {
        let mut spoiled = points();
        spoiled.at_m[7].z += 0.4;
        let cleaned = spoiled.without_gross(&FIELD, 4.5);
        let mut expected = points();
        expected.at_m.remove(7);
        expected.noise.remove(7);
        assert_eq!(cleaned, expected);
        assert_eq!(points().without_gross(&FIELD, 4.5), points());
    }

    #[test]
    fn a_common_shift_of_the_tile_changes_nothing() {
        let found = points().collocate(&FIELD).expect("regular");
        let shift: Vector2<f64> = (0..25)
            .map(|k| found.trace[k] - (found.slopes[k] - found.plane_slope) * found.alpha[k])
            .sum();
        assert!(shift.norm() < 1e-9 * found.alpha.norm());
        assert!(found.alpha.sum().abs() < 1e-9 * found.alpha.norm());
    }

    /// A claim is told right to a quarter; a noise that is exactly the claimed one was held, not told.
    #[test]
    fn a_claimed_noise_is_right_wrong_or_not_told() {
        let told = |noise_factor| {
            let field = Field {
                noise_factor,
                ..FIELD
            };
            field.noise_is_as_claimed()
        };
        assert_eq!([0.9, 1.2].map(told), [Some(true); 2]);
        assert_eq!([0.52, 1.4].map(told), [Some(false); 2]);
        assert_eq!(told(CLAIMED), None);
    }

    #[test]
    fn omega_is_the_quadratic_form_of_the_deviance() {
        let points = points();
        let found = points.collocate(&FIELD).expect("regular");
        let mut flat = points.clone();
        for p in &mut flat.at_m {
            p.z = 0.0;
        }
        let difference = points.restricted_deviance(&FIELD).expect("regular")
            - flat.restricted_deviance(&FIELD).expect("regular");
        assert!((difference - found.omega).abs() < 1e-6 * found.omega);
    }
}
