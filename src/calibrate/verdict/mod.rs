//! The verdict on an adjustment: does the model fit, and what if it had the unknowns that it has not?
//!
//! Every procedure ends here (mathematics section 10, `docs/verdict.md`). It names its cells, its doubts and its shares; the tests and
//! their words are the same for all:
//!
//! | file | what |
//! |---|---|
//! | [`config`] | the `[verdict]` section |
//! | [`fit`] | global test, tests of parts, of priors and of the chain |
//! | [`doubts`] | score tests of unknowns that the model could have |
//! | [`bounds`] | size of the corrections, shares of the observations |
//! | [`alternatives`] | which discrete mistake turns a misfit into a fit |

pub mod alternatives;
pub mod bounds;
pub mod config;
pub mod doubts;
pub mod fit;

pub use alternatives::{Alternative, Tried};
pub use config::VerdictConfig;
pub use doubts::{Bound, Doubt, Doubted};

use crate::results::{Finding, Verdict};

/// The verdict on findings, those that the survey file accepts marked.
#[must_use]
pub fn verdict(findings: Vec<Finding>, config: &VerdictConfig) -> Verdict {
    Verdict::of(accepted(findings, config))
}

/// The findings, those that the survey file accepts marked.
#[must_use]
pub fn accepted(mut findings: Vec<Finding>, config: &VerdictConfig) -> Vec<Finding> {
    for finding in &mut findings {
        finding.accepted = config.accept.contains(&finding.code);
    }
    findings
}
