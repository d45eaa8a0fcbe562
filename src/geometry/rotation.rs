//! Rotations: exponential, logarithm, attitude angles.
//!
//! Attitude and every mounting angle: `R = Rz(-heading) Rx(pitch) Ry(roll)` between axes x right, y forward, z up
//! and east, north, up. Roll is positive starboard down, pitch positive bow up, heading clockwise from north.

use crate::math;
use nalgebra::{Matrix3, Vector3};

/// The cross-product matrix: `skew(a) b = a x b`.
#[must_use]
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// `Exp(v)`: the rotation by |v| radians about v (Rodrigues).
#[inline]
#[must_use]
pub fn exp(v: &Vector3<f64>) -> Matrix3<f64> {
    let squared = v.norm_squared();
    // below a tenth of a radian the series is exact to rounding and faster than sine and cosine
    let (a, b) = if squared < 1e-2 {
        (series(squared, &SINE), series(squared, &COSINE))
    } else {
        let angle = squared.sqrt();
        (math::sin(angle) / angle, (1.0 - math::cos(angle)) / squared)
    };
    let (x, y, z) = (v.x, v.y, v.z);
    let (ax, ay, az) = (a * x, a * y, a * z);
    let (bx, by, bz) = (b * x, b * y, b * z);
    Matrix3::new(
        1.0 - (by * y + bz * z),
        bx * y - az,
        bx * z + ay,
        bx * y + az,
        1.0 - (bx * x + bz * z),
        by * z - ax,
        bx * z - ay,
        by * z + ax,
        1.0 - (bx * x + by * y),
    )
}

/// Coefficients of `sin(x) / x` in powers of `x^2`.
const SINE: [f64; 6] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362880.0,
    -1.0 / 39916800.0,
];
/// Coefficients of `(1 - cos(x)) / x^2` in powers of `x^2`.
const COSINE: [f64; 6] = [
    0.5,
    -1.0 / 24.0,
    1.0 / 720.0,
    -1.0 / 40320.0,
    1.0 / 3628800.0,
    0.0,
];

/// A polynomial in `q`, without a division.
#[inline(always)]
fn series(q: f64, c: &[f64; 6]) -> f64 {
    let square = q * q;
    (c[0] + c[1] * q) + square * ((c[2] + c[3] * q) + square * (c[4] + c[5] * q))
}

/// `Log(R)`: the rotation vector (radians) of an orthonormal matrix, |v| <= pi.
#[must_use]
pub fn log(r: &Matrix3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(
        r[(2, 1)] - r[(1, 2)],
        r[(0, 2)] - r[(2, 0)],
        r[(1, 0)] - r[(0, 1)],
    ) * 0.5;
    let sine = axis.norm();
    let angle = math::atan2(sine, 0.5 * (r.trace() - 1.0));
    if sine > 1e-7 {
        return axis * (angle / sine);
    }
    if r.trace() > 0.0 {
        return axis;
    }
    nalgebra::UnitQuaternion::from_matrix(r).scaled_axis()
}

/// The nearest rotation to a nearly orthonormal matrix (polar factor).
#[must_use]
pub fn orthonormalised(m: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = m.svd(true, true);
    match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) => {
            let sign = (u * v_t).determinant().signum();
            u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t
        }
        _ => *m,
    }
}

/// `Rz(-heading) Rx(pitch) Ry(roll)`, angles in radians (`docs/conventions.md`).
#[must_use]
pub fn from_attitude(roll_rad: f64, pitch_rad: f64, heading_rad: f64) -> Matrix3<f64> {
    let (sr, cr) = math::sin_cos(roll_rad);
    let (sp, cp) = math::sin_cos(pitch_rad);
    let (sh, ch) = math::sin_cos(heading_rad);
    Matrix3::new(
        ch * cr + sh * sp * sr,
        sh * cp,
        ch * sr - sh * sp * cr,
        -sh * cr + ch * sp * sr,
        ch * cp,
        -sh * sr - ch * sp * cr,
        -cp * sr,
        sp,
        cp * cr,
    )
}

/// Roll, pitch, heading (radians) of a matrix made by [`from_attitude`]; pitch within +-pi/2, heading in (-pi, pi].
#[must_use]
pub fn to_attitude(r: &Matrix3<f64>) -> (f64, f64, f64) {
    let roll = math::atan2(-r[(2, 0)], r[(2, 2)]);
    let pitch = math::atan2(r[(2, 1)], math::hypot(r[(2, 0)], r[(2, 2)]));
    let heading = math::atan2(r[(0, 1)], r[(1, 1)]);
    (roll, pitch, heading)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn about(axis: usize, angle: f64) -> Matrix3<f64> {
        let mut v = Vector3::zeros();
        v[axis] = angle;
        exp(&v)
    }

    #[test]
    fn attitude_is_the_product_of_three_turns() {
        let (roll, pitch, heading) = (0.3, -0.4, 2.2);
        let product = about(2, -heading) * about(0, pitch) * about(1, roll);
        assert!((product - from_attitude(roll, pitch, heading)).norm() < 1e-15);
    }

    /// The same three numbers mean the same rotation as the usual Rz(h) Ry(p) Rx(r) between NED and forward-right-down.
    #[test]
    fn identity_with_north_east_down_and_forward_right_down() {
        let swap = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
        let (roll, pitch, heading) = (0.3, -0.4, 2.2);
        let ned_from_frd = about(2, heading) * about(1, pitch) * about(0, roll);
        let enu_from_rfu = swap * ned_from_frd * swap.transpose();
        assert!((enu_from_rfu - from_attitude(roll, pitch, heading)).norm() < 1e-15);
    }

    #[test]
    fn log_near_half_a_turn() {
        for axis in 0..3 {
            let v = log(&about(axis, std::f64::consts::PI - 1e-9));
            assert!((v[axis].abs() - std::f64::consts::PI).abs() < 1e-8);
        }
    }

    proptest! {
        #[test]
        fn log_undoes_exp(x in -1.7..1.7f64, y in -1.7..1.7f64, z in -1.7..1.7f64) {
            let v = Vector3::new(x, y, z);
            prop_assert!((log(&exp(&v)) - v).norm() < 1e-12);
            prop_assert!((log(&exp(&(v * 1e-6))) - v * 1e-6).norm() < 1e-19);
        }

        #[test]
        fn angles_return(r in -3.1..3.1f64, p in -1.5..1.5f64, h in -3.1..3.1f64) {
            let (r2, p2, h2) = to_attitude(&from_attitude(r, p, h));
            prop_assert!((r - r2).abs() < 1e-12 && (p - p2).abs() < 1e-12 && (h - h2).abs() < 1e-12);
        }
    }
}
