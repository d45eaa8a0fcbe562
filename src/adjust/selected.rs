//! Selected inverse: the covariance blocks that single conditions need, by backward recursion over the factor.
//!
//! From `s_k = L^-T (e - U s_(k+1) - W x)` with unit white `e` (Takahashi's equations in block form; Triggs et al. 2000,
//! app. B.4):
//! `Q_kx = -L^-T (U Q_(k+1)x + W Q_xx)`, `Q_k(k+1) = -L^-T (U Q_(k+1)(k+1) + W Q_x(k+1))`,
//! `Q_kk = L^-T (L^-1 - U Q_(k+1)k - W Q_xk)`. First over the cuts, then inside each block from the cofactors of its cuts, those of
//! the first one among the columns `x`.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::block::ChainFactor;
use super::chain::{ChainModel, VISIBLE};
use super::condition::ChainRow;
use super::error::AdjustError;
use super::factor::{Factor, Square, dot, with_size};
use super::linearise::factor_here;
use super::partition::{in_waves, windows};
use super::problem::Problem;
use super::solve::Solution;
use super::store::Reader;

/// Windows of a block at a time.
const BATCH: usize = 16;

type Block = [[f64; VISIBLE]; VISIBLE];

/// Cofactors of the visible quantities of a stretch of epochs.
pub(super) struct Covariances {
    /// Intervals covered; one epoch more than intervals.
    pub intervals: Range<usize>,
    columns: usize,
    own: Vec<Block>,
    next: Vec<Block>,
    /// All columns by visible quantities, epoch after epoch.
    border: Vec<f64>,
}

impl Covariances {
    /// Variance of a condition's prediction from the visible quantities alone.
    pub(super) fn variance(&self, chain: &ChainRow) -> f64 {
        let local = chain.interval as usize - self.intervals.start;
        let (w0, w1, v) = (chain.weight0, chain.weight1, &chain.visible);
        w0 * w0 * form(&self.own[local], v)
            + w1 * w1 * form(&self.own[local + 1], v)
            + 2.0 * w0 * w1 * form(&self.next[local], v)
    }

    /// Cofactor of a condition's interpolated visible quantities, weighted by its derivatives, with a column.
    pub(super) fn with_column(&self, chain: &ChainRow, column: usize) -> f64 {
        let local = chain.interval as usize - self.intervals.start;
        let at = |epoch: usize| {
            let start = (epoch * self.columns + column) * VISIBLE;
            dot(&self.border[start..start + VISIBLE], &chain.visible)
        };
        chain.weight0 * at(local) + chain.weight1 * at(local + 1)
    }
}

/// `v^T Q v`.
fn form(q: &Block, v: &[f64; VISIBLE]) -> f64 {
    q.iter().zip(v).map(|(row, a)| a * dot(row, v)).sum()
}

/// Cofactors at the ends of a block.
pub(super) struct Ends {
    /// States of the first cut, if there is one, and free columns: of them all together.
    columns: DMatrix<f64>,
    /// States of the last cut, if there is one, by themselves and by those columns.
    last: Option<Recursion>,
}

impl Ends {
    /// Of every block, from the factor over the cuts and the cofactors of the free columns.
    pub(super) fn of_cuts(cuts: &Factor, parameters: &DMatrix<f64>) -> Vec<Ends> {
        let mut recursion = Recursion::new(cuts.size, parameters.ncols());
        let mut ends = Vec::new();
        let mut last: Option<Recursion> = None;
        for cut in cuts.epochs.clone().rev() {
            let ahead =
                with_size!(cuts.size, N => recursion.step::<N>(cuts, cut, parameters).concat());
            ends.push(Ends {
                columns: recursion.with(parameters),
                last: last.map(|last| last.beside(&ahead)),
            });
            last = Some(recursion.clone());
        }
        ends.push(Ends {
            columns: parameters.clone(),
            last,
        });
        ends.reverse();
        ends
    }
}

/// Cofactors of an epoch: what the recursion hands from one to the one before.
#[derive(Clone)]
struct Recursion {
    /// States by themselves, by rows.
    own: Vec<f64>,
    /// States by columns, by rows.
    border: Vec<f64>,
}

impl Recursion {
    /// Behind the last epoch.
    fn new(size: usize, width: usize) -> Self {
        Recursion {
            own: vec![0.0; size * size],
            border: vec![0.0; size * width],
        }
    }

    /// The epoch and the columns together.
    fn with(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let (width, size) = (columns.ncols(), self.own.len().isqrt());
        DMatrix::from_fn(size + width, size + width, |i, j| {
            match (i < size, j < size) {
                (true, true) => self.own[i * size + j],
                (true, false) => self.border[i * width + j - size],
                (false, true) => self.border[j * width + i - size],
                (false, false) => columns[(i - size, j - size)],
            }
        })
    }

    /// The same with the states of an epoch before as columns in front of the others; `before` holds that epoch by this one.
    fn beside(self, before: &[f64]) -> Self {
        let size = self.own.len().isqrt();
        let width = self.border.len() / size;
        let mut border = Vec::with_capacity(size * (size + width));
        for i in 0..size {
            border.extend((0..size).map(|j| before[j * size + i]));
            border.extend_from_slice(&self.border[i * width..(i + 1) * width]);
        }
        Recursion {
            own: self.own,
            border,
        }
    }

    /// Moves to the epoch before; returns the cofactors between it and the one it comes from.
    fn step<const N: usize>(
        &mut self,
        factor: &Factor,
        epoch: usize,
        columns: &DMatrix<f64>,
    ) -> Square<N> {
        let (upper, width) = (factor.upper::<N>(epoch), columns.ncols());
        let cross = self.cross(factor, &upper, epoch, width);
        let border = self.stepped_border(factor, &upper, epoch, columns);
        let mut own = inverse(&upper);
        for (i, row) in own.iter_mut().enumerate() {
            let (next, weights) = factor.row(epoch, i);
            for (j, entry) in row.iter_mut().enumerate() {
                *entry -= dot(next, &cross[j]) + dot(&border[j * width..(j + 1) * width], weights);
            }
        }
        backward(&upper, own.as_flattened_mut(), N);
        self.own.copy_from_slice(own.as_flattened());
        self.border = border;
        cross
    }

    /// `Q_k(k+1)`.
    fn cross<const N: usize>(
        &self,
        factor: &Factor,
        upper: &Square<N>,
        epoch: usize,
        width: usize,
    ) -> Square<N> {
        let mut cross = [[0.0; N]; N];
        for (i, row) in cross.iter_mut().enumerate() {
            let (next, weights) = factor.row(epoch, i);
            for (factor, ahead) in next.iter().zip(self.own.chunks_exact(N)) {
                add(row, -factor, ahead);
            }
            for (j, entry) in row.iter_mut().enumerate() {
                *entry -= dot(&self.border[j * width..(j + 1) * width], weights);
            }
        }
        backward(upper, cross.as_flattened_mut(), N);
        cross
    }

    /// `Q_kx`.
    fn stepped_border<const N: usize>(
        &self,
        factor: &Factor,
        upper: &Square<N>,
        epoch: usize,
        columns: &DMatrix<f64>,
    ) -> Vec<f64> {
        let width = columns.ncols();
        let mut border = vec![0.0; N * width];
        for (i, row) in border.chunks_exact_mut(width.max(1)).enumerate() {
            let (next, weights) = factor.row(epoch, i);
            for (factor, ahead) in next.iter().zip(self.border.chunks_exact(width)) {
                add(row, -factor, ahead);
            }
            for (factor, cofactors) in weights.iter().zip(columns.column_iter()) {
                add(row, -factor, cofactors.as_slice());
            }
        }
        backward(upper, &mut border, width);
        border
    }
}

/// The recursion over a block, from its last epoch to its first.
struct Backward<'a> {
    model: &'a ChainModel,
    reader: Reader<'a>,
    size: usize,
    free: &'a [usize],
    /// Columns in all, held ones included.
    columns: usize,
    ends: &'a Ends,
    /// Of the epoch last visited.
    here: Recursion,
    started: bool,
}

impl<'a> Backward<'a> {
    fn new(survey: &Chain<'a>, block: usize, ends: &'a Ends) -> Self {
        let size = survey.factor.cuts.size;
        let behind = || Recursion::new(size, ends.columns.ncols());
        Backward {
            model: survey.model,
            reader: survey.factor.reader(block),
            size,
            free: survey.free,
            columns: survey.columns,
            here: ends.last.clone().unwrap_or_else(behind),
            started: ends.last.is_some(),
            ends,
        }
    }

    /// Cofactors of a window's epochs. Windows must come from the last to the first.
    fn window(
        &mut self,
        intervals: Range<usize>,
        block: &Range<usize>,
    ) -> Result<Covariances, AdjustError> {
        let epochs = intervals.len() + 1;
        let mut out = Covariances {
            columns: self.columns,
            own: vec![Block::default(); epochs],
            next: vec![Block::default(); intervals.len()],
            border: vec![0.0; epochs * VISIBLE * self.columns],
            intervals: intervals.clone(),
        };
        if !self.started {
            self.step(intervals.end)?;
            self.started = true;
        }
        self.keep(epochs - 1, &mut out);
        for epoch in intervals.clone().rev() {
            let local = epoch - intervals.start;
            out.next[local] = match epoch == block.start && epoch > 0 {
                true => self.arrive(),
                false => self.step(epoch)?,
            };
            self.keep(local, &mut out);
        }
        Ok(out)
    }

    /// Moves to the epoch before; returns the visible cofactors between it and the one it comes from.
    fn step(&mut self, epoch: usize) -> Result<Block, AdjustError> {
        self.reader.open_at(epoch)?;
        let (page, columns) = (self.reader.page(), &self.ends.columns);
        let cross = with_size!(self.size, N => {
            self.here.step::<N>(page, epoch, columns).as_flattened().to_vec()
        });
        Ok(self.visible(|i, j| cross[i * self.size + j]))
    }

    /// Moves to the first cut, whose cofactors are known.
    fn arrive(&mut self) -> Block {
        let (n, width) = (self.size, self.ends.columns.ncols());
        let cross = self.visible(|i, j| self.here.border[j * width + i]);
        let known = |i: usize, j: usize| self.ends.columns[(i, j)];
        for i in 0..n {
            (0..n).for_each(|j| self.here.own[i * n + j] = known(i, j));
            (0..width).for_each(|j| self.here.border[i * width + j] = known(i, j));
        }
        cross
    }

    /// Sums cofactors of states to those of visible quantities.
    fn visible(&self, states: impl Fn(usize, usize) -> f64) -> Block {
        let mut block = Block::default();
        for (i, a) in self.model.processes().iter().enumerate() {
            for (j, b) in self.model.processes().iter().enumerate() {
                block[a.component][b.component] += states(i, j);
            }
        }
        block
    }

    fn keep(&self, local: usize, out: &mut Covariances) {
        out.own[local] = self.visible(|i, j| self.here.own[i * self.size + j]);
        let width = self.ends.columns.ncols();
        for (i, process) in self.model.processes().iter().enumerate() {
            let rows = out.border[local * self.columns * VISIBLE..]
                .as_chunks_mut::<VISIBLE>()
                .0;
            let border = &self.here.border[i * width..(i + 1) * width];
            let border = &border[width - self.free.len()..];
            for (column, cofactor) in self.free.iter().zip(border) {
                rows[*column][process.component] += cofactor;
            }
        }
    }
}

/// A chain with its factor, for the cofactors along it.
struct Chain<'a> {
    model: &'a ChainModel,
    factor: &'a ChainFactor,
    free: &'a [usize],
    columns: usize,
}

/// Hands the cofactors of every window of a solution's chain to `judge` and what that finds to `take`, from the last window to the
/// first. Nothing without a chain.
///
/// # Errors
/// Those of `judge`, and [`AdjustError::NoSpill`].
pub(super) fn each_window<T: Send>(
    problem: &Problem,
    solution: &Solution,
    judge: impl Fn(&Covariances) -> Result<T, AdjustError> + Sync,
    mut take: impl FnMut(T),
) -> Result<(), AdjustError> {
    let made;
    let factor = match &solution.linearisation.factor {
        Some(factor) if factor.is_elsewhere() => {
            made = factor_here(problem, &solution.estimate, solution.weighting)?;
            &made
        }
        factor => factor,
    };
    let (Some(model), Some(factor)) = (problem.chain, factor) else {
        return Ok(());
    };
    let parameters = &solution.estimate.parameters;
    let chain = Chain {
        model,
        factor,
        free: &parameters.free_columns(),
        columns: parameters.columns(),
    };
    let ends = factor.ends(&solution.linearisation.spectrum.cofactor());
    let count = factor.blocks.iter().map(|block| windows(block).len()).sum();
    let done = AtomicUsize::new(0);
    let of_block = |block: usize| {
        let mut backward = Backward::new(&chain, block, &ends[block]);
        let (intervals, mut found) = (&factor.blocks[block], Vec::new());
        for batch in windows(intervals).rchunks(BATCH) {
            problem.counted(done.fetch_add(batch.len(), Ordering::Relaxed), count);
            let covariances: Result<Vec<_>, AdjustError> = batch
                .iter()
                .rev()
                .map(|window| backward.window(window.clone(), intervals))
                .collect();
            let parts: Result<Vec<T>, AdjustError> = covariances?.par_iter().map(&judge).collect();
            found.extend(parts?);
        }
        Ok(found)
    };
    in_waves((0..factor.blocks.len()).rev(), of_block, |found| {
        found.into_iter().for_each(&mut take);
    })
}

fn add(out: &mut [f64], factor: f64, row: &[f64]) {
    out.iter_mut().zip(row).for_each(|(o, r)| *o += factor * r);
}

/// `X <- L^-T X` for N rows of any width; the diagonal of `upper`, which is `L^T`, is inverted.
fn backward<const N: usize>(upper: &Square<N>, x: &mut [f64], width: usize) {
    for (i, factors) in upper.iter().enumerate().rev() {
        let (before, done) = x.split_at_mut((i + 1) * width);
        let row = &mut before[i * width..];
        for (factor, other) in factors[i + 1..].iter().zip(done.chunks_exact(width.max(1))) {
            add(row, -factor, other);
        }
        row.iter_mut().for_each(|a| *a *= factors[i]);
    }
}

/// `L^-1`.
fn inverse<const N: usize>(upper: &Square<N>) -> Square<N> {
    let mut inverse = [[0.0; N]; N];
    for i in 0..N {
        let (done, rest) = inverse.split_at_mut(i);
        rest[0][i] = 1.0;
        for (row, other) in upper.iter().zip(done.iter()) {
            add(&mut rest[0], -row[i], other);
        }
        rest[0].iter_mut().for_each(|a| *a *= upper[i][i]);
    }
    inverse
}
