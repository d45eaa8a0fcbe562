//! Where a result comes from: program, inputs, configuration.

use serde::{Deserialize, Serialize};

use crate::adjust::fingerprint;

/// Everything that is needed to get the same bytes again. Holds no time, duration, machine name or thread count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The program that made the result.
    pub software: Software,
    /// Seed of every random draw (RANSAC).
    pub seed: u64,
    /// Every file that was read, the survey file first.
    pub inputs: Vec<InputFile>,
    /// The configuration as it took effect, defaults included.
    pub configuration: serde_json::Value,
}

/// Name and version of the program, and the arithmetic that it found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Software {
    /// `boresight`.
    pub name: String,
    /// Semantic version.
    pub version: String,
    /// SHA-256 of a thousand function values and a small adjustment ([`fingerprint`]): where it is the same, so are the last digits.
    /// Empty in a result of a version that did not state it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub numerics: String,
}

impl Software {
    /// This build.
    #[must_use]
    pub fn this() -> Self {
        Self {
            name: env!("CARGO_PKG_NAME").into(),
            version: env!("CARGO_PKG_VERSION").into(),
            numerics: fingerprint().into(),
        }
    }
}

/// One input file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Path as it stands in the survey file.
    pub path: String,
    /// SHA-256 of its bytes, 64 hexadecimal digits.
    pub sha256: String,
}
