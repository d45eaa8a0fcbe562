//! Sums over weighted conditions: normal equations of the parameters, and of the chain in visible quantities.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::chain::VISIBLE;
use super::condition::Row;
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

/// Rows added at a time: sums are loaded and stored once for all of them, and added to in the rows' order, so that the bits are those of one by one.
const TOGETHER: usize = 4;

/// A row as it is added: derivatives and misclosure in vectors of four, zeros behind them.
#[derive(Clone, Copy)]
struct Held {
    values: [[f64; 4]; WIDE / 4],
    weight: f64,
    /// Weights of the interval's epochs and derivatives by the visible quantities.
    epochs: [f64; 2],
    visible: [f64; VISIBLE],
}

impl Held {
    const NONE: Held = Held {
        values: [[0.0; 4]; WIDE / 4],
        weight: 0.0,
        epochs: [0.0; 2],
        visible: [0.0; VISIBLE],
    };

    /// Takes up a row of a run whose rows have all as many columns.
    #[inline]
    fn take(&mut self, weighted: &Weighted) {
        let values = weighted.row.values();
        let places = self.values.as_flattened_mut();
        places[..values.len()].copy_from_slice(values);
        places[values.len()] = weighted.row.misclosure;
        let end = (values.len() + 1).next_multiple_of(4);
        places[values.len() + 1..end].fill(0.0);
        self.weight = weighted.weight;
        if let Some(chain) = &weighted.row.chain {
            self.epochs = [chain.weight0, chain.weight1];
            self.visible = chain.visible;
        }
    }
}

/// What a run sums.
struct Sums {
    normal: [[f64; WIDE]; WIDE],
    /// Visible quantities times columns, for the interval's first and second epoch.
    border: [[[f64; WIDE]; VISIBLE]; 2],
    /// Pairs of visible quantities: first epoch, first with second, second.
    pairs: [[f64; PAIRS]; 3],
}

impl Sums {
    const ZERO: Sums = Sums {
        normal: [[0.0; WIDE]; WIDE],
        border: [[[0.0; WIDE]; VISIBLE]; 2],
        pairs: [[0.0; PAIRS]; 3],
    };

    /// Clears what rows of this width use; the rest is never read.
    #[inline(always)]
    fn clear<const Q: usize>(&mut self, chained: bool) {
        let clear = |sums: &mut [f64; WIDE]| sums.as_chunks_mut::<4>().0[..Q].fill([0.0; 4]);
        self.normal[..4 * Q].iter_mut().for_each(clear);
        if chained {
            self.border.as_flattened_mut().iter_mut().for_each(clear);
            self.pairs = [[0.0; PAIRS]; 3];
        }
    }

    #[inline(always)]
    fn add<const Q: usize, const N: usize>(&mut self, rows: &[Held; N], chained: bool) {
        for block in 0..Q {
            for i in 0..4 {
                let sums = self.normal[4 * block + i].as_chunks_mut::<4>().0;
                let factors: [f64; N] =
                    std::array::from_fn(|k| rows[k].weight * rows[k].values[block][i]);
                for (q, sums) in sums.iter_mut().enumerate().take(Q).skip(block) {
                    add_multiples(&factors, rows, q, sums);
                }
            }
        }
        if chained {
            self.add_chain::<Q, N>(rows);
        }
    }

    #[inline(always)]
    fn add_chain<const Q: usize, const N: usize>(&mut self, rows: &[Held; N]) {
        for (e, epoch) in self.border.iter_mut().enumerate() {
            for (v, sums) in epoch.iter_mut().enumerate() {
                let factors: [f64; N] = std::array::from_fn(|k| {
                    rows[k].weight * rows[k].visible[v] * rows[k].epochs[e]
                });
                let sums = sums.as_chunks_mut::<4>().0;
                for (q, sums) in sums.iter_mut().enumerate().take(Q) {
                    add_multiples(&factors, rows, q, sums);
                }
            }
        }
        for row in rows {
            let products = upper_products(&row.visible);
            let [w0, w1] = row.epochs;
            for (sums, factor) in self.pairs.iter_mut().zip([w0 * w0, w0 * w1, w1 * w1]) {
                let factor = row.weight * factor;
                sums.iter_mut()
                    .zip(&products)
                    .for_each(|(sum, product)| *sum += factor * product);
            }
        }
    }
}

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
    sums: Sums,
    /// Rows that wait to be added, the first `waiting` of them.
    held: [Held; TOGETHER],
    waiting: usize,
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

/// The rows of a run that wait, to be added with the widest instructions.
struct Addition<'a>(&'a mut Run);

impl WithSimd for Addition<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        with_quads!(self.0.quads, Q => self.0.add_quads::<Q>());
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
            sums: Sums::ZERO,
            held: [Held::NONE; TOGETHER],
            waiting: 0,
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
        self.waiting = 0;
        with_quads!(self.quads, Q => self.sums.clear::<Q>(self.interval.is_some()));
    }

    /// Adds a row of this run, or holds it until there are some.
    #[inline]
    pub(super) fn add(&mut self, weighted: &Weighted) {
        self.held[self.waiting].take(weighted);
        self.waiting += 1;
        if self.waiting == TOGETHER {
            self.add_held();
        }
    }

    /// Adds the rows that wait.
    fn add_held(&mut self) {
        let arch = self.arch;
        arch.dispatch(Addition(self));
        self.waiting = 0;
    }

    #[inline(always)]
    fn add_quads<const Q: usize>(&mut self) {
        let chained = self.interval.is_some();
        if self.waiting == TOGETHER {
            return self.sums.add::<Q, TOGETHER>(&self.held, chained);
        }
        for row in &self.held[..self.waiting] {
            self.sums.add::<Q, 1>(std::array::from_ref(row), chained);
        }
    }

    /// Scatters the sums and forgets them.
    pub(super) fn flush(&mut self, normal: &mut Normal, window: Option<&mut Window>) {
        if !self.running {
            return;
        }
        if self.waiting > 0 {
            self.add_held();
        }
        let columns = || self.columns.iter().map(|column| usize::from(*column));
        let all: Vec<usize> = columns().chain([self.last]).collect();
        normal.scatter(&all, &self.sums.normal);
        if let (Some(interval), Some(window)) = (self.interval, window) {
            window.scatter(interval as usize, &all, &self.sums.border, &self.sums.pairs);
        }
        self.running = false;
    }
}

/// Adds to `sums` each row's vector `q` times its factor, in the order of the rows.
#[inline(always)]
fn add_multiples<const N: usize>(
    factors: &[f64; N],
    rows: &[Held; N],
    q: usize,
    sums: &mut [f64; 4],
) {
    let mut all = *sums;
    for (factor, row) in factors.iter().zip(rows) {
        for (sum, value) in all.iter_mut().zip(&row.values[q]) {
            *sum += factor * value;
        }
    }
    *sums = all;
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

#[cfg(test)]
mod tests {
    use super::super::condition::ChainRow;
    use super::*;

    /// Rows of one run with five columns, the chain in them or not.
    fn rows(chained: bool) -> Vec<Row> {
        let value = |k: usize| crate::math::sin(0.7 * k as f64) * 1e3;
        let row = |k: usize| {
            let mut row = Row::default();
            row.clear();
            for column in 0..5 {
                row.push(2 * column, value(7 * k + column));
            }
            row.misclosure = value(100 + k);
            row.chain = chained.then(|| ChainRow {
                interval: 3,
                weight0: 0.25,
                weight1: 0.75,
                visible: std::array::from_fn(|v| value(200 + 11 * k + v)),
            });
            row
        };
        (0..11).map(row).collect()
    }

    /// The sums of the same rows, each added for itself.
    fn one_by_one(rows: &[Row], normal: &mut Normal, window: &mut Window) {
        let weight = 0.3;
        for row in rows {
            let all: Vec<f64> = row
                .values()
                .iter()
                .copied()
                .chain([row.misclosure])
                .collect();
            let places: Vec<usize> = row.columns().iter().map(|c| usize::from(*c)).collect();
            let places: Vec<usize> = places.into_iter().chain([normal.width - 1]).collect();
            for i in 0..all.len() {
                for j in i..all.len() {
                    normal.values[places[i] * normal.width + places[j]] += weight * all[i] * all[j];
                }
            }
            let Some(chain) = &row.chain else { continue };
            for (e, w) in [chain.weight0, chain.weight1].into_iter().enumerate() {
                for (v, visible) in chain.visible.iter().enumerate() {
                    for (place, value) in places.iter().zip(&all) {
                        let at = (e * VISIBLE + v) * window.width + place;
                        window.border[at] += weight * visible * w * value;
                    }
                }
            }
            let products = upper_products(&chain.visible);
            let (w0, w1) = (chain.weight0, chain.weight1);
            let sums = [(w0 * w0, 0), (w0 * w1, 1), (w1 * w1, 2)];
            for (factor, which) in sums {
                let sums = match which {
                    0 => &mut window.own[0],
                    1 => &mut window.next[0],
                    _ => &mut window.own[1],
                };
                for (sum, product) in sums.iter_mut().zip(&products) {
                    *sum += weight * factor * product;
                }
            }
        }
    }

    /// Bit for bit, whatever the number of rows that are left at the end.
    #[test]
    fn rows_added_together_sum_as_one_by_one() {
        for (count, chained) in (0..12).flat_map(|n| [(n, false), (n, true)]) {
            let rows = &rows(chained)[..count];
            let window = || Window::zero(3..4, 11);
            let (mut expected, mut expected_window) = (Normal::zero(10), window());
            one_by_one(rows, &mut expected, &mut expected_window);
            let (mut normal, mut window, mut run) = (Normal::zero(10), window(), Run::new());
            for (condition, row) in rows.iter().enumerate() {
                if !run.takes(row) {
                    run.flush(&mut normal, Some(&mut window));
                    run.start(row, 10);
                }
                run.add(&Weighted {
                    condition,
                    row,
                    variance: 1.0,
                    weight: 0.3,
                });
            }
            run.flush(&mut normal, Some(&mut window));
            assert_eq!(normal, expected, "{count} {chained}");
            assert_eq!(window.border, expected_window.border, "{count}");
            assert_eq!(window.own, expected_window.own, "{count}");
            assert_eq!(window.next, expected_window.next, "{count}");
        }
    }
}
