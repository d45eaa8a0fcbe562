//! Dense sums in a fixed order.
//!
//! Libraries of linear algebra choose their block sizes, and whether they fuse a product with a sum, by the CPU that they find; their
//! last bits follow. Here each entry is a sum of rounded products in the order of the inner index, started from what stands there.
//! The widest instructions only do several entries at once, so they change no bit.

use nalgebra::{DMatrix, Dim, Matrix, RawStorage};
use pulp::{Arch, Simd, WithSimd};

/// Entries of a column that are summed at once: four vectors of four.
const STRIP: usize = 16;

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
}
