//! Plane fit by iteratively reweighted least squares (Huber 1964; Beaton and Tukey 1974), for points with outliers once a
//! start is known (see `ransac` where they are many).

use nalgebra::Vector3;

use super::plane::{Plane, PlaneError, PlaneFit, PlaneMoments, fit};
use crate::stats::mad_sigma;

/// Weight of a standardised distance in the robust fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DistanceWeight {
    /// Huber: 1 up to `k` sigma, then k/|x|.
    Huber {
        /// Bend, in sigmas (1.345 for 95 % efficiency).
        k: f64,
    },
    /// Tukey's biweight: (1 - (x/c)^2)^2 up to `c` sigma, then 0.
    Tukey {
        /// Where the weight reaches zero, in sigmas (4.685 for 95 % efficiency).
        c: f64,
    },
}

impl DistanceWeight {
    /// Weight of the standardised distance `x` (sigmas).
    #[must_use]
    pub fn weight(&self, x: f64) -> f64 {
        match *self {
            Self::Huber { k } => {
                if x.abs() <= k {
                    1.0
                } else {
                    k / x.abs()
                }
            }
            Self::Tukey { c } => {
                let left = (1.0 - (x / c).powi(2)).max(0.0);
                left * left
            }
        }
    }
}

/// How the robust fit weighs and stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustOptions {
    /// Weight function.
    pub weight: DistanceWeight,
    /// The distances' scale is never taken smaller than this, metres.
    pub least_sigma_m: f64,
    /// Stops when the normal turns by less than this (radians) and the offset moves by less than this times one metre.
    pub tolerance: f64,
    /// Largest number of refits.
    pub max_iterations: usize,
}

impl Default for RobustOptions {
    fn default() -> Self {
        Self {
            weight: DistanceWeight::Tukey { c: 4.685 },
            least_sigma_m: 1e-4,
            tolerance: 1e-9,
            max_iterations: 50,
        }
    }
}

/// A robust fit and what it made of the points.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustFit {
    /// The fit; its weights are those of the last iteration.
    pub fit: PlaneFit,
    /// Scale of the distances from their median absolute deviation, metres.
    pub sigma_m: f64,
    /// Weight of every point, 0 to 1.
    pub weights: Vec<f64>,
    /// Refits done.
    pub iterations: usize,
}

/// Iteratively reweighted plane fit, starting at `start` (or the plain fit), scale re-estimated each time from the
/// median absolute deviation.
///
/// # Errors
/// As [`PlaneMoments::fit`], also when too few points keep a weight.
pub fn fit_robust(
    points_m: &[Vector3<f64>],
    start: Option<Plane>,
    options: &RobustOptions,
) -> Result<RobustFit, PlaneError> {
    let mut plane = match start {
        Some(plane) => plane,
        None => fit(points_m)?.plane,
    };
    let mut iterations = 0;
    loop {
        iterations += 1;
        let (fit, sigma_m, weights) = reweighted(points_m, &plane, options)?;
        let moved =
            (fit.plane.normal - plane.normal).norm() + plane.distance_m(&fit.centroid_m).abs();
        plane = fit.plane;
        if moved < options.tolerance || iterations >= options.max_iterations {
            return Ok(RobustFit {
                fit,
                sigma_m,
                weights,
                iterations,
            });
        }
    }
}

fn reweighted(
    points_m: &[Vector3<f64>],
    plane: &Plane,
    options: &RobustOptions,
) -> Result<(PlaneFit, f64, Vec<f64>), PlaneError> {
    let distances: Vec<f64> = points_m.iter().map(|p| plane.distance_m(p)).collect();
    let scale = mad_sigma(&mut distances.clone()).ok_or(PlaneError::TooFew { found: 0 })?;
    let sigma_m = scale.max(options.least_sigma_m);
    let weights: Vec<f64> = distances
        .iter()
        .map(|d| options.weight.weight(d / sigma_m))
        .collect();
    let mut moments = PlaneMoments::default();
    for (point, weight) in points_m.iter().zip(&weights) {
        moments.add_weighted(point, *weight);
    }
    Ok((moments.fit()?.towards(&plane.normal), sigma_m, weights))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats;
    use crate::stats::normal;
    use rand::RngExt;

    /// A patch of x = 2 with 1 cm noise, of whose points every fourth stands 0.1 to 0.6 m in front.
    fn spoiled() -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
        let mut random = stats::stream(9, 0);
        let mut clean = vec![];
        let mut all = vec![];
        for k in 0..800 {
            let e = normal::draw(&mut random);
            let (y, z) = (
                random.random_range(-2.0..2.0),
                random.random_range(-1.0..1.0),
            );
            if k % 4 == 0 {
                all.push(Vector3::new(
                    2.0 - random.random_range(0.1..0.6),
                    y,
                    0.5 * (z + 1.0),
                ));
            } else {
                clean.push(Vector3::new(2.0 + 0.01 * e, y, z));
                all.push(clean[clean.len() - 1]);
            }
        }
        (clean, all)
    }

    #[test]
    fn gross_errors_do_not_move_the_plane() {
        let (clean, all) = spoiled();
        let truth = fit(&clean).expect("plane").plane;
        let plain = fit(&all).expect("plane").plane;
        let tukey = fit_robust(&all, None, &RobustOptions::default()).expect("plane");
        let sigma = (0.01 / 600.0_f64.sqrt(), 0.01 / 600.0_f64.sqrt() / 0.57);
        assert!(
            tukey
                .fit
                .plane
                .angle_to_rad(&truth.towards(&tukey.fit.plane.normal))
                < sigma.1
        );
        assert!(
            tukey
                .fit
                .plane
                .distance_m(&Vector3::new(2.0, 0.0, 0.0))
                .abs()
                < 3.0 * sigma.0
        );
        assert!(plain.distance_m(&Vector3::new(2.0, 0.0, 0.0)).abs() > 0.05);
        // 25 % outliers move the median absolute deviation to its 2/3 quantile: 1.43 sigma
        assert!(
            (tukey.sigma_m / 0.01 - 1.43).abs() < 0.2,
            "{}",
            tukey.sigma_m
        );
        assert!(tukey.iterations < 50);
        assert!(tukey.weights.iter().step_by(4).all(|w| *w < 0.2));
        let huber = RobustOptions {
            weight: DistanceWeight::Huber { k: 1.345 },
            ..RobustOptions::default()
        };
        let huber = fit_robust(&all, None, &huber).expect("plane").fit.plane;
        assert!(huber.distance_m(&Vector3::new(2.0, 0.0, 0.0)).abs() < 0.02);
    }

    #[test]
    fn weight_functions_bend_where_they_say() {
        let huber = DistanceWeight::Huber { k: 1.5 };
        assert_eq!((huber.weight(-1.5), huber.weight(3.0)), (1.0, 0.5));
        let tukey = DistanceWeight::Tukey { c: 2.0 };
        assert_eq!(
            (tukey.weight(0.0), tukey.weight(2.0), tukey.weight(-9.0)),
            (1.0, 0.0, 0.0)
        );
        assert!((tukey.weight(1.0) - 0.5625).abs() < 1e-15);
    }
}
