//! Symmetric positive definite systems whose unknowns each meet few others: rows stored from their first entry on, factored in place.
//!
//! The order is the reversed Cuthill-McKee one (George and Liu, *Computer Solution of Large Sparse Positive Definite Systems*, 1981,
//! ch. 4): it keeps what meets together, so that a row is as long as the survey is wide and not as the survey is long. Unknowns
//! that meet everything stand last. Sums run in a fixed order, so that the result does not depend on the CPU.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

/// A symmetric matrix, its lower triangle row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Skyline {
    /// Row of each unknown.
    place: Vec<usize>,
    /// First column of each row.
    first: Vec<usize>,
    /// Where each row begins in `values`; one more for the end.
    start: Vec<usize>,
    values: Vec<f64>,
}

impl Skyline {
    /// Zero, with room for every pair within each of the `groups`; the first `border` unknowns meet all others.
    #[must_use]
    pub fn new<'g>(
        size: usize,
        border: usize,
        groups: impl Iterator<Item = &'g [usize]> + Clone,
    ) -> Self {
        let meet = neighbours(size, border, groups);
        let order = order(&meet, border);
        let mut place = vec![0; size];
        for (row, unknown) in order.iter().enumerate() {
            place[*unknown] = row;
        }
        let inner = size - border;
        let reach = |(row, unknown): (usize, &usize)| {
            if row >= inner {
                return 0;
            }
            let columns = meet[*unknown].iter().map(|k| place[*k as usize]);
            columns.min().unwrap_or(row).min(row)
        };
        let first: Vec<usize> = order.iter().enumerate().map(reach).collect();
        let mut start = vec![0];
        for (row, column) in first.iter().enumerate() {
            start.push(start[row] + row + 1 - column);
        }
        let values = vec![0.0; start[size]];
        Self {
            place,
            first,
            start,
            values,
        }
    }

    fn at(&self, i: usize, j: usize) -> usize {
        let (row, column) = (
            self.place[i].max(self.place[j]),
            self.place[i].min(self.place[j]),
        );
        assert!(
            column >= self.first[row],
            "unknowns {i} and {j} share no group"
        );
        self.start[row] + column - self.first[row]
    }

    /// Adds to the entry of two unknowns, and to its mirror image.
    ///
    /// # Panics
    /// If no group has both.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let at = self.at(i, j);
        self.values[at] += value;
    }

    /// The entry of an unknown on the diagonal.
    #[must_use]
    pub fn diagonal(&self, i: usize) -> f64 {
        self.values[self.at(i, i)]
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.values[self.start[row]..self.start[row + 1]]
    }

    /// Solves for each right-hand side; `None` where the matrix is not positive definite.
    #[must_use]
    pub fn solve(mut self, right: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let scale = self.scaled();
        self.factor(self.first.len())?;
        let solved = |b: &Vec<f64>| {
            let mut x = vec![0.0; b.len()];
            for (unknown, value) in b.iter().enumerate() {
                let row = self.place[unknown];
                x[row] = value * scale[row];
            }
            self.substitute(&mut x);
            let of = |unknown: usize| x[self.place[unknown]] * scale[self.place[unknown]];
            (0..b.len()).map(of).collect()
        };
        Some(right.iter().map(solved).collect())
    }

    /// What is left for the first `border` unknowns once all others are eliminated: the lower triangle and its mirror image, and the
    /// right-hand side; `None` where the matrix of the others is not positive definite.
    #[must_use]
    pub fn reduced(mut self, border: usize, right: &[f64]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let scale = self.scaled();
        let inner = self.first.len() - border;
        self.factor(inner)?;
        let mut x = vec![0.0; right.len()];
        for (unknown, value) in right.iter().enumerate() {
            x[self.place[unknown]] = value * scale[self.place[unknown]];
        }
        for row in 0..right.len() {
            let (own, first, end) = (self.row(row), self.first[row], row.min(inner));
            x[row] -= dot(&own[..end - first], &x[first..end]);
            if row < inner {
                x[row] /= own[own.len() - 1];
            }
        }
        let left = |i: usize, j: usize| {
            let (row, column) = (self.place[i], self.place[j]);
            self.values[self.at(i, j)] / (scale[row] * scale[column])
        };
        let of = |unknown: usize| x[self.place[unknown]] / scale[self.place[unknown]];
        let right = DVector::from_iterator(border, (0..border).map(of));
        Some((DMatrix::from_fn(border, border, left), right))
    }

    /// Makes the diagonal one; the factors by row.
    fn scaled(&mut self) -> Vec<f64> {
        let size = self.first.len();
        let diagonal = |row: usize| self.values[self.start[row + 1] - 1];
        let scale: Vec<f64> = (0..size)
            .map(|row| diagonal(row).max(1e-300).sqrt().recip())
            .collect();
        for row in 0..size {
            let (begin, end) = (self.start[row], self.start[row + 1]);
            let columns = &scale[self.first[row]..=row];
            for (value, column) in self.values[begin..end].iter_mut().zip(columns) {
                *value *= scale[row] * column;
            }
        }
        scale
    }

    /// The first `inner` rows become those of the Cholesky factor; of what stands behind them, what their elimination leaves.
    fn factor(&mut self, inner: usize) -> Option<()> {
        for row in 0..self.first.len() {
            let (done, rest) = self.values.split_at_mut(self.start[row]);
            let own = &mut rest[..row + 1 - self.first[row]];
            let first = self.first[row];
            for column in first..row {
                let begin = first.max(self.first[column]);
                let other = &done[self.start[column]..self.start[column + 1]];
                let left = &own[begin - first..column.min(inner) - first];
                let sum = dot(left, &other[begin - self.first[column]..][..left.len()]);
                own[column - first] -= sum;
                if column < inner {
                    own[column - first] /= other[column - self.first[column]];
                }
            }
            let before = &own[..row.min(inner) - first];
            let left = own[row - first] - dot(before, before);
            if row < inner && !(left > 0.0) {
                return None;
            }
            own[row - first] = if row < inner { left.sqrt() } else { left };
        }
        Some(())
    }

    /// Forward and backward substitution of the factor.
    fn substitute(&self, x: &mut [f64]) {
        let size = self.first.len();
        for row in 0..size {
            let own = self.row(row);
            let (before, pivot) = (&own[..own.len() - 1], own[own.len() - 1]);
            x[row] = (x[row] - dot(before, &x[self.first[row]..row])) / pivot;
        }
        for row in (0..size).rev() {
            let own = self.row(row);
            x[row] /= own[own.len() - 1];
            let found = x[row];
            for (value, factor) in x[self.first[row]..row].iter_mut().zip(own) {
                *value -= factor * found;
            }
        }
    }
}

/// Sums that run side by side.
const LANES: usize = 8;

/// `a' b`: eight sums side by side, then together; the same on any CPU.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (ours, theirs) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = (ours.remainder().iter().zip(theirs.remainder()))
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in ours.zip(theirs) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + b) + (c + d)) + ((e + f) + (g + h)) + rest
}

/// Which unknowns beyond the border each meets, ascending.
fn neighbours<'g>(
    size: usize,
    border: usize,
    groups: impl Iterator<Item = &'g [usize]>,
) -> Vec<Vec<u32>> {
    let mut meet: Vec<Vec<u32>> = vec![vec![]; size];
    for group in groups {
        for a in group.iter().filter(|k| **k >= border) {
            let others = group.iter().filter(|b| **b >= border && *b != a);
            meet[*a].extend(others.map(|b| *b as u32));
            // a group of many tiles on one spot says the same again and again
            if meet[*a].len() > 4096 {
                meet[*a].sort_unstable();
                meet[*a].dedup();
            }
        }
    }
    for all in &mut meet {
        all.sort_unstable();
        all.dedup();
    }
    meet
}

/// The unknowns in the order of their rows: reversed Cuthill-McKee, the border last.
fn order(meet: &[Vec<u32>], border: usize) -> Vec<usize> {
    let mut seen = vec![false; meet.len()];
    let mut order = Vec::with_capacity(meet.len());
    let mut by_degree: Vec<usize> = (border..meet.len()).collect();
    by_degree.sort_by_key(|k| (meet[*k].len(), *k));
    for begin in by_degree {
        if !seen[begin] {
            let far = last_of(meet, begin);
            breadth_first(meet, far, &mut seen, &mut order);
        }
    }
    order.reverse();
    order.extend(0..border);
    order
}

/// An end of the component that holds `begin`: the one last met from the one last met.
fn last_of(meet: &[Vec<u32>], begin: usize) -> usize {
    let once = |from: usize| {
        let (mut seen, mut all) = (vec![false; meet.len()], vec![]);
        breadth_first(meet, from, &mut seen, &mut all);
        all.last().copied().unwrap_or(from)
    };
    once(once(begin))
}

fn breadth_first(meet: &[Vec<u32>], from: usize, seen: &mut [bool], all: &mut Vec<usize>) {
    let mut queue = VecDeque::from([from]);
    seen[from] = true;
    while let Some(unknown) = queue.pop_front() {
        all.push(unknown);
        let mut next: Vec<usize> = meet[unknown].iter().map(|k| *k as usize).collect();
        next.retain(|k| !seen[*k]);
        next.sort_by_key(|k| (meet[*k].len(), *k));
        for k in next {
            seen[k] = true;
            queue.push_back(k);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two chains of 30 that meet rung by rung, in an order that is none, and two unknowns that meet all.
    fn ladder() -> (usize, Vec<Vec<usize>>) {
        let name = |side: usize, k: usize| 2 + (side * 30 + k) * 37 % 60;
        let rung = |k: usize| {
            vec![
                0,
                1,
                name(0, k),
                name(1, k),
                name(0, (k + 1).min(29)),
                name(1, (k + 1).min(29)),
            ]
        };
        (62, (0..29).map(rung).collect())
    }

    /// The ladder with numbers, sparse and dense, and a right-hand side.
    fn numbered() -> (Skyline, DMatrix<f64>, Vec<f64>) {
        let (size, groups) = ladder();
        let mut sparse = Skyline::new(size, 2, groups.iter().map(Vec::as_slice));
        let mut dense = DMatrix::zeros(size, size);
        for (g, group) in groups.iter().enumerate() {
            for (a, i) in group.iter().enumerate() {
                for (b, j) in group.iter().enumerate().take(a + 1) {
                    let value = if i == j {
                        9.0 + g as f64 * 0.1
                    } else {
                        ((a * 5 + b * 3 + g) % 7) as f64 * 0.2 - 0.6
                    };
                    sparse.add(*i, *j, value);
                    dense[(*i, *j)] += value;
                    if i != j {
                        dense[(*j, *i)] += value;
                    }
                }
            }
        }
        let right: Vec<f64> = (0..size).map(|k| ((k * 13) % 17) as f64 - 8.0).collect();
        (sparse, dense, right)
    }

    #[test]
    fn a_sparse_system_is_solved_as_a_dense_one() {
        let (sparse, dense, right) = numbered();
        let size = right.len();
        let expected = dense
            .cholesky()
            .expect("positive")
            .solve(&DVector::from(right.clone()));
        // two whole rows, and at most six entries of each other one
        let held = sparse.values.len();
        assert!(held < 2 * size + 6 * size, "{held}");
        let found = sparse.solve(&[right]).expect("positive");
        for (x, y) in found[0].iter().zip(&expected) {
            assert!((x - y).abs() < 1e-12, "{x} {y}");
        }
    }

    /// The border's own system has the border's part of the solution, also where the border itself is singular.
    #[test]
    fn the_border_is_left_when_all_else_is_eliminated() {
        let (sparse, dense, right) = numbered();
        let b = DVector::from(right.clone());
        let expected = dense.cholesky().expect("positive").solve(&b);
        let (left, own) = sparse.clone().reduced(2, &right).expect("positive");
        let found = left.clone().cholesky().expect("positive").solve(&own);
        assert!((found - expected.rows(0, 2)).amax() < 1e-12);
        let mut singular = sparse;
        singular.add(
            1,
            1,
            -left[(1, 1)] + left[(0, 1)] * left[(0, 1)] / left[(0, 0)],
        );
        let (left, _) = singular.reduced(2, &right).expect("positive inside");
        assert!(left.determinant().abs() < 1e-12 * left[(0, 0)] * left[(0, 0)]);
    }

    #[test]
    fn what_is_not_positive_definite_has_no_solution() {
        let mut saddle = Skyline::new(2, 0, [&[0usize, 1][..]].into_iter());
        for (i, j, value) in [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 2.0)] {
            saddle.add(i, j, value);
        }
        assert!(saddle.solve(&[vec![1.0, 0.0]]).is_none());
        let mut none = Skyline::new(1, 0, std::iter::empty());
        none.add(0, 0, f64::NAN);
        assert!(none.solve(&[vec![1.0]]).is_none());
    }
}
