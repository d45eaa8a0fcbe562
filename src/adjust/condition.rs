//! Conditions: what observations demand of the parameters.
//!
//! Gauss-Helmert model (Niemeier, *Ausgleichungsrechnung*, 2008, ch. 5): each scalar condition
//! `f(x, s, l) = 0` is linearised at the current parameters `x`, chain states `s` and **adjusted** observations `l_adj`,
//! `w + A dx + C ds + B v = 0` with `w = f(x, s, l_adj) + B (l - l_adj)` and variance `m = B S B^T`. The implementer
//! evaluates the adjusted observations; the engine sees `w`, `m`, `A` and `C`.

use std::ops::Range;

use super::chain::{ChainState, VISIBLE};
use super::parameters::ParameterSet;

/// Largest number of parameter columns of one condition; one with more is refused by name ([`super::AdjustError::TooManyColumns`]).
pub const MAX_COLUMNS: usize = 48;

/// How a condition sees the chain: `weight0 y_k + weight1 y_(k+1)` at interval `k`, through its derivatives by `y`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ChainRow {
    /// Interval between epoch `interval` and the next; must equal [`Conditions::interval`].
    pub interval: u32,
    /// Weight of the interval's first epoch.
    pub weight0: f64,
    /// Weight of its second epoch.
    pub weight1: f64,
    /// Derivatives by the interpolated visible quantities (condition unit per component unit).
    pub visible: [f64; VISIBLE],
}

/// One linearised condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Misclosure `w` with current parameters and chain states in it.
    pub misclosure: f64,
    /// Its variance `B S B^T` from the observations alone, in squared units of the misclosure.
    pub variance: f64,
    /// Derivatives by the chain, for conditions that see it.
    pub chain: Option<ChainRow>,
    /// Columns asked for, of which the first [`MAX_COLUMNS`] are kept.
    asked: usize,
    columns: [u16; MAX_COLUMNS],
    values: [f64; MAX_COLUMNS],
}

impl Default for Row {
    fn default() -> Self {
        let (columns, values) = ([0; MAX_COLUMNS], [0.0; MAX_COLUMNS]);
        Row {
            misclosure: f64::NAN,
            variance: f64::NAN,
            chain: None,
            asked: 0,
            columns,
            values,
        }
    }
}

impl Row {
    /// Forgets everything; misclosure and variance become NaN so that an unfilled row is noticed.
    pub fn clear(&mut self) {
        self.misclosure = f64::NAN;
        self.variance = f64::NAN;
        self.chain = None;
        self.asked = 0;
    }

    /// Appends one derivative by the parameter column `column` (a column may appear once). A row that is asked for more than
    /// [`MAX_COLUMNS`] is refused when it is used.
    #[inline]
    pub fn push(&mut self, column: usize, value: f64) {
        if self.asked < MAX_COLUMNS {
            self.columns[self.asked] = column as u16;
            self.values[self.asked] = value;
        }
        self.asked += 1;
    }

    /// Columns that were asked for; beyond [`MAX_COLUMNS`] the row does not hold them all.
    #[inline]
    pub fn asked(&self) -> usize {
        self.asked
    }

    /// Appends derivatives by consecutive columns.
    #[inline]
    pub fn extend(&mut self, first_column: usize, values: &[f64]) {
        for (i, value) in values.iter().enumerate() {
            self.push(first_column + i, *value);
        }
    }

    /// Columns with derivatives.
    #[inline]
    pub fn columns(&self) -> &[u16] {
        &self.columns[..self.asked.min(MAX_COLUMNS)]
    }

    /// Derivatives, beside [`Row::columns`].
    #[inline]
    pub fn values(&self) -> &[f64] {
        &self.values[..self.asked.min(MAX_COLUMNS)]
    }
}

/// A set of scalar conditions of one kind.
pub trait Conditions: Sync {
    /// Number of conditions.
    fn len(&self) -> usize;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Observation group of condition `k`, for variance components and group figures.
    fn group(&self, _k: usize) -> u16 {
        0
    }

    /// Cell of condition `k` for the tests of parts (a sensor's observations of one face in one pass); the group unless told otherwise.
    fn cell(&self, k: usize) -> u16 {
        self.group(k)
    }

    /// Chain interval that condition `k` sees, or `None` for a whole set that sees none. Must not decrease with `k`.
    fn interval(&self, _k: usize) -> Option<u32> {
        None
    }

    /// Linearises condition `k` into a cleared row. A failure is told by a misclosure that is not a number.
    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row);

    /// Linearises a range of conditions into rows of the same number. Override it to hoist what the conditions share.
    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        chain: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        for (k, row) in range.zip(rows) {
            row.clear();
            self.linearise(k, x, chain, row);
        }
    }
}
