//! Block Cholesky elimination of the chain, back substitution, and the covariance blocks of its states.
//!
//! The normal matrix is block tridiagonal over the epochs with a border of the parameters. Epoch after epoch:
//! `A = L L^T`, `U = L^-1 O`, `W = L^-1 B`; the next epoch loses `U^T U` and `U^T W`, the parameters lose `W^T W`
//! (Triggs et al., "Bundle adjustment – a modern synthesis", 2000, sec. 6).

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

use super::accumulate::{Window, pair};
use super::chain::{ChainModel, ChainState};
use super::error::AdjustError;

/// Sizes of state vectors that have their own compiled loops; a chain uses the next larger one, padded with idle states.
pub(super) const SIZES: [usize; 7] = [3, 6, 9, 10, 12, 16, 24];

/// Runs a block of code with the constant `$n` of the compiled size.
macro_rules! with_size {
    ($size:expr, $n:ident => $body:expr) => {
        match $size {
            3 => {
                const $n: usize = 3;
                $body
            }
            6 => {
                const $n: usize = 6;
                $body
            }
            9 => {
                const $n: usize = 9;
                $body
            }
            10 => {
                const $n: usize = 10;
                $body
            }
            12 => {
                const $n: usize = 12;
                $body
            }
            16 => {
                const $n: usize = 16;
                $body
            }
            _ => {
                const $n: usize = 24;
                $body
            }
        }
    };
}
pub(super) use with_size;

/// Compiled size for a number of processes.
pub(super) fn compiled_size(states: usize) -> Result<usize, AdjustError> {
    let found = SIZES.into_iter().find(|size| *size >= states);
    found.ok_or(AdjustError::BadChain {
        what: "number of processes",
        place: 0,
        found: states as f64,
    })
}

/// Factor of an eliminated chain, epoch after epoch.
#[derive(Debug, Clone, Default)]
pub(super) struct Factor {
    /// Compiled state size.
    pub size: usize,
    /// Free columns and the right-hand side.
    pub width: usize,
    /// `L` by rows, its diagonal inverted.
    pub lower: Vec<f64>,
    /// `U` by rows.
    pub next: Vec<f64>,
    /// `W` by rows, right-hand side last.
    pub border: Vec<f64>,
}

/// Forward elimination in progress.
pub(super) struct Elimination<'a> {
    model: &'a ChainModel,
    state: &'a ChainState,
    /// Columns kept: the free ones, then the misclosure.
    columns: &'a [usize],
    factor: Factor,
    /// What the epochs so far have taken from the next one.
    own_carry: Vec<f64>,
    border_carry: Vec<f64>,
    /// Schur complement's loss `W^T W` over free columns and right-hand side.
    loss: DMatrix<f64>,
    /// Cost of the states' priors.
    pub prior_cost: f64,
}

impl<'a> Elimination<'a> {
    /// Starts; `recycled` lends its memory.
    pub(super) fn new(
        model: &'a ChainModel,
        state: &'a ChainState,
        columns: &'a [usize],
        recycled: Option<Factor>,
    ) -> Result<Self, AdjustError> {
        let (size, width, epochs) = (
            compiled_size(model.state_size())?,
            columns.len(),
            model.epochs(),
        );
        let mut factor = recycled.unwrap_or_default();
        factor.size = size;
        factor.width = width;
        factor.lower.resize(epochs * size * size, 0.0);
        factor.next.resize(epochs * size * size, 0.0);
        factor.border.resize(epochs * size * width, 0.0);
        Ok(Elimination {
            model,
            state,
            columns,
            factor,
            own_carry: vec![0.0; size * size],
            border_carry: vec![0.0; size * width],
            loss: DMatrix::zeros(width, width),
            prior_cost: 0.0,
        })
    }

    /// Eliminates the epochs of a window, all but its last one unless the window ends the chain.
    pub(super) fn eliminate(&mut self, window: &Window) -> Result<(), AdjustError> {
        let end =
            window.intervals.end + usize::from(window.intervals.end == self.model.intervals());
        let size = self.factor.size;
        for epoch in window.intervals.start..end {
            let local = epoch - window.intervals.start;
            with_size!(size, N => self.epoch::<N>(epoch, local, window)?);
        }
        self.subtract(window.intervals.start..end);
        Ok(())
    }

    /// The factor, and the loss of the parameters' normal matrix.
    pub(super) fn finish(self) -> (Factor, DMatrix<f64>) {
        (self.factor, self.loss)
    }

    fn epoch<const N: usize>(
        &mut self,
        epoch: usize,
        local: usize,
        window: &Window,
    ) -> Result<(), AdjustError> {
        let (square, wide) = (epoch * N * N, epoch * N * self.columns.len());
        let lower = self.own::<N>(epoch, local, window);
        self.border::<N>(local, window, wide);
        self.prior_gradient(epoch, wide);
        let lower = cholesky(lower).ok_or(AdjustError::NotPositive { epoch })?;
        let mut next = self.coupling::<N>(epoch, local, window);
        forward_block(&lower, &mut next);
        let width = self.columns.len();
        let border = &mut self.factor.border[wide..wide + N * width];
        forward(&lower, border, width);
        take_square(&next, &mut self.own_carry);
        take_border(&next, border, width, &mut self.border_carry);
        self.factor.lower[square..square + N * N].copy_from_slice(lower.as_flattened());
        self.factor.next[square..square + N * N].copy_from_slice(next.as_flattened());
        Ok(())
    }

    /// The epoch's own block: conditions, priors, and what earlier epochs took.
    fn own<const N: usize>(&self, epoch: usize, local: usize, window: &Window) -> [[f64; N]; N] {
        let mut own = [[0.0; N]; N];
        let (processes, sums) = (self.model.processes(), window.own(local));
        own.as_flattened_mut().copy_from_slice(&self.own_carry);
        for (i, a) in processes.iter().enumerate() {
            for (j, b) in processes.iter().enumerate().take(i + 1) {
                own[i][j] += sums[pair(a.component, b.component)];
            }
        }
        for (i, row) in own.iter_mut().enumerate() {
            row[i] += processes
                .get(i)
                .map_or(1.0, |process| self.own_information(process, epoch));
        }
        own
    }

    fn own_information(&self, process: &super::Process, epoch: usize) -> f64 {
        let model = self.model;
        let before = match epoch {
            0 => process.sigma * process.sigma,
            _ => model.innovation(process, epoch - 1),
        };
        if epoch == model.intervals() {
            return 1.0 / before;
        }
        1.0 / before + model.transition(process, epoch).powi(2) / model.innovation(process, epoch)
    }

    fn coupling<const N: usize>(
        &self,
        epoch: usize,
        local: usize,
        window: &Window,
    ) -> [[f64; N]; N] {
        let mut next = [[0.0; N]; N];
        if epoch == self.model.intervals() {
            return next;
        }
        let (processes, sums) = (self.model.processes(), window.next(local));
        for (i, a) in processes.iter().enumerate() {
            for (j, b) in processes.iter().enumerate() {
                next[i][j] = sums[pair(a.component, b.component)];
            }
            next[i][i] -= self.model.transition(a, epoch) / self.model.innovation(a, epoch);
        }
        next
    }

    fn border<const N: usize>(&mut self, local: usize, window: &Window, wide: usize) {
        let width = self.columns.len();
        self.factor.border[wide..wide + N * width].copy_from_slice(&self.border_carry);
        for (i, process) in self.model.processes().iter().enumerate() {
            let sums = window.border(local, process.component);
            let row = &mut self.factor.border[wide + i * width..][..width];
            row.iter_mut()
                .zip(self.columns)
                .for_each(|(entry, column)| *entry += sums[*column]);
        }
    }

    /// Adds the gradient of the process priors around this epoch, and the cost of the one leading to it.
    fn prior_gradient(&mut self, epoch: usize, wide: usize) {
        let (model, width) = (self.model, self.columns.len());
        for (i, process) in model.processes().iter().enumerate() {
            let here = self.state.state(epoch)[i];
            let (innovation, variance) = match epoch {
                0 => (here, process.sigma * process.sigma),
                _ => {
                    let before = self.state.state(epoch - 1)[i];
                    (
                        here - model.transition(process, epoch - 1) * before,
                        model.innovation(process, epoch - 1),
                    )
                }
            };
            self.prior_cost += 0.5 * innovation * innovation / variance;
            let gradient = &mut self.factor.border[wide + (i + 1) * width - 1];
            *gradient += innovation / variance;
            if epoch < model.intervals() {
                let phi = model.transition(process, epoch);
                let ahead = self.state.state(epoch + 1)[i] - phi * here;
                *gradient -= phi * ahead / model.innovation(process, epoch);
            }
        }
    }

    /// Adds `W^T W` of finished epochs to the loss.
    fn subtract(&mut self, epochs: std::ops::Range<usize>) {
        let (rows, width) = (self.factor.size, self.columns.len());
        let border = &self.factor.border[epochs.start * rows * width..epochs.end * rows * width];
        let transposed = MatRef::from_column_major_slice(border, width, epochs.len() * rows);
        let loss = MatMut::from_column_major_slice_mut(self.loss.as_mut_slice(), width, width);
        matmul(
            loss,
            Accum::Add,
            transposed,
            transposed.transpose(),
            1.0,
            Par::Seq,
        );
    }
}

/// Cholesky factor of the lower triangle, diagonal inverted.
fn cholesky<const N: usize>(mut a: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    for j in 0..N {
        let (above, below) = a.split_at_mut(j);
        for k in 0..above.len() {
            let factor = below[0][k];
            for r in below.iter_mut() {
                r[j] -= factor * r[k];
            }
        }
        let pivot = a[j][j];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let inverse = 1.0 / pivot.sqrt();
        for row in &mut a[j + 1..] {
            row[j] *= inverse;
        }
        a[j][j] = inverse;
        a[j][j + 1..].fill(0.0);
    }
    Some(a)
}

/// `X <- L^-1 X` for an N x N block.
fn forward_block<const N: usize>(lower: &[[f64; N]; N], x: &mut [[f64; N]; N]) {
    for (i, factors) in lower.iter().enumerate() {
        let (done, rest) = x.split_at_mut(i);
        let row = &mut rest[0];
        for (factor, other) in factors.iter().zip(done.iter()) {
            for (a, b) in row.iter_mut().zip(other) {
                *a -= factor * b;
            }
        }
        row.iter_mut().for_each(|a| *a *= factors[i]);
    }
}

/// `X <- L^-1 X` for N rows of any width.
fn forward<const N: usize>(lower: &[[f64; N]; N], x: &mut [f64], width: usize) {
    for (i, factors) in lower.iter().enumerate() {
        let (done, rest) = x.split_at_mut(i * width);
        let row = &mut rest[..width];
        for (factor, other) in factors.iter().zip(done.chunks_exact(width)) {
            for (a, b) in row.iter_mut().zip(other) {
                *a -= factor * b;
            }
        }
        row.iter_mut().for_each(|a| *a *= factors[i]);
    }
}

/// `carry = -U^T U`.
fn take_square<const N: usize>(next: &[[f64; N]; N], carry: &mut [f64]) {
    let mut product = [[0.0; N]; N];
    for row in next {
        for (i, factor) in row.iter().enumerate() {
            for (a, b) in product[i].iter_mut().zip(row) {
                *a -= factor * b;
            }
        }
    }
    carry.copy_from_slice(product.as_flattened());
}

/// `carry = -U^T W`.
fn take_border<const N: usize>(
    next: &[[f64; N]; N],
    border: &[f64],
    width: usize,
    carry: &mut [f64],
) {
    carry.fill(0.0);
    for (row, w) in next.iter().zip(border.chunks_exact(width)) {
        for (factor, out) in row.iter().zip(carry.chunks_exact_mut(width)) {
            for (a, b) in out.iter_mut().zip(w) {
                *a -= factor * b;
            }
        }
    }
}

impl Factor {
    /// Step of all states for a step of the free columns: `s = -L^-T (z + U s_next + W x)`.
    pub(super) fn back_substitute(&self, model: &ChainModel, x: &[f64]) -> Vec<f64> {
        with_size!(self.size, N => self.back::<N>(model, x))
    }

    fn back<const N: usize>(&self, model: &ChainModel, x: &[f64]) -> Vec<f64> {
        let used = model.state_size();
        let mut steps = vec![0.0; model.epochs() * used];
        let mut ahead = [0.0; N];
        for epoch in (0..model.epochs()).rev() {
            let mut rhs = [0.0; N];
            for (i, value) in rhs.iter_mut().enumerate() {
                let border = &self.border[(epoch * N + i) * self.width..][..self.width];
                let next = &self.next[(epoch * N + i) * N..][..N];
                *value = -border[self.width - 1] - dot(border, x) - dot(next, &ahead);
            }
            back_solve(&self.lower_block::<N>(epoch), &mut rhs);
            ahead = rhs;
            steps[epoch * used..(epoch + 1) * used].copy_from_slice(&ahead[..used]);
        }
        steps
    }

    pub(super) fn lower_block<const N: usize>(&self, epoch: usize) -> [[f64; N]; N] {
        block(&self.lower, epoch)
    }

    pub(super) fn next_block<const N: usize>(&self, epoch: usize) -> [[f64; N]; N] {
        block(&self.next, epoch)
    }
}

fn block<const N: usize>(values: &[f64], epoch: usize) -> [[f64; N]; N] {
    let mut block = [[0.0; N]; N];
    block
        .as_flattened_mut()
        .copy_from_slice(&values[epoch * N * N..(epoch + 1) * N * N]);
    block
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `x <- L^-T x`.
fn back_solve<const N: usize>(lower: &[[f64; N]; N], x: &mut [f64; N]) {
    for i in (0..N).rev() {
        x[i] *= lower[i][i];
        let solved = x[i];
        for j in 0..i {
            x[j] -= lower[i][j] * solved;
        }
    }
}
