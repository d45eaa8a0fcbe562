//! What every simulator's error sources have in common: a random stream and a switch each.

use std::collections::BTreeMap;

use rand::distr::{Distribution, StandardUniform};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::stats::{normal, stream};

/// The error sources of one simulator.
pub trait Sourced: Copy + Ord + 'static {
    /// Every source, in the order of the streams.
    fn all() -> &'static [Self];

    /// Number of the source's random stream: never renumbered.
    fn stream(self) -> u64;
}

/// Factors by which the scenario's errors are scaled, source by source: 1 where nothing is said, 0 switches a source off.
///
/// Only what really happens is scaled; the standard deviations that the survey claims stay as they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Factors<S: Ord>(BTreeMap<S, f64>);

impl<S: Ord> Default for Factors<S> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<S: Sourced> Factors<S> {
    /// Nothing goes wrong: every factor 0.
    #[must_use]
    pub fn none() -> Self {
        Self(S::all().iter().map(|&source| (source, 0.0)).collect())
    }

    /// Only these sources act, as the scenario says.
    #[must_use]
    pub fn only(sources: &[S]) -> Self {
        sources
            .iter()
            .fold(Self::none(), |all, &s| all.with(s, 1.0))
    }

    /// The same with one factor changed.
    #[must_use]
    pub fn with(mut self, source: S, factor: f64) -> Self {
        self.0.insert(source, factor);
        self
    }

    /// The factor of a source.
    #[must_use]
    pub fn factor(&self, source: S) -> f64 {
        self.0.get(&source).copied().unwrap_or(1.0)
    }

    /// What was said, source by source.
    pub fn iter(&self) -> impl Iterator<Item = (S, f64)> {
        self.0.iter().map(|(&source, &factor)| (source, factor))
    }
}

/// Words of the stream that each row (ping, scan line) may use; rows start at fixed places, so that a row's draws
/// do not depend on how many the rows before it took.
const WORDS_PER_ROW: u128 = 1 << 18;

/// The random numbers of one source.
pub(crate) struct Draws {
    generator: ChaCha8Rng,
    factor: f64,
}

impl Draws {
    /// The stream of `source` under `seed`, scaled by the source's factor.
    pub(crate) fn new<S: Sourced>(seed: u64, source: S, factors: &Factors<S>) -> Self {
        Self {
            generator: stream(seed, source.stream()),
            factor: factors.factor(source),
        }
    }

    /// Goes to the beginning of a row.
    pub(crate) fn seek(&mut self, row: u64) {
        self.generator.set_word_pos(u128::from(row) * WORDS_PER_ROW);
    }

    /// The source's factor.
    pub(crate) fn factor(&self) -> f64 {
        self.factor
    }

    /// A normal error with this standard deviation, scaled by the source's factor.
    pub(crate) fn normal(&mut self, sigma: f64) -> f64 {
        normal::draw(&mut self.generator) * sigma * self.factor
    }

    /// A uniform number in [0, 1), not scaled.
    pub(crate) fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.generator)
    }
}
