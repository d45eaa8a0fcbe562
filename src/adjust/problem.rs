//! A problem: sets of conditions over parameters and, optionally, a chain.

use super::bits::Bits;
use super::chain::{ChainModel, ChainState};
use super::condition::Conditions;
use super::elsewhere::Elsewhere;
use super::large::Large;
use super::parameters::ParameterSet;
use crate::watch::Watch;

/// A set of conditions with what is switched about it.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The conditions.
    pub conditions: &'a dyn Conditions,
    /// A mark switches a condition off (after data snooping); `None` leaves all on. As long as the set.
    pub ignored: Option<&'a Bits>,
}

impl<'a> Source<'a> {
    /// All conditions of a set, none ignored.
    pub fn new(conditions: &'a dyn Conditions) -> Self {
        Source {
            conditions,
            ignored: None,
        }
    }

    /// Whether condition `k` takes part.
    #[inline]
    pub fn takes_part(&self, k: usize) -> bool {
        self.ignored.is_none_or(|ignored| !ignored.get(k))
    }
}

/// Everything that is known except the answer.
#[derive(Clone, Default)]
pub struct Problem<'a> {
    /// Sets of conditions.
    pub sources: Vec<Source<'a>>,
    /// States along the trajectory, if any condition sees them.
    pub chain: Option<&'a ChainModel>,
    /// How a long chain is worked on.
    pub large: Large,
    /// Variance component per observation group; multiplies each condition's variance. Groups beyond the list have one.
    pub components: Vec<f64>,
    /// Who watches the passes over the conditions and may stop them.
    pub watch: Option<&'a dyn Watch>,
    /// Who works on the blocks of a long chain in other processes. What was solved so is judged with the same conditions switched off.
    pub elsewhere: Option<&'a dyn Elsewhere>,
}

impl<'a> Problem<'a> {
    /// A problem without chain.
    pub fn dense(sources: Vec<Source<'a>>) -> Self {
        Problem {
            sources,
            ..Self::default()
        }
    }

    /// A problem over a chain.
    pub fn with_chain(sources: Vec<Source<'a>>, chain: &'a ChainModel) -> Self {
        Problem {
            sources,
            chain: Some(chain),
            ..Self::default()
        }
    }

    /// The same, watched.
    #[must_use]
    pub fn watched<'b>(&self, watch: &'b dyn Watch) -> Problem<'b>
    where
        'a: 'b,
    {
        let mut problem: Problem<'b> = self.clone();
        problem.watch = Some(watch);
        problem
    }

    /// Tells how far a pass is.
    pub(super) fn counted(&self, done: usize, of: usize) {
        if let Some(watch) = self.watch {
            watch.counted(done, of);
        }
    }

    /// Variance component of a group.
    #[inline]
    pub fn component(&self, group: u16) -> f64 {
        self.components.get(group as usize).copied().unwrap_or(1.0)
    }

    /// Conditions that take part.
    pub fn condition_count(&self) -> usize {
        let ignored = |source: &Source| source.ignored.map_or(0, Bits::count);
        self.sources
            .iter()
            .map(|source| source.conditions.len() - ignored(source))
            .sum()
    }
}

/// Parameters and states: where a solve starts and what it returns.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Parameters.
    pub parameters: ParameterSet,
    /// States, when the problem has a chain; `None` starts them at zero.
    pub chain: Option<ChainState>,
}

impl Estimate {
    /// A start with all states at zero.
    pub fn new(parameters: ParameterSet) -> Self {
        Estimate {
            parameters,
            chain: None,
        }
    }
}
