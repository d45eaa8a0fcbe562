//! An error budget as plain serialisable data: `result.json`.
//!
//! Every list over parameters is in the order of [`BudgetResult::parameters`], each entry in that parameter's unit. What could not be
//! determined is `None` (`null` in the file), never NaN.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Software, SwathResult};

/// Version of [`BudgetResult`]'s form.
pub const BUDGET_FORMAT_VERSION: u32 = 2;

/// A figure for each parameter; `None` for one of which nothing is known.
pub type Figures = Vec<Option<f64>>;

/// Name of the joint path in every budget.
pub const JOINT: &str = "joint";

/// `result.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BudgetResult {
    /// [`BUDGET_FORMAT_VERSION`].
    pub format_version: u32,
    /// The procedure.
    pub procedure: String,
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of the scenario as it took effect, but for its seed.
    pub scenario_sha256: String,
    /// The program that made the result.
    pub software: Software,
    /// First seed of every set of trials: common random numbers.
    pub first_seed: u64,
    /// Trials of all sources together.
    pub trials: u64,
    /// Trials of each source alone; 0 when they were not asked for.
    pub single_trials: u64,
    /// Probability inside every interval.
    pub confidence: f64,
    /// The configuration of all paths as it took effect.
    pub configuration: serde_json::Value,
    /// The parameters.
    pub parameters: Vec<BudgetParameter>,
    /// Root mean square errors that would do, by parameter in its unit; empty where nobody said.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub wanted: BTreeMap<String, f64>,
    /// The sources that act, in the order of their random streams.
    pub sources: Vec<SourceDescription>,
    /// Each path.
    pub paths: Vec<PathBudget>,
    /// Trials of all sources together in which a path gave nothing usable.
    pub refusals: Vec<RefusalCount>,
    /// Scenario values over ranges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// What the calibration means for soundings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swath: Option<SwathResult>,
    /// The command that makes the result again, the scenario by the name of its file.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub command: String,
    /// Sentences that the reader should know.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct BudgetParameter {
    /// Its name.
    pub name: String,
    /// Unit of everything said of it, `1` for a ratio.
    pub unit: String,
}

/// An error source in words.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SourceDescription {
    /// As in `[sources]` of a scenario file.
    pub source: String,
    /// For tables and pictures.
    pub title: String,
    /// Distribution, and what shares one draw.
    pub description: String,
    /// Scenario keys that size it, with their values in this scenario.
    #[serde(default)]
    pub size: BTreeMap<String, String>,
    /// The same keys (last part) by default; empty where a scenario must say.
    pub default: BTreeMap<String, f64>,
    /// Where the default is from.
    pub reference: String,
}

/// A path with what each source does to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathBudget {
    /// Its key: `joint`, `reference`.
    pub path: String,
    /// Its variant as configured, such as `literal`; empty for the joint path.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub variant: String,
    /// All sources together, by Monte Carlo.
    pub together: Option<PathStatistics>,
    /// All sources that have a derivative together, analytically.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted: Option<SourceShare>,
    /// Source by source, by whichever way; a remainder last of each origin where the trials allow one.
    pub shares: Vec<SourceShare>,
    /// Analytic propagation against Monte Carlo, source by source.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub agreement: Vec<Agreement>,
    /// Standard deviations that the path states from data free of error, before any trial.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub claimed: Option<Figures>,
    /// Cramer-Rao bound of the standard deviation of any unbiased path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<Figures>,
    /// Bound's variance by the path's variance, 1 for the best possible path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub efficiency: Option<Figures>,
}

/// How a figure was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Through the derivatives.
    Analytic,
    /// By simulation.
    MonteCarlo,
}

/// What one source does to a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceShare {
    /// A source's name, `association` (together's error minus that with true ties, seed by seed), `nothing` (the method's own error without
    /// any source), `remainder` (together's variance minus the sum of the sources') or `interaction` (the error with true ties minus the sum
    /// of the sources', seed by seed).
    pub source: String,
    /// How it was found.
    pub origin: Origin,
    /// Trials with a usable result; 0 for analytic figures.
    pub usable: u64,
    /// Trials; 0 for analytic figures.
    pub trials: u64,
    /// Mean error; of a source alone by Monte Carlo, the method's own is taken off.
    pub bias: Option<Figures>,
    /// One sigma of the bias.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_standard_error: Option<Figures>,
    /// Standard deviation; `None` of a remainder, whose variance may be negative.
    pub standard_deviation: Option<Figures>,
    /// Factors from the standard deviation to the ends of its interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_deviation_interval: Option<Interval>,
    /// Part of the variance of all sources together.
    pub share: Option<Figures>,
    /// What the reader should know, or empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// An interval with the result's confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// Whether a value lies inside.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }
}

/// What a set of trials says of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathStatistics {
    /// Which.
    pub path: String,
    /// Trials.
    pub trials: u64,
    /// Trials with a usable result of this path; the figures are of these.
    pub usable: u64,
    /// Mean error.
    pub bias: Option<Figures>,
    /// One sigma of the bias.
    pub bias_standard_error: Option<Figures>,
    /// Standard deviation about the mean.
    pub standard_deviation: Option<Figures>,
    /// Factors from the standard deviation to the ends of its interval.
    pub standard_deviation_interval: Option<Interval>,
    /// Root mean square error.
    pub rms: Option<Figures>,
    /// What the path says of itself; `None` for the reference path, which says nothing.
    pub reported: Option<Reported>,
}

/// Honesty of the reported covariance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reported {
    /// Root of the mean reported variance.
    pub standard_deviation: Option<Figures>,
    /// Mean of error / reported standard deviation; 0 of a parameter that was held.
    pub pull_mean: Vec<f64>,
    /// Root mean square of the same, 1 when the covariance is true.
    pub pull_rms: Vec<f64>,
    /// Where the root mean square of a true covariance would lie, by chi-square.
    pub pull_rms_interval: Interval,
    /// Normalised estimation error squared, `e^T C^-1 e`.
    pub nees: Option<Nees>,
    /// Mean variance factor; `None` where none was judged.
    pub variance_factor: Option<f64>,
}

/// Mean of `e^T C^-1 e` over trials, the number of parameters that were not held when the covariance is true.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Nees {
    /// Mean.
    pub mean: f64,
    /// Where the mean of a true covariance would lie, by chi-square.
    pub interval: Interval,
    /// Trials whose covariance could be inverted.
    pub trials: u64,
    /// Parameters that were not held.
    pub parameters: u64,
}

/// Analytic variance against that of the trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// A source's name, or `together`.
    pub source: String,
    /// Trials' variance by analytic variance; a parameter is left out where the analytic one is 0.
    pub variance_ratio: BTreeMap<String, f64>,
    /// Where the ratio would lie if both were the same, by chi-square, for all comparisons at once (Sidak).
    pub interval: Interval,
    /// Comparisons that the interval was widened for.
    pub comparisons: u64,
    /// Parameters outside the interval.
    pub outside: Vec<String>,
    /// Why, where they differ; or empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// Trials in which a path gave nothing usable, by reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefusalCount {
    /// Which.
    pub path: String,
    /// The reason as one word.
    pub code: String,
    /// How many.
    pub count: u64,
    /// The first seeds, at most ten.
    pub seeds: Vec<u64>,
    /// The first one's words.
    pub example: String,
}

/// One or two scenario values over ranges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// The varied keys, one or two.
    pub keys: Vec<String>,
    /// Trials at each point, all under the same seeds.
    pub trials: u64,
    /// The points; of two keys the first varies slowest.
    pub points: Vec<SweepPoint>,
}

/// A point of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// Value of each key, in the key's unit.
    pub values: Vec<SweepValue>,
    /// Each path.
    pub paths: Vec<PathStatistics>,
    /// Trials in which a path gave nothing usable.
    pub refusals: Vec<RefusalCount>,
}

/// A value of a varied key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SweepValue {
    /// A number, in the key's unit.
    Number(f64),
    /// `true` or `false`.
    Flag(bool),
    /// A word.
    Text(String),
}

impl std::fmt::Display for SweepValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Text(text) => write!(f, "{text}"),
        }
    }
}
