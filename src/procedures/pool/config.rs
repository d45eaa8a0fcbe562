//! What steers the pool calibration: the `[sequential]` and `[joint]` sections of a survey file.

use serde::{Deserialize, Serialize};

pub use crate::calibrate::choices::KernelName;
use crate::calibrate::verdict::VerdictConfig;

/// How the reference path measures an angle between two normals (mathematics section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Variant {
    /// The full angle between the normals, as the patent says: the three corrections mix.
    #[default]
    Literal,
    /// The component of `nM x nL` about the axis concerned.
    Projected,
}

impl Variant {
    /// `literal` or `projected`, with `, repeated` where angles and offsets are repeated in turn.
    #[must_use]
    pub fn in_words(self, repeated: bool) -> String {
        let name = match self {
            Self::Literal => "literal",
            Self::Projected => "projected",
        };
        format!("{name}{}", if repeated { ", repeated" } else { "" })
    }
}

/// The `[sequential]` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SequentialConfig {
    /// Which angle is taken.
    pub variant: Variant,
    /// Angles and offsets in turn until both are stable, instead of the patent's single round.
    pub repeated: bool,
    /// Angle below which a pair of normals agrees, degrees.
    pub threshold_deg: f64,
    /// Most passes of the angle iteration.
    pub max_passes: u32,
}

impl Default for SequentialConfig {
    fn default() -> Self {
        Self {
            variant: Variant::Literal,
            repeated: false,
            threshold_deg: 0.05,
            max_passes: 30,
        }
    }
}

/// Whether the scanner's planes are unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Planes {
    /// Unknowns, observed by the laser returns.
    #[default]
    Adjusted,
    /// Fitted to the laser returns beforehand and taken as free of error.
    Fixed,
}

/// Whether the trajectory's errors are unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Drift {
    /// White noise and drift of every record are states with their prior.
    #[default]
    On,
    /// White noise is added to each condition's variance, drift is ignored.
    Off,
}

/// Standard deviations of prior knowledge about the six parameters, about their nominal values.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MountingPrior {
    /// Pitch, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_sigma_deg: Option<f64>,
    /// Roll, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll_sigma_deg: Option<f64>,
    /// Yaw, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_sigma_deg: Option<f64>,
    /// Lever arm to the right, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lx_sigma_m: Option<f64>,
    /// Lever arm forward, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ly_sigma_m: Option<f64>,
    /// Lever arm up, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lz_sigma_m: Option<f64>,
}

/// The `[joint]` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointConfig {
    /// Whether the scanner's planes are unknowns.
    pub planes: Planes,
    /// Whether the trajectory's errors are unknowns.
    pub drift: Drift,
    /// Robust kernel.
    pub kernel: KernelName,
    /// Width of the kernel in sigmas.
    pub kernel_width_sigma: f64,
    /// Gate of the association in sigmas; 4 or wider, or the uncertainty becomes a lie.
    pub gate_sigma: f64,
    /// Estimate the latency of the soundings' time stamps.
    pub latency: bool,
    /// Estimate a scale of the ranges (sound speed).
    pub range_scale: bool,
    /// Parameters held at their nominal value: any of pitch, roll, yaw, lx, ly, lz.
    pub hold: Vec<String>,
    /// Prior knowledge of the six parameters.
    pub prior: MountingPrior,
    /// An angle whose standard deviation exceeds this (degrees) is refused.
    pub max_sigma_deg: f64,
    /// An offset whose standard deviation exceeds this (metres) is refused.
    pub max_sigma_m: f64,
    /// Iterate the variance components of soundings and returns (several more adjustments); the one-step figures otherwise.
    pub variance_components: bool,
    /// Limits of the verdict: the `[verdict]` section of a survey file.
    #[serde(skip)]
    pub verdict: VerdictConfig,
    /// Solve the simple model (planes fixed, drift off) as well, for comparison.
    pub simple: bool,
}

impl Default for JointConfig {
    fn default() -> Self {
        Self {
            planes: Planes::Adjusted,
            drift: Drift::On,
            kernel: KernelName::Huber,
            kernel_width_sigma: 2.0,
            gate_sigma: 5.0,
            latency: false,
            range_scale: false,
            hold: vec![],
            prior: MountingPrior::default(),
            max_sigma_deg: 1.0,
            max_sigma_m: 0.5,
            variance_components: false,
            verdict: VerdictConfig::default(),
            simple: false,
        }
    }
}
