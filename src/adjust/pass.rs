//! One pass over conditions: linearises and weighs them, in order.

use std::ops::Range;

use super::condition::{MAX_COLUMNS, Row};
use super::error::AdjustError;
use super::kernel::Kernel;
use super::problem::{Estimate, Problem};

/// Rows linearised at a time: they stay in the first-level caches.
const ROWS: usize = 32;
/// How residuals weigh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Weighting {
    /// By a kernel at the current residual.
    Kernel(Kernel),
    /// All alike; for the covariance under a kernel.
    Uniform(f64),
}

impl Weighting {
    #[inline]
    fn weight(self, r: f64) -> f64 {
        match self {
            Weighting::Kernel(kernel) => kernel.weight(r),
            Weighting::Uniform(weight) => weight,
        }
    }

    fn kernel(self) -> Kernel {
        match self {
            Weighting::Kernel(kernel) => kernel,
            Weighting::Uniform(_) => Kernel::LeastSquares,
        }
    }
}

/// Sums over residuals, in sigmas.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Tally {
    /// Sum of `rho`.
    pub cost: f64,
    /// Conditions that took part.
    pub conditions: usize,
    /// Sum of `weight r^2`.
    pub omega: f64,
    /// Sum of `psi^2`.
    pub influence_square: f64,
    /// Sum of `psi'`.
    pub slope: f64,
    /// Sum of its square.
    pub slope_square: f64,
}

impl Tally {
    pub(super) fn add(&mut self, other: &Tally) {
        self.cost += other.cost;
        self.conditions += other.conditions;
        self.omega += other.omega;
        self.influence_square += other.influence_square;
        self.slope += other.slope;
        self.slope_square += other.slope_square;
    }

    #[inline]
    fn count(&mut self, kernel: Kernel, r: f64, weight: f64) {
        self.conditions += 1;
        self.omega += weight * r * r;
        if kernel.is_least_squares() {
            self.cost += 0.5 * r * r;
            return;
        }
        self.cost += kernel.rho(r);
        self.influence_square += kernel.influence(r).powi(2);
        self.slope += kernel.slope(r);
        self.slope_square += kernel.slope(r).powi(2);
    }
}

/// A linearised condition with its weight, as a pass sees it.
pub(super) struct Weighted<'r> {
    /// Index in its set.
    pub condition: usize,
    /// The linearised condition.
    pub row: &'r Row,
    /// Its variance with the variance component of its group.
    pub variance: f64,
    /// Kernel weight over variance.
    pub weight: f64,
}

/// Where the conditions of a pass are linearised and how they weigh.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a> {
    pub problem: &'a Problem<'a>,
    pub at: &'a Estimate,
    pub weighting: Weighting,
}

impl Pass<'_> {
    /// Linearises the conditions `range` of a set, in order, and hands each one that takes part to `visit`.
    pub(super) fn visit(
        &self,
        set: usize,
        range: Range<usize>,
        mut visit: impl FnMut(&Weighted),
    ) -> Result<Tally, AdjustError> {
        if let Some(watch) = self.problem.watch {
            watch.go_on()?;
        }
        let mut rows = [Row::default(); ROWS];
        let mut tally = Tally::default();
        let source = &self.problem.sources[set];
        for start in range.clone().step_by(ROWS) {
            let chunk = start..(start + ROWS).min(range.end);
            let rows = &mut rows[..chunk.len()];
            source.conditions.linearise_range(
                chunk.clone(),
                &self.at.parameters,
                self.at.chain.as_ref(),
                rows,
            );
            for (condition, row) in chunk.zip(rows) {
                if source.takes_part(condition) {
                    visit(&self.weigh(set, condition, row, &mut tally)?);
                }
            }
        }
        Ok(tally)
    }

    #[inline]
    fn weigh<'r>(
        &self,
        set: usize,
        condition: usize,
        row: &'r Row,
        tally: &mut Tally,
    ) -> Result<Weighted<'r>, AdjustError> {
        let mut variance = row.variance;
        if !self.problem.components.is_empty() {
            variance *= self
                .problem
                .component(self.problem.sources[set].conditions.group(condition));
        }
        let r = row.misclosure / variance.sqrt();
        if !(r.is_finite() && variance > 0.0 && row.asked() <= MAX_COLUMNS) {
            return Err(fault(set, condition, row, variance));
        }
        let kernel_weight = self.weighting.weight(r);
        tally.count(self.weighting.kernel(), r, kernel_weight);
        Ok(Weighted {
            condition,
            row,
            variance,
            weight: kernel_weight / variance,
        })
    }
}

fn fault(set: usize, condition: usize, row: &Row, variance: f64) -> AdjustError {
    if row.asked() > MAX_COLUMNS {
        return AdjustError::TooManyColumns {
            set,
            condition,
            found: row.asked(),
            most: MAX_COLUMNS,
        };
    }
    if !row.misclosure.is_finite() {
        return AdjustError::NotFinite {
            set,
            condition,
            what: "misclosure",
            found: row.misclosure,
        };
    }
    AdjustError::BadVariance {
        set,
        condition,
        found: variance,
    }
}
