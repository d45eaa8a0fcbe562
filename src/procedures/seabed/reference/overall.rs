//! The overall adjustment of Li 2019, equations (1) to (11), on matched points: what the paper does once its features are matched.
//!
//! Axes as in the paper: X north, Y east, Z down; `kappa` heading; `y` across-track distance (starboard positive) and `h` depth under the
//! transducer. Of the coefficients printed under (8) all but one agree with the model by differences; a13 must be
//! `y2 cos k2 - y1 cos k1`, the print has the other sign.

use crate::math;
use nalgebra::{DMatrix, DVector, SMatrix, Vector3};

/// One side of a matched point: what one line measured of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Transducer, north, east, down, metres.
    pub transducer_m: Vector3<f64>,
    /// Heading, radians.
    pub heading_rad: f64,
    /// Speed over ground, metres per second, along the heading (3).
    pub speed_m_s: f64,
    /// Depression of the beam from the vertical, radians, starboard positive.
    pub beam_rad: f64,
    /// Slant range, metres.
    pub range_m: f64,
}

/// The five unknowns: roll, pitch, heading, latency, range scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overall {
    /// Roll, radians (`dphi`).
    pub roll_rad: f64,
    /// Pitch, radians (`domega`).
    pub pitch_rad: f64,
    /// Heading, radians (`dkappa`).
    pub heading_rad: f64,
    /// Latency, seconds (`dt`).
    pub latency_s: f64,
    /// Range scale (`dS / S`).
    pub scale: f64,
}

impl Side {
    /// Across distance and depth under the transducer at these values (11).
    fn across_and_depth(&self, at: &Overall) -> (f64, f64) {
        let range_m = self.range_m * (1.0 + at.scale);
        let beam = self.beam_rad + at.roll_rad;
        (range_m * math::sin(beam), range_m * math::cos(beam))
    }

    /// The point, north, east, down (1): turned by heading and the small pitch, moved back by the latency.
    pub(super) fn point_m(&self, at: &Overall) -> Vector3<f64> {
        let (across_m, depth_m) = self.across_and_depth(at);
        let (sine, cosine) = math::sin_cos(self.heading_rad + at.heading_rad);
        // a bow-up pitch swings the beam forward
        let (forward_m, down_m) = (
            depth_m * math::sin(at.pitch_rad),
            depth_m * math::cos(at.pitch_rad),
        );
        let late = self.speed_m_s * at.latency_s;
        let (own_sine, own_cosine) = math::sin_cos(self.heading_rad);
        self.transducer_m
            + Vector3::new(
                cosine * forward_m - sine * across_m + late * own_cosine,
                sine * forward_m + cosine * across_m + late * own_sine,
                down_m,
            )
    }

    /// Columns of (5): how the point moves with roll, pitch, heading, latency, scale.
    fn columns(&self, at: &Overall) -> SMatrix<f64, 3, 5> {
        let (y, h) = self.across_and_depth(at);
        let (s, c) = math::sin_cos(self.heading_rad + at.heading_rad);
        let (own_s, own_c) = math::sin_cos(self.heading_rad);
        let v = self.speed_m_s;
        SMatrix::from_columns(&[
            Vector3::new(-h * s, h * c, -y),
            Vector3::new(h * c, h * s, 0.0),
            Vector3::new(-y * c, -y * s, 0.0),
            Vector3::new(v * own_c, v * own_s, 0.0),
            Vector3::new(-y * s, y * c, h),
        ])
    }
}

/// Why the adjustment has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OverallError {
    /// Too few matches, or a geometry that does not separate the five.
    #[error("the matched points do not separate the five unknowns")]
    Singular,
    /// The angles never moved by less than 0.01 degrees.
    #[error("not below 0.01 degrees after {0} passes")]
    Endless(usize),
}

/// Most passes.
const PASSES: usize = 30;

/// Adjusts the matched points (8) until roll, pitch and heading move by less than 0.01 degrees; with `bounded` the latency is held at
/// or above zero (9), as in the paper.
///
/// # Errors
/// [`OverallError`].
pub fn adjust(matches: &[[Side; 2]], bounded: bool) -> Result<Overall, OverallError> {
    let mut at = Overall::default();
    for _ in 0..PASSES {
        let mut step = solve(matches, &at, None)?;
        if bounded && at.latency_s + step[3] < 0.0 {
            step = solve(matches, &at, Some(-at.latency_s))?;
        }
        at = Overall {
            roll_rad: at.roll_rad + step[0],
            pitch_rad: at.pitch_rad + step[1],
            heading_rad: at.heading_rad + step[2],
            latency_s: at.latency_s + step[3],
            scale: at.scale + step[4],
        };
        let largest = step.rows(0, 3).amax();
        if largest < 0.01f64.to_radians() {
            return Ok(at);
        }
    }
    Err(OverallError::Endless(PASSES))
}

/// Standard deviations of the five at a solution, from the misclosures that are left; `None` where the matches do not separate them.
#[must_use]
pub fn sigmas(matches: &[[Side; 2]], at: &Overall) -> Option<[f64; 5]> {
    let (mut normal, mut squares) = (SMatrix::<f64, 5, 5>::zeros(), 0.0);
    for [a, b] in matches {
        let columns = a.columns(at) - b.columns(at);
        normal += columns.tr_mul(&columns);
        squares += (b.point_m(at) - a.point_m(at)).norm_squared();
    }
    let redundancy = (3 * matches.len()).checked_sub(5).filter(|r| *r > 0)?;
    let covariance = normal.cholesky()?.inverse() * (squares / redundancy as f64);
    Some(std::array::from_fn(|k| covariance[(k, k)].sqrt()))
}

/// One least-squares step; with the latency's step given, of the other four.
fn solve(
    matches: &[[Side; 2]],
    at: &Overall,
    latency_step: Option<f64>,
) -> Result<DVector<f64>, OverallError> {
    let mut design = DMatrix::zeros(3 * matches.len(), 5);
    let mut misclosure = DVector::zeros(3 * matches.len());
    for (k, [a, b]) in matches.iter().enumerate() {
        let columns = a.columns(at) - b.columns(at);
        design.view_mut((3 * k, 0), (3, 5)).copy_from(&columns);
        let off = b.point_m(at) - a.point_m(at);
        misclosure.rows_mut(3 * k, 3).copy_from(&off);
    }
    if let Some(step) = latency_step {
        misclosure -= design.column(3) * step;
        design.column_mut(3).fill(0.0);
    }
    let mut normal = design.tr_mul(&design);
    if latency_step.is_some() {
        normal[(3, 3)] = 1.0;
    }
    let right = design.tr_mul(&misclosure);
    let scale = normal.diagonal().map(|d| 1.0 / d.max(1e-300).sqrt());
    let scaled = DMatrix::from_fn(5, 5, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let smallest = scaled.clone().symmetric_eigenvalues().min();
    if !(smallest > 1e-10) {
        return Err(OverallError::Singular);
    }
    let factor = scaled.cholesky().ok_or(OverallError::Singular)?;
    let mut step = factor
        .solve(&right.component_mul(&scale))
        .component_mul(&scale);
    if let Some(given) = latency_step {
        step[3] = given;
    }
    Ok(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Perfect matches: both lines measured the same point through the same wrong mounting.
    fn matches(truth: &Overall) -> Vec<[Side; 2]> {
        let side = |point: &Vector3<f64>, track_east: f64, heading: f64, speed: f64| {
            let mut side = Side {
                transducer_m: Vector3::new(point.x, track_east, 1.0),
                heading_rad: heading,
                speed_m_s: speed,
                beam_rad: 0.1,
                range_m: 14.0,
            };
            // the transducer, the beam and the range with which the true values reach the point exactly
            for _ in 0..60 {
                let off = point - side.point_m(truth);
                let (sine, cosine) = math::sin_cos(heading);
                let (along, across) =
                    (off.x * cosine + off.y * sine, off.y * cosine - off.x * sine);
                side.transducer_m += Vector3::new(cosine, sine, 0.0) * along;
                let (y, h) = side.across_and_depth(truth);
                let (y, h) = (y + across, h + off.z);
                side.range_m = math::hypot(y, h) / (1.0 + truth.scale);
                side.beam_rad = math::atan2(y, h) - truth.roll_rad;
            }
            side
        };
        let point = |k: usize| {
            let x = k as f64;
            Vector3::new(3.0 * x, 8.0 * math::sin(1.7 * x), 14.0 + math::cos(0.9 * x))
        };
        let lines = [
            (0.0, 0.3, 2.0),
            (20.0, 0.3, 2.0),
            (0.0, 3.44, 2.0),
            (0.0, 0.3, 3.5),
        ];
        (0..60)
            .map(|k| {
                let of =
                    |(east, heading, speed): (f64, f64, f64)| side(&point(k), east, heading, speed);
                [of(lines[0]), of(lines[1 + k % 3])]
            })
            .collect()
    }

    const TRUTH: Overall = Overall {
        roll_rad: 0.03,
        pitch_rad: -0.02,
        heading_rad: 0.015,
        latency_s: 0.08,
        scale: -0.002,
    };

    #[test]
    fn perfect_matches_are_recovered() {
        let found = adjust(&matches(&TRUTH), false).expect("solved");
        for (a, b) in [
            (found.roll_rad, TRUTH.roll_rad),
            (found.pitch_rad, TRUTH.pitch_rad),
            (found.heading_rad, TRUTH.heading_rad),
            (found.latency_s, TRUTH.latency_s),
            (found.scale, TRUTH.scale),
        ] {
            assert!((a - b).abs() < 1e-5, "{found:?}");
        }
    }

    /// A millimetre of noise on the ranges: the stated sigmas have the size of the errors.
    #[test]
    fn sigmas_are_of_the_size_of_the_errors() {
        let noisy = |(k, mut pair): (usize, [Side; 2])| {
            pair[0].range_m += 1e-3 * ((k * 37 % 23) as f64 / 8.0 - 1.4);
            pair
        };
        let all: Vec<[Side; 2]> = matches(&TRUTH).into_iter().enumerate().map(noisy).collect();
        let found = adjust(&all, false).expect("solved");
        let sigma = sigmas(&all, &found).expect("regular");
        let off = (found.roll_rad - TRUTH.roll_rad).abs();
        assert!(sigma[0] > 1e-7 && off < 5.0 * sigma[0], "{off} {sigma:?}");
        let one_track: Vec<[Side; 2]> = all.iter().map(|[a, _]| [*a, *a]).collect();
        assert_eq!(sigmas(&one_track, &found), None);
    }

    #[test]
    fn a_negative_latency_stops_at_zero_when_bounded() {
        let late = Overall {
            latency_s: -0.08,
            ..TRUTH
        };
        let free = adjust(&matches(&late), false).expect("solved");
        let bounded = adjust(&matches(&late), true).expect("solved");
        assert!((free.latency_s + 0.08).abs() < 1e-5);
        assert!(bounded.latency_s.abs() < 1e-12);
    }

    /// The printed sign of a13 is wrong: with it the derivative of the northing difference with heading has the other sign.
    #[test]
    fn a13_has_the_sign_of_the_model() {
        let [a, b] = matches(&TRUTH)[3];
        let difference = |heading: f64| {
            let at = Overall {
                heading_rad: heading,
                ..Overall::default()
            };
            (a.point_m(&at) - b.point_m(&at)).x
        };
        let by_differences = (difference(1e-6) - difference(-1e-6)) / 2e-6;
        let across = |s: &Side| s.across_and_depth(&Overall::default()).0;
        let printed = across(&a) * math::cos(a.heading_rad) - across(&b) * math::cos(b.heading_rad);
        assert!((by_differences + printed).abs() < 1e-6);
        assert!(printed.abs() > 1.0);
    }

    #[test]
    fn two_lines_alike_do_not_separate_the_five() {
        let all = matches(&TRUTH);
        let alike: Vec<_> = all.iter().map(|[a, _]| [*a, *a]).collect();
        assert_eq!(adjust(&alike, false), Err(OverallError::Singular));
    }
}
