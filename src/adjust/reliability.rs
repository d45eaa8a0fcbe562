//! Redundancy, normalised residuals and detectable biases of single conditions, in one pass without storing them.

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::condition::Row;
use super::error::AdjustError;
use super::kernel::Kernel;
use super::partition::{chunks, conditions_of, sees_chain};
use super::pass::{Pass, Weighted};
use super::problem::Problem;
use super::selected::{Covariances, each_window};
use super::solve::Solution;

/// Rows of a chunk of a set without chain.
const CHUNK: usize = 4096;
/// Redundancy below which a condition is uncontrolled and its normalised residual meaningless.
const CONTROLLED: f64 = 1e-6;

/// Figures of one condition.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionQuality {
    /// Set of conditions.
    pub set: usize,
    /// Index in the set.
    pub condition: usize,
    /// Observation group.
    pub group: u16,
    /// Residual of the condition, in its own unit.
    pub residual: f64,
    /// Standard deviation of its observations, in its own unit.
    pub sigma: f64,
    /// Redundancy number, 0 (uncontrolled) to 1 (no influence on the result).
    pub redundancy: f64,
    /// Residual over its own standard deviation, `w / (sigma sqrt r)`; zero where it is uncontrolled.
    pub normalised: f64,
    /// Effect of a bias of this condition that just escapes a test with non-centrality one on the columns sought
    /// ([`super::ParameterSet::sought_columns`]), each in its own unit.
    pub effects: Vec<f64>,
}

impl ConditionQuality {
    fn figures(&self) -> Figures {
        Figures {
            residual: self.residual,
            sigma: self.sigma,
            redundancy: self.redundancy,
            normalised: self.normalised,
        }
    }

    /// Smallest bias of the condition that a test with non-centrality `delta0` finds, in its own unit.
    pub fn detectable_bias(&self, delta0: f64) -> f64 {
        delta0 * self.sigma / self.redundancy.sqrt()
    }
}

/// How well one condition is controlled, for a table of all of them; NaN of one that took no part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Residual of the condition, in its own unit.
    pub residual: f64,
    /// Standard deviation of its observations, in its own unit.
    pub sigma: f64,
    /// Redundancy number, 0 (uncontrolled) to 1 (no influence on the result).
    pub redundancy: f64,
    /// Residual over its own standard deviation; zero where it is uncontrolled.
    pub normalised: f64,
}

impl Figures {
    const NONE: Self = Self {
        residual: f64::NAN,
        sigma: f64::NAN,
        redundancy: f64::NAN,
        normalised: f64::NAN,
    };
}

/// Sums over an observation group.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupQuality {
    /// Observation group.
    pub group: u16,
    /// Conditions that took part.
    pub conditions: usize,
    /// Sum of redundancy numbers.
    pub redundancy: f64,
    /// Weighted sum of squares, divided by what the kernel keeps of normal residuals: the redundancy on average if the stated noise is true.
    pub omega: f64,
    /// Largest normalised residual, without sign.
    pub largest_normalised: f64,
    /// Smallest redundancy number.
    pub smallest_redundancy: f64,
}

impl GroupQuality {
    /// Part of its sum of squares that a kernel keeps if the stated noise is true: its residuals scatter by the root of the mean
    /// redundancy number.
    pub(super) fn kept(&self, kernel: Kernel) -> f64 {
        let mean = self.redundancy / self.conditions.max(1) as f64;
        kernel.kept_of_normal(mean.clamp(0.0, 1.0).sqrt())
    }
}

/// Largest effect on a parameter of a bias that just escapes the test with non-centrality one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effect {
    /// Size, in the parameter's unit, per unit of non-centrality.
    pub size: f64,
    /// Set of the condition that causes it.
    pub set: usize,
    /// That condition.
    pub condition: usize,
}

/// What one pass over the conditions finds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Survey {
    pub groups: Vec<GroupQuality>,
    pub cells: Vec<GroupQuality>,
    pub worst: Vec<ConditionQuality>,
    /// Of the columns sought.
    pub effects: Vec<Effect>,
    /// Set, condition and figures of every condition, where all are asked for.
    all: Vec<(usize, usize, Figures)>,
}

impl Survey {
    fn new(sought: usize) -> Self {
        Survey {
            groups: vec![],
            cells: vec![],
            worst: vec![],
            effects: vec![Effect::default(); sought],
            all: vec![],
        }
    }

    fn count(&mut self, one: &ConditionQuality, cell: u16, effects: &[f64], kernel: Kernel) {
        let r = one.residual / one.sigma;
        let alone = GroupQuality {
            group: one.group,
            conditions: 1,
            redundancy: one.redundancy,
            omega: kernel.weight(r) * r * r,
            largest_normalised: one.normalised.abs(),
            smallest_redundancy: one.redundancy,
        };
        add_group(numbered(&mut self.groups, usize::from(one.group)), &alone);
        add_group(numbered(&mut self.cells, usize::from(cell)), &alone);
        for (largest, effect) in self.effects.iter_mut().zip(effects) {
            if effect.abs() > largest.size {
                *largest = Effect {
                    size: effect.abs(),
                    set: one.set,
                    condition: one.condition,
                };
            }
        }
    }

    fn merge(&mut self, other: Survey) {
        merge_groups(&mut self.groups, &other.groups);
        merge_groups(&mut self.cells, &other.cells);
        self.all.extend(other.all);
        for (mine, theirs) in self.effects.iter_mut().zip(other.effects) {
            if theirs.size > mine.size {
                *mine = theirs;
            }
        }
    }
}

/// The worst conditions among those looked at so far, by whichever thread.
#[derive(Default)]
struct Ranking {
    worst: Vec<ConditionQuality>,
    /// Normalised residual, without sign, below which nothing is ranked any more.
    floor: f64,
}

impl Ranking {
    /// Ranks a condition.
    fn rank(&mut self, mut one: ConditionQuality, effects: &[f64], keep: usize) {
        if one.normalised.abs() >= self.floor {
            one.effects = effects.to_vec();
            self.worst.push(one);
            self.cut_beyond(2 * keep + 64, keep);
        }
    }

    /// Takes up what another ranked.
    fn merge(&mut self, other: Ranking, keep: usize) {
        let floor = self.floor;
        let near = |one: &ConditionQuality| one.normalised.abs() >= floor;
        self.worst.extend(other.worst.into_iter().filter(near));
        self.cut_beyond(2 * keep + 64, keep);
    }

    fn cut_beyond(&mut self, most: usize, keep: usize) {
        if self.worst.len() >= most {
            self.cut(keep);
        }
    }

    /// Leaves the `keep` worst, worst first.
    fn cut(&mut self, keep: usize) {
        self.worst.sort_unstable_by(worse);
        self.worst.truncate(keep);
        if self.worst.len() == keep {
            self.floor = self.worst.last().map_or(0.0, |w| w.normalised.abs());
        }
    }
}

/// Worst first; the earlier one where they are alike.
fn worse(a: &ConditionQuality, b: &ConditionQuality) -> Ordering {
    let size = b.normalised.abs().total_cmp(&a.normalised.abs());
    size.then((a.set, a.condition).cmp(&(b.set, b.condition)))
}

fn empty_group(group: usize) -> GroupQuality {
    GroupQuality {
        group: group as u16,
        smallest_redundancy: 1.0,
        ..GroupQuality::default()
    }
}

/// The sums of this number, with empty ones before it where there are none yet.
fn numbered(groups: &mut Vec<GroupQuality>, number: usize) -> &mut GroupQuality {
    while groups.len() <= number {
        groups.push(empty_group(groups.len()));
    }
    &mut groups[number]
}

fn merge_groups(groups: &mut Vec<GroupQuality>, others: &[GroupQuality]) {
    for (i, other) in others.iter().enumerate() {
        add_group(numbered(groups, i), other);
    }
}

fn add_group(sum: &mut GroupQuality, other: &GroupQuality) {
    sum.conditions += other.conditions;
    sum.redundancy += other.redundancy;
    sum.omega += other.omega;
    sum.largest_normalised = sum.largest_normalised.max(other.largest_normalised);
    sum.smallest_redundancy = sum.smallest_redundancy.min(other.smallest_redundancy);
}

/// Judges every condition at a solution; the `keep` worst are returned one by one.
pub(super) fn survey(
    problem: &Problem,
    solution: &Solution,
    keep: usize,
) -> Result<Survey, AdjustError> {
    surveyed(problem, solution, keep, false)
}

/// Residual, sigma, redundancy and normalised residual of every condition, set by set: one more pass over the conditions.
///
/// # Errors
/// What a pass can find wrong with the conditions.
pub fn figures(problem: &Problem, solution: &Solution) -> Result<Vec<Vec<Figures>>, AdjustError> {
    let lengths = problem.sources.iter().map(|s| s.conditions.len());
    let mut sets: Vec<Vec<Figures>> = lengths.map(|n| vec![Figures::NONE; n]).collect();
    for (set, condition, one) in surveyed(problem, solution, 0, true)?.all {
        sets[set][condition] = one;
    }
    Ok(sets)
}

fn surveyed(
    problem: &Problem,
    solution: &Solution,
    keep: usize,
    all: bool,
) -> Result<Survey, AdjustError> {
    let judge = Judge {
        all,
        pass: Pass {
            problem,
            at: &solution.estimate,
            weighting: solution.weighting,
        },
        cofactor: &solution.cofactor,
        sought: solution.estimate.parameters.sought_columns(),
        kernel: solution.kernel,
        keep,
        ranking: Mutex::default(),
    };
    let mut sum = judge.without_chain()?;
    each_window(
        problem,
        solution,
        |window| judge.window(window),
        |part| sum.merge(part),
    )?;
    sum.worst = judge.worst();
    for group in sum.groups.iter_mut().chain(&mut sum.cells) {
        group.omega /= group.kept(solution.kernel);
    }
    Ok(sum)
}

struct Judge<'a> {
    pass: Pass<'a>,
    cofactor: &'a DMatrix<f64>,
    sought: Vec<usize>,
    kernel: Kernel,
    keep: usize,
    all: bool,
    ranking: Mutex<Ranking>,
}

impl Judge<'_> {
    /// The worst conditions of all, worst first. Which of them are left out meanwhile depends on the threads, which are left does not.
    fn worst(self) -> Vec<ConditionQuality> {
        let ranking = self.ranking.into_inner();
        let mut ranking = ranking.unwrap_or_else(PoisonError::into_inner);
        ranking.cut(self.keep);
        ranking.worst
    }

    fn ranked(&self) -> std::sync::MutexGuard<'_, Ranking> {
        self.ranking.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn without_chain(&self) -> Result<Survey, AdjustError> {
        let problem = self.pass.problem;
        let chunks = chunks(problem, CHUNK, |set| {
            problem.chain.is_none() || !sees_chain(problem, set)
        });
        let part = |(set, range)| self.range(set, range, None);
        let parts: Result<Vec<_>, AdjustError> = chunks.into_par_iter().map(part).collect();
        let mut sum = Survey::new(self.sought.len());
        parts?.into_iter().for_each(|part| sum.merge(part));
        Ok(sum)
    }

    fn window(&self, window: &Covariances) -> Result<Survey, AdjustError> {
        let mut sum = Survey::new(self.sought.len());
        for set in
            (0..self.pass.problem.sources.len()).filter(|set| sees_chain(self.pass.problem, *set))
        {
            let range = conditions_of(self.pass.problem, set, &window.intervals);
            sum.merge(self.range(set, range, Some(window))?);
        }
        Ok(sum)
    }

    fn range(
        &self,
        set: usize,
        range: Range<usize>,
        window: Option<&Covariances>,
    ) -> Result<Survey, AdjustError> {
        let mut sum = Survey::new(self.sought.len());
        let mut effects = vec![0.0; self.sought.len()];
        let mut own = Ranking {
            floor: self.ranked().floor,
            ..Ranking::default()
        };
        self.pass.visit(set, range, |weighted| {
            let variance = self.predict(weighted.row, window, &mut effects);
            let one = self.figures(set, weighted, variance);
            scale_to_undetected_bias(&mut effects, &one, weighted);
            let conditions = self.pass.problem.sources[set].conditions;
            let cell = conditions.cell(one.condition);
            sum.count(&one, cell, &effects, self.kernel);
            if self.all {
                sum.all.push((set, one.condition, one.figures()));
            }
            own.rank(one, &effects, self.keep);
        })?;
        self.ranked().merge(own, self.keep);
        Ok(sum)
    }

    /// Variance of a condition's prediction from parameters and states; `gain` becomes its cofactors with the columns sought.
    fn predict(&self, row: &Row, window: Option<&Covariances>, gain: &mut [f64]) -> f64 {
        let mut variance = self.predict_by_parameters(row, gain);
        if let (Some(chain), Some(window)) = (&row.chain, window) {
            variance += window.variance(chain);
            for (column, value) in row.columns().iter().zip(row.values()) {
                variance += 2.0 * value * window.with_column(chain, usize::from(*column));
            }
            for (gain, column) in gain.iter_mut().zip(&self.sought) {
                *gain += window.with_column(chain, *column);
            }
        }
        variance
    }

    fn predict_by_parameters(&self, row: &Row, gain: &mut [f64]) -> f64 {
        let mut variance = 0.0;
        gain.fill(0.0);
        for (column, value) in row.columns().iter().zip(row.values()) {
            let cofactors = self.cofactor.column(usize::from(*column));
            let cofactors = cofactors.as_slice();
            let terms = row.columns().iter().zip(row.values());
            let own: f64 = terms
                .map(|(other, a)| a * cofactors[usize::from(*other)])
                .sum();
            variance += value * own;
            for (gain, column) in gain.iter_mut().zip(&self.sought) {
                *gain += value * cofactors[*column];
            }
        }
        variance
    }

    fn figures(&self, set: usize, weighted: &Weighted, predicted: f64) -> ConditionQuality {
        let (residual, sigma) = (weighted.row.misclosure, weighted.variance.sqrt());
        let redundancy = (1.0 - weighted.weight * predicted).clamp(0.0, 1.0);
        let controlled = redundancy > CONTROLLED;
        let normalised = if controlled {
            residual / (sigma * redundancy.sqrt())
        } else {
            0.0
        };
        let condition = weighted.condition;
        let group = self.pass.problem.sources[set].conditions.group(condition);
        ConditionQuality {
            set,
            condition,
            group,
            residual,
            sigma,
            redundancy,
            normalised,
            effects: vec![],
        }
    }
}

/// Turns cofactors with the columns sought into what a bias that escapes a test with non-centrality one does to them:
/// `Q A^T M^-1` times that bias; zero where the condition is uncontrolled.
fn scale_to_undetected_bias(gain: &mut [f64], one: &ConditionQuality, weighted: &Weighted) {
    if one.redundancy <= CONTROLLED {
        return gain.fill(0.0);
    }
    let bias = weighted.weight * one.detectable_bias(1.0);
    gain.iter_mut().for_each(|gain| *gain *= bias);
}
