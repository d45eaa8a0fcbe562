//! What every adjustment reports: global test, redundancy, normalised residuals, detectable biases.
//!
//! Baarda, *A testing procedure for use in geodetic networks*, 1968; Förstner, "Reliability analysis of parameter estimation in
//! linear models", 1987.

use crate::math;
use crate::stats::{ChiSquare, normal};
use nalgebra::DMatrix;

use super::error::AdjustError;
use super::fit_test::FitTest;
use super::problem::Problem;
use super::reliability::{ConditionQuality, Effect, GroupQuality, survey};
use super::solve::{Solution, redundancy};

/// What to judge with.
#[derive(Debug, Clone, PartialEq)]
pub struct QualityOptions {
    /// Error probability of the global test, both sides together.
    pub global_alpha: f64,
    /// Error probability of the test of one condition.
    pub condition_alpha: f64,
    /// Error probability of all these tests together.
    pub family_alpha: f64,
    /// Power that detectable biases are stated for.
    pub power: f64,
    /// Practical bounds of the variance factor, reported beside the test: with 1e5 conditions the test itself fails at 1 %.
    pub practical: (f64, f64),
    /// Number of conditions with the largest normalised residuals to list.
    pub worst: usize,
}

impl Default for QualityOptions {
    fn default() -> Self {
        QualityOptions {
            global_alpha: 0.05,
            condition_alpha: 0.001,
            family_alpha: 0.05,
            power: 0.8,
            practical: (0.8, 1.25),
            worst: 20,
        }
    }
}

/// Test of the variance factor.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalTest {
    /// Weighted sum of squares of conditions (divided by [`Kernel::kept_of_normal`](super::Kernel::kept_of_normal)), priors and states.
    pub omega: f64,
    /// Conditions and priors less all unknowns; states and their priors cancel.
    pub degrees_of_freedom: f64,
    /// `omega / degrees_of_freedom`; NaN without redundancy.
    pub variance_factor: f64,
    /// Interval the variance factor lies in if the model is true; under a kernel that of [`FitTest::interval`].
    pub interval: (f64, f64),
    /// Whether it does.
    pub passed: bool,
    /// Whether it lies within the practical bounds.
    pub practical: bool,
    /// Estimated variance components make the test void.
    pub void: bool,
}

/// Critical value of a test of single conditions and the non-centrality of its detectable bias.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConditionTest {
    /// Error probability of one test.
    pub alpha: f64,
    /// Normalised residuals beyond this are flagged.
    pub critical: f64,
    /// Non-centrality: a bias of `delta0 sigma / sqrt r` is found with the power asked for.
    pub delta0: f64,
}

/// Judgement of a solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Quality {
    /// Test of the variance factor.
    pub global: GlobalTest,
    /// Test of one condition by itself.
    pub single: ConditionTest,
    /// Test of one condition with a family-wise error probability.
    pub family: ConditionTest,
    /// Sums per observation group, in order of the group numbers.
    pub groups: Vec<GroupQuality>,
    /// The same sums per cell ([`super::Conditions::cell`]).
    pub cells: Vec<GroupQuality>,
    /// Conditions with the largest normalised residuals, worst first.
    pub worst: Vec<ConditionQuality>,
    /// Per column sought: largest effect of an undetected bias of one condition, per unit of non-centrality (times a test's
    /// `delta0`).
    pub effects: Vec<Effect>,
    /// Correlation of all columns; zero rows for held ones.
    pub correlation: DMatrix<f64>,
}

/// Judges a solution with one more pass over its conditions.
///
/// # Errors
/// [`AdjustError::BadProbability`] on options outside (0, 1), and what a pass can find wrong with the conditions.
pub fn assess(
    problem: &Problem,
    solution: &Solution,
    options: &QualityOptions,
) -> Result<Quality, AdjustError> {
    let survey = survey(problem, solution, options.worst)?;
    let tests = problem.condition_count().max(1) as f64;
    let one_of_family = -math::exp_m1(math::ln_1p(-options.family_alpha) / tests);
    Ok(Quality {
        global: global_test(problem, solution, &survey.groups, options)?,
        single: condition_test(options.condition_alpha, options.power)?,
        family: condition_test(one_of_family, options.power)?,
        groups: survey.groups,
        cells: survey.cells,
        worst: survey.worst,
        effects: survey.effects,
        correlation: correlation(&solution.cofactor),
    })
}

/// Critical value and non-centrality of a two-sided normal test.
///
/// # Errors
/// [`AdjustError::BadProbability`] when a probability is outside (0, 1).
pub fn condition_test(alpha: f64, power: f64) -> Result<ConditionTest, AdjustError> {
    let critical = -normal_quantile("alpha", 0.5 * alpha)?;
    Ok(ConditionTest {
        alpha,
        critical,
        delta0: critical + normal_quantile("power", power)?,
    })
}

fn normal_quantile(what: &'static str, probability: f64) -> Result<f64, AdjustError> {
    within(what, probability)?;
    Ok(normal::quantile(probability))
}

fn within(what: &'static str, found: f64) -> Result<(), AdjustError> {
    if found > 0.0 && found < 1.0 {
        return Ok(());
    }
    Err(AdjustError::BadProbability { what, found })
}

fn global_test(
    problem: &Problem,
    solution: &Solution,
    groups: &[GroupQuality],
    options: &QualityOptions,
) -> Result<GlobalTest, AdjustError> {
    within("global_alpha", options.global_alpha)?;
    let given_back = |group: &GroupQuality| (1.0 - group.kept(solution.kernel)) * group.omega;
    let omega = solution.omega + groups.iter().map(given_back).sum::<f64>();
    let degrees_of_freedom = redundancy(problem, &solution.estimate);
    let variance_factor = if degrees_of_freedom > 0.0 {
        omega / degrees_of_freedom
    } else {
        f64::NAN
    };
    let interval = if solution.kernel.is_least_squares() {
        factor_interval(degrees_of_freedom, options.global_alpha)
    } else {
        let of_group = |group| FitTest::of(group, solution.kernel);
        let conditions = groups.iter().map(of_group);
        let conditions = conditions.fold(FitTest::default(), FitTest::with);
        let beside = (degrees_of_freedom - conditions.redundancy).max(0.0);
        let all = conditions.with(FitTest::plain(0, beside, beside));
        all.interval(-normal_quantile(
            "global_alpha",
            0.5 * options.global_alpha,
        )?)
    };
    let inside = |(low, high): (f64, f64)| low <= variance_factor && variance_factor <= high;
    let void = problem.components.iter().any(|component| *component != 1.0);
    Ok(GlobalTest {
        omega,
        degrees_of_freedom,
        variance_factor,
        interval,
        passed: inside(interval),
        practical: inside(options.practical),
        void,
    })
}

/// Two-sided interval of `chi^2 / dof`.
fn factor_interval(dof: f64, alpha: f64) -> (f64, f64) {
    match ChiSquare::new(dof) {
        Some(chi) => (
            chi.quantile(0.5 * alpha) / dof,
            chi.quantile(1.0 - 0.5 * alpha) / dof,
        ),
        None => (f64::NAN, f64::NAN),
    }
}

/// Correlation of a covariance; zero where a variance is zero.
pub fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let sigma: Vec<f64> = covariance
        .diagonal()
        .iter()
        .map(|variance| variance.sqrt())
        .collect();
    DMatrix::from_fn(sigma.len(), sigma.len(), |i, j| match sigma[i] * sigma[j] {
        product if product > 0.0 => covariance[(i, j)] / product,
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::super::toys::{DenseToy, Toy};
    use super::super::*;
    use super::condition_test;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    fn tight() -> Options {
        Options {
            step_tolerance_sigmas: 1e-9,
            ..Options::default()
        }
    }

    fn all(count: usize) -> QualityOptions {
        QualityOptions {
            worst: count,
            ..QualityOptions::default()
        }
    }

    /// From the nomograms of Baarda 1968.
    #[test]
    fn textbook_non_centralities() {
        let test = condition_test(0.001, 0.8).unwrap();
        assert_abs_diff_eq!(test.delta0, 4.13, epsilon = 5e-3);
        let family = condition_test(0.05 / 1e5, 0.8).unwrap();
        assert_abs_diff_eq!(family.critical, 5.03, epsilon = 1e-2);
        assert_abs_diff_eq!(family.delta0, 5.87, epsilon = 1e-2);
    }

    fn by_condition(quality: &Quality) -> Vec<ConditionQuality> {
        let mut list = quality.worst.clone();
        list.sort_by_key(|one| one.condition);
        list
    }

    /// Redundancy numbers sum to the degrees of freedom, and the chain's selected inverse gives those of the whole inverse.
    #[test]
    fn redundancy_numbers() {
        let toy = Toy::new(21, 12, 8);
        let chained = solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap();
        let chained = assess(&toy.problem(), &chained, &all(toy.len())).unwrap();
        let dense = DenseToy(&toy);
        let problem = Problem::dense(vec![Source::new(&dense)]);
        let whole_solution = solve(&problem, Estimate::new(dense.parameters()), &tight()).unwrap();
        let whole = assess(&problem, &whole_solution, &all(dense.len())).unwrap();
        let sum: f64 = whole.groups.iter().map(|group| group.redundancy).sum();
        assert_relative_eq!(sum, whole.global.degrees_of_freedom, max_relative = 1e-9);
        assert_relative_eq!(
            chained.global.omega,
            whole.global.omega,
            max_relative = 1e-9
        );
        assert_relative_eq!(
            chained.global.degrees_of_freedom,
            whole.global.degrees_of_freedom
        );
        let table = figures(&problem, &whole_solution).unwrap();
        for (one, listed) in table[0].iter().zip(by_condition(&whole)) {
            assert_eq!(
                (one.residual, one.sigma, one.redundancy, one.normalised),
                (
                    listed.residual,
                    listed.sigma,
                    listed.redundancy,
                    listed.normalised
                )
            );
        }
        for (a, b) in by_condition(&chained).iter().zip(by_condition(&whole)) {
            assert_eq!(a.condition, b.condition);
            assert_abs_diff_eq!(a.redundancy, b.redundancy, epsilon = 1e-9);
            assert_abs_diff_eq!(a.normalised, b.normalised, epsilon = 1e-7);
        }
        for (a, b) in chained.effects.iter().zip(&whole.effects) {
            assert!(b.size >= a.size * (1.0 - 1e-9));
        }
    }

    /// The effect stated for a bias is the change that the bias causes.
    #[test]
    fn effect_of_a_bias() {
        let mut toy = Toy::new(22, 100, 5);
        let before = solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap();
        let quality = assess(&toy.problem(), &before, &all(toy.len())).unwrap();
        let effect = quality.effects[2];
        let one = quality
            .worst
            .iter()
            .find(|one| one.condition == effect.condition)
            .unwrap();
        toy.rows[effect.condition].observed += one.detectable_bias(4.13);
        let after = solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap();
        let value = |solution: &Solution| solution.estimate.parameters.blocks()[0].value[2];
        assert_relative_eq!(
            (value(&after) - value(&before)).abs(),
            4.13 * effect.size,
            max_relative = 1e-6
        );
    }

    /// Observations of one number each, all of one sigma.
    struct Numbers(Vec<Vec<f64>>);

    impl Conditions for Numbers {
        fn len(&self) -> usize {
            self.0.iter().map(Vec::len).sum()
        }

        fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
            let each = self.0[0].len();
            let (parameter, place) = (k / each, k % each);
            row.misclosure = x.blocks()[parameter].value[0] - self.0[parameter][place];
            row.variance = 0.04;
            row.extend(parameter, &[1.0]);
        }
    }

    /// Nine numbers observed four times each; the even ones are sought.
    fn nine() -> ParameterSet {
        let mut set = ParameterSet::new();
        for i in 0..9 {
            let name = format!("x{i}");
            let component = Component::new(name.clone(), Unit::Metre);
            let block = Block::euclidean(name, vec![component], &[0.0]);
            set.push(if i % 2 == 0 { block.sought() } else { block })
                .unwrap();
        }
        set
    }

    /// Only the first six columns were ever given.
    #[test]
    fn every_parameter_sought_has_its_effect_and_no_other() {
        let numbers = Numbers((0..9).map(|i| vec![f64::from(i); 4]).collect());
        let problem = Problem::dense(vec![Source::new(&numbers)]);
        let solution = solve(&problem, Estimate::new(nine()), &tight()).unwrap();
        let quality = assess(&problem, &solution, &all(36)).unwrap();
        assert_eq!(quality.effects.len(), 5);
        // a mean of four: an undetected bias of delta0 sigma / sqrt(3/4) moves it by a quarter
        let expected = 0.2 / 0.75f64.sqrt() / 4.0;
        for effect in &quality.effects {
            assert_relative_eq!(effect.size, expected, max_relative = 1e-9);
        }
        for one in &quality.worst {
            let parameter = one.condition / 4;
            for (i, effect) in one.effects.iter().enumerate() {
                let own = if 2 * i == parameter { expected } else { 0.0 };
                assert_abs_diff_eq!(effect.abs(), own, epsilon = 1e-12);
            }
        }
        let found = influence(&problem, &solution).unwrap();
        assert_eq!(found.conditions[0].shape(), (5, 36));
        assert_relative_eq!(found.conditions[0][(4, 35)], -0.25, max_relative = 1e-9);
    }

    /// A condition of more columns than a row holds.
    struct Wide(usize);

    impl Conditions for Wide {
        fn len(&self) -> usize {
            2 * self.0
        }

        fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
            for (column, value) in x.blocks()[0].value.iter().enumerate() {
                row.push(column, 1.0 + (k * column % 7) as f64 + 0.0 * value);
            }
            (row.misclosure, row.variance) = (1.0, 1.0);
        }
    }

    #[test]
    fn a_condition_of_too_many_columns_is_refused_by_name() {
        let columns = MAX_COLUMNS + 1;
        let names = (0..columns).map(|i| Component::new(format!("x{i}"), Unit::One));
        let mut set = ParameterSet::new();
        let block = Block::euclidean("x", names.collect(), &vec![0.0; columns]);
        set.push(block).unwrap();
        let wide = Wide(columns);
        let error = solve(
            &Problem::dense(vec![Source::new(&wide)]),
            Estimate::new(set),
            &tight(),
        )
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            "condition 0 of set 0: 49 parameter columns, expected at most 48"
        );
    }

    /// On normal residuals the variance factor is one under every kernel: seeds 1 to 40, four standard errors of `sqrt(2 / redundancy)`.
    #[test]
    fn the_variance_factor_is_one_under_every_kernel() {
        for kernel in [
            Kernel::LeastSquares,
            Kernel::Huber { k: 1.345 },
            Kernel::Tukey { k: 4.685 },
        ] {
            let options = Options {
                kernel,
                ..Options::default()
            };
            let (mut sum, mut redundancy) = (0.0, 0.0);
            for seed in 1..=40 {
                let toy = Toy::new(seed, 12, 150);
                let solution =
                    solve(&toy.problem(), Estimate::new(toy.parameters()), &options).unwrap();
                let global = assess(&toy.problem(), &solution, &all(0)).unwrap().global;
                sum += global.variance_factor / 40.0;
                redundancy += global.degrees_of_freedom;
            }
            let sigma = (2.0 / redundancy).sqrt();
            println!("{kernel:?}: {sum:.4}, sigma {sigma:.4}");
            assert!((sum - 1.0).abs() < 4.0 * sigma, "{kernel:?}: {sum}");
        }
    }

    /// A gross error is the worst condition, beyond the family-wise limit, and the survey is the same on one and two threads.
    #[test]
    fn gross_error_is_named() {
        let mut toy = Toy::new(23, 1200, 4);
        toy.rows[3210].observed += 8.0;
        let run = |threads| {
            let workers = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            workers.install(|| {
                let solution =
                    solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap();
                assess(&toy.problem(), &solution, &QualityOptions::default()).unwrap()
            })
        };
        let quality = run(1);
        assert_eq!(quality.worst[0].condition, 3210);
        assert!(quality.worst[0].normalised.abs() > quality.family.critical);
        assert!(quality.worst[1].normalised.abs() < quality.family.critical);
        assert_eq!(quality, run(2));
    }
}
