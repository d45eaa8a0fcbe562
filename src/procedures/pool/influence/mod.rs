//! What an error of one observation does to the six parameters, by both paths: the first derivatives of the calibration.
//!
//! To first order both paths are linear in the errors of the points along the normals of their faces. The joint path's
//! derivatives are the columns that its adjustment applies ([`crate::adjust::influence`]). The reference path is differentiated
//! in two steps: the real code by central differences with respect to the few numbers it takes from the points (tilt and shift of
//! every plane, means, mean attitudes), times the closed-form derivatives of these by each point: a least-squares plane turns by
//! `sum(s_i eps) / sum(s_i^2)` about its axes and shifts by `sum(eps) / N`, `s` counted from the centroid along the principal axes.
//! The frame in which angles and offsets are taken is one of these numbers: the laser points that register the target move it.

mod moved;
mod reference;
mod rigorous;

pub use reference::{SequentialInfluence, sequential};
pub use rigorous::{JointInfluence, cofactor, joint, observations};

use nalgebra::{Matrix6x3, Vector6};

use crate::observe::Mounting;

/// One observation's pull on pitch, roll, yaw (radians) and lx, ly, lz (metres), per metre along the normal of its face's group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Row of the raw observation.
    pub row: u32,
    /// Face that it is tied to.
    pub face: u16,
    /// The pull.
    pub six: Vector6<f64>,
}

/// Pulls of all observations that one path uses, in order of their rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Pulls {
    /// Of the soundings.
    pub soundings: Vec<Pull>,
    /// Of the laser returns.
    pub returns: Vec<Pull>,
    /// Per face: pull of one sounding's attitude error (target frame, radians) beside what its point does; the reference path
    /// carries its corrections into the body with the mean attitude.
    pub turns: Vec<Matrix6x3<f64>>,
}

/// Pitch, roll, yaw (rad), lx, ly, lz (m) by which one mounting differs from another.
#[must_use]
pub fn difference(found: &Mounting, from: &Mounting) -> Vector6<f64> {
    let (turn, arm) = (
        found.correction_from(from),
        found.lever_arm_m - from.lever_arm_m,
    );
    Vector6::new(turn.x, turn.y, turn.z, arm.x, arm.y, arm.z)
}
