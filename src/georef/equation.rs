//! The georeferencing equation and its derivatives.

use nalgebra::Vector3;

use crate::observe::{Mounting, PoseSample};

/// `X = p + R_b^t (R u + l)` in the frame of `pose`, metres (patent \[0034\]).
#[must_use]
pub fn georeference(pose: &PoseSample, mounting: &Mounting, u_m: &Vector3<f64>) -> Vector3<f64> {
    pose.position_m + pose.rotation * (mounting.rotation * u_m + mounting.lever_arm_m)
}

/// `n . X` and its derivatives: all that a point-to-plane condition needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalPartials {
    /// The georeferenced point, metres.
    pub point_m: Vector3<f64>,
    /// d(n.X)/d(delta): left perturbation of the mounting in the body (pitch, roll, yaw), metres per radian.
    pub rotation: Vector3<f64>,
    /// d(n.X)/d(l), unitless; the normal in the body frame.
    pub lever_arm: Vector3<f64>,
    /// d(n.X)/d(psi): left perturbation of `R_b^t` in the target frame, metres per radian.
    pub attitude: Vector3<f64>,
    /// d(n.X)/d(u), unitless; the normal in the sensor frame.
    pub sensor: Vector3<f64>,
}

/// [`georeference`] along a plane's normal `n` (unit, frame of `pose`), with every derivative.
#[must_use]
pub fn along_normal(
    pose: &PoseSample,
    mounting: &Mounting,
    u_m: &Vector3<f64>,
    normal: &Vector3<f64>,
) -> NormalPartials {
    let turned = mounting.rotation * u_m;
    let arm = pose.rotation * (turned + mounting.lever_arm_m);
    let in_body = pose.rotation.tr_mul(normal);
    NormalPartials {
        point_m: pose.position_m + arm,
        rotation: turned.cross(&in_body),
        lever_arm: in_body,
        attitude: arm.cross(normal),
        sensor: mounting.rotation.tr_mul(&in_body),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation;

    #[test]
    fn derivatives_agree_with_differences() {
        let pose = PoseSample {
            position_m: Vector3::new(3.0, -2.0, 1.0),
            rotation: rotation::from_attitude(0.05, -0.03, 1.1),
            record: 0,
            weight_before: 0.5,
        };
        let mounting = Mounting::from_angles(-0.8, 0.02, 0.1, Vector3::new(0.5, -0.2, -1.6));
        let (u, normal) = (
            Vector3::new(-4.0, 0.3, -2.0),
            Vector3::new(-0.6, 0.64, 0.48),
        );
        let partials = along_normal(&pose, &mounting, &u, &normal);
        let value = |pose: &PoseSample, mounting: &Mounting, u: &Vector3<f64>| {
            normal.dot(&georeference(pose, mounting, u))
        };
        let step = 1e-6;
        for axis in 0..3 {
            let bump = Vector3::ith(axis, step);
            let slope = |f: &dyn Fn(Vector3<f64>) -> f64| (f(bump) - f(-bump)) / (2.0 * step);
            let rotated = slope(&|d| value(&pose, &mounting.corrected(&d, &Vector3::zeros()), &u));
            assert!((rotated - partials.rotation[axis]).abs() < 1e-8);
            let moved = slope(&|d| value(&pose, &mounting.corrected(&Vector3::zeros(), &d), &u));
            assert!((moved - partials.lever_arm[axis]).abs() < 1e-8);
            let turned = slope(&|d| {
                value(
                    &PoseSample {
                        rotation: rotation::exp(&d) * pose.rotation,
                        ..pose
                    },
                    &mounting,
                    &u,
                )
            });
            assert!((turned - partials.attitude[axis]).abs() < 1e-8);
            let shifted = slope(&|d| value(&pose, &mounting, &(u + d)));
            assert!((shifted - partials.sensor[axis]).abs() < 1e-8);
        }
        assert_eq!(partials.point_m, georeference(&pose, &mounting, &u));
    }
}
