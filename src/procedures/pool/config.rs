//! What steers the pool calibration: the `[sequential]` and `[joint]` sections of a survey file.

use serde::{Deserialize, Serialize};

use super::survey::keys::{PARAMETERS, SIGMA_DEG, SIGMA_M};
use crate::adjust::Large;
pub use crate::calibrate::choices::KernelName;
use crate::calibrate::verdict::VerdictConfig;
use crate::survey::limits::{ABOVE, GATE, KERNEL, WIDTH, limits};
use crate::survey::schema::Kind;
use crate::survey::section::section;

/// How the reference path measures an angle between two normals (`docs/reference-path.md`).
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

section! {
    #[settings]
    /// The `[sequential]` section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct SequentialConfig {
        /// Which angle is taken.
        variant: Variant = or (Variant::Literal), Kind::OneOf(&["literal", "projected"]);
        /// Angles and offsets in turn until both are stable, instead of the patent's single round.
        repeated: bool = or (false), Kind::Flag;
        /// Angle below which a pair of normals agrees, degrees.
        threshold_deg: f64 = or (0.05), Kind::Number(limits(1e-9, 10.0, "degrees from 1e-9 to 10"));
        /// Most passes of the angle iteration.
        max_passes: u32 = or (30), Kind::Count(limits(1.0, 10_000.0, "1 to 10000"));
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

section! {
    #[settings]
    /// Standard deviations of prior knowledge about the six parameters, about their nominal values.
    #[derive(Clone, Debug, PartialEq)]
    pub struct MountingPrior {
        /// Pitch, degrees.
        #[serde(skip_serializing_if = "Option::is_none")]
        pitch_sigma_deg: Option<f64> = or (None), Kind::Number(SIGMA_DEG);
        /// Roll, degrees.
        #[serde(skip_serializing_if = "Option::is_none")]
        roll_sigma_deg: Option<f64> = or (None), Kind::Number(SIGMA_DEG);
        /// Yaw, degrees.
        #[serde(skip_serializing_if = "Option::is_none")]
        yaw_sigma_deg: Option<f64> = or (None), Kind::Number(SIGMA_DEG);
        /// Lever arm to the right, metres.
        #[serde(skip_serializing_if = "Option::is_none")]
        lx_sigma_m: Option<f64> = or (None), Kind::Number(SIGMA_M);
        /// Lever arm forward, metres.
        #[serde(skip_serializing_if = "Option::is_none")]
        ly_sigma_m: Option<f64> = or (None), Kind::Number(SIGMA_M);
        /// Lever arm up, metres.
        #[serde(skip_serializing_if = "Option::is_none")]
        lz_sigma_m: Option<f64> = or (None), Kind::Number(SIGMA_M);
    }
}

section! {
    #[settings]
    /// The `[joint]` section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct JointConfig {
        /// Whether the scanner's planes are unknowns.
        planes: Planes = or (Planes::Adjusted), Kind::OneOf(&["adjusted", "fixed"]);
        /// Whether the trajectory's errors are unknowns.
        drift: Drift = or (Drift::On), Kind::OneOf(&["on", "off"]);
        /// Robust kernel.
        kernel: KernelName = or (KernelName::Huber), KERNEL;
        /// Width of the kernel in sigmas.
        kernel_width_sigma: f64 = or (2.0), Kind::Number(WIDTH);
        /// Gate of the association in sigmas; 4 or wider, or the standard deviations come out too small.
        gate_sigma: f64 = or (5.0), Kind::Number(GATE);
        /// Estimate the latency of the soundings' time stamps.
        latency: bool = or (false), Kind::Flag;
        /// Estimate a scale of the ranges (sound speed).
        range_scale: bool = or (false), Kind::Flag;
        /// Parameters held at their nominal value: any of pitch, roll, yaw, lx, ly, lz.
        hold: Vec<String> = or (vec![]), Kind::Words(PARAMETERS);
        /// Prior knowledge of the six parameters.
        prior: MountingPrior = or (MountingPrior::default()), Kind::Table(MountingPrior::KEYS);
        /// An angle whose standard deviation exceeds this (degrees) is refused.
        max_sigma_deg: f64 = or (1.0), Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180"));
        /// An offset whose standard deviation exceeds this (metres) is refused.
        max_sigma_m: f64 = or (0.5), Kind::Number(limits(ABOVE, 1000.0, "metres above 0 and up to 1000"));
        /// Iterate the variance components of soundings and returns (several more adjustments); the one-step figures otherwise.
        variance_components: bool = or (false), Kind::Flag;
        /// Solve the simple model (planes fixed, drift off) as well, for comparison.
        simple: bool = or (false), Kind::Flag;
        aside
        /// Limits of the verdict: the `[verdict]` section of a survey file.
        verdict: VerdictConfig = VerdictConfig::default();
        aside
        /// How a long trajectory is worked on: the `[large]` section of a survey file.
        large: Large = Large::default();
    }
}
