//! The adjustment engine, blind to instruments.
//!
//! [`Conditions`] over a [`ParameterSet`] and, optionally, a [`ChainModel`] make a [`Problem`]; [`solve`] turns a start into a
//! [`Solution`]; [`assess`] judges it.

mod accumulate;
mod bits;
mod block;
mod chain;
mod chart;
mod condition;
mod curvature;
mod derivatives;
mod elimination;
mod elsewhere;
mod error;
mod factor;
mod fit_test;
mod influence;
mod kernel;
mod large;
mod linearise;
mod mestimate;
mod numerics;
mod observability;
mod options;
mod orthogonal;
mod parameters;
mod partition;
mod pass;
mod problem;
mod quality;
mod refine;
mod reliability;
mod score;
mod selected;
mod solve;
mod spectrum;
mod store;
#[cfg(test)]
mod toys;

pub use bits::Bits;
pub use chain::{ChainModel, ChainState, Process, ProcessKind, VISIBLE};
pub use chart::{Chart, tangent_basis};
pub use condition::{ChainRow, Conditions, MAX_COLUMNS, Row};
pub use derivatives::{DerivativeFault, check_derivatives};
pub use elsewhere::{Elsewhere, Worker, shares};
pub use error::AdjustError;
pub use fit_test::{FitTest, PriorTest, beside_conditions, prior_tests};
pub use influence::{Influence, influence};
pub use kernel::Kernel;
pub use large::Large;
pub use numerics::fingerprint;
pub use observability::{Direction, Limits, Observability, Undetermined, WeakPair, observability};
pub use options::{Bending, IterationRecord, Options, Status};
pub use parameters::{Block, BlockId, Component, ParameterSet, Prior, PriorRow, Unit};
pub use problem::{Estimate, Problem, Source};
pub use quality::{
    ConditionTest, GlobalTest, Quality, QualityOptions, assess, condition_test, correlation,
};
pub use refine::{Snooped, VarianceComponent, VarianceComponents, snoop, variance_components};
pub use reliability::{ConditionQuality, Effect, Figures, GroupQuality, figures};
pub use score::{
    Jump, Score, ScoreColumns, ScoreOptions, Scores, Solved, Suspect, score_tests, score_tests_of,
};
pub use solve::{Solution, solve};
