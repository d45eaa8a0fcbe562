//! What steers the rail calibration: the `[reference]` and `[joint]` sections of a survey file.

use super::survey::keys::COUNT;
use crate::adjust::{Large, Options};
use crate::calibrate::choices::KernelName;
use crate::calibrate::verdict::VerdictConfig;
use crate::survey::limits::{GATE, KERNEL, WIDTH, limits};
use crate::survey::schema::Kind;
use crate::survey::section::section;

section! {
    #[settings]
    /// The `[reference]` section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct RailReferenceConfig {
        /// Spacing of the standard profile's points, metres.
        spacing_m: f64 = or (1e-4), Kind::Number(limits(1e-6, 0.01, "metres from 1e-6 to 0.01"));
        /// Steps of the coarse fit at the most.
        max_steps: u32 = or (200), Kind::Count(COUNT);
        /// A point belongs to a region when it lies so near to it after the coarse fit, metres.
        region_m: f64 = or (1e-3), Kind::Number(limits(1e-6, 0.1, "metres from 1e-6 to 0.1"));
        /// Positions belong to a sweep when the other angle is so near to level, degrees.
        axis_tolerance_deg: f64 = or (0.1), Kind::Number(limits(1e-6, 10.0, "degrees from 1e-6 to 10"));
    }
}

section! {
    #[settings]
    /// The `[joint]` section.
    #[derive(Clone, Debug, PartialEq)]
    pub struct RailJointConfig {
        /// Robust kernel of the last adjustment; the rounds before use Huber's.
        kernel: KernelName = or (KernelName::Tukey), KERNEL;
        /// Width of the kernel in sigmas.
        kernel_width_sigma: f64 = or (4.685), Kind::Number(WIDTH);
        /// Gate of the association in sigmas; 4 or wider, or the standard deviations come out too small.
        gate_sigma: f64 = or (5.0), Kind::Number(GATE);
        /// Rounds of association at the most.
        max_rounds: u32 = or (40), Kind::Count(limits(3.0, 1000.0, "3 to 1000"));
        /// An angle whose standard deviation exceeds this (degrees) is refused.
        max_sigma_deg: f64 = or (0.5), Kind::Number(limits(1e-9, 180.0, "degrees from 1e-9 to 180"));
        /// An offset whose standard deviation exceeds this (metres) is refused.
        max_sigma_m: f64 = or (0.002), Kind::Number(limits(1e-9, 10.0, "metres from 1e-9 to 10"));
        /// Smallest range of table angles that tells the sign of heading and pitch, degrees.
        least_turn_deg: f64 = or (0.5), Kind::Number(limits(0.0, 90.0, "degrees from 0 to 90"));
        aside
        /// Limits of the verdict: the `[verdict]` section of a survey file.
        verdict: VerdictConfig = VerdictConfig::default();
        aside
        /// How a long trajectory is worked on: the `[large]` section of a survey file.
        large: Large = Large::default();
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
