//! What only a USBL calibration has in its result. Level coordinates are east, north, up of the surveyed transducer.

use serde::{Deserialize, Serialize};

use crate::results::{Matrix3, MountingAngles};

/// Everything beside the solutions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblDetails {
    /// The surveyed beacons.
    pub beacons: Vec<UsblBeacon>,
    /// Standard deviations of the surveyed transducer, east, north, up, metres.
    pub transducer_standard_deviation_m: [f64; 3],
    /// Nominal mounting, degrees.
    pub nominal_mounting_deg: MountingAngles,
    /// The patent's verification: predicted minus surveyed beacons.
    pub verification: Vec<UsblVerification>,
}

/// What only the reference path has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UsblReferenceDetails {
    /// Formal covariance of pitch, roll, yaw (rad^2) from the residuals of the means; it knows nothing of errors that the fixes of
    /// all beacons share.
    pub formal_covariance: Option<Matrix3>,
    /// The adjusted attitude of the transducer in the patent's angles.
    pub adjusted_printed_deg: UsblPrintedAngles,
    /// The attitude sensor's mean, its pitch and roll with the patent's signs.
    pub measured_printed_deg: UsblPrintedAngles,
    /// The patent's calibration: adjusted minus measured.
    pub difference_printed_deg: UsblPrintedAngles,
    /// Every iteration.
    pub iterations: Vec<UsblIteration>,
}

/// What only the joint path has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblJointDetails {
    /// The mounting as the patent's angles.
    pub printed_deg: UsblPrintedAngles,
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

/// One iteration of the reference path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblIteration {
    /// Corrections, degrees.
    pub step_deg: UsblPrintedAngles,
    /// Root mean square of the coordinate differences before it, metres.
    pub rms_m: f64,
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
