//! What can be wrong with a problem handed to the engine.

use crate::files::wire::Torn;
use crate::watch::Stopped;
use thiserror::Error;

/// Faults of a problem, found before or while it is solved. How a solve *ended* is not an error: see [`super::Status`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AdjustError {
    /// A condition gave a misclosure, variance or derivative that is not a number.
    #[error("condition {condition} of set {set}: {what} is {found}, expected a finite number")]
    NotFinite {
        /// Index of the set of conditions in the problem.
        set: usize,
        /// Index of the condition in its set.
        condition: usize,
        /// The quantity concerned.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A condition gave a variance that is not positive.
    #[error("condition {condition} of set {set}: variance is {found}, expected a positive number")]
    BadVariance {
        /// Index of the set of conditions in the problem.
        set: usize,
        /// Index of the condition in its set.
        condition: usize,
        /// The variance given.
        found: f64,
    },
    /// Conditions that see the chain are not sorted by interval, or point outside the chain.
    #[error(
        "condition {condition} of set {set}: interval {found} is out of order or outside the chain's {intervals} intervals"
    )]
    BadInterval {
        /// Index of the set of conditions in the problem.
        set: usize,
        /// Index of the condition in its set.
        condition: usize,
        /// The interval given.
        found: u32,
        /// Number of intervals of the chain.
        intervals: usize,
    },
    /// Stopped by whoever watches.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// A block of parameters does not fit its chart.
    #[error("parameter block `{block}`: {what} has {found} entries, expected {expected}")]
    BadBlock {
        /// Name of the block.
        block: String,
        /// The part that does not fit.
        what: &'static str,
        /// Entries found.
        found: usize,
        /// Entries expected.
        expected: usize,
    },
    /// A covariance of a prior is not symmetric positive definite.
    #[error("parameter block `{block}`: the covariance of its prior is not positive definite")]
    BadPrior {
        /// Name of the block.
        block: String,
    },
    /// The chain of states is unusable.
    #[error("trajectory chain: {what} at {place} is {found}")]
    BadChain {
        /// The quantity concerned.
        what: &'static str,
        /// Epoch or process index.
        place: usize,
        /// Its value.
        found: f64,
    },
    /// An epoch's block of the normal matrix is not positive definite although every process has a proper prior.
    #[error("trajectory chain: the normal matrix of epoch {epoch} is not positive definite")]
    NotPositive {
        /// Epoch index.
        epoch: usize,
    },
    /// The file that holds what does not fit into memory failed.
    #[error(
        "cannot {what} in {folder}, where the adjustment keeps what exceeds its memory: {why}; free space there, name another folder in `[large] spill`, or raise `[large] factor_memory_mb`"
    )]
    NoSpill {
        /// What was tried.
        what: &'static str,
        /// Folder of the file.
        folder: String,
        /// What the system says.
        why: String,
    },
    /// Blocks of a chain are put together, and one is missing.
    #[error("block {block} of {blocks} of the trajectory chain is missing")]
    MissingBlock {
        /// Its number, from zero.
        block: usize,
        /// Blocks of the chain.
        blocks: usize,
    },
    /// Blocks of a chain are put together, and one came twice, or belongs to another chain.
    #[error(
        "block {block} of the trajectory chain came twice, or the chain's {blocks} blocks do not hold it"
    )]
    SurplusBlock {
        /// Its number, from zero.
        block: usize,
        /// Blocks of the chain.
        blocks: usize,
    },
    /// What another process asked or answered cannot be read.
    #[error(transparent)]
    Torn(Torn),
    /// A decomposition of the reduced normal matrix did not converge.
    #[error("the decomposition of the {size} x {size} reduced system did not converge")]
    NoDecomposition {
        /// Number of free columns.
        size: usize,
    },
    /// There is nothing to estimate from.
    #[error("{conditions} conditions and priors cannot determine {unknowns} unknowns")]
    TooFew {
        /// Conditions that take part, and scalar priors.
        conditions: usize,
        /// Free columns.
        unknowns: usize,
    },
    /// A condition depends on more parameters than a row holds.
    #[error(
        "condition {condition} of set {set}: {found} parameter columns, expected at most {most}"
    )]
    TooManyColumns {
        /// Index of the set of conditions in the problem.
        set: usize,
        /// Index of the condition in its set.
        condition: usize,
        /// Columns of the condition.
        found: usize,
        /// Columns that a row holds.
        most: usize,
    },
    /// A probability outside (0, 1).
    #[error("{what} is {found}, expected a probability strictly between 0 and 1")]
    BadProbability {
        /// The option concerned.
        what: &'static str,
        /// Its value.
        found: f64,
    },
}
