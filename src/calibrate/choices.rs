//! What every procedure lets its user choose: which paths run, which robust kernel the joint one has.

use serde::{Deserialize, Serialize};

use crate::adjust::Kernel;

/// Which paths run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// The reference path only.
    Reference,
    /// The joint path only.
    Joint,
    /// Both, compared.
    #[default]
    Both,
}

impl Method {
    /// As on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Joint => "joint",
            Self::Both => "both",
        }
    }
}

/// Robust kernel of the joint path, as a survey file names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KernelName {
    /// No robustness.
    LeastSquares,
    /// Linear tails.
    #[default]
    Huber,
    /// Logarithmic tails.
    Cauchy,
    /// Zero weight beyond the width.
    Tukey,
    /// Bounded cost.
    GemanMcclure,
}

impl KernelName {
    /// The kernel with its width in sigmas.
    #[must_use]
    pub fn kernel(self, k: f64) -> Kernel {
        match self {
            Self::LeastSquares => Kernel::LeastSquares,
            Self::Huber => Kernel::Huber { k },
            Self::Cauchy => Kernel::Cauchy { k },
            Self::Tukey => Kernel::Tukey { k },
            Self::GemanMcclure => Kernel::GemanMcClure { k },
        }
    }
}
