//! The result of a calibration, whatever the procedure: the whole of `result.json`.

use super::{Comparison, Convention, Provenance, Solution, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the layout of `result.json`. A file with another one is refused when read.
pub const SCHEMA: u32 = 2;

/// A calibration by one or several paths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Layout version, [`SCHEMA`].
    pub schema: u32,
    /// Such as `pool`, as in the survey file.
    pub procedure: String,
    /// Program, seed, inputs and configuration.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Whether the deciding solution may be used: the joint one where it ran, else the reference one. `false` goes with exit code 1.
    pub usable: bool,
    /// Why the result is not usable; `None` when it is.
    pub reason: Option<String>,
    /// The verdict and everything that speaks against the result.
    pub verdict: Verdict,
    /// Observations read, used and rejected, by sensor.
    pub counts: BTreeMap<String, SensorCounts>,
    /// One entry per path that was asked for.
    pub solutions: Solutions,
    /// The reference solution against the joint one; `None` unless both are usable.
    pub comparison: Option<Comparison>,
    /// RMS distance of the same observations from where they belong, metres, by solution. It does not say which solution is right: one
    /// with more freedom always fits better.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub residual_rms_m: BTreeMap<String, f64>,
    /// Sentences that the reader should know, without a full stop.
    pub notes: Vec<String>,
    /// What only this procedure has.
    pub details: serde_json::Value,
    /// The deciding solution in the senses of other programs; empty where it is not usable or none is known.
    pub conventions: Vec<Convention>,
}

impl Calibration {
    /// The solution that decides: the joint one where it ran, else the reference one.
    #[must_use]
    pub fn deciding(&self) -> Option<&Solution> {
        self.solutions.deciding()
    }
}

/// The solutions of the paths that ran.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Solutions {
    /// The path of the procedure's source document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Solution>,
    /// One rigorous adjustment of everything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<Solution>,
    /// A joint adjustment that takes the target and the trajectory as error-free: for research.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_simple: Option<Solution>,
}

impl Solutions {
    /// Every solution with its name in the file, the reference one first.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &Solution)> {
        let all = [
            ("reference", &self.reference),
            ("joint", &self.joint),
            ("joint_simple", &self.joint_simple),
        ];
        all.into_iter()
            .filter_map(|(name, solution)| Some((name, solution.as_ref()?)))
    }

    /// The solution that decides: the joint one where it ran, else the reference one.
    #[must_use]
    pub fn deciding(&self) -> Option<&Solution> {
        self.joint.as_ref().or(self.reference.as_ref())
    }

    /// Its name in the file.
    #[must_use]
    pub fn deciding_name(&self) -> Option<&'static str> {
        let joint = self.joint.as_ref().map(|_| "joint");
        joint.or(self.reference.as_ref().map(|_| "reference"))
    }
}

/// Counts of one sensor's observations; `read` is `used` and all of `rejected`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorCounts {
    /// Read from the file.
    pub read: u64,
    /// Entered the final adjustment.
    pub used: u64,
    /// Left out, by reason.
    pub rejected: BTreeMap<String, u64>,
}
