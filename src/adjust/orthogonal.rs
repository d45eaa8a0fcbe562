//! Orthogonalisation of the whitened Jacobian, chunk by chunk, so that no digit is lost to normal equations.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::error::AdjustError;
use super::linearise::Linearisation;
use super::partition::chunks;
use super::pass::{Pass, Tally};
use super::problem::Estimate;
use super::spectrum::Reduced;

/// Rows orthogonalised at a time.
const QR_CHUNK: usize = 256;
/// Linearises a problem without chain.
pub(super) fn orthogonalised(pass: &Pass) -> Result<Linearisation, AdjustError> {
    let free = pass.at.parameters.free_columns();
    let chunks = chunks(pass.problem, QR_CHUNK, |_| true);
    let parts: Result<Vec<_>, _> = chunks
        .into_par_iter()
        .map(|(set, range)| whitened(pass, set, range, &free))
        .collect();
    let mut tally = Tally::default();
    let (priors, prior_cost) = prior_rows(pass.at, &free)?;
    let mut root = priors;
    for (rows, part) in parts? {
        tally.add(&part);
        root = triangle(stacked(&root, &rows));
    }
    let n = free.len();
    let residuals: Vec<f64> = root.column(n).iter().copied().collect();
    let reduced = Reduced::Root {
        factor: root.columns(0, n).into_owned(),
        residuals,
    };
    Linearisation::new(pass, reduced, tally, prior_cost)
}

/// Whitened Jacobian of a chunk with its residuals as last column, already triangular.
fn whitened(
    pass: &Pass,
    set: usize,
    range: Range<usize>,
    free: &[usize],
) -> Result<(DMatrix<f64>, Tally), AdjustError> {
    let place = places(pass.at.parameters.columns(), free);
    let mut rows = DMatrix::zeros(range.len(), free.len() + 1);
    let first = range.start;
    let tally = pass.visit(set, range, |weighted| {
        let (i, root) = (weighted.condition - first, weighted.weight.sqrt());
        for (column, value) in weighted.row.columns().iter().zip(weighted.row.values()) {
            if let Some(j) = place[usize::from(*column)] {
                rows[(i, j)] += root * value;
            }
        }
        rows[(i, free.len())] = root * weighted.row.misclosure;
    })?;
    Ok((triangle(rows), tally))
}

fn places(columns: usize, free: &[usize]) -> Vec<Option<usize>> {
    let mut place = vec![None; columns];
    free.iter()
        .enumerate()
        .for_each(|(j, column)| place[*column] = Some(j));
    place
}

/// Priors as whitened rows over the free columns, residuals last; and their cost.
fn prior_rows(at: &Estimate, free: &[usize]) -> Result<(DMatrix<f64>, f64), AdjustError> {
    let place = places(at.parameters.columns(), free);
    let priors = at.parameters.prior_rows()?;
    let mut rows = DMatrix::zeros(priors.len(), free.len() + 1);
    for (i, prior) in priors.iter().enumerate() {
        for (k, value) in prior.derivatives.iter().enumerate() {
            if let Some(j) = place[prior.column + k] {
                rows[(i, j)] = *value;
            }
        }
        rows[(i, free.len())] = prior.residual;
    }
    let cost = priors
        .iter()
        .map(|prior| 0.5 * prior.residual * prior.residual)
        .sum();
    Ok((rows, cost))
}

fn stacked(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = DMatrix::zeros(a.nrows() + b.nrows(), a.ncols());
    both.rows_mut(0, a.nrows()).copy_from(a);
    both.rows_mut(a.nrows(), b.nrows()).copy_from(b);
    both
}

/// Triangular factor of a matrix that has more rows than columns; other matrices as they are.
fn triangle(rows: DMatrix<f64>) -> DMatrix<f64> {
    if rows.nrows() <= rows.ncols() {
        return rows;
    }
    rows.qr().unpack_r()
}
