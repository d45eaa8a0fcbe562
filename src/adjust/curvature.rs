//! Second order of the conditions along a step: geodesic acceleration.
//!
//! Transtrum & Sethna, "Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares minimization", 2012,
//! eq. 9-15: the step `v` is bent by `a = -1/2 (J^T J + damping)^-1 J^T r''`, and refused where `2 |a| > 0.75 |v|`, for there the
//! linear model does not reach that far.

use std::ops::Range;

use rayon::prelude::*;

use super::condition::Row;
use super::error::AdjustError;
use super::partition::chunks;
use super::pass::Pass;
use super::problem::Estimate;

/// Part of the step over which the second difference is taken.
pub(super) const REACH: f64 = 0.1;
/// Largest bend of an acceptable step.
pub(super) const LARGEST_BEND: f64 = 0.75;
/// Rows of a chunk.
const CHUNK: usize = 1024;

/// `J^T W r''` over all columns, `r''` the second derivative of the conditions along `step`, by the difference to `ahead`, which
/// lies [`REACH`] of the step away. Without a chain.
pub(super) fn curvature(
    pass: &Pass,
    ahead: &Estimate,
    step: &[f64],
) -> Result<Vec<f64>, AdjustError> {
    let chunks = chunks(pass.problem, CHUNK, |_| true);
    let part = |(set, range): (usize, Range<usize>)| chunk_curvature(pass, ahead, step, set, range);
    let parts: Result<Vec<_>, AdjustError> = chunks.into_par_iter().map(part).collect();
    let mut sum = vec![0.0; step.len()];
    for part in parts? {
        sum.iter_mut()
            .zip(part)
            .for_each(|(sum, part)| *sum += part);
    }
    Ok(sum)
}

fn chunk_curvature(
    pass: &Pass,
    ahead: &Estimate,
    step: &[f64],
    set: usize,
    range: Range<usize>,
) -> Result<Vec<f64>, AdjustError> {
    let conditions = pass.problem.sources[set].conditions;
    let mut sum = vec![0.0; step.len()];
    let mut there = Row::default();
    pass.visit(set, range, |weighted| {
        there.clear();
        conditions.linearise(weighted.condition, &ahead.parameters, None, &mut there);
        let entries = || {
            weighted
                .row
                .columns()
                .iter()
                .map(|c| usize::from(*c))
                .zip(weighted.row.values())
        };
        let slope: f64 = entries().map(|(column, value)| value * step[column]).sum();
        let rise = (there.misclosure - weighted.row.misclosure) / REACH;
        let second = 2.0 / REACH * (rise - slope);
        entries().for_each(|(column, value)| sum[column] += weighted.weight * value * second);
    })?;
    Ok(sum)
}
