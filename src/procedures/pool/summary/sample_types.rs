//! Decimated samples for the report's pictures, in the refined target frame (x through the wall, away from the boat; y along it; z up).

use serde::{Deserialize, Serialize};

use crate::results::DriftSample;

/// What the pictures are drawn from. Stays in memory; `result.json` does not hold it. A hundred thousand points keep the report quick.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ReportSamples {
    /// Height of the water level, metres; `None` when not known.
    pub water_level_m: Option<f64>,
    /// The target's faces.
    pub faces: Vec<FaceSample>,
    /// Some of the soundings, evenly thinned.
    pub soundings: Vec<SoundingSample>,
    /// Some of the laser returns, evenly thinned.
    pub returns: Vec<ReturnSample>,
    /// INS positions, one polyline per pass, metres.
    pub trajectory_m: Vec<Vec<[f64; 3]>>,
    /// Residual figures per face of all used soundings, not of the samples only.
    pub face_statistics: Vec<FaceStatistics>,
    /// The trajectory's drift as the joint path estimates it.
    pub drift: Vec<DriftSample>,
}

/// One value per path that ran.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PerPath<T> {
    /// Reference path.
    pub reference: Option<T>,
    /// Joint path.
    pub joint: Option<T>,
    /// Simple joint path.
    pub joint_simple: Option<T>,
}

/// One face of the target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaceSample {
    /// As in the target model.
    pub name: String,
    /// `P1`, `P2`, `P3`, `horizontal` or `other`.
    pub role: String,
    /// Corners, counter-clockwise seen from the sensors, metres.
    pub vertices_m: Vec<[f64; 3]>,
    /// Whether the face lies above the water wholly or in part, so that the scanner sees it.
    pub above_water: bool,
}

/// One sounding of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SoundingSample {
    /// With the nominal mounting, metres.
    pub nominal_m: [f64; 3],
    /// With each path's mounting, metres.
    pub position_m: PerPath<[f64; 3]>,
    /// Index into [`ReportSamples::faces`]; `None` when it was assigned to no face.
    pub face: Option<u32>,
    /// Signed distance from its face along the outward normal with the nominal mounting, metres; `None` without a face.
    pub nominal_residual_m: Option<f64>,
    /// The same after each path.
    pub residual_m: PerPath<f64>,
    /// Whether it entered the final adjustment.
    pub used: bool,
    /// Across-track angle of the beam, positive to starboard, degrees.
    pub across_deg: f64,
    /// Slant range, metres.
    pub range_m: f64,
    /// Time of the ping on the trajectory's clock, seconds.
    pub time_s: f64,
    /// Standard deviation of its distance from the face by what the survey states of sonar and INS, metres; `None` without a face.
    pub stated_sigma_m: Option<f64>,
}

/// One laser return of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReturnSample {
    /// Position, metres.
    pub position_m: [f64; 3],
    /// Index into [`ReportSamples::faces`].
    pub face: Option<u32>,
    /// Signed distance from its face along the outward normal, metres; `None` without a face.
    pub residual_m: Option<f64>,
    /// Whether it entered the final adjustment.
    pub used: bool,
}

/// Residuals of the soundings on one face after one path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FaceStatistics {
    /// Index into [`ReportSamples::faces`].
    pub face: u32,
    /// How many soundings.
    pub soundings: u64,
    /// Mean signed residual per path, metres.
    pub mean_m: PerPath<f64>,
    /// RMS residual per path, metres.
    pub rms_m: PerPath<f64>,
}
