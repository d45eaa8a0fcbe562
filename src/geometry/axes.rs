//! The axes in which sources state body vectors, lever arms and rotations, brought to ours: x right, y forward, z up.
//!
//! | source | body axes | level axes | heading, pitch, roll positive |
//! |---|---|---|---|
//! | ours, `NovAtel` SPAN vehicle frame | right, forward, up | east, north, up | clockwise, bow up, starboard down |
//! | Applanix, Kongsberg | forward, right, down | north, east, down | clockwise, bow up, starboard down |
//! | ROS REP 103 | forward, left, up | north, west, up | counter-clockwise, bow down, starboard down |
//!
//! Attitude from a forward-right-down source, `Rz(heading) Ry(pitch) Rx(roll)` between north-east-down and forward-right-down,
//! has the same three numbers as ours: only vectors and matrices need converting. Rows two and three of the table are tested below.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Right-handed body axes of a source, with the level axes that go with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// x right, y forward, z up; level east, north, up.
    #[default]
    RightForwardUp,
    /// x forward, y right (starboard), z down; level north, east, down.
    ForwardRightDown,
    /// x forward, y left (port), z up; level north, west, up.
    ForwardLeftUp,
}

impl Axes {
    /// The matrix that turns coordinates in these axes into right-forward-up (level: into east-north-up).
    #[must_use]
    pub fn to_right_forward_up(self) -> Matrix3<f64> {
        match self {
            Self::RightForwardUp => Matrix3::identity(),
            Self::ForwardRightDown => Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0),
            Self::ForwardLeftUp => Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        }
    }

    /// A vector or lever arm (any unit) in these axes, in ours.
    #[must_use]
    pub fn vector(self, v: &Vector3<f64>) -> Vector3<f64> {
        self.to_right_forward_up() * v
    }

    /// A vector of ours, in these axes.
    #[must_use]
    pub fn vector_back(self, v: &Vector3<f64>) -> Vector3<f64> {
        self.to_right_forward_up().tr_mul(v)
    }

    /// A rotation between two frames that both have these axes (body into level, sensor into body), between ours.
    #[must_use]
    pub fn rotation(self, r: &Matrix3<f64>) -> Matrix3<f64> {
        let turn = self.to_right_forward_up();
        turn * r * turn.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation::{exp, from_attitude};
    use proptest::prelude::*;

    fn about(axis: usize, angle_rad: f64) -> Matrix3<f64> {
        exp(&Vector3::ith(axis, angle_rad))
    }

    /// The usual `Rz(yaw) Ry(pitch) Rx(roll)`.
    fn z_y_x(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
        about(2, yaw) * about(1, pitch) * about(0, roll)
    }

    #[test]
    fn unit_vectors_go_where_their_names_say() {
        let (right, forward, up) = (Vector3::x(), Vector3::y(), Vector3::z());
        let frd = Axes::ForwardRightDown;
        assert_eq!(frd.vector(&Vector3::x()), forward);
        assert_eq!(frd.vector(&Vector3::y()), right);
        assert_eq!(frd.vector(&Vector3::z()), -up);
        let flu = Axes::ForwardLeftUp;
        assert_eq!(flu.vector(&Vector3::x()), forward);
        assert_eq!(flu.vector(&Vector3::y()), -right);
        assert_eq!(flu.vector(&Vector3::z()), up);
        for axes in [Axes::RightForwardUp, frd, flu] {
            assert_eq!(axes.to_right_forward_up().determinant(), 1.0);
        }
    }

    proptest! {
        /// NED/FRD = ENU/RFU: attitude with the same three numbers, a sensor vector, its mounting and lever arm through both.
        #[test]
        fn north_east_down_is_east_north_up(
            (r, p, h) in (-0.5..0.5f64, -0.5..0.5f64, -3.1..3.1f64),
            (mr, mp, mh) in (-3.0..3.0f64, -1.5..1.5f64, -3.1..3.1f64),
            arm in proptest::array::uniform3(-5.0..5.0f64),
            u in proptest::array::uniform3(-50.0..50.0f64),
        ) {
            let (arm, u) = (Vector3::from(arm), Vector3::from(u));
            let ned = z_y_x(r, p, h) * (z_y_x(mr, mp, mh) * u + arm);
            let axes = Axes::ForwardRightDown;
            let enu = from_attitude(r, p, h) * (from_attitude(mr, mp, mh) * axes.vector(&u) + axes.vector(&arm));
            prop_assert!((axes.vector(&ned) - enu).norm() < 1e-13 * 60.0);
            prop_assert!((axes.rotation(&z_y_x(r, p, h)) - from_attitude(r, p, h)).norm() < 1e-14);
            prop_assert!((axes.vector_back(&enu) - ned).norm() < 1e-13 * 60.0);
        }

        /// Forward-left-up: yaw is counter-clockwise and pitch bow down, so both change sign.
        #[test]
        fn forward_left_up_changes_two_signs((r, p, h) in (-0.5..0.5f64, -0.5..0.5f64, -3.1..3.1f64)) {
            let turned = Axes::ForwardLeftUp.rotation(&z_y_x(r, p, h));
            prop_assert!((turned - from_attitude(r, -p, -h)).norm() < 1e-14);
        }
    }
}
