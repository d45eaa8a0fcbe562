//! Step 3: angles between the planes' normals, and the correction they give.

use nalgebra::{Matrix3, Vector3};

use super::super::config::Variant;
use super::{RoleSoundings, ScannerPlanes, SequentialError};
use crate::geometry::rotation;
use crate::math;

/// The normals of P1 to P4 as one sensor sees them: unit, target frame, P1 to P3 towards the boat, P4 upward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normals {
    /// n1 to n4.
    pub n: [Vector3<f64>; 4],
}

impl Normals {
    /// P4 stands at right angles to P1 and P2 (\[0020\]); its normal is along n1 x n2, turned upward.
    #[must_use]
    pub fn new(n1: Vector3<f64>, n2: Vector3<f64>, n3: Vector3<f64>) -> Self {
        let n4 = n1.cross(&n2).normalize();
        let up = if n4.z < 0.0 { -n4 } else { n4 };
        Self {
            n: [n1, n2, n3, up],
        }
    }

    /// The scanner's normals.
    #[must_use]
    pub fn of_scanner(scanner: &ScannerPlanes) -> Self {
        Self::new(
            scanner.p1.plane.normal,
            scanner.p2.plane.normal,
            scanner.p3.plane.normal,
        )
    }

    /// The multibeam's normals, on the same sides as the scanner's.
    ///
    /// # Errors
    /// [`SequentialError`] naming the plane without enough soundings.
    pub fn of_soundings(
        soundings: &RoleSoundings,
        scanner: &ScannerPlanes,
    ) -> Result<Self, SequentialError> {
        let p1 = soundings.p1.plane("P1", &scanner.p1.plane.normal)?;
        let p2 = soundings.p2.plane("P2", &scanner.p2.plane.normal)?;
        let p3 = soundings.p3.plane("P3", &scanner.p3.plane.normal)?;
        Ok(Self::new(p1.plane.normal, p2.plane.normal, p3.plane.normal))
    }

    /// Angles between the normals of both sensors, P1 to P4, radians (\[0092\]).
    #[must_use]
    pub fn angles_rad(&self, truth: &Self) -> [f64; 4] {
        [0, 1, 2, 3].map(|k| angle_vector_rad(&self.n[k], &truth.n[k]).norm())
    }

    /// What turns this sensor's normals into the true ones: (pitch about X, roll about Y, yaw about Z), target frame, radians.
    ///
    /// Roll comes from P2, yaw from P3, pitch from P4 (\[0020\], \[0109\]). The sign is that of the component of `nM x nL`
    /// about the axis; the size is the full angle (literal) or that component (projected).
    #[must_use]
    pub fn correction_rad(&self, truth: &Self, variant: Variant) -> Vector3<f64> {
        let about = |plane: usize, axis: usize| {
            let turn = angle_vector_rad(&self.n[plane], &truth.n[plane]);
            match variant {
                Variant::Literal if turn[axis] == 0.0 => 0.0,
                Variant::Literal => turn.norm().copysign(turn[axis]),
                Variant::Projected => turn[axis],
            }
        };
        let (pitch, roll, yaw) = (about(3, 0), about(1, 1), about(2, 2));
        Vector3::new(pitch, roll, yaw)
    }
}

/// The shortest turn from one unit normal to another as a rotation vector (radians): along `from x to`.
#[must_use]
pub fn angle_vector_rad(from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let cross = from.cross(to);
    let sine = cross.norm();
    if sine < 1e-12 {
        return cross;
    }
    cross * (math::atan2(sine, from.dot(to)) / sine)
}

/// `I + Omega` (\[0032\]) of a small turn (pitch, roll, yaw about x, y, z of the body; radians), orthonormal again.
#[must_use]
pub fn body_correction(turn_rad: &Vector3<f64>) -> Matrix3<f64> {
    rotation::orthonormalised(&(Matrix3::identity() + rotation::skew(turn_rad)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target() -> Normals {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Normals::new(
            Vector3::new(-half, half, 0.0),
            -Vector3::x(),
            Vector3::new(-half, -half, 0.0),
        )
    }

    fn turned(normals: &Normals, by: &Vector3<f64>) -> Normals {
        let n = normals.n.map(|n| rotation::exp(by) * n);
        Normals::new(n[0], n[1], n[2])
    }

    #[test]
    fn p4_points_upward() {
        assert!((target().n[3] - Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn omega_is_printed_in_the_patent() {
        let (pitch, roll, yaw) = (1e-3, 2e-3, 3e-3);
        let omega = rotation::skew(&Vector3::new(pitch, roll, yaw));
        let printed = Matrix3::new(0.0, -yaw, roll, yaw, 0.0, -pitch, -roll, pitch, 0.0);
        assert_eq!(omega, printed);
        let corrected = body_correction(&Vector3::new(pitch, roll, yaw));
        assert!((corrected - Matrix3::identity() - printed).norm() < 2e-5);
        assert!((corrected.tr_mul(&corrected) - Matrix3::identity()).norm() < 1e-14);
    }

    #[test]
    fn projected_gives_each_angle_by_itself_and_literal_mixes() {
        let wrong = Vector3::new(2e-4, -3e-4, 4e-4);
        let seen = turned(&target(), &-wrong);
        let projected = seen.correction_rad(&target(), Variant::Projected);
        assert!((projected - wrong).norm() < 3e-7, "{projected}");
        let literal = seen.correction_rad(&target(), Variant::Literal);
        let expected = Vector3::new(
            math::hypot(wrong.x, wrong.y),
            -math::hypot(wrong.y, wrong.z),
            // the turn of n3 about itself does not show
            (wrong.z.powi(2) + 0.5 * (wrong.x - wrong.y).powi(2)).sqrt(),
        );
        assert!((literal - expected).norm() < 3e-7, "{literal} {expected}");
    }

    #[test]
    fn pure_yaw_tilts_the_literal_roll_too() {
        let seen = turned(&target(), &Vector3::new(0.0, 1e-6, -0.01));
        let literal = seen.correction_rad(&target(), Variant::Literal);
        assert!((literal.y.abs() - 0.01).abs() < 1e-6);
        assert!(seen.correction_rad(&target(), Variant::Projected).y.abs() < 2e-5);
    }
}
