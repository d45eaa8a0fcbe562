//! Beams of a transmit and a receive array that stand, and move, each on its own: sent at one moment, heard at another.

use nalgebra::{Matrix3, Vector3};

use super::model::Aim;
use super::scene::Sounding;
use crate::georef::two_arrays::ArrayAim;
use crate::observe::ArrayMountings;

/// A beam sent and heard at two poses (position, attitude) by arrays that stand as they do at some values of the parameters; `None` where
/// no direction has its two angles.
pub(super) fn aim(
    arrays: &ArrayMountings,
    sounding: &Sounding,
    sent: (Vector3<f64>, Matrix3<f64>),
    heard: (Vector3<f64>, Matrix3<f64>),
) -> Option<Aim> {
    let speed_m_s = f64::from(sounding.head_speed_m_s);
    let angles = (sounding.along_rad, sounding.across_rad);
    let way = (sounding.one_way_s, speed_m_s);
    let aim = ArrayAim::new(arrays, angles, way, [sent, heard])?;
    let cones = aim.pair.partials_at(aim.direction, angles.0, angles.1)?;
    Some(Aim {
        transducer_m: aim.transducer_m,
        direction: cones.direction,
        sideways: cones.angles[1],
        forwards: cones.angles[0],
        sensor: None,
        head_speed_m_s: (speed_m_s > 0.0).then_some(speed_m_s),
    })
}
