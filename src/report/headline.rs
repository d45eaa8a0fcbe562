//! The verdict in one sentence, and how a difference of the paths reads.

use super::format::{probability, shown};
use crate::results::{Calibration, Comparison};

/// Level at which a difference of the paths is called significant.
pub const SIGNIFICANCE: f64 = 0.05;

/// What the reader must know first: whether the numbers may be used, and why not.
#[must_use]
pub fn headline(result: &Calibration) -> String {
    if !result.usable {
        return format!("No usable result: {}.", because(result));
    }
    let first = result.verdict.findings.first();
    let state = match first {
        Some(found) => format!("Usable, with something to look at: {}.", ended(&found.seen)),
        None => "Usable.".to_owned(),
    };
    if result.solutions.joint.is_some() {
        return state;
    }
    format!("{state} Without standard deviations: the joint path, which states them, did not run.")
}

/// Why there is no usable result, without a full stop.
fn because(result: &Calibration) -> &str {
    let reason = result.reason.as_deref();
    ended(reason.unwrap_or("the run gave no reason"))
}

/// Without the full stop that it may have.
fn ended(sentence: &str) -> &str {
    sentence.trim_end_matches('.')
}

/// How far the two paths are apart, in one sentence.
#[must_use]
pub fn difference(comparison: &Comparison) -> String {
    let Some(largest) = comparison.largest() else {
        return String::new();
    };
    let verdict = if comparison.p_value < SIGNIFICANCE {
        "significant"
    } else {
        "not significant"
    };
    format!(
        "The two solutions differ most in {name}: {value} {unit}, {sigmas:.1} standard deviations of the joint solution. All differences together \
         are {verdict}: chi-square {chi:.1} on {free} degrees of freedom, {p}.",
        name = largest.name,
        value = shown(largest.difference, &largest.unit),
        unit = unit_after(&largest.unit),
        sigmas = largest.in_joint_sigmas.abs(),
        chi = comparison.chi_square,
        free = comparison.degrees_of_freedom,
        p = probability(comparison.p_value),
    )
}

/// A ratio has no unit to print.
fn unit_after(unit: &str) -> &str {
    if unit == "1" { "as a ratio" } else { unit }
}
