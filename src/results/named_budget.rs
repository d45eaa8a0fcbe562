//! An error budget of a procedure whose parameters are named, as plain serialisable data: `result.json`.
//!
//! Every list over parameters is in the order of [`NamedBudget::parameters`], each entry in that parameter's unit. What could not be
//! determined is `None` (`null` in the file), never NaN.

use serde::{Deserialize, Serialize};

use super::{Interval, Nees, Software};

/// Version of [`NamedBudget`]'s form.
pub const NAMED_BUDGET_FORMAT_VERSION: u32 = 1;

/// `result.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedBudget {
    /// [`NAMED_BUDGET_FORMAT_VERSION`].
    pub format_version: u32,
    /// The procedure: `usbl`, `rail`.
    pub procedure: String,
    /// Name of the scenario.
    pub scenario: String,
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
    /// The parameters.
    pub parameters: Vec<NamedParameter>,
    /// The sources that act, in the order of their random streams.
    pub sources: Vec<NamedSource>,
    /// Each path.
    pub paths: Vec<NamedPath>,
    /// Trials of all sources together in which a path gave nothing usable.
    pub refusals: Vec<NamedRefusal>,
    /// The command that makes the result again.
    pub command: String,
    /// Sentences that the reader should know.
    pub notes: Vec<String>,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedParameter {
    /// Its name.
    pub name: String,
    /// Unit of everything said of it, `1` for a ratio.
    pub unit: String,
}

/// A source of error.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedSource {
    /// As a scenario's `[sources]` has it.
    pub source: String,
    /// For tables and pictures.
    pub title: String,
    /// Its distribution and size.
    pub description: String,
}

/// One path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedPath {
    /// `joint` or `reference`.
    pub path: String,
    /// Standard deviations that the path states before any trial, from data free of error; `None` where it states none.
    pub claimed: Option<Vec<f64>>,
    /// All sources together.
    pub together: Option<NamedFigures>,
    /// Each source alone, and `nothing`: the method's own error.
    pub shares: Vec<NamedShare>,
    /// What the reported uncertainty is worth; `None` for a path that reports none.
    pub honesty: Option<NamedHonesty>,
    /// Joint path's variance by this path's variance, from the trials.
    pub efficiency: Option<Vec<f64>>,
}

/// Errors over trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedFigures {
    /// Trials run.
    pub trials: u64,
    /// Trials with a usable result.
    pub usable: u64,
    /// Mean error.
    pub bias: Vec<f64>,
    /// One sigma of the mean.
    pub bias_standard_error: Option<Vec<f64>>,
    /// Standard deviation of the error.
    pub standard_deviation: Option<Vec<f64>>,
    /// Factors from a standard deviation to the ends of its interval.
    pub standard_deviation_interval: Option<Interval>,
}

/// What one source does alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedShare {
    /// Its name, or `nothing`.
    pub source: String,
    /// Its errors; `None` when no trial was usable.
    pub figures: Option<NamedFigures>,
    /// Its variance by that of all together.
    pub share: Option<Vec<f64>>,
}

/// What the reported uncertainty is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedHonesty {
    /// Root mean square of the reported standard deviations.
    pub reported: Vec<f64>,
    /// Mean of error by reported standard deviation.
    pub pull_mean: Vec<f64>,
    /// Their root mean square, 1 when honest.
    pub pull_rms: Vec<f64>,
    /// Where an honest one lies.
    pub pull_rms_interval: Interval,
    /// Normalised estimation error squared; its degrees of freedom are the number of parameters.
    pub nees: Option<Nees>,
    /// Mean variance factor.
    pub variance_factor: Option<f64>,
}

/// Trials without a usable result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedRefusal {
    /// `joint` or `reference`.
    pub path: String,
    /// Why, as the first such trial had it.
    pub reason: String,
    /// How many.
    pub count: u64,
    /// Seeds of the first ones.
    pub seeds: Vec<u64>,
}
