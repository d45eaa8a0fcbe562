//! The solution of one path.

use super::{Matrix3, Quality};
use serde::{Deserialize, Serialize};

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

/// What one path found, by name. A refused one has neither parameters nor matrices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// How it ended; a reference path that `stalled` counts as usable.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// The parameters sought; those of a mounting stand together as pitch, roll, yaw, lx, ly, lz.
    pub parameters: Vec<Parameter>,
    /// Covariance in the parameters' order: rad, m, s, 1; left perturbation in the body frame. `None` for a path that has none.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Correlations in the same order.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// The same mountings as matrices and angles.
    pub mountings: Vec<MountingResult>,
    /// Every iteration of an adjustment.
    pub convergence: Vec<Iteration>,
    /// Tests, reliability, what the data determine; `None` when nothing was adjusted.
    pub quality: Option<Quality>,
    /// What only this path of this procedure has.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub details: serde_json::Value,
}

impl Solution {
    /// A path without a result.
    #[must_use]
    pub fn without_result(status: Status, message: String) -> Self {
        Self {
            status,
            usable: false,
            message,
            parameters: vec![],
            covariance: None,
            correlation: None,
            mountings: vec![],
            convergence: vec![],
            quality: None,
            details: serde_json::Value::Null,
        }
    }

    /// A parameter by its name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// One parameter of a solution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Such as `roll` or `left head yaw`.
    pub name: String,
    /// Unit of all its numbers: `deg`, `m`, `s`, or `1` for a ratio.
    pub unit: String,
    /// What a positive value means; empty where that says nothing.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub positive: String,
    /// Estimate; `None` when not determined or not estimated by this path. For pitch, roll and yaw the mounting angle of a survey file (yaw
    /// is minus the heading), which does not grow by exactly the correction: rotations do not add.
    pub value: Option<f64>,
    /// The same before the calibration.
    pub nominal: Option<f64>,
    /// What the calibration changes: for pitch, roll and yaw the components of `log(R R_nominal^T)` in the body frame, else value minus
    /// nominal.
    pub correction: Option<f64>,
    /// One sigma of the correction; `None` when held or where the path has none.
    pub sigma: Option<f64>,
    /// Whether the path determined it; a parameter that was held at its nominal value was not.
    pub determined: bool,
    /// What the reader should know, empty without.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// Where a sensor sits: its mounting before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountingResult {
    /// The sensor, such as `multibeam`.
    pub name: String,
    /// Rotation, sensor frame to body frame (x right, y forward, z up), by rows.
    pub rotation_matrix: Matrix3,
    /// The same before the calibration.
    pub nominal_rotation_matrix: Matrix3,
    /// The rotation as angles in the sense of a survey file, degrees.
    pub mounting_deg: MountingAngles,
    /// The same before the calibration.
    pub nominal_mounting_deg: MountingAngles,
    /// One sigma of each mounting angle (not of the correction's components, whose axes differ), degrees.
    pub mounting_sigma_deg: Option<MountingAngles>,
    /// `log(R R_nominal^T)` in the body frame, degrees.
    pub correction_deg: Angles,
    /// Lever arm from the body's origin to the sensor, body frame, metres; `None` where the procedure seeks none.
    pub lever_arm_m: Option<[f64; 3]>,
    /// The same before the calibration.
    pub nominal_lever_arm_m: Option<[f64; 3]>,
    /// Lever arm minus the nominal one.
    pub lever_arm_correction_m: Option<[f64; 3]>,
    /// One sigma of each component; 0 for one that was held.
    pub lever_arm_sigma_m: Option<[f64; 3]>,
    /// Of a sounder whose two arrays stand each on its own: the transmit and the receive array, moved as this mounting has moved. It
    /// stands for both and is neither's record; what a program holds of each is here.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arrays: Vec<MountingResult>,
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

/// One step of an adjustment, or all steps of one round where only the last is kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Iteration {
    /// Round of association, from 1.
    pub outer: u32,
    /// Step inside the round, from 1.
    pub inner: u32,
    /// Robust cost (dimensionless, half the weighted sum of squares for the quadratic kernel).
    pub cost: f64,
    /// Largest change of a parameter in its own sigma.
    pub largest_step_in_sigma: f64,
    /// Observations that changed what they are tied to before this step.
    pub reassigned: u64,
}
