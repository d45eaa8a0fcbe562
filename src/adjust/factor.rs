//! The factor of an eliminated chain: storage, small triangular kernels, back substitution.
//!
//! Rows are padded to whole vectors of four and loops run over fixed sizes, so that the compiler vectorises them.

use super::chain::ChainModel;
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

/// Factor of an eliminated chain. Per epoch: `L^T`, and the rows `[U | W]` with the right-hand side as last column of `W`.
#[derive(Debug, Clone, Default)]
pub(super) struct Factor {
    /// Compiled state size.
    pub size: usize,
    /// Columns of `W`: the free ones and the right-hand side.
    pub width: usize,
    /// Vectors of four per row.
    pub quads: usize,
    /// `L^T` by rows, its diagonal inverted, epoch after epoch.
    upper: Vec<f64>,
    /// `[U | W]` by rows, epoch after epoch.
    rows: Vec<Quad>,
}

impl Factor {
    /// Room for a chain; the memory of an old factor is used again.
    pub(super) fn sized(mut self, size: usize, width: usize, epochs: usize) -> Self {
        (self.size, self.width, self.quads) = (size, width, (size + width).div_ceil(4));
        self.upper.resize(epochs * size * size, 0.0);
        self.rows.resize(epochs * size * self.quads, [0.0; 4]);
        self
    }

    /// Rows of an epoch, to be filled.
    pub(super) fn rows_mut(&mut self, epoch: usize) -> &mut [Quad] {
        let length = self.size * self.quads;
        &mut self.rows[epoch * length..(epoch + 1) * length]
    }

    /// Rows of some epochs; `quads` vectors to a row.
    pub(super) fn rows(&self, epochs: std::ops::Range<usize>) -> &[Quad] {
        let length = self.size * self.quads;
        &self.rows[epochs.start * length..epochs.end * length]
    }

    /// `U` and `W` of one state of an epoch.
    pub(super) fn row(&self, epoch: usize, state: usize) -> (&[f64], &[f64]) {
        let row = (epoch * self.size + state) * self.quads;
        let row = self.rows[row..row + self.quads].as_flattened();
        (&row[..self.size], &row[self.size..self.size + self.width])
    }

    /// Keeps `L^T` of an epoch.
    pub(super) fn set_upper<const N: usize>(&mut self, epoch: usize, upper: &Square<N>) {
        self.upper[epoch * N * N..(epoch + 1) * N * N].copy_from_slice(upper.as_flattened());
    }

    /// `L^T` of an epoch, its diagonal inverted.
    pub(super) fn upper<const N: usize>(&self, epoch: usize) -> Square<N> {
        let mut block = [[0.0; N]; N];
        block
            .as_flattened_mut()
            .copy_from_slice(&self.upper[epoch * N * N..(epoch + 1) * N * N]);
        block
    }

    /// Step of all states for a step of the free columns: `s = -L^-T (z + U s_next + W x)`.
    pub(super) fn back_substitute(&self, model: &ChainModel, x: &[f64]) -> Vec<f64> {
        with_size!(self.size, N => self.back::<N>(model, x))
    }

    fn back<const N: usize>(&self, model: &ChainModel, x: &[f64]) -> Vec<f64> {
        let used = model.state_size();
        let mut steps = vec![0.0; model.epochs() * used];
        let mut ahead = [0.0; N];
        for epoch in (0..model.epochs()).rev() {
            let state = |i| {
                let (next, border) = self.row(epoch, i);
                -border[self.width - 1] - dot(border, x) - dot(next, &ahead)
            };
            ahead = std::array::from_fn(state);
            back_solve(&self.upper::<N>(epoch), &mut ahead);
            steps[epoch * used..(epoch + 1) * used].copy_from_slice(&ahead[..used]);
        }
        steps
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
pub(super) fn cholesky<const N: usize>(mut a: Square<N>) -> Option<Square<N>> {
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
pub(super) fn forward<const N: usize>(upper: &Square<N>, x: &mut [Quad], quads: usize) {
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
pub(super) fn carried<const N: usize>(x: &[Quad], quads: usize, out: &mut [Quad]) {
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
