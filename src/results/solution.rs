//! The solution of one path.

use super::{Matrix3, Matrix6, Quality};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How a path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Below its tolerance.
    Converged,
    /// In a cycle or without progress; the best state is kept.
    Stalled,
    /// The data do not determine every parameter.
    RankDeficient,
    /// Out of iterations or passes.
    OutOfIterations,
    /// Solved, but refused: a limit on a standard deviation, absurd misfit, mirrored axes, target not found.
    Refused,
}

/// Mounting of the multibeam, found by any path. All `None` when refused.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Mounting rotation, sonar frame to body frame (x right, y forward, z up), by rows.
    pub rotation_matrix: Option<Matrix3>,
    /// The same as angles in the sense of a survey file, degrees.
    pub mounting_deg: Option<MountingAngles>,
    /// `log(R R_nominal^T)` in the body frame, degrees.
    pub correction_deg: Option<Angles>,
    /// Lever arm from the INS centre to the multibeam, body frame, metres.
    pub lever_arm_m: Option<[f64; 3]>,
    /// Lever arm minus the nominal one, body frame, metres.
    pub lever_arm_correction_m: Option<[f64; 3]>,
    /// Covariance of pitch, roll, yaw (rad) and lx, ly, lz (m), left perturbation in the body frame; `None` for the sequential path,
    /// which has none.
    pub covariance: Option<Matrix6>,
}

/// Mounting angles, degrees: `R = Rz(-heading) Rx(pitch) Ry(roll)`; roll positive starboard down, pitch positive bow up, heading clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MountingAngles {
    /// About the body's y axis.
    pub roll: f64,
    /// About the body's x axis.
    pub pitch: f64,
    /// About the body's z axis, clockwise seen from above.
    pub heading: f64,
}

/// A small rotation as a vector in the body frame, degrees, right-handed about (x, y, z).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Angles {
    /// About x (right): positive bow up.
    pub pitch: f64,
    /// About y (forward): positive starboard down.
    pub roll: f64,
    /// About z (up): positive counter-clockwise.
    pub yaw: f64,
}

/// One number for each of the six parameters, in the unit that its field states.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SixValues {
    /// About x.
    pub pitch: f64,
    /// About y.
    pub roll: f64,
    /// About z.
    pub yaw: f64,
    /// Along x (right).
    pub lx: f64,
    /// Along y (forward).
    pub ly: f64,
    /// Along z (up).
    pub lz: f64,
}

/// Standard deviations of the six parameters, one sigma.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SixSigmas {
    /// About x, degrees.
    pub pitch_deg: f64,
    /// About y, degrees.
    pub roll_deg: f64,
    /// About z, degrees.
    pub yaw_deg: f64,
    /// Along x, metres.
    pub lx_m: f64,
    /// Along y, metres.
    pub ly_m: f64,
    /// Along z, metres.
    pub lz_m: f64,
}

/// Solution of the reference path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SequentialSolution {
    /// Which variant ran: `literal` or `projected`, with `, repeated` where angles and offsets were repeated in turn.
    pub variant: String,
    /// How it ended; `stalled` counts as usable.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// The mounting.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// Every pass.
    pub iterations: Vec<SequentialIteration>,
}

/// One pass of the reference path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SequentialIteration {
    /// From 0, the mounting as given; pass k is the mounting after k corrections.
    pub pass: u32,
    /// Angle between the scanner's and the multibeam's normal under this mounting, by plane (`P1` to `P4`), degrees.
    pub angle_deg: BTreeMap<String, f64>,
    /// Correction of this mounting, body frame.
    pub correction_deg: Angles,
}

/// Solution of a joint path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointSolution {
    /// How it ended.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// The mounting with its covariance.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// One sigma of each parameter.
    pub standard_deviation: Option<SixSigmas>,
    /// Correlations in the covariance's order.
    pub correlation: Option<Matrix6>,
    /// Further calibration parameters: latency, range scale.
    pub extra: Vec<ExtraParameter>,
    /// Every iteration.
    pub iterations: Vec<JointIteration>,
    /// Quality figures; `None` when nothing was solved.
    pub quality: Option<Quality>,
}

/// A calibration parameter beside the six.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExtraParameter {
    /// `latency_s`, `range_scale`.
    pub name: String,
    /// Estimate; `None` when not observable.
    pub value: Option<f64>,
    /// One sigma; `None` when not observable.
    pub standard_deviation: Option<f64>,
    /// Unit of both, `1` for a ratio.
    pub unit: String,
    /// Whether the data determine it.
    pub observable: bool,
}

/// One step of the joint path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointIteration {
    /// Round of association, from 1.
    pub outer: u32,
    /// Step inside the round, from 1.
    pub inner: u32,
    /// Robust cost (dimensionless, half the weighted sum of squares for the quadratic kernel).
    pub cost: f64,
    /// Largest change of a parameter in its own sigma.
    pub largest_step_in_sigma: f64,
    /// Soundings that changed their face before this step.
    pub reassigned: u64,
}
