//! Selected inverse: the covariance blocks that single conditions need, by backward recursion over the factor.
//!
//! From `s_k = L^-T (e - U s_(k+1) - W x)` with unit white `e` (Takahashi's equations in block form; Triggs et al. 2000,
//! app. B.4):
//! `Q_kx = -L^-T (U Q_(k+1)x + W Q_xx)`, `Q_k(k+1) = -L^-T (U Q_(k+1)(k+1) + W Q_x(k+1))`,
//! `Q_kk = L^-T (L^-1 - U Q_(k+1)k - W Q_xk)`.

use std::ops::Range;

use nalgebra::DMatrix;

use super::chain::{ChainModel, VISIBLE};
use super::condition::ChainRow;
use super::factor::{Factor, Square, dot, with_size};

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

/// The recursion, from the last epoch to the first.
pub(super) struct Backward<'a> {
    model: &'a ChainModel,
    factor: &'a Factor,
    free: &'a [usize],
    columns: usize,
    /// Cofactors of the free columns.
    parameters: &'a DMatrix<f64>,
    /// Cofactors of the epoch last visited: its states, and its states by free columns.
    own: Vec<f64>,
    border: Vec<f64>,
    started: bool,
}

impl<'a> Backward<'a> {
    pub(super) fn new(
        model: &'a ChainModel,
        factor: &'a Factor,
        free: &'a [usize],
        columns: usize,
        parameters: &'a DMatrix<f64>,
    ) -> Self {
        let n = factor.size;
        let (own, border) = (vec![0.0; n * n], vec![0.0; n * free.len()]);
        Backward {
            model,
            factor,
            free,
            columns,
            parameters,
            own,
            border,
            started: false,
        }
    }

    /// Cofactors of a window's epochs. Windows must come from the last to the first.
    pub(super) fn window(&mut self, intervals: Range<usize>) -> Covariances {
        let epochs = intervals.len() + 1;
        let mut out = Covariances {
            columns: self.columns,
            own: vec![Block::default(); epochs],
            next: vec![Block::default(); intervals.len()],
            border: vec![0.0; epochs * VISIBLE * self.columns],
            intervals: intervals.clone(),
        };
        if !self.started {
            with_size!(self.factor.size, N => self.step::<N>(intervals.end));
            self.started = true;
        }
        self.keep(epochs - 1, &mut out);
        for epoch in intervals.clone().rev() {
            let local = epoch - intervals.start;
            out.next[local] = with_size!(self.factor.size, N => self.step::<N>(epoch));
            self.keep(local, &mut out);
        }
        out
    }

    /// Moves to the epoch before; returns the visible cofactors between it and the one it comes from.
    fn step<const N: usize>(&mut self, epoch: usize) -> Block {
        let upper = self.factor.upper::<N>(epoch);
        let cross = self.cross(&upper, epoch);
        let border = self.stepped_border(&upper, epoch);
        let width = self.free.len();
        let mut own = inverse(&upper);
        for (i, row) in own.iter_mut().enumerate() {
            let (next, weights) = self.factor.row(epoch, i);
            for (j, entry) in row.iter_mut().enumerate() {
                *entry -= dot(next, &cross[j]) + dot(&border[j * width..(j + 1) * width], weights);
            }
        }
        backward(&upper, own.as_flattened_mut(), N);
        self.own.copy_from_slice(own.as_flattened());
        self.border = border;
        self.visible(cross.as_flattened())
    }

    /// `Q_k(k+1)`.
    fn cross<const N: usize>(&self, upper: &Square<N>, epoch: usize) -> Square<N> {
        let width = self.free.len();
        let mut cross = [[0.0; N]; N];
        for (i, row) in cross.iter_mut().enumerate() {
            let (next, weights) = self.factor.row(epoch, i);
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
    fn stepped_border<const N: usize>(&self, upper: &Square<N>, epoch: usize) -> Vec<f64> {
        let width = self.free.len();
        let mut border = vec![0.0; N * width];
        for (i, row) in border.chunks_exact_mut(width.max(1)).enumerate() {
            let (next, weights) = self.factor.row(epoch, i);
            for (factor, ahead) in next.iter().zip(self.border.chunks_exact(width)) {
                add(row, -factor, ahead);
            }
            for (factor, cofactors) in weights.iter().zip(self.parameters.column_iter()) {
                add(row, -factor, cofactors.as_slice());
            }
        }
        backward(upper, &mut border, width);
        border
    }

    /// Sums cofactors of states to those of visible quantities.
    fn visible(&self, states: &[f64]) -> Block {
        let mut block = Block::default();
        for (i, a) in self.model.processes().iter().enumerate() {
            for (j, b) in self.model.processes().iter().enumerate() {
                block[a.component][b.component] += states[i * self.factor.size + j];
            }
        }
        block
    }

    fn keep(&self, local: usize, out: &mut Covariances) {
        out.own[local] = self.visible(&self.own);
        for (i, process) in self.model.processes().iter().enumerate() {
            let rows = out.border[local * self.columns * VISIBLE..]
                .as_chunks_mut::<VISIBLE>()
                .0;
            for (j, column) in self.free.iter().enumerate() {
                rows[*column][process.component] += self.border[i * self.free.len() + j];
            }
        }
    }
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
