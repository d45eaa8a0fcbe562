//! The factor of a stretch of an eliminated chain: storage, small triangular kernels, back substitution.
//!
//! Rows are padded to whole vectors of four and loops run over fixed sizes, so that the compiler vectorises them.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::error::AdjustError;

/// Sizes of state vectors that have their own compiled loops; a chain uses the next larger one, padded with idle states.
const SIZES: [usize; 7] = [3, 6, 9, 10, 12, 16, 24];

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

/// A square block by rows.
pub(super) type Square<const N: usize> = [[f64; N]; N];
/// Four neighbouring entries of a row.
pub(super) type Quad = [f64; 4];

/// Factor of a stretch of eliminated epochs. Per epoch: `L^T`, and the rows `[U | W]` with the right-hand side as last column of `W`.
#[derive(Debug, Clone, Default)]
pub(super) struct Factor {
    /// Compiled state size.
    pub size: usize,
    /// Columns of `W`: those of the first cut, the free ones and the right-hand side.
    pub width: usize,
    /// Vectors of four per row.
    pub quads: usize,
    /// The epochs.
    pub epochs: Range<usize>,
    /// `L^T` by rows, its diagonal inverted, epoch after epoch.
    upper: Vec<f64>,
    /// `[U | W]` by rows, epoch after epoch.
    rows: Vec<Quad>,
}

impl Factor {
    /// Room for some epochs; the memory of an old factor is used again.
    pub(super) fn sized(mut self, size: usize, width: usize, epochs: Range<usize>) -> Self {
        (self.size, self.width, self.quads) = (size, width, (size + width).div_ceil(4));
        self.upper.resize(epochs.len() * size * size, 0.0);
        self.rows.resize(epochs.len() * size * self.quads, [0.0; 4]);
        self.epochs = epochs;
        self
    }

    /// Bytes of one epoch.
    pub(super) fn bytes(size: usize, width: usize) -> u64 {
        let row = size + 4 * (size + width).div_ceil(4);
        (size_of::<f64>() * size * row) as u64
    }

    /// All its numbers, part by part.
    pub(super) fn parts(&self) -> [&[f64]; 2] {
        [&self.upper, self.rows.as_flattened()]
    }

    /// The same, to be filled.
    pub(super) fn parts_mut(&mut self) -> [&mut [f64]; 2] {
        [&mut self.upper, self.rows.as_flattened_mut()]
    }

    /// Rows of an epoch, to be filled.
    pub(super) fn rows_mut(&mut self, epoch: usize) -> &mut [Quad] {
        let (length, local) = (self.size * self.quads, epoch - self.epochs.start);
        &mut self.rows[local * length..(local + 1) * length]
    }

    /// Rows of some epochs; `quads` vectors to a row.
    pub(super) fn rows(&self, epochs: Range<usize>) -> &[Quad] {
        let (length, first) = (self.size * self.quads, self.epochs.start);
        &self.rows[(epochs.start - first) * length..(epochs.end - first) * length]
    }

    /// `U` and `W` of one state of an epoch.
    pub(super) fn row(&self, epoch: usize, state: usize) -> (&[f64], &[f64]) {
        let row = ((epoch - self.epochs.start) * self.size + state) * self.quads;
        let row = self.rows[row..row + self.quads].as_flattened();
        (&row[..self.size], &row[self.size..self.size + self.width])
    }

    /// Keeps `L^T` of an epoch.
    pub(super) fn set_upper<const N: usize>(&mut self, epoch: usize, upper: &Square<N>) {
        let local = epoch - self.epochs.start;
        self.upper[local * N * N..(local + 1) * N * N].copy_from_slice(upper.as_flattened());
    }

    /// `L^T` of an epoch, its diagonal inverted.
    pub(super) fn upper<const N: usize>(&self, epoch: usize) -> Square<N> {
        let (mut block, local) = ([[0.0; N]; N], epoch - self.epochs.start);
        block
            .as_flattened_mut()
            .copy_from_slice(&self.upper[local * N * N..(local + 1) * N * N]);
        block
    }

    /// Steps of the states for a step `x` of the columns of `W`, from the last epoch to the first: `s = -L^-T (z + U s_next + W x)`.
    /// `ahead` is the step of the epoch after the last one, then of the first; `steps` holds `used` numbers of each epoch.
    pub(super) fn back_substitute(
        &self,
        x: &[f64],
        ahead: &mut [f64],
        steps: &mut [f64],
        used: usize,
    ) {
        with_size!(self.size, N => self.back::<N>(x, ahead, steps, used));
    }

    fn back<const N: usize>(&self, x: &[f64], next: &mut [f64], steps: &mut [f64], used: usize) {
        let mut ahead = [0.0; N];
        ahead.copy_from_slice(next);
        let steps = steps.chunks_exact_mut(used).rev();
        for (epoch, step) in self.epochs.clone().rev().zip(steps) {
            let state = |i| {
                let (next, border) = self.row(epoch, i);
                -border[self.width - 1] - dot(border, x) - dot(next, &ahead)
            };
            ahead = std::array::from_fn(state);
            back_solve(&self.upper::<N>(epoch), &mut ahead);
            step.copy_from_slice(&ahead[..used]);
        }
        next.copy_from_slice(&ahead);
    }
}

/// Elimination of an epoch with the widest instructions, which give the same bits as any others: `L^T`, or nothing where the block
/// is not positive definite. `rows` holds `[O | B]` and then `[U | W]`, `carry` what the next epoch gets, `-U^T [U | W]`.
struct Step<'a, const N: usize> {
    own: Square<N>,
    rows: &'a mut [Quad],
    carry: &'a mut [Quad],
    quads: usize,
}

impl<const N: usize> WithSimd for Step<'_, N> {
    type Output = Option<Square<N>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let upper = cholesky(self.own)?;
        forward(&upper, self.rows, self.quads);
        carried::<N>(self.rows, self.quads, self.carry);
        Some(upper)
    }
}

impl Factor {
    /// Eliminates an epoch whose rows `[O | B]` are filled and whose own block is `own`; `carry` becomes `-U^T [U | W]`.
    pub(super) fn eliminate<const N: usize>(
        &mut self,
        epoch: usize,
        own: Square<N>,
        carry: &mut [Quad],
        arch: Arch,
    ) -> Result<(), AdjustError> {
        let quads = self.quads;
        let rows = self.rows_mut(epoch);
        let step = Step {
            own,
            rows,
            carry,
            quads,
        };
        let upper = arch.dispatch(step);
        let upper = upper.ok_or(AdjustError::NotPositive { epoch })?;
        self.set_upper(epoch, &upper);
        Ok(())
    }
}

/// Sum of products over the shorter of two rows.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `x <- L^-T x`.
fn back_solve<const N: usize>(upper: &Square<N>, x: &mut [f64; N]) {
    for i in (0..N).rev() {
        let known: f64 = dot(&upper[i][i + 1..], &x[i + 1..]);
        x[i] = (x[i] - known) * upper[i][i];
    }
}

/// `L^T` of a symmetric matrix, diagonal inverted; `None` unless positive definite.
#[inline(always)]
fn cholesky<const N: usize>(mut a: Square<N>) -> Option<Square<N>> {
    for k in 0..N {
        let (above, below) = a.split_at_mut(k + 1);
        let row = &mut above[k];
        let pivot = row[k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let inverse = 1.0 / pivot.sqrt();
        row.iter_mut().for_each(|entry| *entry *= inverse);
        for (i, other) in below.iter_mut().enumerate() {
            let factor = row[k + 1 + i];
            for j in 0..N {
                other[j] -= factor * row[j];
            }
        }
        row[k] = inverse;
    }
    Some(a)
}

/// `X <- L^-1 X` for N rows of `quads` vectors.
#[inline(always)]
fn forward<const N: usize>(upper: &Square<N>, x: &mut [Quad], quads: usize) {
    for i in 0..N {
        let (done, rest) = x.split_at_mut(i * quads);
        for (q, entry) in rest[..quads].iter_mut().enumerate() {
            let mut sum = *entry;
            for (row, above) in upper.iter().zip(done.chunks_exact(quads)) {
                subtract(&mut sum, row[i], &above[q]);
            }
            *entry = sum.map(|value| value * upper[i][i]);
        }
    }
}

/// `-U^T X`, `U` being the first N columns of `X`.
#[inline(always)]
fn carried<const N: usize>(x: &[Quad], quads: usize, out: &mut [Quad]) {
    let mut next = [[0.0; N]; N];
    for (row, x) in next.iter_mut().zip(x.chunks_exact(quads)) {
        row.copy_from_slice(&x.as_flattened()[..N]);
    }
    for (i, out) in out.chunks_exact_mut(quads).enumerate() {
        for (q, entry) in out.iter_mut().enumerate() {
            let mut sum = [0.0; 4];
            for (row, x) in next.iter().zip(x.chunks_exact(quads)) {
                subtract(&mut sum, row[i], &x[q]);
            }
            *entry = sum;
        }
    }
}

#[inline(always)]
fn subtract(sum: &mut Quad, factor: f64, x: &Quad) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum -= factor * x;
    }
}
