//! Beams of a transmit and a receive array that stand, and move, each on its own: sent at one moment, heard at another.

use nalgebra::{Matrix3, Vector3};

use super::model::Aim;
use super::scene::{Arrays, Sounding};
use crate::georef::two_arrays::ArrayPair;
use crate::observe::Mounting;

/// Sound speed that serves where only a share of the arrays' distance hangs on it, metres per second.
const ORDINARY_M_S: f64 = 1500.0;

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
        let sender_m = sent.0 + sent.1 * self.transmitter.lever_arm_m;
        let listener_m = heard.0 + heard.1 * self.receiver.lever_arm_m;
        let speed_m_s = f64::from(sounding.head_speed_m_s);
        let range_m = sounding.one_way_s
            * if speed_m_s > 0.0 {
                speed_m_s
            } else {
                ORDINARY_M_S
            };
        let angles = (sounding.along_rad, sounding.across_rad);
        let direction = pair.from_between(angles, &(listener_m - sender_m), range_m)?;
        let cones = pair.partials_at(direction, angles.0, angles.1)?;
        Some(Aim {
            transducer_m: (sender_m + listener_m) * 0.5,
            direction: cones.direction,
            sideways: cones.angles[1],
            sensor: None,
            head_speed_m_s: (speed_m_s > 0.0).then_some(speed_m_s),
        })
    }
}
