//! Sums over weighted conditions: normal equations of the parameters, and of the chain in visible quantities.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::chain::VISIBLE;
use super::condition::{ChainRow, Row};
use super::pass::Weighted;

/// Pairs of visible quantities, upper triangle by rows.
pub(super) const PAIRS: usize = VISIBLE * (VISIBLE + 1) / 2;

/// Normal equations of the parameters over all columns, the misclosure as one more column; upper triangle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Normal {
    /// Columns, misclosure included.
    pub width: usize,
    /// Upper triangle by rows, `width` squared with the lower part unused.
    pub values: Vec<f64>,
}

impl Normal {
    pub(super) fn zero(columns: usize) -> Self {
        let width = columns + 1;
        Normal {
            width,
            values: vec![0.0; width * width],
        }
    }

    pub(super) fn add(&mut self, other: &Normal) {
        self.values
            .iter_mut()
            .zip(&other.values)
            .for_each(|(a, b)| *a += b);
    }

    /// Entry of the symmetric matrix.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i.min(j) * self.width + i.max(j)]
    }

    /// Adds a block of sums over the columns `columns`, the misclosure last in it.
    fn scatter(&mut self, columns: &[usize], sums: &[[f64; WIDE]]) {
        for (i, &a) in columns.iter().enumerate() {
            for (j, &b) in columns.iter().enumerate().skip(i) {
                self.values[a.min(b) * self.width + a.max(b)] += sums[i][j];
            }
        }
    }

    /// Adds one whitened row with its residual.
    pub(super) fn add_row(&mut self, first: usize, derivatives: &[f64], residual: f64) {
        let last = self.width - 1;
        for (i, a) in derivatives.iter().enumerate() {
            for (j, b) in derivatives.iter().enumerate().skip(i) {
                self.values[(first + i) * self.width + first + j] += a * b;
            }
            self.values[(first + i) * self.width + last] += a * residual;
        }
        self.values[last * self.width + last] += residual * residual;
    }
}

/// Widest compact row: the columns of a condition and its misclosure, in whole vectors of four.
const WIDE: usize = (super::condition::MAX_COLUMNS + 1).next_multiple_of(4);

/// Sums over a run of conditions with the same columns (and the same interval), kept compact and scattered when the run ends.
pub(super) struct Run {
    /// Columns of the rows.
    columns: Vec<u16>,
    /// Column of the misclosure.
    last: usize,
    running: bool,
    interval: Option<u32>,
    /// Columns and misclosure in whole vectors of four.
    quads: usize,
    normal: [[f64; WIDE]; WIDE],
    /// Visible quantities times columns, for the interval's first and second epoch.
    border: [[[f64; WIDE]; VISIBLE]; 2],
    /// Pairs of visible quantities: first epoch, first with second, second.
    pairs: [[f64; PAIRS]; 3],
    /// The widest instructions of this machine; they give the same bits as any others.
    arch: Arch,
}

/// Runs a block of code with the constant `$q` of a number of vectors.
macro_rules! with_quads {
    ($quads:expr, $q:ident => $body:expr) => {
        match $quads {
            1 => {
                const $q: usize = 1;
                $body
            }
            2 => {
                const $q: usize = 2;
                $body
            }
            3 => {
                const $q: usize = 3;
                $body
            }
            4 => {
                const $q: usize = 4;
                $body
            }
            5 => {
                const $q: usize = 5;
                $body
            }
            6 => {
                const $q: usize = 6;
                $body
            }
            7 => {
                const $q: usize = 7;
                $body
            }
            8 => {
                const $q: usize = 8;
                $body
            }
            _ => {
                const $q: usize = 9;
                $body
            }
        }
    };
}

/// A row to be added with the widest instructions.
struct Addition<'a, 'r> {
    run: &'a mut Run,
    weighted: &'a Weighted<'r>,
}

impl WithSimd for Addition<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        with_quads!(self.run.quads, Q => self.run.add_quads::<Q>(self.weighted));
    }
}

impl Run {
    pub(super) fn new() -> Self {
        Run {
            columns: Vec::with_capacity(WIDE),
            last: 0,
            running: false,
            interval: None,
            quads: 0,
            normal: [[0.0; WIDE]; WIDE],
            border: [[[0.0; WIDE]; VISIBLE]; 2],
            pairs: [[0.0; PAIRS]; 3],
            arch: Arch::new(),
        }
    }

    /// Whether a row belongs to this run.
    #[inline]
    pub(super) fn takes(&self, row: &Row) -> bool {
        let interval = row.chain.as_ref().map(|chain| chain.interval);
        self.running && self.interval == interval && self.columns == row.columns()
    }

    /// Starts a run with the columns of `row`; `last` is the column of the misclosure.
    pub(super) fn start(&mut self, row: &Row, last: usize) {
        self.columns.clear();
        self.columns.extend_from_slice(row.columns());
        (self.last, self.running) = (last, true);
        self.interval = row.chain.map(|chain| chain.interval);
        self.quads = (self.columns.len() + 1).div_ceil(4);
        with_quads!(self.quads, Q => self.clear::<Q>());
    }

    /// Clears what rows of this width use; the rest is never read.
    #[inline(always)]
    fn clear<const Q: usize>(&mut self) {
        let clear = |sums: &mut [f64; WIDE]| sums.as_chunks_mut::<4>().0[..Q].fill([0.0; 4]);
        self.normal[..4 * Q].iter_mut().for_each(clear);
        if self.interval.is_some() {
            self.border.as_flattened_mut().iter_mut().for_each(clear);
            self.pairs = [[0.0; PAIRS]; 3];
        }
    }

    /// Adds a row of this run.
    #[inline]
    pub(super) fn add(&mut self, weighted: &Weighted) {
        let arch = self.arch;
        arch.dispatch(Addition {
            run: self,
            weighted,
        });
    }

    #[inline(always)]
    fn add_quads<const Q: usize>(&mut self, weighted: &Weighted) {
        let mut a = [[0.0; 4]; Q];
        let values = weighted.row.values();
        a.as_flattened_mut()[..values.len()].copy_from_slice(values);
        a.as_flattened_mut()[values.len()] = weighted.row.misclosure;
        for block in 0..Q {
            for i in 0..4 {
                let s = weighted.weight * a[block][i];
                let sums = self.normal[4 * block + i].as_chunks_mut::<4>().0;
                for q in block..Q {
                    axpy(s, &a[q], &mut sums[q]);
                }
            }
        }
        if let Some(chain) = &weighted.row.chain {
            self.add_chain(chain, weighted.weight, &a);
        }
    }

    #[inline(always)]
    fn add_chain<const Q: usize>(&mut self, chain: &ChainRow, weight: f64, a: &[[f64; 4]; Q]) {
        let (w0, w1) = (chain.weight0, chain.weight1);
        for (epoch, w) in self.border.iter_mut().zip([w0, w1]) {
            for (sums, visible) in epoch.iter_mut().zip(chain.visible) {
                let sums = sums.as_chunks_mut::<4>().0;
                for q in 0..Q {
                    axpy(weight * visible * w, &a[q], &mut sums[q]);
                }
            }
        }
        let products = upper_products(&chain.visible);
        for (sums, factor) in self.pairs.iter_mut().zip([w0 * w0, w0 * w1, w1 * w1]) {
            let factor = weight * factor;
            sums.iter_mut()
                .zip(&products)
                .for_each(|(sum, product)| *sum += factor * product);
        }
    }

    /// Scatters the sums and forgets them.
    pub(super) fn flush(&mut self, normal: &mut Normal, window: Option<&mut Window>) {
        if !self.running {
            return;
        }
        let columns = || self.columns.iter().map(|column| usize::from(*column));
        let all: Vec<usize> = columns().chain([self.last]).collect();
        normal.scatter(&all, &self.normal);
        if let (Some(interval), Some(window)) = (self.interval, window) {
            window.scatter(interval as usize, &all, &self.border, &self.pairs);
        }
        self.running = false;
    }
}

/// `y += s x`.
#[inline(always)]
fn axpy(s: f64, x: &[f64; 4], y: &mut [f64; 4]) {
    for (x, y) in x.iter().zip(y) {
        *y += s * x;
    }
}

#[inline(always)]
fn upper_products(v: &[f64; VISIBLE]) -> [f64; PAIRS] {
    let mut products = [0.0; PAIRS];
    let mut k = 0;
    for i in 0..VISIBLE {
        for j in i..VISIBLE {
            products[k] = v[i] * v[j];
            k += 1;
        }
    }
    products
}

/// Sums over the intervals of a stretch of epochs, in visible quantities. It has one epoch more than intervals; that last epoch
/// is the first of the next window.
pub(super) struct Window {
    /// Intervals covered.
    pub intervals: Range<usize>,
    width: usize,
    border: Vec<f64>,
    own: Vec<[f64; PAIRS]>,
    next: Vec<[f64; PAIRS]>,
}

impl Window {
    pub(super) fn zero(intervals: Range<usize>, width: usize) -> Self {
        let epochs = intervals.len() + 1;
        Window {
            width,
            border: vec![0.0; epochs * VISIBLE * width],
            own: vec![[0.0; PAIRS]; epochs],
            next: vec![[0.0; PAIRS]; intervals.len()],
            intervals,
        }
    }

    fn scatter(
        &mut self,
        interval: usize,
        columns: &[usize],
        border: &[[[f64; WIDE]; VISIBLE]; 2],
        pairs: &[[f64; PAIRS]; 3],
    ) {
        let local = interval - self.intervals.start;
        add_pairs(&mut self.own[local], &pairs[0]);
        add_pairs(&mut self.next[local], &pairs[1]);
        add_pairs(&mut self.own[local + 1], &pairs[2]);
        for (i, sums) in border.iter().flatten().enumerate() {
            let row = &mut self.border[(local * VISIBLE + i) * self.width..][..self.width];
            columns
                .iter()
                .zip(sums)
                .for_each(|(column, sum)| row[*column] += sum);
        }
    }

    /// A window of no interval and one epoch: what this window leaves at the epoch it shares with the next.
    pub(super) fn last_epoch(&self) -> Window {
        let epoch = self.intervals.len();
        Window {
            intervals: self.intervals.end..self.intervals.end,
            width: self.width,
            border: self.border[epoch * VISIBLE * self.width..].to_vec(),
            own: vec![self.own[epoch]],
            next: Vec::new(),
        }
    }

    /// Adds what the window before left at the shared epoch.
    pub(super) fn take_over(&mut self, spill: &Window) {
        add_pairs(&mut self.own[0], &spill.own[0]);
        self.border
            .iter_mut()
            .zip(&spill.border)
            .for_each(|(a, b)| *a += b);
    }

    /// Border of a local epoch: visible quantity `i` times all columns and the misclosure.
    #[inline]
    pub(super) fn border(&self, local: usize, i: usize) -> &[f64] {
        &self.border[(local * VISIBLE + i) * self.width..][..self.width]
    }

    /// Sum of pairs at a local epoch.
    #[inline]
    pub(super) fn own(&self, local: usize) -> &[f64; PAIRS] {
        &self.own[local]
    }

    /// Sum of pairs between a local epoch and the next.
    #[inline]
    pub(super) fn next(&self, local: usize) -> &[f64; PAIRS] {
        &self.next[local]
    }
}

fn add_pairs(a: &mut [f64; PAIRS], b: &[f64; PAIRS]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
}

/// Place of the pair `(i, j)` of visible quantities.
#[inline]
pub(super) fn pair(i: usize, j: usize) -> usize {
    let (i, j) = (i.min(j), i.max(j));
    i * VISIBLE - i * (i + 1) / 2 + j
}
