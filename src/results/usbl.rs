//! `result.json` of a USBL calibration.

use serde::{Deserialize, Serialize};

use super::{
    Angles, Matrix3, MountingAngles, Parameter, ParameterComparison, Provenance, Quality,
    SensorCounts, Status, Verdict,
};

/// The whole result. Level coordinates are east, north, up of the surveyed transducer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblResult {
    /// Version of this layout.
    pub schema: u32,
    /// `usbl`.
    pub procedure: String,
    /// Program, seed, inputs, configuration.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Whether there is a usable result.
    pub usable: bool,
    /// Why not, where there is none.
    pub reason: Option<String>,
    /// Whether the result may be used, with everything that speaks against it.
    #[serde(default)]
    pub verdict: Verdict,
    /// What became of the fixes.
    pub fixes: SensorCounts,
    /// The surveyed beacons.
    pub beacons: Vec<UsblBeacon>,
    /// Standard deviations of the surveyed transducer, east, north, up, metres.
    pub transducer_standard_deviation_m: [f64; 3],
    /// Nominal mounting, degrees.
    pub nominal_mounting_deg: MountingAngles,
    /// Both paths.
    pub solutions: UsblSolutions,
    /// Reference minus joint: pitch, roll, yaw.
    pub comparison: Option<ParameterComparison>,
    /// The patent's verification: predicted minus surveyed beacons.
    pub verification: Vec<UsblVerification>,
    /// What the reader should know.
    pub notes: Vec<String>,
}

/// A beacon as surveyed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblBeacon {
    /// Its name.
    pub name: String,
    /// `common` or `check`.
    pub role: String,
    /// East, north, up of the surveyed transducer, metres.
    pub position_m: [f64; 3],
    /// Standard deviations of the same, metres.
    pub standard_deviation_m: [f64; 3],
    /// Its fixes.
    pub fixes: u64,
}

/// Both paths; those that were not asked for are `None`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblSolutions {
    /// The patent's.
    pub reference: Option<UsblReference>,
    /// One adjustment of everything.
    pub joint: Option<UsblJoint>,
}

/// The patent's angles, degrees: `Rz(-H) Ry(-R) Rx(-P)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblPrintedAngles {
    /// As a heading.
    pub h: f64,
    /// Positive bow down.
    pub p: f64,
    /// Positive starboard up.
    pub r: f64,
}

/// The reference path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblReference {
    /// How it ended.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// The mounting rotation `R_u^b`, transducer into attitude sensor, by rows.
    pub rotation_matrix: Option<Matrix3>,
    /// The same as angles of a survey file, degrees.
    pub mounting_deg: Option<MountingAngles>,
    /// `log(R R_nominal^T)` in the body, degrees.
    pub correction_deg: Option<Angles>,
    /// Formal covariance of pitch, roll, yaw (rad^2) from the residuals of the means; it knows nothing of errors that the fixes of
    /// all beacons share.
    pub formal_covariance: Option<Matrix3>,
    /// The adjusted attitude of the transducer in the patent's angles.
    pub adjusted_printed_deg: Option<UsblPrintedAngles>,
    /// The attitude sensor's mean, its pitch and roll with the patent's signs.
    pub measured_printed_deg: Option<UsblPrintedAngles>,
    /// The patent's calibration: adjusted minus measured.
    pub difference_printed_deg: Option<UsblPrintedAngles>,
    /// Every iteration.
    pub iterations: Vec<UsblIteration>,
}

/// One iteration of the reference path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblIteration {
    /// Corrections, degrees.
    pub step_deg: UsblPrintedAngles,
    /// Root mean square of the coordinate differences before it, metres.
    pub rms_m: f64,
}

/// The joint path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblJoint {
    /// How it ended.
    pub status: Status,
    /// Whether the numbers may be used.
    pub usable: bool,
    /// The end in words, empty when there is nothing to say.
    pub message: String,
    /// The mounting rotation `R_u^b`, transducer into attitude sensor, by rows.
    pub rotation_matrix: Option<Matrix3>,
    /// The same as angles of a survey file, degrees.
    pub mounting_deg: Option<MountingAngles>,
    /// The same as the patent's angles.
    pub printed_deg: Option<UsblPrintedAngles>,
    /// `log(R R_nominal^T)` in the body, degrees.
    pub correction_deg: Option<Angles>,
    /// Adjusted minus surveyed position of the transducer, east, north, up, metres.
    pub transducer_m: Option<[f64; 3]>,
    /// True range = measured x (1 + scale).
    pub range_scale: Option<f64>,
    /// The parameters sought, in the order of the covariance, with their standard deviations.
    pub parameters: Vec<Parameter>,
    /// Covariance of the parameters: rad, m, 1; left perturbation in the body.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Correlations in the same order.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Iterations of the last adjustment.
    pub iterations: u64,
    /// Tests and reliability.
    pub quality: Option<Quality>,
}

/// One beacon's residuals under both paths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblVerification {
    /// The beacon.
    pub beacon: String,
    /// `common` or `check`.
    pub role: String,
    /// With the reference path's correction.
    pub reference: Option<UsblResiduals>,
    /// With the joint path's.
    pub joint: Option<UsblResiduals>,
}

/// Predicted minus surveyed beacon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblResiduals {
    /// Fixes within five standard deviations.
    pub fixes: u64,
    /// Fixes beyond.
    pub outliers: u64,
    /// Mean, east, north, up, metres.
    pub mean_m: [f64; 3],
    /// Root mean square length, metres.
    pub rms_m: f64,
    /// Predicted standard deviations of the mean, metres; for a check beacon under the joint path with the calibration's share.
    pub mean_standard_deviation_m: [f64; 3],
    /// Squared mean in the metric of its predicted covariance (3 degrees of freedom); check beacon under the joint path only.
    pub test_statistic: Option<f64>,
    /// Probability of a larger one by chance.
    pub p_value: Option<f64>,
}

/// What the pictures are drawn from; `result.json` does not hold it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UsblSamples {
    /// Name of the survey.
    pub title: String,
    /// Some of the fixes of every beacon, evenly thinned.
    pub fixes: Vec<UsblFixSample>,
    /// The truth, where the survey was simulated.
    pub truth: Option<UsblTruth>,
}

/// One fix of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblFixSample {
    /// Index into [`UsblResult::beacons`].
    pub beacon: u32,
    /// Time from the first fix, seconds.
    pub time_s: f64,
    /// Predicted minus surveyed beacon with the reference path, east, north, up, metres.
    pub reference_m: Option<[f64; 3]>,
    /// The same with the joint path.
    pub joint_m: Option<[f64; 3]>,
    /// Whether it is an outlier (under the joint path where it ran).
    pub outlier: bool,
}

/// The truth of a simulated survey.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblTruth {
    /// True mounting rotation, by rows.
    pub rotation_matrix: Matrix3,
    /// `log(R R_nominal^T)`, degrees.
    pub correction_deg: Angles,
    /// True minus surveyed transducer, metres.
    pub transducer_m: [f64; 3],
    /// True range scale.
    pub range_scale: f64,
}
