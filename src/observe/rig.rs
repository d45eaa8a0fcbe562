//! The rig: how a sensor is mounted on the INS body.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Body, Pose, frames::Frame, rotation};
use crate::math;

/// Mounting of a sensor: rotation from the sensor frame into the body, and the lever arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// `R_m^b`, sensor into body.
    pub rotation: Matrix3<f64>,
    /// Sensor origin in the body frame (x right, y forward, z up), metres.
    pub lever_arm_m: Vector3<f64>,
}

impl Mounting {
    /// From mounting angles in the sense of `docs/conventions.md` (radians) and the lever arm (metres).
    #[must_use]
    pub fn from_angles(
        roll_rad: f64,
        pitch_rad: f64,
        heading_rad: f64,
        lever_arm_m: Vector3<f64>,
    ) -> Self {
        Self {
            rotation: rotation::from_attitude(roll_rad, pitch_rad, heading_rad),
            lever_arm_m,
        }
    }

    /// Roll, pitch, heading of the mounting, radians.
    #[must_use]
    pub fn angles(&self) -> (f64, f64, f64) {
        rotation::to_attitude(&self.rotation)
    }

    /// As a frame-typed pose of the sensor frame `S` in the body.
    #[must_use]
    pub fn pose<S: Frame>(&self) -> Pose<Body, S> {
        Pose::new(self.rotation, self.lever_arm_m)
    }

    /// The mounting after `Exp(delta) R` (delta = pitch, roll, yaw about x, y, z of the body, radians) and a longer lever arm.
    #[must_use]
    pub fn corrected(&self, delta_rad: &Vector3<f64>, lever_arm_m: &Vector3<f64>) -> Self {
        Self {
            rotation: rotation::exp(delta_rad) * self.rotation,
            lever_arm_m: self.lever_arm_m + lever_arm_m,
        }
    }

    /// The mounting turned in the body.
    #[must_use]
    pub fn turned(&self, turn: &Matrix3<f64>) -> Self {
        Self {
            rotation: turn * self.rotation,
            ..*self
        }
    }

    /// `Log(R R_nominal^T)`: the correction (pitch, roll, yaw; radians) that turned `nominal` into this mounting.
    #[must_use]
    pub fn correction_from(&self, nominal: &Self) -> Vector3<f64> {
        rotation::log(&(self.rotation * nominal.rotation.transpose()))
    }
}

/// Mountings of a transmit and a receive array that stand each on its own. Of their soundings the angle along is the tilt of the
/// transmitted cone, the angle across that against the receive array, the time that of transmission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrayMountings {
    /// The transmit array.
    pub transmitter: Mounting,
    /// The receive array.
    pub receiver: Mounting,
}

impl ArrayMountings {
    /// One mounting for both: roll of the receive array, the rest of the transmit array; the receive array's where one of the two is
    /// built in the other way round.
    #[must_use]
    pub fn together(&self) -> Mounting {
        let (transmitter, receiver) = (&self.transmitter, &self.receiver);
        let ((_, pitch, heading), (roll, _, other)) = (transmitter.angles(), receiver.angles());
        if math::cos(heading - other) < 0.0 {
            return Mounting {
                rotation: receiver.rotation,
                ..*transmitter
            };
        }
        Mounting::from_angles(roll, pitch, heading, transmitter.lever_arm_m)
    }

    /// Both arrays moved as a mounting has moved from its nominal place: one correction of the angles and one of the lever arm serves
    /// both.
    #[must_use]
    pub fn moved(&self, nominal: &Mounting, mounting: &Mounting) -> Self {
        let turn = mounting.rotation * nominal.rotation.transpose();
        let shift_m = mounting.lever_arm_m - nominal.lever_arm_m;
        let moved = |array: &Mounting| Mounting {
            rotation: turn * array.rotation,
            lever_arm_m: array.lever_arm_m + shift_m,
        };
        Self {
            transmitter: moved(&self.transmitter),
            receiver: moved(&self.receiver),
        }
    }
}

/// Standard deviations of a mounting: three angles (pitch, roll, yaw about x, y, z of the body; radians), three offsets (metres).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountingSigma {
    /// Standard deviations about the body axes x, y, z, radians.
    pub rotation_rad: Vector3<f64>,
    /// Standard deviations of the lever arm, metres.
    pub lever_arm_m: Vector3<f64>,
}
