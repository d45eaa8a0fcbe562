//! Beams of a transmit and a receive array that stand, and move, each on its own: sent at one moment, heard at another.

use nalgebra::{Matrix3, Vector3};

use super::model::Aim;
use super::scene::{Arrays, Sounding};
use crate::georef::two_arrays::ArrayPair;
use crate::observe::Mounting;

/// Both arrays at some values of the parameters: one correction of the angles and one of the lever arm serves both.
pub(super) struct Pair {
    transmitter: Mounting,
    receiver: Mounting,
}

impl Pair {
    /// The arrays moved as the mounting has moved from its nominal place.
    pub(super) fn new(arrays: &Arrays, nominal: &Mounting, mounting: &Mounting) -> Self {
        let turn = mounting.rotation * nominal.rotation.transpose();
        let shift_m = mounting.lever_arm_m - nominal.lever_arm_m;
        let moved = |array: &Mounting| Mounting {
            rotation: turn * array.rotation,
            lever_arm_m: array.lever_arm_m + shift_m,
        };
        Self {
            transmitter: moved(&arrays.transmitter),
            receiver: moved(&arrays.receiver),
        }
    }

    /// A beam sent and heard at two poses (position, attitude); `None` where no direction has its two angles.
    ///
    /// The sound goes from the transmit array down and up to the receive array; half its time from half way between the two places is
    /// as good as a part in eight of their distance squared over the range.
    pub(super) fn aim(
        &self,
        sounding: &Sounding,
        sent: (Vector3<f64>, Matrix3<f64>),
        heard: (Vector3<f64>, Matrix3<f64>),
    ) -> Option<Aim> {
        let pair = ArrayPair {
            attitude_at_transmission: sent.1,
            attitude_at_reception: heard.1,
            transmitter: self.transmitter.rotation,
            receiver: self.receiver.rotation,
        };
        let cones = pair.partials(sounding.along_rad, sounding.across_rad)?;
        let sender_m = sent.0 + sent.1 * self.transmitter.lever_arm_m;
        let listener_m = heard.0 + heard.1 * self.receiver.lever_arm_m;
        let speed_m_s = f64::from(sounding.head_speed_m_s);
        Some(Aim {
            transducer_m: (sender_m + listener_m) * 0.5,
            direction: cones.direction,
            sideways: cones.angles[1],
            sensor: None,
            head_speed_m_s: (speed_m_s > 0.0).then_some(speed_m_s),
        })
    }
}
