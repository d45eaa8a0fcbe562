//! The reference paths: the classical patch test, one parameter after the other on pairs of lines, and the paper's overall adjustment of
//! features that are matched between the lines.

pub mod config;
pub mod features;
pub mod image;
pub mod overall;
pub mod patch;
pub mod sift;

pub use config::ReferenceConfig;
pub use features::{Features, FeaturesError, features};
pub use patch::{Patch, Step, patch_test};

use super::joint::JointError;
use super::model::Values;

/// What a reference path found.
#[derive(Clone, Debug)]
pub enum Reference {
    /// The patch test.
    Patch(Patch),
    /// The paper's path.
    Features(Features),
}

/// Why a reference path has no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// The lines do not meet, or nothing can be placed on the bed.
    #[error(transparent)]
    Lines(#[from] JointError),
    /// The paper's path.
    #[error(transparent)]
    Features(#[from] FeaturesError),
}

impl Reference {
    /// Values found.
    #[must_use]
    pub fn values(&self) -> &Values {
        match self {
            Self::Patch(patch) => &patch.values,
            Self::Features(features) => &features.values,
        }
    }

    /// Pitch, roll, yaw, latency, range scale: whether it found it.
    #[must_use]
    pub fn found(&self) -> [bool; 5] {
        match self {
            Self::Patch(patch) => std::array::from_fn(|k| k < 4 && patch.found[k]),
            Self::Features(_) => [true; 5],
        }
    }
}
