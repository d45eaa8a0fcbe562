//! The result in one sentence.

use super::format::{ROWS, in_order, millimetres, plain, probability, shown, status};
use crate::results::{Comparison, PoolResult};

/// Level at which a difference of the paths is called significant.
pub const SIGNIFICANCE: f64 = 0.05;

/// What the reader must know first: why there is no usable result, or how much the joint path gains over the sequential one and whether
/// the difference is significant.
#[must_use]
pub fn headline(result: &PoolResult) -> String {
    if !result.usable {
        return refusal(result.reason.as_deref());
    }
    match &result.comparison {
        Some(comparison) => difference(comparison),
        None => single(result),
    }
}

fn refusal(reason: Option<&str>) -> String {
    format!(
        "No usable result: {}.",
        reason
            .unwrap_or("the run gave no reason")
            .trim_end_matches('.')
    )
}

fn difference(comparison: &Comparison) -> String {
    format!("{}; {}.", misfit(comparison), test(comparison))
}

fn misfit(comparison: &Comparison) -> String {
    let rms = &comparison.residual_rms_m;
    let verb = if rms.joint < rms.sequential {
        "brings"
    } else {
        "leaves"
    };
    format!(
        "The joint adjustment {verb} the soundings' RMS distance from the target {from} {before:.1} mm (sequential path) to {after:.1} mm and states \
         its uncertainty, which the sequential path cannot",
        from = if rms.joint < rms.sequential {
            "from"
        } else {
            "at"
        },
        before = millimetres(rms.sequential),
        after = millimetres(rms.joint),
    )
}

fn test(comparison: &Comparison) -> String {
    let (place, sigmas) = largest(comparison);
    let value = shown(
        comparison.difference.correction_deg,
        comparison.difference.lever_arm_m,
    )[place];
    let row = &ROWS[place];
    format!(
        "the two solutions differ by up to {sigmas:.1} standard deviations of the joint one ({name}, {value} {unit}), which is {verdict} \
         (chi-square {chi:.1} on 6 degrees of freedom, {p})",
        sigmas = sigmas.abs(),
        name = row.name,
        value = plain(value, row.unit),
        unit = row.unit,
        verdict = verdict(comparison.p_value),
        chi = comparison.chi_square,
        p = probability(comparison.p_value),
    )
}

fn largest(comparison: &Comparison) -> (usize, f64) {
    let sigmas = in_order(&comparison.in_joint_sigmas);
    sigmas
        .into_iter()
        .enumerate()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or((0, 0.0))
}

fn verdict(p_value: f64) -> &'static str {
    if p_value < SIGNIFICANCE {
        "significant"
    } else {
        "not significant"
    }
}

fn single(result: &PoolResult) -> String {
    let solutions = &result.solutions;
    if let Some(joint) = &solutions.joint {
        return format!(
            "The joint adjustment ended {}; there is no usable sequential solution to compare it with.",
            status(joint.status)
        );
    }
    solutions.sequential.as_ref().map_or_else(
        || "No path ran.".into(),
        |s| format!("The sequential path ended {}; only the joint adjustment, which did not run, would state an uncertainty.", status(s.status)),
    )
}
