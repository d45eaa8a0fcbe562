//! What steers the rail calibration: the `[reference]` and `[joint]` sections of a survey file.

use serde::{Deserialize, Serialize};

use crate::adjust::Options;
use crate::calibrate::choices::KernelName;
use crate::calibrate::verdict::VerdictConfig;

/// The `[reference]` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RailReferenceConfig {
    /// Spacing of the standard profile's points, metres.
    pub spacing_m: f64,
    /// Steps of the coarse fit at the most.
    pub max_steps: u32,
    /// A point belongs to a region when it lies so near to it after the coarse fit, metres.
    pub region_m: f64,
    /// Positions belong to a sweep when the other angle is so near to level, degrees.
    pub axis_tolerance_deg: f64,
}

impl Default for RailReferenceConfig {
    fn default() -> Self {
        Self {
            spacing_m: 1e-4,
            max_steps: 200,
            region_m: 1e-3,
            axis_tolerance_deg: 0.1,
        }
    }
}

/// The `[joint]` section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RailJointConfig {
    /// Robust kernel of the last adjustment; the rounds before use Huber's.
    pub kernel: KernelName,
    /// Width of the kernel in sigmas.
    pub kernel_width_sigma: f64,
    /// Gate of the association in sigmas; 4 or wider, or the uncertainty becomes a lie.
    pub gate_sigma: f64,
    /// Rounds of association at the most.
    pub max_rounds: u32,
    /// An angle whose standard deviation exceeds this (degrees) is refused.
    pub max_sigma_deg: f64,
    /// An offset whose standard deviation exceeds this (metres) is refused.
    pub max_sigma_m: f64,
    /// Limits of the verdict: the `[verdict]` section of a survey file.
    #[serde(skip)]
    pub verdict: VerdictConfig,
    /// Smallest range of table angles that tells the sign of heading and pitch, degrees.
    pub least_turn_deg: f64,
}

impl Default for RailJointConfig {
    fn default() -> Self {
        Self {
            kernel: KernelName::Tukey,
            kernel_width_sigma: 4.685,
            gate_sigma: 5.0,
            max_rounds: 40,
            max_sigma_deg: 0.5,
            max_sigma_m: 0.002,
            verdict: VerdictConfig::default(),
            least_turn_deg: 0.5,
        }
    }
}

impl RailJointConfig {
    /// The engine's options.
    #[must_use]
    pub fn options(&self) -> Options {
        Options {
            kernel: self.kernel.kernel(self.kernel_width_sigma),
            step_tolerance_sigmas: 0.01,
            ..Options::default()
        }
    }
}
