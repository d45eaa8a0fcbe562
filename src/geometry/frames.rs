//! Frame-typed points, rotations and poses: `target_from_body * (body_from_sonar * point)` compiles, the wrong order does not.
//!
//! | type | frame | axes |
//! |---|---|---|
//! | [`Ecef`] | e | earth-centred, earth-fixed |
//! | [`Level`] | l | east, north, up at the INS centre |
//! | [`Target`] | t | X away from the boat through the wall, Y along the wall, Z up |
//! | [`Body`] | b | x right, y forward, z up (INS body) |
//! | [`Sonar`], [`Scanner`] | m, s | x right, y forward, z up when the mounting angles are zero |

use std::marker::PhantomData;
use std::ops::Mul;

use nalgebra::{Matrix3, Vector3};

/// Names a coordinate frame at compile time.
pub trait Frame: Copy + Clone + std::fmt::Debug + Send + Sync + 'static {}

macro_rules! frames {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $($(#[$doc])* #[derive(Clone, Copy, Debug, PartialEq, Eq)] pub enum $name {} impl Frame for $name {})*
    };
}
frames! {
    /// Earth-centred, earth-fixed.
    Ecef,
    /// East, north, up at the INS centre.
    Level,
    /// The calibration target's frame.
    Target,
    /// INS body: x right, y forward, z up.
    Body,
    /// The multibeam's own frame.
    Sonar,
    /// The laser scanner's own frame.
    Scanner,
}

/// A point in frame `F`, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<F: Frame> {
    /// Coordinates in `F`, metres.
    pub coordinates: Vector3<f64>,
    frame: PhantomData<F>,
}

impl<F: Frame> Point<F> {
    /// The point with these coordinates (metres) in frame `F`.
    #[must_use]
    pub fn new(coordinates: Vector3<f64>) -> Self {
        Self {
            coordinates,
            frame: PhantomData,
        }
    }
}

/// A rotation that turns coordinates in `From` into coordinates in `To`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<To: Frame, From: Frame> {
    /// The orthonormal matrix.
    pub matrix: Matrix3<f64>,
    frames: PhantomData<(To, From)>,
}

impl<To: Frame, From: Frame> Rotation<To, From> {
    /// Claims that `matrix` (orthonormal) turns `From` into `To`.
    #[must_use]
    pub fn new(matrix: Matrix3<f64>) -> Self {
        Self {
            matrix,
            frames: PhantomData,
        }
    }

    /// The rotation back.
    #[must_use]
    pub fn inverse(&self) -> Rotation<From, To> {
        Rotation::new(self.matrix.transpose())
    }
}

impl<To: Frame, Via: Frame, From: Frame> Mul<Rotation<Via, From>> for Rotation<To, Via> {
    type Output = Rotation<To, From>;
    fn mul(self, right: Rotation<Via, From>) -> Self::Output {
        Rotation::new(self.matrix * right.matrix)
    }
}

/// A rigid transform from `From` into `To`: rotation, then the position of `From`'s origin in `To`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<To: Frame, From: Frame> {
    /// Rotation from `From` into `To`.
    pub rotation: Rotation<To, From>,
    /// Origin of `From` in `To`, metres.
    pub translation: Point<To>,
}

impl<To: Frame, From: Frame> Pose<To, From> {
    /// The pose with this rotation and the origin of `From` at `translation` (metres, in `To`).
    #[must_use]
    pub fn new(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Self {
        Self {
            rotation: Rotation::new(rotation),
            translation: Point::new(translation),
        }
    }

    /// The transform back.
    #[must_use]
    pub fn inverse(&self) -> Pose<From, To> {
        let back = self.rotation.matrix.transpose();
        Pose::new(back, -(back * self.translation.coordinates))
    }
}

impl<To: Frame, From: Frame> Mul<Point<From>> for Pose<To, From> {
    type Output = Point<To>;
    fn mul(self, point: Point<From>) -> Point<To> {
        Point::new(self.rotation.matrix * point.coordinates + self.translation.coordinates)
    }
}

impl<To: Frame, Via: Frame, From: Frame> Mul<Pose<Via, From>> for Pose<To, Via> {
    type Output = Pose<To, From>;
    fn mul(self, right: Pose<Via, From>) -> Self::Output {
        Pose {
            rotation: self.rotation * right.rotation,
            translation: self * right.translation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation;

    #[test]
    fn a_pose_and_its_inverse_cancel() {
        let matrix = rotation::from_attitude(0.1, -0.2, 2.0);
        let pose = Pose::<Target, Body>::new(matrix, Vector3::new(1.0, 2.0, 3.0));
        let point = Point::<Body>::new(Vector3::new(-4.0, 0.5, 9.0));
        let back = pose.inverse() * (pose * point);
        assert!((back.coordinates - point.coordinates).norm() < 1e-14);
        let same = (pose.inverse() * pose).rotation.matrix;
        assert!((same - Matrix3::identity()).norm() < 1e-15);
    }
}
