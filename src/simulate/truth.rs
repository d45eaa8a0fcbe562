//! The answer to a simulated survey, as `truth.json` gives it.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::reality::Reality;
use crate::units::degrees;

/// What a calibration should have found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// True `R_m^b`, row by row.
    pub rotation_matrix: [[f64; 3]; 3],
    /// True lever arm, metres.
    pub lever_arm_m: [f64; 3],
    /// Nominal `R_m^b`, row by row.
    pub nominal_rotation_matrix: [[f64; 3]; 3],
    /// Nominal lever arm, metres.
    pub nominal_lever_arm_m: [f64; 3],
    /// `log(R R_nominal^T)`, degrees.
    pub correction_deg: TrueCorrection,
    /// Stamp minus measurement epoch, seconds.
    pub latency_s: f64,
    /// True range = measured x (1 + scale).
    pub range_scale: f64,
    /// True pose of the target.
    pub target: TrueTarget,
}

/// Components of the correction about the body axes, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueCorrection {
    /// About x.
    pub pitch: f64,
    /// About y.
    pub roll: f64,
    /// About z.
    pub yaw: f64,
}

/// Where the target truly stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueTarget {
    /// Latitude of the origin, degrees.
    pub latitude_deg: f64,
    /// Longitude of the origin, degrees.
    pub longitude_deg: f64,
    /// Ellipsoidal height of the origin, metres.
    pub height_m: f64,
    /// Azimuth of the +Y axis, degrees.
    pub azimuth_deg: f64,
}

impl Truth {
    /// Of this reality.
    #[must_use]
    pub fn of(reality: &Reality) -> Self {
        let correction = reality
            .sonar
            .correction_from(&reality.nominal_sonar)
            .map(degrees);
        let (target, origin) = (&reality.target, &reality.target.origin);
        Self {
            rotation_matrix: rows(&reality.sonar.rotation),
            lever_arm_m: reality.sonar.lever_arm_m.into(),
            nominal_rotation_matrix: rows(&reality.nominal_sonar.rotation),
            nominal_lever_arm_m: reality.nominal_sonar.lever_arm_m.into(),
            correction_deg: TrueCorrection {
                pitch: correction.x,
                roll: correction.y,
                yaw: correction.z,
            },
            latency_s: reality.latency_s,
            range_scale: reality.range_scale,
            target: TrueTarget {
                latitude_deg: degrees(origin.latitude_rad),
                longitude_deg: degrees(origin.longitude_rad),
                height_m: origin.height_m,
                azimuth_deg: degrees(target.azimuth_rad),
            },
        }
    }

    /// The true rotation `R_m^b`.
    #[must_use]
    pub fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_row_iterator(self.rotation_matrix.iter().flatten().copied())
    }

    /// The true lever arm, metres.
    #[must_use]
    pub fn lever_arm(&self) -> Vector3<f64> {
        Vector3::from(self.lever_arm_m)
    }
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    m.transpose().into()
}
