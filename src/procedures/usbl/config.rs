//! How a USBL calibration is to be made: the sections `[reference]` and `[joint]` of a survey file.

use crate::adjust::Options;
pub use crate::calibrate::choices::KernelName;
use crate::calibrate::verdict::VerdictConfig;
use crate::survey::limits::{ABOVE, GATE, KERNEL, WIDTH, limits};
use crate::survey::schema::Kind;
use crate::survey::section::section;

section! {
    #[settings]
    /// The `[reference]` section.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ReferenceConfig {
        /// Iterations at the most.
        max_iterations: u32 = or (50), Kind::Count(limits(1.0, 10_000.0, "1 to 10000"));
        /// An angle whose formal standard deviation exceeds this (degrees) is refused.
        max_sigma_deg: f64 = or (1.0), Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180"));
    }
}

section! {
    #[settings]
    /// The `[joint]` section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct JointConfig {
        /// Robust kernel.
        kernel: KernelName = or (KernelName::Huber), KERNEL;
        /// Width of the kernel in sigmas.
        kernel_width_sigma: f64 = or (2.0), Kind::Number(WIDTH);
        /// Estimate the transducer's position about its surveyed one; otherwise it is held there.
        transducer: bool = or (true), Kind::Flag;
        /// Estimate the beacons' positions about their surveyed ones; otherwise they are held there.
        beacons: bool = or (true), Kind::Flag;
        /// Estimate a scale of the ranges (sound speed), with the prior that the sound speed's standard deviation gives.
        range_scale: bool = or (true), Kind::Flag;
        /// Estimate the attitude sensor's noise of every record; otherwise it is left out.
        attitude_noise: bool = or (true), Kind::Flag;
        /// A fix with a residual above this many standard deviations after the robust start is a gross error.
        gate_sigma: f64 = or (5.0), Kind::Number(GATE);
        /// An angle whose standard deviation exceeds this (degrees) is refused.
        max_sigma_deg: f64 = or (1.0), Kind::Number(limits(ABOVE, 180.0, "degrees above 0 and up to 180"));
        /// A position whose standard deviation exceeds this (metres) is refused.
        max_sigma_m: f64 = or (0.5), Kind::Number(limits(ABOVE, 1000.0, "metres above 0 and up to 1000"));
        aside
        /// Limits of the verdict: the `[verdict]` section of a survey file.
        verdict: VerdictConfig = VerdictConfig::default();
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
