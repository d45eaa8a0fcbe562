//! Dense sums in a fixed order.
//!
//! Libraries of linear algebra choose their block sizes, and whether they fuse a product with a sum, by the CPU that they find; their
//! last bits follow. Here each entry is a sum of rounded products in the order of the inner index, started from what stands there.
//! The widest instructions only do several entries at once, so they change no bit.

use nalgebra::{DMatrix, Dim, Matrix, RawStorage};
use pulp::{Arch, Simd, WithSimd};

/// Entries of a column that are summed at once: four vectors of four.
const STRIP: usize = 16;

/// Columns that are eliminated together in a factorisation.
const PANEL: usize = 32;

/// Rows whose squares are summed before they go to their place.
const ROWS: usize = 256;

/// `a b`. For small fixed sizes nalgebra's own operator does the same; with sizes known only at run time it calls a library that
/// chooses its sums by the CPU.
///
/// # Panics
/// If `a` has not as many columns as `b` has rows.
#[must_use]
pub fn product<R1: Dim, C1: Dim, R2: Dim, C2: Dim>(
    a: &Matrix<f64, R1, C1, impl RawStorage<f64, R1, C1>>,
    b: &Matrix<f64, R2, C2, impl RawStorage<f64, R2, C2>>,
) -> DMatrix<f64> {
    assert_eq!(a.ncols(), b.nrows(), "sizes of a product");
    let rows = a.nrows();
    let left: Vec<f64> = a.iter().copied().collect();
    let mut out = DMatrix::zeros(rows, b.ncols());
    if rows == 0 {
        return out;
    }
    for (mut column, factors) in out.column_iter_mut().zip(b.column_iter()) {
        let factors: Vec<f64> = factors.iter().copied().collect();
        Arch::new().dispatch(Columns {
            sums: column.as_mut_slice(),
            factors: &factors,
            columns: &left,
            stride: rows,
        });
    }
    out
}

/// Adds to `sums` the columns of `columns`, `stride` apart, each times its factor.
struct Columns<'a> {
    sums: &'a mut [f64],
    factors: &'a [f64],
    columns: &'a [f64],
    stride: usize,
}

impl WithSimd for Columns<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let (strips, rest) = self.sums.as_chunks_mut::<STRIP>();
        let begin = strips.len() * STRIP;
        for (at, strip) in strips.iter_mut().enumerate() {
            let mut sums = *strip;
            for (factor, column) in self.factors.iter().zip(self.columns.chunks(self.stride)) {
                let Some(column) = column[at * STRIP..].first_chunk::<STRIP>() else {
                    continue;
                };
                for (sum, x) in sums.iter_mut().zip(column) {
                    *sum += factor * x;
                }
            }
            *strip = sums;
        }
        for (factor, column) in self.factors.iter().zip(self.columns.chunks(self.stride)) {
            for (sum, x) in rest.iter_mut().zip(&column[begin..]) {
                *sum += factor * x;
            }
        }
    }
}

/// Adds `W^T W` to the square matrix `out`; `rows` holds the rows of W in whole vectors of four, `quads` of them to a row, and W
/// begins with the column `first` and is as wide as `out`.
pub fn add_squares(out: &mut DMatrix<f64>, rows: &[[f64; 4]], quads: usize, first: usize) {
    let arch = Arch::new();
    for some in rows.chunks(ROWS * quads) {
        for i in first / 4..quads {
            for j in (i..quads).step_by(2) {
                let sums = arch.dispatch(Squares {
                    rows: some,
                    quads,
                    pair: (i, j),
                });
                place(out, &sums, (4 * i, 4 * j), first);
            }
        }
    }
}

/// Sums of products of the columns `4 i ..` with the columns `4 j ..`, two vectors of the latter.
struct Squares<'a> {
    rows: &'a [[f64; 4]],
    quads: usize,
    pair: (usize, usize),
}

impl WithSimd for Squares<'_> {
    type Output = [[[f64; 4]; 2]; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let (i, j) = self.pair;
        let second = (j + 1).min(self.quads - 1);
        let mut sums = [[[0.0; 4]; 2]; 4];
        for row in self.rows.chunks_exact(self.quads) {
            let (a, b, c) = (row[i], row[j], row[second]);
            for (sums, a) in sums.iter_mut().zip(a) {
                for (sum, b) in sums[0].iter_mut().zip(b) {
                    *sum += a * b;
                }
                for (sum, c) in sums[1].iter_mut().zip(c) {
                    *sum += a * c;
                }
            }
        }
        sums
    }
}

/// Puts sums of products at both their places; what lies beside the matrix or below the diagonal is left out.
fn place(out: &mut DMatrix<f64>, sums: &[[[f64; 4]; 2]; 4], corner: (usize, usize), first: usize) {
    for (a, row) in sums.iter().enumerate() {
        for (b, sum) in row.as_flattened().iter().enumerate() {
            let (i, j) = (corner.0 + a, corner.1 + b);
            if i < first || j < i || j - first >= out.ncols() {
                continue;
            }
            let (i, j) = (i - first, j - first);
            out[(i, j)] += sum;
            if i != j {
                out[(j, i)] += sum;
            }
        }
    }
}

/// Solves `A X = B` for a symmetric positive definite A, of which the lower triangle is read and overwritten with its factor; X takes
/// B's place. `None` where A is not positive definite.
#[must_use]
pub fn solve_positive(a: &mut DMatrix<f64>, b: &mut DMatrix<f64>) -> Option<()> {
    let size = a.nrows();
    for begin in (0..size).step_by(PANEL) {
        let end = (begin + PANEL).min(size);
        for k in begin..end {
            subtract(a, begin..k, k);
            let pivot = a[(k, k)];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            let root = pivot.sqrt();
            let column = &mut a.as_mut_slice()[k * size..(k + 1) * size];
            column[k..].iter_mut().for_each(|entry| *entry /= root);
        }
        for k in end..size {
            subtract(a, begin..end, k);
        }
    }
    for mut column in b.column_iter_mut() {
        substitute(a.as_slice(), column.as_mut_slice());
    }
    Some(())
}

/// What the columns `done` take from the column `k` on and below the diagonal.
fn subtract(a: &mut DMatrix<f64>, done: std::ops::Range<usize>, k: usize) {
    let size = a.nrows();
    let mut factors = [0.0; PANEL];
    for (factor, p) in factors.iter_mut().zip(done.clone()) {
        *factor = -a[(k, p)];
    }
    let (before, from) = a.as_mut_slice().split_at_mut(k * size);
    if done.is_empty() {
        return;
    }
    Arch::new().dispatch(Columns {
        sums: &mut from[k..size],
        factors: &factors[..done.len()],
        columns: &before[done.start * size + k..],
        stride: size,
    });
}

/// `x <- L^-T L^-1 x`, L by columns.
fn substitute(lower: &[f64], x: &mut [f64]) {
    let size = x.len();
    for k in 0..size {
        let column = &lower[k * size..(k + 1) * size];
        x[k] /= column[k];
        let (known, below) = x.split_at_mut(k + 1);
        for (x, l) in below.iter_mut().zip(&column[k + 1..]) {
            *x -= known[k] * l;
        }
    }
    for k in (0..size).rev() {
        let column = &lower[k * size..(k + 1) * size];
        let known: f64 = column[k + 1..]
            .iter()
            .zip(&x[k + 1..])
            .map(|(l, x)| l * x)
            .sum();
        x[k] = (x[k] - known) / column[k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries without a pattern, from -1 to 1.
    fn filled(rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| {
            (0.618_033_988_749_894_9 * (1 + i + 37 * j) as f64).fract() * 2.0 - 1.0
        })
    }

    /// The definition, one rounded product after the other.
    fn plain(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| {
            (0..a.ncols()).fold(0.0, |sum, p| sum + b[(p, j)] * a[(i, p)])
        })
    }

    #[test]
    fn a_product_is_the_plain_sum_to_the_last_bit() {
        for (rows, inner, columns) in [(1, 1, 1), (6, 6, 6), (16, 9, 3), (37, 40, 21), (0, 3, 2)] {
            let (a, b) = (filled(rows, inner), filled(inner, columns));
            assert_eq!(product(&a, &b), plain(&a, &b), "{rows} {inner} {columns}");
        }
    }

    #[test]
    fn squares_are_those_of_the_columns_wanted() {
        for (quads, first, width) in [(3, 3, 8), (5, 10, 7), (6, 9, 15), (1, 0, 4), (4, 12, 1)] {
            let count = 700;
            let all = filled(4 * quads, count);
            let (rows, _) = all.as_slice().as_chunks::<4>();
            let mut found = DMatrix::from_element(width, width, 0.5);
            add_squares(&mut found, rows, quads, first);
            let w = all.rows(first, width).transpose();
            let expected = w.tr_mul(&w).add_scalar(0.5);
            assert!((&found - expected).amax() < 1e-12 * count as f64);
            assert_eq!(found, found.transpose());
        }
    }

    #[test]
    fn a_positive_definite_matrix_is_solved() {
        for size in [1, 5, 31, 32, 33, 100] {
            let root = filled(size, size);
            let matrix = plain(&root, &root.transpose()) + DMatrix::identity(size, size);
            let right = filled(size, 3);
            let (mut factor, mut found) = (matrix.clone(), right.clone());
            solve_positive(&mut factor, &mut found).expect("positive definite");
            let left = (plain(&matrix, &found) - right).amax();
            assert!(left < 1e-11, "{size}: {left}");
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_refused() {
        let mut negative = DMatrix::identity(40, 40);
        negative[(35, 35)] = -1e-3;
        assert!(solve_positive(&mut negative, &mut filled(40, 1)).is_none());
        let mut none = DMatrix::from_element(1, 1, f64::NAN);
        assert!(solve_positive(&mut none, &mut filled(1, 1)).is_none());
    }
}
