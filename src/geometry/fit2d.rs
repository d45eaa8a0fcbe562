//! Lines and circles through points of a plane, by orthogonal distances.

use nalgebra::{Matrix2, Matrix3, SymmetricEigen, Vector2, Vector3};
use thiserror::Error;

/// Steps of the circle's iteration at the most.
const MOST_STEPS: usize = 100;
/// Smallest angle (radians) that the points must span as seen from a circle's centre.
const SMALLEST_SPAN_RAD: f64 = 0.05;

/// Points that no line or circle can be put through.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FitError {
    /// Too few points.
    #[error("{found} points, expected at least {needed}")]
    TooFew {
        /// Points given.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// The points do not span the figure.
    #[error("the points do not span a {figure}")]
    Degenerate {
        /// `line` or `circle`.
        figure: &'static str,
    },
}

/// A line through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineFit {
    /// Mean of the points, metres.
    pub centroid_m: Vector2<f64>,
    /// Unit direction; its sign is arbitrary.
    pub direction: Vector2<f64>,
    /// Root mean square distance, metres.
    pub rms_m: f64,
}

/// Total least squares: the direction of the largest eigenvalue of the centred second moments.
///
/// # Errors
/// [`FitError`] on fewer than two points or on points that are all the same.
pub fn line(points: &[Vector2<f64>]) -> Result<LineFit, FitError> {
    if points.len() < 2 {
        let (found, needed) = (points.len(), 2);
        return Err(FitError::TooFew { found, needed });
    }
    let n = points.len() as f64;
    let centroid_m = points.iter().sum::<Vector2<f64>>() / n;
    let arms = points.iter().map(|p| p - centroid_m);
    let moments = arms.fold(Matrix2::zeros(), |sum, a| sum + a * a.transpose()) / n;
    let eigen = SymmetricEigen::new(moments);
    let (large, small) = if eigen.eigenvalues[0] > eigen.eigenvalues[1] {
        (0, 1)
    } else {
        (1, 0)
    };
    if !(eigen.eigenvalues[large] > 0.0) {
        return Err(FitError::Degenerate { figure: "line" });
    }
    Ok(LineFit {
        centroid_m,
        direction: eigen.eigenvectors.column(large).into_owned(),
        rms_m: eigen.eigenvalues[small].max(0.0).sqrt(),
    })
}

/// A circle through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircleFit {
    /// Centre, metres.
    pub centre_m: Vector2<f64>,
    /// Radius, metres.
    pub radius_m: f64,
    /// Root mean square distance, metres.
    pub rms_m: f64,
}

/// Least squares of the orthogonal distances (Gander, Golub, Strebel, "Least-squares fitting of circles and ellipses", BIT 34, 1994,
/// section 3), by Gauss-Newton from Kåsa's algebraic circle.
///
/// # Errors
/// [`FitError`] on fewer than three points or on points that hardly bend.
pub fn circle(points: &[Vector2<f64>]) -> Result<CircleFit, FitError> {
    let degenerate = FitError::Degenerate { figure: "circle" };
    let mut fit = algebraic(points)?;
    for _ in 0..MOST_STEPS {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for p in points {
            let arm = fit.centre_m - p;
            let length = arm.norm().max(f64::MIN_POSITIVE);
            let row = Vector3::new(arm.x / length, arm.y / length, -1.0);
            normal += row * row.transpose();
            right -= row * (length - fit.radius_m);
        }
        let step = normal
            .cholesky()
            .ok_or_else(|| degenerate.clone())?
            .solve(&right);
        fit.centre_m += step.fixed_rows::<2>(0);
        fit.radius_m += step.z;
        if step.norm() < 1e-14 * fit.radius_m.abs().max(1.0) {
            break;
        }
    }
    let square = |p: &Vector2<f64>| ((p - fit.centre_m).norm() - fit.radius_m).powi(2);
    fit.rms_m = (points.iter().map(square).sum::<f64>() / points.len() as f64).sqrt();
    let extent = points
        .iter()
        .map(|p| (p - points[0]).norm())
        .fold(0.0, f64::max);
    if fit.radius_m.is_finite() && fit.radius_m > 0.0 && extent > SMALLEST_SPAN_RAD * fit.radius_m {
        return Ok(fit);
    }
    Err(degenerate)
}

/// Kåsa's circle: least squares of `|p|^2 - 2 c . p - k`.
fn algebraic(points: &[Vector2<f64>]) -> Result<CircleFit, FitError> {
    if points.len() < 3 {
        let (found, needed) = (points.len(), 3);
        return Err(FitError::TooFew { found, needed });
    }
    let mean = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for p in points {
        let arm = p - mean;
        let row = Vector3::new(2.0 * arm.x, 2.0 * arm.y, 1.0);
        normal += row * row.transpose();
        right += row * arm.norm_squared();
    }
    let solved = normal
        .cholesky()
        .ok_or(FitError::Degenerate { figure: "circle" })?
        .solve(&right);
    let arm = Vector2::new(solved.x, solved.y);
    Ok(CircleFit {
        centre_m: mean + arm,
        radius_m: (solved.z + arm.norm_squared()).sqrt(),
        rms_m: f64::NAN,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn points(xy: &[(f64, f64)]) -> Vec<Vector2<f64>> {
        xy.iter().map(|&(x, y)| Vector2::new(x, y)).collect()
    }

    /// Gander, Golub, Strebel 1994, section 3: centre (4.7398, 2.9835), radius 4.7142, all rounded to four decimals.
    #[test]
    fn the_published_circle_is_found() {
        let six = points(&[
            (1.0, 7.0),
            (2.0, 6.0),
            (5.0, 8.0),
            (7.0, 7.0),
            (9.0, 5.0),
            (3.0, 7.0),
        ]);
        let fit = circle(&six).expect("a circle");
        assert_abs_diff_eq!(fit.centre_m.x, 4.7398, epsilon = 5e-5);
        assert_abs_diff_eq!(fit.centre_m.y, 2.9835, epsilon = 5e-5);
        assert_abs_diff_eq!(fit.radius_m, 4.7142, epsilon = 5e-5);
    }

    /// Pearson's data (Phil. Mag. 2, 1901, p. 569): the line of closest fit is y = -0.5456 x + 5.784 in four digits; numpy's
    /// `linalg.eigh` of the moments gives -0.54556 and 5.78404.
    #[test]
    fn pearson_s_line_is_found() {
        let ten = points(&[
            (0.0, 5.9),
            (0.9, 5.4),
            (1.8, 4.4),
            (2.6, 4.6),
            (3.3, 3.5),
            (4.4, 3.7),
            (5.2, 2.8),
            (6.1, 2.8),
            (6.5, 2.4),
            (7.4, 1.5),
        ]);
        let fit = line(&ten).expect("a line");
        let slope = fit.direction.y / fit.direction.x;
        assert_abs_diff_eq!(slope, -0.5456, epsilon = 5e-5);
        assert_abs_diff_eq!(
            fit.centroid_m.y - slope * fit.centroid_m.x,
            5.784,
            epsilon = 5e-4
        );
    }

    #[test]
    fn a_line_is_no_circle_and_one_point_no_line() {
        let straight = points(&[(0.0, 0.0), (1.0, 1e-9), (2.0, 0.0), (3.0, 1e-9)]);
        assert!(circle(&straight).is_err());
        assert!(line(&points(&[(1.0, 1.0), (1.0, 1.0)])).is_err());
        assert!(matches!(
            circle(&straight[..2]),
            Err(FitError::TooFew { .. })
        ));
    }
}
