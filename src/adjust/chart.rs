//! Charts: how a small tangent step moves a parameter, and how two values differ.
//!
//! Rotations are perturbed on the left, `R' = Exp(d) R` (Solà, Deray, Atchuthan, "A micro Lie theory", 2018, eq. 25-27); unit normals
//! by a step in their tangent plane and renormalisation.

use crate::math;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Rotation3, UnitQuaternion, Vector2, Vector3};

/// The space that a block of parameters lives in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chart {
    /// Plain numbers; the value and the tangent have the same size.
    Euclidean(usize),
    /// A 3x3 rotation matrix, stored by columns; tangent: rotation vector (rad), applied from the left.
    Rotation,
    /// A unit vector; tangent: two components along [`tangent_basis`].
    UnitNormal,
}

impl Chart {
    /// Number of stored values.
    pub fn value_size(self) -> usize {
        match self {
            Chart::Euclidean(n) => n,
            Chart::Rotation => 9,
            Chart::UnitNormal => 3,
        }
    }

    /// Number of tangent columns.
    pub fn tangent_size(self) -> usize {
        match self {
            Chart::Euclidean(n) => n,
            Chart::Rotation => 3,
            Chart::UnitNormal => 2,
        }
    }

    /// Moves `value` by the tangent `step`. The result stays on the manifold to rounding.
    pub fn retract(self, value: &mut [f64], step: &[f64]) {
        match self {
            Chart::Euclidean(_) => value.iter_mut().zip(step).for_each(|(v, d)| *v += d),
            Chart::Rotation => value.copy_from_slice(turn(value, step).as_slice()),
            Chart::UnitNormal => value.copy_from_slice(tilt(value, step).as_slice()),
        }
    }

    /// Tangent difference of `value` from `reference`: the residual of a prior at `reference`, zero where the two agree.
    ///
    /// Rotation: `log(R R_ref^T)`. Unit normal: `T_ref^T (n - n_ref)`.
    pub fn difference(self, value: &[f64], reference: &[f64]) -> Vec<f64> {
        match self {
            Chart::Euclidean(_) => value.iter().zip(reference).map(|(v, r)| v - r).collect(),
            Chart::Rotation => rotation_difference(value, reference).as_slice().to_vec(),
            Chart::UnitNormal => normal_difference(value, reference).as_slice().to_vec(),
        }
    }

    /// Derivative of [`Chart::difference`] by a tangent step at `value`, by rows.
    pub fn difference_jacobian(self, value: &[f64], reference: &[f64]) -> Vec<f64> {
        match self {
            Chart::Euclidean(n) => (0..n * n)
                .map(|i| f64::from(u8::from(i / n == i % n)))
                .collect(),
            Chart::Rotation => by_rows(left_jacobian_inverse(&rotation_difference(
                value, reference,
            ))),
            Chart::UnitNormal => normal_jacobian(value, reference)
                .transpose()
                .as_slice()
                .to_vec(),
        }
    }
}

/// Two unit vectors spanning the plane at right angles to the unit vector `normal`, chosen from the axis least along it.
///
/// The choice jumps between neighbouring normals, which is harmless: a step is applied in the basis it was computed in.
pub fn tangent_basis(normal: &Vector3<f64>) -> Matrix3x2<f64> {
    let first = Vector3::ith_axis(normal.iamin()).cross(normal).normalize();
    Matrix3x2::from_columns(&[first, normal.cross(&first)])
}

fn turn(value: &[f64], step: &[f64]) -> Matrix3<f64> {
    let turned = Rotation3::new(Vector3::from_column_slice(step)) * rotation(value);
    reorthonormalised(turned.matrix())
}

/// One Newton step towards the nearest rotation, `R (3 I - R^T R) / 2`: exact to the square of the rounding it removes.
fn reorthonormalised(r: &Matrix3<f64>) -> Matrix3<f64> {
    r * (Matrix3::identity() * 3.0 - r.transpose() * r) * 0.5
}

fn tilt(value: &[f64], step: &[f64]) -> Vector3<f64> {
    let normal = Vector3::from_column_slice(value);
    (normal + tangent_basis(&normal) * Vector2::from_column_slice(step)).normalize()
}

fn rotation(value: &[f64]) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_column_slice(value))
}

/// Through the quaternion: the trace alone loses half the digits of a small angle.
fn rotation_difference(value: &[f64], reference: &[f64]) -> Vector3<f64> {
    UnitQuaternion::from_rotation_matrix(&(rotation(value) * rotation(reference).inverse()))
        .scaled_axis()
}

fn normal_difference(value: &[f64], reference: &[f64]) -> Vector2<f64> {
    let reference = Vector3::from_column_slice(reference);
    tangent_basis(&reference).transpose() * (Vector3::from_column_slice(value) - reference)
}

fn normal_jacobian(value: &[f64], reference: &[f64]) -> Matrix2<f64> {
    let reference = tangent_basis(&Vector3::from_column_slice(reference));
    reference.transpose() * tangent_basis(&Vector3::from_column_slice(value))
}

fn by_rows(m: Matrix3<f64>) -> Vec<f64> {
    m.transpose().as_slice().to_vec()
}

/// Inverse left Jacobian of SO(3) (Solà et al. 2018, eq. 146), by its series below 1e-4 rad.
fn left_jacobian_inverse(phi: &Vector3<f64>) -> Matrix3<f64> {
    let angle = phi.norm();
    let second = if angle < 1e-4 {
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        1.0 / (angle * angle) - (1.0 + math::cos(angle)) / (2.0 * angle * math::sin(angle))
    };
    let cross = phi.cross_matrix();
    Matrix3::identity() - cross * 0.5 + cross * cross * second
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn samples() -> Vec<(Chart, Vec<f64>)> {
        let rotation = Rotation3::new(Vector3::new(0.3, -0.5, 1.1));
        let normal = Vector3::new(0.2, -0.7, 0.4).normalize();
        vec![
            (Chart::Euclidean(2), vec![3.0, -4.0]),
            (Chart::Rotation, rotation.matrix().as_slice().to_vec()),
            (Chart::UnitNormal, normal.as_slice().to_vec()),
            (Chart::UnitNormal, vec![0.0, 0.0, 1.0]),
        ]
    }

    fn moved(chart: Chart, value: &[f64], step: &[f64]) -> Vec<f64> {
        let mut out = value.to_vec();
        chart.retract(&mut out, step);
        out
    }

    /// Every chart: no step no change, a small step comes back as the difference, and sizes agree.
    #[test]
    fn conformance() {
        for (chart, value) in samples() {
            let n = chart.tangent_size();
            assert_eq!(value.len(), chart.value_size());
            assert_abs_diff_eq!(
                moved(chart, &value, &vec![0.0; n])[..],
                value[..],
                epsilon = 1e-15
            );
            let step: Vec<f64> = (0..n).map(|i| 1e-5 * (i as f64 + 1.0)).collect();
            let back = chart.difference(&moved(chart, &value, &step), &value);
            assert_abs_diff_eq!(back[..], step[..], epsilon = 1e-14);
        }
    }

    /// Every chart: the Jacobian of the difference agrees with central differences away from the reference.
    #[test]
    fn difference_jacobian_by_differences() {
        for (chart, reference) in samples() {
            let n = chart.tangent_size();
            let value = moved(chart, &reference, &vec![0.2; n]);
            let jacobian = chart.difference_jacobian(&value, &reference);
            for column in 0..n {
                let mut step = vec![0.0; n];
                step[column] = 1e-6;
                let plus = chart.difference(&moved(chart, &value, &step), &reference);
                step[column] = -1e-6;
                let minus = chart.difference(&moved(chart, &value, &step), &reference);
                for row in 0..n {
                    assert_abs_diff_eq!(
                        jacobian[row * n + column],
                        (plus[row] - minus[row]) / 2e-6,
                        epsilon = 1e-9
                    );
                }
            }
        }
    }

    proptest! {
        #[test]
        fn rotations_stay_rotations(a in -3.0..3.0f64, b in -3.0..3.0f64, c in -3.0..3.0f64) {
            let mut value = Rotation3::new(Vector3::new(a, b, c)).matrix().as_slice().to_vec();
            for _ in 0..50 {
                Chart::Rotation.retract(&mut value, &[c, a, b]);
            }
            let m = Matrix3::from_column_slice(&value);
            prop_assert!((m.transpose() * m - Matrix3::identity()).norm() < 1e-14);
        }

        #[test]
        fn normals_stay_unit(a in -1.0..1.0f64, b in -1.0..1.0f64) {
            let mut value = vec![0.6, 0.0, 0.8];
            Chart::UnitNormal.retract(&mut value, &[a, b]);
            prop_assert!((Vector3::from_column_slice(&value).norm() - 1.0).abs() < 1e-15);
        }
    }
}
