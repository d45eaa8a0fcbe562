//! Score tests: would a further unknown mend the fit?
//!
//! Rao, "Large sample tests of statistical hypotheses concerning several parameters", 1948; in geodesy the identification step of DIA
//! (Teunissen, "Distributional theory for the DIA method", 2018). The columns of unknowns that the model could have and has not are
//! appended at the solution. With score `g` and information `I` of a suspect after elimination of everything estimated, states
//! included, `T = g^T I^-1 g` is chi-square with as many degrees of freedom as the suspect has columns, `-I^-1 g` is the estimate that
//! one step with it would give, and `-N^-1 N_xs` times that is what it would do to the parameters. One pass over the conditions
//! serves all suspects.
//!
//! Under a kernel the weights of the solution are used; for normal residuals and Huber's kernel with bend 2 that makes `T` about 7 %
//! too small, so the test errs towards saying nothing.

use std::ops::Range;

use crate::math;
use crate::math::dense::product;
use crate::stats::ChiSquare;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::chain::ChainState;
use super::condition::{Conditions, MAX_COLUMNS, Row};
use super::error::AdjustError;
use super::linearise::{Keep, linearise};
use super::parameters::{Block, Component, ParameterSet};
use super::pass::Weighting;
use super::problem::{Estimate, Problem};
use super::solve::Solution;

/// Share of a suspect direction's information that must be left after elimination of what is estimated; with less it cannot be told
/// apart from the parameters.
const TESTABLE: f64 = 1e-6;

/// Derivatives of a set of conditions by further unknowns.
pub trait ScoreColumns: Sync {
    /// Hands each derivative of condition `k` at a solution to `push`, by the column among all suspects; a column may be pushed once.
    /// `row` holds the model's own derivatives.
    ///
    /// The derivatives must be those at the adjusted observations, like the model's own: one taken at a measured value errs together
    /// with the misclosure, and where little of a suspect's information is left beside the parameters that small common part is
    /// all there is (seen: a range offset of 15.7 +- 2.3 mm on a right survey, from dividing by the measured range).
    fn derive(&self, k: usize, at: &Solved<'_>, row: &Row, push: &mut dyn FnMut(usize, f64));

    /// The same of a range of conditions, `push` also told which of the range it is of. Override it to hoist what the conditions share.
    fn derive_range(
        &self,
        range: Range<usize>,
        at: &Solved<'_>,
        rows: &[Row],
        push: &mut dyn FnMut(usize, usize, f64),
    ) {
        for ((i, k), row) in range.enumerate().zip(rows) {
            self.derive(k, at, row, &mut |column, value| push(i, column, value));
        }
    }
}

/// Where derivatives are wanted.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// Parameters, those of the suspects after the model's own.
    pub parameters: &'a ParameterSet,
    /// States of the chain.
    pub chain: Option<&'a ChainState>,
}

/// An unknown, of one or several columns, that the model could have and has not.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// Short name.
    pub name: String,
    /// Its columns.
    pub components: Vec<Component>,
    /// Values that mistakes of a known size would give it (a sign reversed: twice the stated value).
    pub jumps: Vec<Vec<f64>>,
}

/// What becomes of the fit if a suspect has a value that is known beforehand.
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// By how much the weighted squares become smaller; negative where they become larger.
    pub gain: f64,
    /// What it would change every parameter column by.
    pub effect: Vec<f64>,
}

/// What a score test says of one suspect.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// Which suspect, in the order given.
    pub suspect: usize,
    /// `g^T I^-1 g`, over the variance factor where that exceeds one: chi-square if the suspect is innocent.
    pub statistic: f64,
    /// Directions of the suspect that can be told apart from what is estimated.
    pub degrees: usize,
    /// Probability of a larger statistic by chance.
    pub p_value: f64,
    /// One-step estimate of each column.
    pub estimate: Vec<f64>,
    /// Its standard deviation.
    pub sigma: Vec<f64>,
    /// What estimating it too would change every parameter column by.
    pub effect: Vec<f64>,
    /// What its known values come to, in the order given.
    pub jumps: Vec<Jump>,
}

impl Score {
    /// Minus the logarithm of the p-value, also where that is too small for a number: what suspects are ranked by.
    #[must_use]
    pub fn weight(&self) -> f64 {
        if self.p_value > 1e-200 {
            return -math::ln(self.p_value);
        }
        let (half, shape) = (0.5 * self.statistic, 0.5 * self.degrees as f64);
        half - (shape - 1.0) * math::ln(half) + math::ln_gamma(shape)
    }
}

/// The scores of all suspects.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scores {
    /// Each suspect by itself; those that cannot be tested are left out.
    pub alone: Vec<Score>,
    /// Guilty ones, the most significant first, each tested with the ones before it admitted.
    pub guilty: Vec<Score>,
}

/// How suspects are tested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoreOptions {
    /// Error probability of all suspects together.
    pub family_alpha: f64,
    /// Suspects that are admitted one after another at the most.
    pub most_guilty: usize,
    /// Weighted sum of squares and redundancy of the solution: misfit beyond the stated noise counts against every suspect alike.
    pub misfit: (f64, f64),
}

/// Tests suspects at a solution; `columns` gives their derivatives per set of conditions.
///
/// # Errors
/// What a pass can find wrong with the conditions or the suspects' derivatives.
pub fn score_tests(
    problem: &Problem,
    solution: &Solution,
    suspects: &[Suspect],
    columns: &[Option<&dyn ScoreColumns>],
    options: &ScoreOptions,
) -> Result<Scores, AdjustError> {
    let first = solution.estimate.parameters.columns();
    let extended: Vec<Extended> = problem
        .sources
        .iter()
        .zip(columns)
        .map(|(source, further)| Extended {
            inner: source.conditions,
            further: *further,
            first,
        })
        .collect();
    let mut wider = problem.clone();
    wider
        .sources
        .iter_mut()
        .zip(&extended)
        .for_each(|(source, extended)| source.conditions = extended);
    let at = with_suspects(&solution.estimate, suspects)?;
    let weighting = Weighting::Kernel(solution.kernel);
    let reduced = linearise(&wider, &at, weighting, Keep::Nothing)?.reduced;
    let mut estimated = at.parameters.free_columns();
    estimated.truncate(estimated.partition_point(|column| *column < first));
    let system = (&reduced.information(), &reduced.gradient());
    let court = Court::new(system, (estimated, first), suspects, options);
    Ok(court.session(options))
}

/// As [`score_tests`], of a problem that was linearised elsewhere, because its conditions are no rows but correlated in blocks: the
/// information and the gradient that it leaves, all else eliminated, for its parameters and, behind them, the suspects' columns.
#[must_use]
pub fn score_tests_of(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    suspects: &[Suspect],
    options: &ScoreOptions,
) -> Scores {
    let further: usize = suspects.iter().map(|s| s.components.len()).sum();
    let width = information.nrows() - further;
    let estimated = ((0..width).collect(), width);
    Court::new((information, gradient), estimated, suspects, options).session(options)
}

/// A set of conditions with the suspects' columns.
struct Extended<'a> {
    inner: &'a dyn Conditions,
    further: Option<&'a dyn ScoreColumns>,
    first: usize,
}

impl Extended<'_> {
    fn append(&self, range: Range<usize>, at: &Solved, rows: &mut [Row]) {
        let Some(further) = self.further else { return };
        let mut found = Vec::with_capacity(rows.len() * MAX_COLUMNS);
        further.derive_range(range, at, rows, &mut |i, column, value| {
            found.push((i, column, value));
        });
        for (i, column, value) in found {
            if let Some(row) = rows.get_mut(i) {
                row.push(self.first + column, value);
            }
        }
    }
}

impl Conditions for Extended<'_> {
    fn len(&self) -> usize {
        self.inner.len()
    }

    fn group(&self, k: usize) -> u16 {
        self.inner.group(k)
    }

    fn interval(&self, k: usize) -> Option<u32> {
        self.inner.interval(k)
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        self.inner.linearise(k, x, chain, row);
        let at = Solved {
            parameters: x,
            chain,
        };
        self.append(k..k + 1, &at, std::slice::from_mut(row));
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        chain: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        self.inner.linearise_range(range.clone(), x, chain, rows);
        let at = Solved {
            parameters: x,
            chain,
        };
        self.append(range, &at, rows);
    }
}

/// The estimate with every suspect's columns appended, at zero.
fn with_suspects(estimate: &Estimate, suspects: &[Suspect]) -> Result<Estimate, AdjustError> {
    let mut wider = estimate.clone();
    for suspect in suspects {
        let zero = vec![0.0; suspect.components.len()];
        let name = format!("suspect {}", suspect.name);
        let block = Block::euclidean(name, suspect.components.clone(), &zero);
        wider.parameters.push(block)?;
    }
    Ok(wider)
}

/// The reduced system, each column scaled by its own length.
struct Court {
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
    scale: Vec<f64>,
    /// Places of the estimated columns, and the columns themselves.
    estimated: Vec<usize>,
    columns: Vec<usize>,
    /// Columns of the model without suspects.
    width: usize,
    /// Places of each suspect's columns.
    suspects: Vec<Vec<usize>>,
    /// Known values of each.
    jumps: Vec<Vec<Vec<f64>>>,
    misfit: (f64, f64),
}

impl Court {
    fn new(
        (normal, gradient): (&DMatrix<f64>, &DVector<f64>),
        (columns, width): (Vec<usize>, usize),
        suspects: &[Suspect],
        options: &ScoreOptions,
    ) -> Self {
        let lengths = normal.diagonal().map(|d| d.max(0.0).sqrt());
        let scale: Vec<f64> = lengths
            .iter()
            .map(|l| if *l > 0.0 { *l } else { 1.0 })
            .collect();
        let mut place = columns.len();
        let jumps = suspects.iter().map(|suspect| suspect.jumps.clone());
        let jumps = jumps.collect();
        let suspects = suspects.iter().map(|suspect| {
            place += suspect.components.len();
            (place - suspect.components.len()..place).collect()
        });
        Court {
            normal: DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
                normal[(i, j)] / (scale[i] * scale[j])
            }),
            gradient: DVector::from_fn(scale.len(), |i, _| gradient[i] / scale[i]),
            suspects: suspects.collect(),
            scale,
            estimated: (0..columns.len()).collect(),
            columns,
            width,
            jumps,
            misfit: options.misfit,
        }
    }

    /// Tests every suspect, admits the most significant one, and again.
    fn session(&self, options: &ScoreOptions) -> Scores {
        let limit = options.family_alpha / self.suspects.len().max(1) as f64;
        let mut scores = Scores::default();
        let mut admitted = self.estimated.clone();
        for round in 0..=options.most_guilty {
            let open = (0..self.suspects.len())
                .filter(|s| scores.guilty.iter().all(|guilty| guilty.suspect != *s));
            let tested = self.tested(&open.collect::<Vec<_>>(), &admitted);
            let worst = tested
                .iter()
                .filter(|score| score.p_value < limit)
                .max_by(|a, b| a.weight().total_cmp(&b.weight()))
                .cloned();
            if round == 0 {
                scores.alone = tested;
            }
            let Some(worst) = worst.filter(|_| round < options.most_guilty) else {
                break;
            };
            admitted.extend(&self.suspects[worst.suspect]);
            scores.guilty.push(worst);
        }
        scores
    }

    /// The testable ones of `open` against the columns `admitted`.
    fn tested(&self, open: &[usize], admitted: &[usize]) -> Vec<Score> {
        let inner = self.picked(admitted, admitted);
        let regular = SymmetricEigen::new(inner);
        let largest = regular.eigenvalues.max();
        let inverse = regular.eigenvalues.map(|value| {
            if value > 1e-14 * largest {
                1.0 / value
            } else {
                0.0
            }
        });
        let axes = &regular.eigenvectors;
        let scaled = product(axes, &DMatrix::from_diagonal(&inverse));
        let inverse = product(&scaled, &axes.transpose());
        let one = |suspect: &usize| self.tried(*suspect, admitted, &inverse);
        open.iter().filter_map(one).collect()
    }

    fn picked(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
            self.normal[(rows[i], columns[j])]
        })
    }

    fn tried(&self, suspect: usize, admitted: &[usize], inverse: &DMatrix<f64>) -> Option<Score> {
        let places = &self.suspects[suspect];
        let cross = self.picked(admitted, places);
        let carried = product(inverse, &cross);
        let information = self.picked(places, places) - product(&cross.transpose(), &carried);
        let known = DVector::from_fn(admitted.len(), |i, _| self.gradient[admitted[i]]);
        let own = DVector::from_fn(places.len(), |i, _| self.gradient[places[i]]);
        let score = own - carried.transpose() * known;
        let jumps = self.jumps[suspect].iter();
        let jumps = jumps.map(|value| self.jump(value, places, (&score, &information, &carried)));
        let jumps = jumps.collect();
        let axes = SymmetricEigen::new(information);
        let along = axes.eigenvectors.transpose() * score;
        let (mut total, mut degrees) = (0.0, 0);
        let mut step = DVector::zeros(places.len());
        let mut variance = DVector::zeros(places.len());
        for (i, value) in axes
            .eigenvalues
            .iter()
            .enumerate()
            .filter(|(_, v)| **v > TESTABLE)
        {
            let axis = axes.eigenvectors.column(i);
            total += along[i] * along[i] / value;
            degrees += 1;
            step -= axis * (along[i] / value);
            variance += axis.map(|a| a * a / value);
        }
        let statistic = total / self.excess(total, degrees);
        let p_value = ChiSquare::new(degrees as f64)?.above(statistic);
        let change = -(carried * &step);
        Some(Score {
            suspect,
            statistic,
            degrees,
            p_value,
            estimate: self.unscaled(places, &step),
            sigma: self.unscaled(places, &variance.map(f64::sqrt)),
            effect: self.effect(&change),
            jumps,
        })
    }

    /// The weighted squares change by `2 g . x + x . I x`, the parameters by what the suspect carries.
    fn jump(
        &self,
        value: &[f64],
        places: &[usize],
        (score, information, carried): (&DVector<f64>, &DMatrix<f64>, &DMatrix<f64>),
    ) -> Jump {
        let scaled = DVector::from_fn(places.len(), |i, _| value[i] * self.scale[places[i]]);
        let curved = information * &scaled;
        Jump {
            gain: -(2.0 * score.dot(&scaled) + scaled.dot(&curved)),
            effect: self.effect(&-(carried * &scaled)),
        }
    }

    /// Variance factor of what the suspect does not explain, where the stated noise is too small.
    fn excess(&self, explained: f64, degrees: usize) -> f64 {
        let (omega, redundancy) = self.misfit;
        ((omega - explained) / (redundancy - degrees as f64).max(1.0)).max(1.0)
    }

    fn unscaled(&self, places: &[usize], values: &DVector<f64>) -> Vec<f64> {
        let pairs = places.iter().zip(values.iter());
        pairs
            .map(|(place, value)| value / self.scale[*place])
            .collect()
    }

    /// A step of the admitted columns over all columns of the model.
    fn effect(&self, change: &DVector<f64>) -> Vec<f64> {
        let mut all = vec![0.0; self.width];
        for (place, column) in self.columns.iter().enumerate() {
            all[*column] = change[place] / self.scale[place];
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::toys::{GLOBALS, Toy};
    use super::super::*;
    use super::*;

    /// Innocent and guilty columns: a slope over the conditions' numbers, and a copy of a parameter.
    struct Slope<'a>(&'a Toy);

    fn slope(k: usize) -> f64 {
        math::sin(0.013 * k as f64)
    }

    impl ScoreColumns for Slope<'_> {
        fn derive(&self, k: usize, _: &Solved, row: &Row, push: &mut dyn FnMut(usize, f64)) {
            push(0, slope(k));
            push(1, row.values()[0]);
            push(2, math::cos(0.21 * k as f64));
            assert!(k < self.0.rows.len());
        }
    }

    fn suspects() -> Vec<Suspect> {
        let one = |name: &str| Suspect {
            name: name.to_owned(),
            components: vec![Component::new(name, Unit::Metre)],
            jumps: vec![vec![0.5]],
        };
        vec![one("slope"), one("copy"), one("wave")]
    }

    fn tested(toy: &Toy, alpha: f64) -> Scores {
        let options = Options {
            step_tolerance_sigmas: 1e-9,
            ..Options::default()
        };
        let problem = toy.problem();
        let solution = solve(&problem, Estimate::new(toy.parameters()), &options).unwrap();
        let quality = assess(&problem, &solution, &QualityOptions::default()).unwrap();
        let options = ScoreOptions {
            family_alpha: alpha,
            most_guilty: 2,
            misfit: (quality.global.omega, quality.global.degrees_of_freedom),
        };
        score_tests(
            &problem,
            &solution,
            &suspects(),
            &[Some(&Slope(toy))],
            &options,
        )
        .unwrap()
    }

    /// The suspect that spoils the data is named with its size; the copy of a parameter cannot be tested; the other is innocent.
    #[test]
    fn the_guilty_suspect_is_named_with_its_size() {
        let mut toy = Toy::new(61, 150, 5);
        let sigma = toy.rows[0].variance.sqrt();
        let size = 0.6 * sigma;
        for (k, row) in toy.rows.iter_mut().enumerate() {
            row.observed += size * slope(k);
        }
        let scores = tested(&toy, 0.01);
        assert!(
            scores.alone.iter().all(|score| score.suspect != 1),
            "{:?}",
            scores.alone
        );
        assert_eq!(scores.guilty.len(), 1, "{:?}", scores.guilty);
        let found = &scores.guilty[0];
        assert_eq!(found.suspect, 0);
        let error = (found.estimate[0].abs() - size).abs();
        assert!(error < 4.0 * found.sigma[0], "{found:?}, {size}");
        assert_eq!(found.effect.len(), GLOBALS);
    }

    /// The statistic of an innocent suspect is chi-square: mean 1 and variance 2 over 300 seeds, and 5 % beyond 3.84.
    #[test]
    fn an_innocent_suspect_has_a_chi_square_statistic() {
        let values: Vec<f64> = (1..=300)
            .map(|seed| tested(&Toy::new(seed, 40, 6), 1e-9).alone[0].statistic)
            .collect();
        let mean = values.iter().sum::<f64>() / 300.0;
        let beyond = values.iter().filter(|v| **v > 3.841).count();
        assert!(
            (mean - 1.0).abs() < 3.0 * (2.0_f64 / 300.0).sqrt(),
            "{mean}"
        );
        assert!((4..=28).contains(&beyond), "{beyond}");
    }

    /// The toy with its slope as a parameter.
    struct Sloping<'a>(&'a Toy, BlockId);

    impl Conditions for Sloping<'_> {
        fn len(&self) -> usize {
            self.0.len()
        }

        fn interval(&self, k: usize) -> Option<u32> {
            self.0.interval(k)
        }

        fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
            self.0.linearise(k, x, chain, row);
            row.misclosure += slope(k) * x.euclidean(self.1)[0];
            row.push(x.offset(self.1), slope(k));
        }
    }

    /// Estimate, standard deviation and effect of one step are those of solving with the suspect as a parameter.
    #[test]
    fn one_step_is_what_estimating_it_gives() {
        let toy = Toy::new(63, 60, 6);
        let options = Options {
            step_tolerance_sigmas: 1e-10,
            ..Options::default()
        };
        let problem = toy.problem();
        let without = solve(&problem, Estimate::new(toy.parameters()), &options).unwrap();
        let options_of_score = ScoreOptions {
            family_alpha: 0.01,
            most_guilty: 0,
            misfit: (0.0, 1.0),
        };
        let further = Slope(&toy);
        let scores = score_tests(
            &problem,
            &without,
            &suspects(),
            &[Some(&further)],
            &options_of_score,
        );
        let score = &scores.unwrap().alone[0];

        let mut wider = toy.parameters();
        let names = vec![Component::new("slope", Unit::Metre)];
        let own = wider
            .push(Block::euclidean("slope", names, &[0.0]))
            .unwrap();
        let sloping = Sloping(&toy, own);
        let problem = Problem::with_chain(vec![Source::new(&sloping)], &toy.model);
        let with = solve(&problem, Estimate::new(wider), &options).unwrap();

        let near = |found: f64, expected: f64, sigma: f64| (found - expected).abs() < 1e-6 * sigma;
        let sigma = with.cofactor[(GLOBALS, GLOBALS)].sqrt();
        let estimate = with.estimate.parameters.euclidean(own)[0];
        assert!(
            near(score.estimate[0], estimate, sigma),
            "{score:?}, {estimate}"
        );
        assert!(near(score.sigma[0], sigma, sigma), "{score:?}, {sigma}");
        let values = |solution: &Solution| solution.estimate.parameters.blocks()[0].value.clone();
        for (i, (after, before)) in values(&with).iter().zip(values(&without)).enumerate() {
            let sigma = without.cofactor[(i, i)].sqrt();
            assert!(near(score.effect[i], after - before, sigma), "{score:?}");
        }
        // a jump to the estimate itself would gain the whole statistic; what it falls short of or overshoots costs the same
        let jump = &score.jumps[0];
        let missed = (estimate - 0.5) / sigma;
        let gained = (estimate / sigma).powi(2) - missed * missed;
        assert!(
            (jump.gain - gained).abs() < 1e-6 * missed.powi(2),
            "{jump:?}, {gained}"
        );
        let part = 0.5 / score.estimate[0];
        assert!((jump.effect[0] - part * score.effect[0]).abs() < 1e-9 * jump.effect[0].abs());
    }
}
