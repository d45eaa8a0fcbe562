//! Loops around a solve: data snooping and variance components.

use super::bits::Bits;
use super::error::AdjustError;
use super::kernel::Kernel;
use super::mestimate::robust_covariance;
use super::options::Options;
use super::problem::{Estimate, Problem, Source};
use super::quality::{Quality, QualityOptions, assess, correlation};
use super::solve::{Solution, solve};

/// A solution after data snooping.
#[derive(Debug)]
pub struct Snooped {
    /// The last solution.
    pub solution: Solution,
    /// Its judgement.
    pub quality: Quality,
    /// Per set: conditions switched off, those switched off beforehand included.
    pub ignored: Vec<Bits>,
    /// Conditions switched off by snooping, in the order of their removal.
    pub removed: Vec<(usize, usize)>,
    /// Whether the last round found nothing more.
    pub finished: bool,
}

/// Data snooping (Baarda 1968): solves, switches off conditions beyond the family-wise critical value, and again.
///
/// Without a kernel a round removes only conditions at least 0.8 times as bad as the worst, since a gross error taints its
/// neighbours; under a kernel, which bounds the taint, all beyond the critical value. A round removes at most as
/// many as the quality options list. Under a kernel the figures of the conditions hold with its weights; the covariance of the
/// last solution is that of the M-estimator.
///
/// # Errors
/// Those of [`solve`] and [`assess`].
pub fn snoop(
    problem: &Problem,
    start: Estimate,
    options: &Options,
    quality_options: &QualityOptions,
    rounds: usize,
) -> Result<Snooped, AdjustError> {
    let mut ignored: Vec<Bits> = problem.sources.iter().map(mask).collect();
    let mut removed = Vec::new();
    let mut start = start;
    let plain = Options {
        robust_covariance: false,
        ..options.clone()
    };
    for round in 0.. {
        let reduced = without(problem, &ignored);
        let solution = solve(&reduced, start, &plain)?;
        let mut quality = assess(&reduced, &solution, quality_options)?;
        let found = flagged(&quality, options.kernel);
        if found.is_empty() || round >= rounds {
            let solution = finished(&reduced, solution, &mut quality, options)?;
            return Ok(Snooped {
                solution,
                quality,
                ignored,
                removed,
                finished: found.is_empty(),
            });
        }
        found
            .iter()
            .for_each(|(set, condition)| ignored[*set].set(*condition));
        removed.extend(found);
        start = solution.estimate;
    }
    Err(AdjustError::TooFew {
        conditions: 0,
        unknowns: start.parameters.free_columns().len(),
    })
}

/// The covariance of a robust estimate in solution and judgement.
fn finished(
    problem: &Problem,
    solution: Solution,
    quality: &mut Quality,
    options: &Options,
) -> Result<Solution, AdjustError> {
    if options.kernel.is_least_squares() || !options.robust_covariance {
        return Ok(solution);
    }
    let solution = robust_covariance(problem, solution, &quality.groups)?;
    quality.correlation = correlation(&solution.cofactor);
    Ok(solution)
}

fn mask(source: &Source) -> Bits {
    let none = || Bits::none(source.conditions.len());
    source.ignored.cloned().unwrap_or_else(none)
}

fn without<'a>(problem: &Problem<'a>, ignored: &'a [Bits]) -> Problem<'a> {
    let mut reduced = problem.clone();
    reduced
        .sources
        .iter_mut()
        .zip(ignored)
        .for_each(|(source, mask)| source.ignored = Some(mask));
    reduced
}

fn flagged(quality: &Quality, kernel: Kernel) -> Vec<(usize, usize)> {
    let worst = quality
        .worst
        .first()
        .map_or(0.0, |one| one.normalised.abs());
    let taint = if kernel.is_least_squares() {
        0.8 * worst
    } else {
        0.0
    };
    let limit = quality.family.critical.max(taint);
    let beyond = quality
        .worst
        .iter()
        .filter(|one| one.normalised.abs() > limit);
    beyond.map(|one| (one.set, one.condition)).collect()
}

/// Variance component of one group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VarianceComponent {
    /// Observation group.
    pub group: u16,
    /// Factor on the group's variances.
    pub factor: f64,
    /// Its standard deviation, `factor sqrt(2 / redundancy)`.
    pub sigma: f64,
    /// Redundancy of the group.
    pub redundancy: f64,
    /// Whether it was estimated; held otherwise, for want of redundancy.
    pub estimated: bool,
}

/// Estimated variance components and the solution with them.
#[derive(Debug)]
pub struct VarianceComponents {
    /// Per group, in order.
    pub components: Vec<VarianceComponent>,
    /// The solution.
    pub solution: Solution,
    /// Whether all factors stand still within 1 %.
    pub converged: bool,
}

/// Redundancy below which a component is held.
const ENOUGH: f64 = 30.0;

/// Iterated variance components, `factor <- factor omega_g / r_g` (Förstner, "Ein Verfahren zur Schätzung von Varianz- und
/// Kovarianzkomponenten", 1979): never negative; groups with a redundancy below 30 are held.
///
/// # Errors
/// Those of [`solve`] and [`assess`].
pub fn variance_components(
    problem: &Problem,
    start: Estimate,
    options: &Options,
    rounds: usize,
) -> Result<VarianceComponents, AdjustError> {
    let mut problem = problem.clone();
    let mut start = start;
    let silent = QualityOptions {
        worst: 0,
        ..QualityOptions::default()
    };
    for round in 0.. {
        let solution = solve(&problem, start, options)?;
        let quality = assess(&problem, &solution, &silent)?;
        let (components, change) = reestimated(&problem, &quality);
        if change < 0.01 || round >= rounds {
            return Ok(VarianceComponents {
                components,
                solution,
                converged: change < 0.01,
            });
        }
        problem.components = components
            .iter()
            .map(|component| component.factor)
            .collect();
        start = solution.estimate;
    }
    Err(AdjustError::TooFew {
        conditions: 0,
        unknowns: start.parameters.free_columns().len(),
    })
}

/// New components and the largest relative change.
fn reestimated(problem: &Problem, quality: &Quality) -> (Vec<VarianceComponent>, f64) {
    let mut change: f64 = 0.0;
    let mut components = Vec::new();
    for group in &quality.groups {
        let old = problem.component(group.group);
        let estimated = group.redundancy >= ENOUGH && group.omega > 0.0;
        let ratio = if estimated {
            group.omega / group.redundancy
        } else {
            1.0
        };
        change = change.max((ratio - 1.0).abs());
        let factor = old * ratio;
        let sigma = factor * (2.0 / group.redundancy).sqrt();
        components.push(VarianceComponent {
            group: group.group,
            factor,
            sigma,
            redundancy: group.redundancy,
            estimated,
        });
    }
    (components, change)
}

#[cfg(test)]
mod tests {
    use super::super::toys::Toy;
    use super::super::*;

    #[test]
    fn snooping_finds_the_gross_errors_and_nothing_else() {
        let mut toy = Toy::new(31, 200, 6);
        let wrong = [(77, 6.0), (78, -9.0), (500, 5.0), (801, -5.0)];
        wrong
            .iter()
            .for_each(|(k, error)| toy.rows[*k].observed += error);
        let (options, quality) = (Options::default(), QualityOptions::default());
        let snooped = snoop(
            &toy.problem(),
            Estimate::new(toy.parameters()),
            &options,
            &quality,
            10,
        )
        .unwrap();
        let mut removed: Vec<_> = snooped
            .removed
            .iter()
            .map(|(_, condition)| *condition)
            .collect();
        removed.sort_unstable();
        assert_eq!(removed, [77, 78, 500, 801]);
        assert!(snooped.finished);
        assert_eq!(snooped.ignored[0].count(), 4);
    }

    /// Observations of the second group are three times as noisy as they claim: a factor of nine on their variance.
    #[test]
    fn variance_component_of_a_noisy_group() {
        let mut toy = Toy::new(32, 400, 12);
        toy.rows
            .iter_mut()
            .skip(1)
            .step_by(2)
            .for_each(|row| row.variance /= 9.0);
        let found = variance_components(
            &toy.problem(),
            Estimate::new(toy.parameters()),
            &Options::default(),
            50,
        )
        .unwrap();
        assert!(found.converged);
        for (component, expected) in found.components.iter().zip([1.0, 9.0]) {
            assert!(component.estimated);
            assert!(
                (component.factor - expected).abs() < 4.0 * component.sigma,
                "{component:?}"
            );
        }
        assert!(found.components[1].sigma < 0.5);
    }

    #[test]
    fn a_small_group_keeps_its_variance() {
        let toy = Toy::new(33, 6, 6);
        let found = variance_components(
            &toy.problem(),
            Estimate::new(toy.parameters()),
            &Options::default(),
            5,
        )
        .unwrap();
        assert!(
            found
                .components
                .iter()
                .all(|component| !component.estimated && component.factor == 1.0)
        );
    }
}
