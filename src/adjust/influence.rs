//! Influence of single conditions and priors on the parameters sought: what an error of one of them does to the estimate.
//!
//! A small error `eps` of condition k moves its misclosure by `eps` and so the estimate by `dx = -(N^-1 A^T M^-1)_k eps`: the
//! column of the generalised inverse that the adjustment itself applies (Baarda 1968, external reliability; Hampel et al.,
//! *Robust Statistics*, 1986, sec. 2.1), the states of a chain eliminated. Summed with the conditions' variances, the chain's
//! processes and the priors these columns give the cofactors back: `N^-1 A^T M^-1 A N^-1 + N^-1 P N^-1 = N^-1`.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::condition::Row;
use super::error::AdjustError;
use super::partition::{chunks, conditions_of, sees_chain};
use super::pass::Pass;
use super::problem::{Problem, Source};
use super::selected::{Covariances, each_window};
use super::solve::Solution;

/// Rows of a chunk of a set without chain.
const CHUNK: usize = 4096;

/// Derivatives of the columns sought ([`super::ParameterSet::sought_columns`], the rows here) by the errors of conditions and
/// priors.
#[derive(Debug, Clone, PartialEq)]
pub struct Influence {
    /// Per set, a column per condition: per unit of the condition; zero for conditions that do not take part.
    pub conditions: Vec<DMatrix<f64>>,
    /// A column per whitened row of the priors ([`super::ParameterSet::prior_rows`]): per sigma.
    pub priors: DMatrix<f64>,
}

/// Influence of every condition and prior at a solution, with the weights of its last linearisation.
///
/// # Errors
/// What a pass can find wrong with the conditions.
pub fn influence(problem: &Problem, solution: &Solution) -> Result<Influence, AdjustError> {
    let reader = Reader {
        pass: Pass {
            problem,
            at: &solution.estimate,
            weighting: solution.weighting,
        },
        cofactor: &solution.cofactor,
        sought: solution.estimate.parameters.sought_columns(),
    };
    let zeros = |source: &Source| DMatrix::zeros(reader.sought.len(), source.conditions.len());
    let mut conditions: Vec<_> = problem.sources.iter().map(zeros).collect();
    reader.without_chain(&mut conditions)?;
    reader.with_chain(solution, &mut conditions)?;
    Ok(Influence {
        conditions,
        priors: reader.of_priors()?,
    })
}

/// Influences of a range of one set.
type Part = (usize, Range<usize>, DMatrix<f64>);

struct Reader<'a> {
    pass: Pass<'a>,
    cofactor: &'a DMatrix<f64>,
    sought: Vec<usize>,
}

impl Reader<'_> {
    fn without_chain(&self, out: &mut [DMatrix<f64>]) -> Result<(), AdjustError> {
        let problem = self.pass.problem;
        let chunks = chunks(problem, CHUNK, |set| {
            problem.chain.is_none() || !sees_chain(problem, set)
        });
        let parts: Result<Vec<Part>, AdjustError> = chunks
            .into_par_iter()
            .map(|(set, range)| self.range(set, range, None))
            .collect();
        parts?.into_iter().for_each(|part| keep(part, out));
        Ok(())
    }

    fn with_chain(&self, solution: &Solution, out: &mut [DMatrix<f64>]) -> Result<(), AdjustError> {
        let judge = |window: &Covariances| self.window(window);
        each_window(self.pass.problem, solution, judge, |parts| {
            parts.into_iter().for_each(|part| keep(part, out));
        })
    }

    fn window(&self, window: &Covariances) -> Result<Vec<Part>, AdjustError> {
        let problem = self.pass.problem;
        (0..problem.sources.len())
            .filter(|set| sees_chain(problem, *set))
            .map(|set| {
                let range = conditions_of(problem, set, &window.intervals);
                self.range(set, range, Some(window))
            })
            .collect()
    }

    /// `-weight gain`, the gain being the cofactors of the condition's prediction with the parameters.
    fn range(
        &self,
        set: usize,
        range: Range<usize>,
        window: Option<&Covariances>,
    ) -> Result<Part, AdjustError> {
        let mut part = DMatrix::zeros(self.sought.len(), range.len());
        self.pass.visit(set, range.clone(), |weighted| {
            let mut gain = part.column_mut(weighted.condition - range.start);
            self.add_gain(weighted.row, window, gain.as_mut_slice());
            gain *= -weighted.weight;
        })?;
        Ok((set, range, part))
    }

    fn add_gain(&self, row: &Row, window: Option<&Covariances>, gain: &mut [f64]) {
        for (column, value) in row.columns().iter().zip(row.values()) {
            self.add(gain, *value, usize::from(*column));
        }
        if let (Some(chain), Some(window)) = (&row.chain, window) {
            for (gain, column) in gain.iter_mut().zip(&self.sought) {
                *gain += window.with_column(chain, *column);
            }
        }
    }

    /// Adds a multiple of a column of cofactors.
    fn add(&self, gain: &mut [f64], factor: f64, column: usize) {
        for (gain, sought) in gain.iter_mut().zip(&self.sought) {
            *gain += factor * self.cofactor[(*sought, column)];
        }
    }

    /// `-Q J^T` of the whitened rows J of the priors.
    fn of_priors(&self) -> Result<DMatrix<f64>, AdjustError> {
        let rows = self.pass.at.parameters.prior_rows()?;
        let mut all = DMatrix::zeros(self.sought.len(), rows.len());
        for (mut gain, row) in all.column_iter_mut().zip(&rows) {
            for (i, derivative) in row.derivatives.iter().enumerate() {
                self.add(gain.as_mut_slice(), -derivative, row.column + i);
            }
        }
        Ok(all)
    }
}

fn keep((set, range, part): Part, out: &mut [DMatrix<f64>]) {
    out[set]
        .columns_mut(range.start, range.len())
        .copy_from(&part);
}

#[cfg(test)]
mod tests {
    use super::super::toys::{GLOBALS, Toy};
    use super::super::*;
    use super::*;
    use crate::math;
    use nalgebra::Matrix4;

    fn tight() -> Options {
        Options {
            step_tolerance_sigmas: 1e-9,
            ..Options::default()
        }
    }

    fn with_prior(toy: &Toy) -> ParameterSet {
        let mut parameters = toy.parameters();
        let id = parameters.find("globals").unwrap();
        let covariance = DMatrix::from_fn(GLOBALS, GLOBALS, |i, j| {
            if i == j { 1e-4 * (i + 1) as f64 } else { 2e-5 }
        });
        parameters.block_mut(id).prior = Some(Prior {
            value: vec![0.1; GLOBALS],
            covariance,
        });
        parameters
    }

    /// Columns of the first four parameters by the visible quantities of every epoch.
    fn by_epoch(toy: &Toy, found: &Influence) -> Vec<[[f64; VISIBLE]; GLOBALS]> {
        let mut epochs = vec![[[0.0; VISIBLE]; GLOBALS]; toy.model.epochs()];
        for (row, c) in toy.rows.iter().zip(found.conditions[0].column_iter()) {
            for (epoch, weight) in [(0, row.weight0), (1, 1.0 - row.weight0)] {
                let sums = &mut epochs[row.interval as usize + epoch];
                for (i, sum) in sums.iter_mut().enumerate() {
                    for (s, v) in sum.iter_mut().zip(row.v) {
                        *s += c[i] * weight * v;
                    }
                }
            }
        }
        epochs
    }

    /// Sums over conditions, processes and priors against the cofactor: the identity of the module's head.
    #[test]
    fn influences_give_the_cofactor_back() {
        let toy = Toy::new(41, 150, 5);
        let problem = toy.problem();
        let solution = solve(&problem, Estimate::new(with_prior(&toy)), &tight()).unwrap();
        let found = influence(&problem, &solution).unwrap();
        let mut sum = Matrix4::<f64>::zeros();
        let mut add = |a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64, factor: f64| {
            sum += Matrix4::from_fn(|i, j| factor * a(i) * b(j));
        };
        for (row, c) in toy.rows.iter().zip(found.conditions[0].column_iter()) {
            add(&|i| c[i], &|j| c[j], row.variance);
        }
        for p in found.priors.column_iter() {
            add(&|i| p[i], &|j| p[j], 1.0);
        }
        let epochs = by_epoch(&toy, &found);
        let times = toy.model.times_s();
        for process in toy.model.processes() {
            let (variance, component) = (process.sigma.powi(2), process.component);
            for (k, a) in epochs.iter().enumerate() {
                for (l, b) in epochs.iter().enumerate() {
                    let correlation = match process.kind {
                        ProcessKind::White => f64::from(u8::from(k == l)),
                        ProcessKind::GaussMarkov { tau_s } => {
                            math::exp(-(times[k] - times[l]).abs() / tau_s)
                        }
                    };
                    let factor = variance * correlation;
                    add(&|i| a[i][component], &|j| b[j][component], factor);
                }
            }
        }
        let cofactor = solution.cofactor.fixed_view::<4, 4>(0, 0);
        assert!(
            (sum - cofactor).amax() < 1e-9 * cofactor.amax(),
            "{sum} {cofactor}"
        );
    }

    /// The estimate moves by the influence times the error put on an observation.
    #[test]
    fn an_error_moves_the_estimate_by_its_influence() {
        let mut toy = Toy::new(42, 90, 4);
        let value = |toy: &Toy| {
            let solution = solve(&toy.problem(), Estimate::new(with_prior(toy)), &tight()).unwrap();
            let found = influence(&toy.problem(), &solution).unwrap();
            (
                solution.estimate.parameters.blocks()[0].value.clone(),
                found,
            )
        };
        let (before, found) = value(&toy);
        for k in [0, 77, toy.rows.len() - 1] {
            // an observation enters its misclosure with a minus sign
            toy.rows[k].observed -= 0.01;
            let (after, _) = value(&toy);
            toy.rows[k].observed += 0.01;
            for i in 0..GLOBALS {
                let moved = (after[i] - before[i]) / 0.01;
                assert!(
                    (moved - found.conditions[0][(i, k)]).abs() < 1e-9,
                    "{k} {i}"
                );
            }
        }
    }

    /// One linear condition per row over a few numbers.
    struct Rows(Vec<(Vec<f64>, f64)>);

    impl Conditions for Rows {
        fn len(&self) -> usize {
            self.0.len()
        }

        fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
            let (a, sigma) = &self.0[k];
            row.misclosure = a.iter().zip(&x.blocks()[0].value).map(|(a, x)| a * x).sum();
            row.variance = sigma * sigma;
            row.extend(0, a);
        }
    }

    /// Covariance of the leading parameters as the sum over conditions.
    fn summed(rows: &Rows) -> DMatrix<f64> {
        let n = rows.0[0].0.len();
        let mut set = ParameterSet::new();
        let names = (0..n).map(|i| Component::new(format!("x{i}"), Unit::Metre));
        set.push(Block::euclidean("x", names.collect(), &vec![0.0; n]).sought())
            .unwrap();
        let problem = Problem::dense(vec![Source::new(rows)]);
        let solution = solve(&problem, Estimate::new(set), &tight()).unwrap();
        let found = influence(&problem, &solution).unwrap();
        let mut sum = DMatrix::zeros(n, n);
        for (c, row) in found.conditions[0].column_iter().zip(&rows.0) {
            sum += DMatrix::from_fn(n, n, |i, j| c[i] * c[j] * row.1 * row.1);
        }
        sum
    }

    /// Straight line `y = a + b t` (Bevington & Robinson 2003, eq. 6.21-6.23): `var a = s2 sum t2 / D`, `var b = s2 n / D`,
    /// `cov = -s2 sum t / D`, `D = n sum t2 - (sum t)^2`.
    #[test]
    fn straight_line_fit() {
        let (n, sigma) = (37, 0.02);
        let times: Vec<f64> = (0..n)
            .map(|k| 0.3 * f64::from(k) + 0.01 * f64::from(k * k))
            .collect();
        let found = summed(&Rows(
            times.iter().map(|t| (vec![1.0, *t], sigma)).collect(),
        ));
        let (t1, t2): (f64, f64) = times.iter().fold((0.0, 0.0), |s, t| (s.0 + t, s.1 + t * t));
        let d = f64::from(n) * t2 - t1 * t1;
        let s2 = sigma * sigma;
        for (i, j, expected) in [(0, 0, t2), (1, 1, f64::from(n)), (0, 1, -t1)] {
            approx::assert_relative_eq!(found[(i, j)], s2 * expected / d, max_relative = 1e-10);
        }
    }

    /// Plane over a centred grid of m by m points, side L: tilt variance `s2 / (m^2 L^2 (m + 1) / (12 (m - 1)))`, offset `s2 / m^2`.
    #[test]
    fn plane_fit_over_a_grid() {
        let (m, side, sigma) = (9, 2.0, 0.01);
        let at = |k: i32| side * (f64::from(k) / f64::from(m - 1) - 0.5);
        let grid = (0..m * m).map(|k| (vec![1.0, at(k % m), at(k / m)], sigma));
        let found = summed(&Rows(grid.collect()));
        let points = f64::from(m * m);
        let spread = points * side * side * f64::from(m + 1) / (12.0 * f64::from(m - 1));
        let expected = DMatrix::from_diagonal(&nalgebra::dvector![
            1.0 / points,
            1.0 / spread,
            1.0 / spread
        ]) * (sigma * sigma);
        assert!((found - &expected).amax() < 1e-12 * expected.amax());
    }

    /// Three angles from known points on three orthogonal planes: `n . (w x X)` has derivatives `X x n`; for points placed
    /// symmetrically about the axes `sigma_angle = sigma / sqrt(sum of squared levers about that axis)`.
    #[test]
    fn three_angle_boresight() {
        let sigma = 0.015;
        let mut rows = vec![];
        let mut levers = [0.0f64; 3];
        for axis in 0..3 {
            for (u, v) in [(1.0, 2.0), (-1.0, 2.0), (1.0, -2.0), (-1.0, -2.0)] {
                let mut x = nalgebra::Vector3::zeros();
                x[axis] = 5.0;
                x[(axis + 1) % 3] = u;
                x[(axis + 2) % 3] = v;
                let lever = x.cross(&nalgebra::Vector3::ith(axis, 1.0));
                (0..3).for_each(|i| levers[i] += lever[i] * lever[i]);
                rows.push((lever.as_slice().to_vec(), sigma));
            }
        }
        let found = summed(&Rows(rows));
        for (i, lever) in levers.into_iter().enumerate() {
            approx::assert_relative_eq!(
                found[(i, i)].sqrt(),
                sigma / f64::sqrt(lever),
                max_relative = 1e-10
            );
        }
    }
}
