//! Planes and their total-least-squares fit (patent \[0051\]-\[0088\]): the normal is the eigenvector of the smallest
//! eigenvalue of the centred second-moment matrix, and that eigenvalue is the sum of squared distances (\[0087\]).

use crate::math;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use thiserror::Error;

/// Smallest ratio of in-plane spread to thickness (both root mean square) that still is a plane and not a line.
const FLATTEST_RATIO: f64 = 3.0;
/// Spread below this share of the points' largest spread is rounding, not extent.
const ROUNDING: f64 = 1e-7;

/// The plane `n . x = d` in the frame of its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal n.
    pub normal: Vector3<f64>,
    /// Offset d along the normal, metres.
    pub offset_m: f64,
}

impl Plane {
    /// The plane with this normal (unit) through `point_m` (metres).
    #[must_use]
    pub fn through(normal: Vector3<f64>, point_m: &Vector3<f64>) -> Self {
        Self {
            normal,
            offset_m: normal.dot(point_m),
        }
    }

    /// `n . x - d`, metres: positive on the side to which the normal points.
    #[must_use]
    pub fn distance_m(&self, point_m: &Vector3<f64>) -> f64 {
        self.normal.dot(point_m) - self.offset_m
    }

    /// The same plane with its normal turned to the side of `direction`.
    #[must_use]
    pub fn towards(self, direction: &Vector3<f64>) -> Self {
        if self.normal.dot(direction) < 0.0 {
            self.flipped()
        } else {
            self
        }
    }

    /// The same plane seen from its other side.
    #[must_use]
    pub fn flipped(self) -> Self {
        Self {
            normal: -self.normal,
            offset_m: -self.offset_m,
        }
    }

    /// Angle between the normals, radians, 0 to pi; accurate for small angles too.
    #[must_use]
    pub fn angle_to_rad(&self, other: &Self) -> f64 {
        let sine = self.normal.cross(&other.normal).norm();
        math::atan2(sine, self.normal.dot(&other.normal))
    }
}

/// Why points give no plane.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PlaneError {
    /// Fewer than three points (or no weight at all).
    #[error("{found} points, expected at least 3 for a plane")]
    TooFew {
        /// Points with positive weight.
        found: usize,
    },
    /// The points lie on a line or in one place, as far as their scatter can tell.
    #[error(
        "{count} points span no plane: their spread is {second_m:.6} m across their longest direction and {thickness_m:.6} m off the plane, expected a spread at least 3 times the thickness"
    )]
    NoExtent {
        /// Number of points.
        count: usize,
        /// Root-mean-square spread along the second in-plane direction, metres.
        second_m: f64,
        /// Root-mean-square distance from the best plane, metres.
        thickness_m: f64,
    },
    /// A coordinate or a weight is not a finite number.
    #[error("a coordinate or weight among {count} points is not finite")]
    NotFinite {
        /// Number of points.
        count: usize,
    },
}

/// Weighted sums over points that suffice for a plane fit; two of them merge into that of all points.
///
/// The sums are about the first point, so that coordinates far from the origin lose no digits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneMoments {
    shift_m: Vector3<f64>,
    count: usize,
    weight: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl PlaneMoments {
    /// Adds a point (metres) with weight 1.
    pub fn add(&mut self, point_m: &Vector3<f64>) {
        self.add_weighted(point_m, 1.0);
    }

    /// Adds a point (metres) with a weight; 0 leaves everything as it is.
    pub fn add_weighted(&mut self, point_m: &Vector3<f64>, weight: f64) {
        if weight == 0.0 {
            return;
        }
        if self.count == 0 {
            self.shift_m = *point_m;
        }
        let x = point_m - self.shift_m;
        let weighted = x * weight;
        self.count += 1;
        self.weight += weight;
        self.first += weighted;
        self.second += weighted * x.transpose();
    }

    /// Adds the points of another accumulator.
    pub fn merge(&mut self, other: &Self) {
        if self.count == 0 {
            *self = *other;
        } else if other.count > 0 {
            let by = other.shift_m - self.shift_m;
            let cross = other.first * by.transpose();
            self.count += other.count;
            self.weight += other.weight;
            self.first += other.first + by * other.weight;
            self.second +=
                other.second + cross + cross.transpose() + by * by.transpose() * other.weight;
        }
    }

    /// Number of points added with a weight other than 0.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Sum of the weights.
    #[must_use]
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Weighted mean of the points, metres; `None` without points.
    #[must_use]
    pub fn centroid_m(&self) -> Option<Vector3<f64>> {
        (self.weight > 0.0).then(|| self.shift_m + self.first / self.weight)
    }

    /// Second-moment matrix about the centroid (patent \[0080\]), square metres times weight.
    #[must_use]
    pub fn scatter_m2(&self) -> Matrix3<f64> {
        if self.weight > 0.0 {
            self.second - self.first * self.first.transpose() / self.weight
        } else {
            Matrix3::zeros()
        }
    }

    /// The plane of least squared distances; its normal points to the side of +Z, or -X, or +Y for upright planes
    /// (turn it with [`PlaneFit::towards`]).
    ///
    /// # Errors
    /// [`PlaneError`] where the points are too few or do not span two dimensions.
    pub fn fit(&self) -> Result<PlaneFit, PlaneError> {
        let count = self.count;
        let centroid_m = match self.centroid_m() {
            Some(c) if count >= 3 => c,
            _ if self.weight.is_nan() => return Err(PlaneError::NotFinite { count }),
            _ => return Err(PlaneError::TooFew { found: count }),
        };
        let scatter = self.scatter_m2();
        if scatter
            .iter()
            .chain(centroid_m.iter())
            .any(|v| !v.is_finite())
        {
            return Err(PlaneError::NotFinite { count });
        }
        let (values, axes) = ascending(&scatter);
        let spread = values.map(|v| (v.max(0.0) / self.weight).sqrt());
        if spread[1] <= ROUNDING * spread[2]
            || spread[1] < FLATTEST_RATIO * spread[0]
            || spread[2] == 0.0
        {
            return Err(PlaneError::NoExtent {
                count,
                second_m: spread[1],
                thickness_m: spread[0],
            });
        }
        let fit = PlaneFit {
            plane: Plane::through(axes[0], &centroid_m),
            centroid_m,
            along: [axes[2], axes[1]],
            count,
            weight: self.weight,
            in_plane_m2: [values[2], values[1]],
            sum_of_squares_m2: values[0].max(0.0),
        };
        Ok(fit.towards(&Vector3::new(-1e-6, 1e-9, 1.0)))
    }
}

/// Eigenvalues in ascending order with their unit eigenvectors.
fn ascending(symmetric: &Matrix3<f64>) -> ([f64; 3], [Vector3<f64>; 3]) {
    let eigen = SymmetricEigen::new(*symmetric);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    (
        order.map(|k| eigen.eigenvalues[k]),
        order.map(|k| eigen.eigenvectors.column(k).normalize()),
    )
}

/// A plane fitted to points, with what its accuracy needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFit {
    /// The plane.
    pub plane: Plane,
    /// Weighted mean of the points, on the plane, metres.
    pub centroid_m: Vector3<f64>,
    /// In-plane unit vectors of largest and second spread.
    pub along: [Vector3<f64>; 2],
    /// Number of points.
    pub count: usize,
    /// Sum of weights (the number of points for a fit without weights).
    pub weight: f64,
    /// Sum of squared in-plane coordinates along `along`, square metres times weight.
    pub in_plane_m2: [f64; 2],
    /// Sum of squared distances, square metres times weight: the smallest eigenvalue (patent \[0087\]).
    pub sum_of_squares_m2: f64,
}

impl PlaneFit {
    /// The fit with its normal turned to the side of `direction`.
    #[must_use]
    pub fn towards(self, direction: &Vector3<f64>) -> Self {
        Self {
            plane: self.plane.towards(direction),
            ..self
        }
    }

    /// Standard deviation of one point about the plane (three parameters), metres; for a fit without weights. 0 for three points.
    #[must_use]
    pub fn point_sigma_m(&self) -> f64 {
        let redundancy = self.count.saturating_sub(3).max(1) as f64;
        (self.sum_of_squares_m2 / redundancy).sqrt()
    }

    /// Covariance of the plane from the noise of its points along the normal: tilt of the normal towards `along[0]` and
    /// `along[1]` (radians), offset at the centroid (metres). With weights 1/sigma^2, `point_sigma` is 1.
    ///
    /// The three are uncorrelated at the centroid. A tilt's variance is `sigma^2 L / (L - L0)^2` with the in-plane
    /// eigenvalue L and the noise's own share `L0 = W sigma^2` (first-order perturbation of the eigenvector).
    #[must_use]
    pub fn covariance(&self, point_sigma: f64) -> Matrix3<f64> {
        let variance = point_sigma * point_sigma;
        let tilt = |spread: f64| {
            let clean = (spread - self.weight * variance).max(0.5 * spread);
            variance * spread / (clean * clean)
        };
        Matrix3::from_diagonal(&Vector3::new(
            tilt(self.in_plane_m2[0]),
            tilt(self.in_plane_m2[1]),
            variance / self.weight,
        ))
    }

    /// Standard deviation (metres) of the plane at `point_m` (extended beyond its points, for example below the water).
    #[must_use]
    pub fn sigma_at_m(&self, point_m: &Vector3<f64>, point_sigma: f64) -> f64 {
        let arm = point_m - self.centroid_m;
        let row = Vector3::new(arm.dot(&self.along[0]), arm.dot(&self.along[1]), -1.0);
        row.dot(&(self.covariance(point_sigma) * row)).sqrt()
    }
}

/// Least-squares plane of `points_m` (metres), all with the same weight.
///
/// # Errors
/// As [`PlaneMoments::fit`].
pub fn fit(points_m: &[Vector3<f64>]) -> Result<PlaneFit, PlaneError> {
    let mut moments = PlaneMoments::default();
    points_m.iter().for_each(|p| moments.add(p));
    moments.fit()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats;
    use crate::stats::normal;
    use rand::RngExt;

    /// Points and values from `tests/recipes/plane_fit.py` (numpy's singular value decomposition).
    const POINTS: [[f64; 3]; 12] = [
        [431.5102, -1207.2153, 37.8064],
        [431.3301, -1207.4173, 38.0955],
        [431.4193, -1207.3481, 37.746],
        [431.3257, -1207.4467, 37.917],
        [431.3597, -1207.3982, 38.0058],
        [431.3716, -1207.3662, 38.2052],
        [431.6906, -1207.0456, 37.885],
        [431.4591, -1207.2499, 37.7801],
        [430.8712, -1207.8713, 37.8766],
        [431.7188, -1207.018, 37.7804],
        [431.2798, -1207.4782, 37.9114],
        [431.0692, -1207.7094, 37.9921],
    ];

    fn points() -> Vec<Vector3<f64>> {
        POINTS.iter().map(|p| Vector3::from(*p)).collect()
    }

    #[test]
    fn agrees_with_numpy() {
        let fit = fit(&points()).expect("a plane").towards(&-Vector3::x());
        let normal = Vector3::new(-0.7197571229260822, 0.6941589109595875, 0.00964833314973616);
        assert!((fit.plane.normal - normal).norm() < 1e-11);
        assert!((fit.plane.offset_m - -1148.22754385098).abs() < 1e-8);
        assert!((fit.sum_of_squares_m2 - 0.0017809212598075812).abs() < 1e-12);
        assert!((fit.in_plane_m2[0] - 1.278879706267525).abs() < 1e-11);
        assert!((fit.in_plane_m2[1] - 0.18862066080600237).abs() < 1e-11);
        let summed: f64 = points()
            .iter()
            .map(|p| fit.plane.distance_m(p).powi(2))
            .sum();
        assert!((summed - fit.sum_of_squares_m2).abs() < 1e-12);
    }

    #[test]
    fn merged_moments_are_the_moments_of_all() {
        let far = Vector3::new(-2.17e6, 4.38e6, 4.08e6);
        let points: Vec<_> = points().iter().map(|p| p + far).collect();
        let mut all = PlaneMoments::default();
        points.iter().for_each(|p| all.add(p));
        let mut parts = [PlaneMoments::default(); 4];
        for (k, p) in points.iter().enumerate() {
            parts[k * k % 3].add(p);
        }
        let mut merged = PlaneMoments::default();
        parts.iter().for_each(|p| merged.merge(p));
        assert_eq!(merged.count(), 12);
        assert!((merged.scatter_m2() - all.scatter_m2()).norm() < 1e-8);
        let (a, b) = (all.fit().expect("plane"), merged.fit().expect("plane"));
        assert!(a.plane.normal.cross(&b.plane.normal).norm() < 1e-7);
        assert!((a.sum_of_squares_m2 - 0.0017809212598075812).abs() < 1e-9);
    }

    #[test]
    fn weights_count_as_repetitions() {
        let (mut weighted, mut repeated) = (PlaneMoments::default(), PlaneMoments::default());
        for (k, p) in points().iter().enumerate() {
            weighted.add_weighted(p, (k % 3) as f64);
            (0..k % 3).for_each(|_| repeated.add(p));
        }
        let (a, b) = (
            weighted.fit().expect("plane"),
            repeated.fit().expect("plane"),
        );
        assert!((a.plane.normal - b.plane.normal).norm() < 1e-12);
        assert!((a.sum_of_squares_m2 - b.sum_of_squares_m2).abs() < 1e-14);
    }

    /// The reported covariance against the scatter of 4000 fits with fresh noise, thick enough for the noise's own share to show.
    #[test]
    fn covariance_is_the_scatter_of_repeated_fits() {
        let (sigma, trials) = (0.035, 4000);
        let mut random = stats::stream(3, 0);
        let base: Vec<Vector3<f64>> = (0..30)
            .map(|_| {
                Vector3::new(
                    0.0,
                    random.random_range(-1.0..1.0),
                    random.random_range(-0.3..0.3),
                )
            })
            .collect();
        let clean = fit(&base).expect("plane").towards(&-Vector3::x());
        let (mut squares, mut claimed) = (Vector3::zeros(), Vector3::zeros());
        for _ in 0..trials {
            let noisy: Vec<_> = base
                .iter()
                .map(|p| p + Vector3::from_fn(|_, _| sigma * normal::draw(&mut random)))
                .collect();
            let fit = fit(&noisy).expect("plane").towards(&-Vector3::x());
            let tilt = |k: usize| fit.plane.normal.dot(&clean.along[k]);
            let offset = fit.plane.distance_m(&clean.centroid_m);
            squares += Vector3::new(tilt(0).powi(2), tilt(1).powi(2), offset * offset);
            claimed += fit.covariance(sigma).diagonal();
        }
        let ratio = squares.component_div(&claimed);
        // chi-square with 4000 degrees of freedom: +- 7 % is three standard deviations
        assert!(ratio.iter().all(|r| (r - 1.0).abs() < 0.07), "{ratio}");
        let at = clean.sigma_at_m(&(clean.centroid_m + clean.along[1] * 3.0), sigma);
        assert!(at > 3.0 * clean.covariance(sigma)[(1, 1)].sqrt());
    }

    #[test]
    fn refuses_what_spans_no_plane() {
        let line: Vec<_> = (0..20)
            .map(|k| Vector3::new(1.0, 2.0, 0.5) * f64::from(k))
            .collect();
        assert!(matches!(
            fit(&line),
            Err(PlaneError::NoExtent { count: 20, .. })
        ));
        let mut random = stats::stream(4, 0);
        let mut noise = || random.random_range(-0.02..0.02);
        let fuzzy: Vec<_> = line
            .iter()
            .map(|p| p + Vector3::new(noise(), noise(), noise()))
            .collect();
        assert!(matches!(fit(&fuzzy), Err(PlaneError::NoExtent { .. })));
        assert!(matches!(
            fit(&[Vector3::zeros(); 5]),
            Err(PlaneError::NoExtent { .. })
        ));
        assert_eq!(fit(&line[..2]), Err(PlaneError::TooFew { found: 2 }));
        assert_eq!(fit(&[]), Err(PlaneError::TooFew { found: 0 }));
        let mut bad = points();
        bad[3].y = f64::NAN;
        assert_eq!(fit(&bad), Err(PlaneError::NotFinite { count: 12 }));
    }
}
