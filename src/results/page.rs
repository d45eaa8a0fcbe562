//! What a report shows beside the result itself.

use serde::{Deserialize, Serialize};

/// A procedure's own section of the report: data that stay in memory (`result.json` does not hold them) and the script that draws them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page {
    /// Name of the survey.
    pub title: String,
    /// What was calibrated, such as `calibration of a multibeam's mounting on a pool wall`.
    pub kind: &'static str,
    /// What the scripts draw from: decimated samples.
    pub data: serde_json::Value,
    /// Scripts, run in this order after those that all pages share; each adds its sections to the page.
    pub scripts: &'static [&'static str],
    /// What the terminal's summary says beside that of every procedure.
    pub tables: Vec<TextTable>,
    /// Errors against the truth, where the survey was simulated.
    pub against_truth: Option<AgainstTruth>,
}

/// A small table for the terminal, with lines under it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TextTable {
    /// Heads of the columns; the first column holds names.
    pub header: Vec<String>,
    /// Cells by row; no table without rows.
    pub rows: Vec<Vec<String>>,
    /// Sentences under the table.
    pub lines: Vec<String>,
}

/// How far each path is off the truth of a simulated survey.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AgainstTruth {
    /// One row per parameter.
    pub rows: Vec<TruthRow>,
}

/// One parameter's true correction and each path's error; `None` where the path has no result or the truth is not known.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthRow {
    /// The parameter's name.
    pub name: String,
    /// Unit of every number but `joint_in_sigmas`.
    pub unit: String,
    /// True correction of the nominal value.
    pub correction: Option<f64>,
    /// Error of the reference solution; for angles the rotation from the truth, `log(R R_true^T)`.
    pub reference: Option<f64>,
    /// Error of the joint solution.
    pub joint: Option<f64>,
    /// The same in its own standard deviation.
    pub joint_in_sigmas: Option<f64>,
    /// Error of the simple joint solution.
    pub joint_simple: Option<f64>,
}

/// One slow error of the trajectory as an adjustment estimates it along, for the report's picture.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DriftSample {
    /// Which one, in words, with its positive sense.
    pub name: String,
    /// `mm` or `deg`.
    pub unit: String,
    /// The standard deviation that the survey states of it, in the unit.
    pub sigma: f64,
    /// (time since the first, seconds; error, in the unit), a part for each stretch without a break.
    pub parts: Vec<Vec<[f64; 2]>>,
}

impl DriftSample {
    /// Most points of a part.
    const SHOWN: usize = 400;

    /// From its parts in seconds and metres, or radians for an `angle`; parts of many points are thinned evenly.
    #[must_use]
    pub fn new(name: &str, angle: bool, sigma: f64, parts: Vec<Vec<[f64; 2]>>) -> Self {
        let (unit, factor) = if angle {
            ("deg", 1f64.to_degrees())
        } else {
            ("mm", 1e3)
        };
        let thinned = |part: Vec<[f64; 2]>| {
            let step = part.len().div_ceil(Self::SHOWN).max(1);
            let shown = part.into_iter().step_by(step);
            shown.map(|[t, value]| [t, value * factor]).collect()
        };
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            sigma: sigma * factor,
            parts: parts.into_iter().map(thinned).collect(),
        }
    }
}
