//! Fixed cuts of the work: chunks of rows and windows of the chain.
//!
//! They depend on the problem alone and sums are reduced in their order, so results have the same bytes on any number of threads.

use std::ops::Range;

use rayon::prelude::*;

use super::chain::ChainModel;
use super::error::AdjustError;
use super::large::Large;
use super::problem::Problem;

/// Intervals of a window of the chain.
const WINDOW: usize = 64;
/// Chunks of rows of the sets for which `wanted` holds, in order.
pub(super) fn chunks(
    problem: &Problem,
    size: usize,
    wanted: impl Fn(usize) -> bool,
) -> Vec<(usize, Range<usize>)> {
    let mut chunks = Vec::new();
    for (set, source) in problem
        .sources
        .iter()
        .enumerate()
        .filter(|(set, _)| wanted(*set))
    {
        let len = source.conditions.len();
        chunks.extend(
            (0..len)
                .step_by(size)
                .map(|start| (set, start..(start + size).min(len))),
        );
    }
    chunks
}

/// Whether the conditions of a set see the chain.
pub(super) fn sees_chain(problem: &Problem, set: usize) -> bool {
    let conditions = problem.sources[set].conditions;
    !conditions.is_empty() && conditions.interval(0).is_some()
}

/// Blocks of a chain, in order: the intervals between two cuts. The epochs where they meet are the cuts.
pub(super) fn blocks(model: &ChainModel, large: &Large) -> Vec<Range<usize>> {
    steps(&(0..model.intervals()), large.block_records.max(2))
}

/// Windows of a block, in order.
pub(super) fn windows(block: &Range<usize>) -> Vec<Range<usize>> {
    steps(block, WINDOW)
}

fn steps(range: &Range<usize>, size: usize) -> Vec<Range<usize>> {
    let cut = |start: usize| start..start.saturating_add(size).min(range.end);
    range.clone().step_by(size).map(cut).collect()
}

/// Blocks that are worked on at a time: what they hold in memory meanwhile is bounded.
const WAVE: usize = 8;

/// Does work for blocks, beside one another, and hands out the results in the blocks' order.
pub(super) fn in_waves<B: Send, T: Send>(
    blocks: impl Iterator<Item = B>,
    work: impl Fn(B) -> Result<T, AdjustError> + Sync,
    mut take: impl FnMut(T),
) -> Result<(), AdjustError> {
    let mut blocks = blocks.fuse();
    loop {
        let wave: Vec<B> = blocks.by_ref().take(WAVE).collect();
        if wave.is_empty() {
            return Ok(());
        }
        let done: Vec<_> = wave.into_par_iter().map(&work).collect();
        for result in done {
            take(result?);
        }
    }
}

/// Conditions of a set that see the intervals of a window.
pub(super) fn conditions_of(
    problem: &Problem,
    set: usize,
    intervals: &Range<usize>,
) -> Range<usize> {
    first_at_or_after(problem, set, intervals.start)..first_at_or_after(problem, set, intervals.end)
}

fn first_at_or_after(problem: &Problem, set: usize, interval: usize) -> usize {
    let conditions = problem.sources[set].conditions;
    let (mut low, mut high) = (0, conditions.len());
    while low < high {
        let middle = low + (high - low) / 2;
        match conditions.interval(middle) {
            Some(found) if (found as usize) < interval => low = middle + 1,
            _ => high = middle,
        }
    }
    low
}

/// Conditions whose intervals are checked by one task.
const CHECKED: usize = 65_536;

/// Checks that every set that sees the chain is sorted by interval and inside it.
pub(super) fn check_intervals(problem: &Problem) -> Result<(), AdjustError> {
    let chunks = chunks(problem, CHECKED, |set| sees_chain(problem, set));
    let faults: Vec<Option<AdjustError>> = chunks
        .into_par_iter()
        .map(|(set, range)| first_fault(problem, set, range))
        .collect();
    faults.into_iter().flatten().next().map_or(Ok(()), Err)
}

fn first_fault(problem: &Problem, set: usize, range: Range<usize>) -> Option<AdjustError> {
    let intervals = problem.chain.map_or(0, ChainModel::intervals);
    let interval = |condition| {
        let conditions = problem.sources[set].conditions;
        conditions.interval(condition).unwrap_or(u32::MAX)
    };
    let mut before = range.start.checked_sub(1).map_or(0, interval);
    for condition in range {
        let found = interval(condition);
        if found < before || found as usize >= intervals {
            return Some(AdjustError::BadInterval {
                set,
                condition,
                found,
                intervals,
            });
        }
        before = found;
    }
    None
}
