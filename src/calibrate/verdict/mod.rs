//! The verdict on an adjustment: does the model fit, and what if it had the unknowns that it has not?
//!
//! Every procedure ends here (`docs/verdict.md`). It names its cells, its doubts and its shares; the tests and
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
pub use doubts::{Doubt, Doubted};

use crate::results::{Finding, Severity, Verdict};

/// How a calibration ended before its verdict.
pub enum Ending<'a> {
    /// Nothing refused the result.
    Usable,
    /// This finding withdrew it.
    Withdrawn(&'a Finding),
    /// The procedure refused it, by code and in words; `determined` tells whether the data would have determined what is sought.
    Refused {
        /// Code of the refusal.
        code: &'a str,
        /// In words.
        seen: String,
        /// Whether the model is to blame and not the data's extent.
        determined: bool,
    },
}

/// The verdict: what ended the calibration first, then what the tests found; nothing was tested where nothing was judged.
#[must_use]
pub fn concluded(ending: Ending, doubted: Option<&Doubted>) -> Verdict {
    let found = doubted.cloned().unwrap_or_default();
    let mut verdict = ended(ending, found.findings);
    verdict.bounds = found.bounds;
    verdict
}

fn ended(ending: Ending, mut findings: Vec<Finding>) -> Verdict {
    match ending {
        Ending::Usable => Verdict::of(findings),
        Ending::Withdrawn(first) => {
            findings.retain(|finding| finding != first);
            findings.insert(0, first.clone());
            Verdict::of(findings)
        }
        Ending::Refused {
            code,
            seen,
            determined,
        } => {
            findings.insert(0, Finding::new(code, Severity::Refuses, seen, "", ""));
            if determined {
                Verdict::of(findings)
            } else {
                Verdict::not_determined(findings)
            }
        }
    }
}

/// The findings, those that the survey file accepts marked.
#[must_use]
pub fn accepted(mut findings: Vec<Finding>, config: &VerdictConfig) -> Vec<Finding> {
    for finding in &mut findings {
        finding.accepted = config.accept.contains(&finding.code);
    }
    findings
}
