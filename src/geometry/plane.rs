//! Planes and their total-least-squares fit (patent \[0051\]-\[0088\]): the normal is the eigenvector of the smallest
//! eigenvalue of the centred second-moment matrix, and that eigenvalue is the sum of squared distances (\[0087\]).

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
        sine.atan2(self.normal.dot(&other.normal))
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
