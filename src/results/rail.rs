//! The result of a rail calibration: the whole of `result.json`, and the samples that its report is drawn from.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::{
    Angles, JointIteration, MountingAngles, Parameter, ParameterComparison, Provenance, Quality,
    Status, Verdict,
};

/// Version of the layout of a rail calibration's `result.json`.
pub const RAIL_SCHEMA: u32 = 1;

/// A rail calibration by both paths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailResult {
    /// Layout version, [`RAIL_SCHEMA`].
    pub schema: u32,
    /// Always `rail`.
    pub procedure: String,
    /// Program, seed, inputs and configuration.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Whether the deciding solution may be used: the joint one where it ran, else the reference one. `false` goes with exit code 1.
    pub usable: bool,
    /// Why the result is not usable; `None` when it is.
    pub reason: Option<String>,
    /// Whether the result may be used, with everything that speaks against it.
    #[serde(default)]
    pub verdict: Verdict,
    /// Name of the standard profile.
    pub rail: String,
    /// Positions of the table.
    pub positions: u64,
    /// Range of the table's turns about the vertical and about the lateral axis, degrees.
    pub turned_deg: [f64; 2],
    /// Points of each profiler.
    pub counts: Vec<ProfilerCounts>,
    /// One entry per path that ran.
    pub solutions: RailSolutions,
    /// The reference path against the joint one; `None` unless both are usable.
    pub comparison: Option<ParameterComparison>,
    /// RMS distance of the points used from the standard profile, metres: `nominal` and `reference` with table, rail and INS as known
    /// before, `joint` with those that it estimated.
    pub residual_rms_m: BTreeMap<String, f64>,
    /// Sentences that the reader should know.
    pub notes: Vec<String>,
}

/// Points of one profiler; `read` is `used` and all of `rejected`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfilerCounts {
    /// Its name.
    pub profiler: String,
    /// Read from the file.
    pub read: u64,
    /// Entered the final adjustment.
    pub used: u64,
    /// Left out, by reason.
    pub rejected: BTreeMap<String, u64>,
}

/// The solutions of the paths that ran.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RailSolutions {
    /// The patent's path (CN114162169A).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<RailReferenceSolution>,
    /// One adjustment of everything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<RailJointSolution>,
}

/// Mounting of one profiler.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailMounting {
    /// Its name.
    pub profiler: String,
    /// Rotation, profiler frame into body (x right, y forward, z up), by rows.
    pub rotation_matrix: [[f64; 3]; 3],
    /// The same as angles in the sense of a survey file, degrees.
    pub mounting_deg: MountingAngles,
    /// `log(R R_nominal^T)` in the body frame, degrees.
    pub correction_deg: Angles,
    /// Lever arm in the body, metres.
    pub lever_arm_m: [f64; 3],
    /// Lever arm minus the nominal one, metres.
    pub lever_arm_correction_m: [f64; 3],
}

/// Solution of the reference path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailReferenceSolution {
    /// How it ended.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// Mountings; empty when refused.
    pub mountings: Vec<RailMounting>,
    /// Corrections, named and with units; no standard deviations, since the path has none.
    pub parameters: Vec<Parameter>,
    /// How each profiler's angles came about.
    pub steps: Vec<RailReferenceSteps>,
}

/// How the reference path found one profiler's angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailReferenceSteps {
    /// Its name.
    pub profiler: String,
    /// Turn of the level profile about the rail's axis after the coarse fit, degrees.
    pub coarse_roll_deg: f64,
    /// The same after the fine fit.
    pub fine_roll_deg: f64,
    /// Hausdorff distance of the 1:20 points over the turns about the vertical.
    pub heading_sweep: Vec<HausdorffStep>,
    /// Hausdorff distance of the R20 points over the turns about the lateral axis.
    pub pitch_sweep: Vec<HausdorffStep>,
    /// RMS distance of the level profile from the standard profile after the fine fit, metres.
    pub fine_rms_m: f64,
    /// The same after compensating the coordinates (claim 10) and fitting again.
    pub compensated_rms_m: f64,
}

/// Hausdorff distance at one position of the table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HausdorffStep {
    /// Heading or pitch of the INS against the rail, degrees.
    pub turn_deg: f64,
    /// Distance, metres.
    pub distance_m: f64,
}

/// Solution of the joint path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RailJointSolution {
    /// How it ended.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// Mountings; empty when refused.
    pub mountings: Vec<RailMounting>,
    /// Corrections of pitch, roll, yaw, lx, lz of each profiler, with standard deviations.
    pub parameters: Vec<Parameter>,
    /// Covariance in the parameters' order (rad, m), left perturbation in the body; empty when refused.
    pub covariance: Vec<Vec<f64>>,
    /// Everything that was estimated along: lever arms along the rail, table, seat, rail, pivot.
    pub nuisance: Vec<Parameter>,
    /// Every iteration.
    pub iterations: Vec<JointIteration>,
    /// Quality figures; `None` when nothing was solved.
    pub quality: Option<Quality>,
}

/// What the report's pictures are drawn from. Stays in memory; `result.json` does not hold it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RailSamples {
    /// Name of the survey.
    pub title: String,
    /// The standard profile as polylines, one per element, millimetres.
    pub outline_mm: Vec<Outline>,
    /// Some of the points at the position nearest to level, under each mounting.
    pub profiles: Vec<ProfileSample>,
    /// Residuals of some of the points over all positions.
    pub residuals: Vec<ResidualSample>,
    /// How far both paths are off the truth, where the survey was simulated.
    pub truth: Option<RailAgainstTruth>,
}

/// True corrections and errors against them, in the parameters' order and units.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RailAgainstTruth {
    /// True corrections to the nominal mountings.
    pub corrections: Vec<f64>,
    /// Errors of the reference path, rotation as `log(R R_true^T)`; empty where it has no result.
    pub reference_errors: Vec<f64>,
    /// The same of the joint path.
    pub joint_errors: Vec<f64>,
}

/// One element of the standard profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// Its name.
    pub name: String,
    /// `line`, `arc` for the reference path's regions, else empty.
    pub region: String,
    /// (x, z), millimetres.
    pub points: Vec<[f64; 2]>,
}

/// Points of one profiler in the cross-section.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProfileSample {
    /// Index of the profiler.
    pub profiler: u32,
    /// `nominal`, `reference` or `joint`.
    pub path: String,
    /// (x, z, distance from the profile), millimetres.
    pub points: Vec<[f64; 3]>,
}

/// A residual with its place on the profile and its position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualSample {
    /// Index of the profiler.
    pub profiler: u32,
    /// Element of the rail.
    pub element: u32,
    /// Position of the table.
    pub position: u32,
    /// Distance from the profile under the joint solution, millimetres.
    pub joint_mm: f64,
}
