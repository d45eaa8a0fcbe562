//! How a USBL calibration is to be made: the sections `[reference]` and `[joint]` of a survey file.

use serde::{Deserialize, Serialize};

use crate::adjust::Options;
pub use crate::calibrate::choices::KernelName;

/// The `[reference]` section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReferenceConfig {
    /// Iterations at the most.
    pub max_iterations: u32,
    /// An angle whose formal standard deviation exceeds this (degrees) is refused.
    pub max_sigma_deg: f64,
}

impl Default for ReferenceConfig {
    fn default() -> Self {
        Self {
            max_iterations: 50,
            max_sigma_deg: 1.0,
        }
    }
}

/// The `[joint]` section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointConfig {
    /// Robust kernel.
    pub kernel: KernelName,
    /// Width of the kernel in sigmas.
    pub kernel_width_sigma: f64,
    /// Estimate the transducer's position about its surveyed one; otherwise it is held there.
    pub transducer: bool,
    /// Estimate the beacons' positions about their surveyed ones; otherwise they are held there.
    pub beacons: bool,
    /// Estimate a scale of the ranges (sound speed), with the prior that the sound speed's standard deviation gives.
    pub range_scale: bool,
    /// Estimate the attitude sensor's noise of every record; otherwise it is left out.
    pub attitude_noise: bool,
    /// A fix with a residual above this many standard deviations after the robust start is a gross error.
    pub gate_sigma: f64,
    /// An angle whose standard deviation exceeds this (degrees) is refused.
    pub max_sigma_deg: f64,
    /// A position whose standard deviation exceeds this (metres) is refused.
    pub max_sigma_m: f64,
}

impl Default for JointConfig {
    fn default() -> Self {
        Self {
            kernel: KernelName::Huber,
            kernel_width_sigma: 2.0,
            transducer: true,
            beacons: true,
            range_scale: true,
            attitude_noise: true,
            gate_sigma: 5.0,
            max_sigma_deg: 1.0,
            max_sigma_m: 0.5,
        }
    }
}

impl JointConfig {
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
