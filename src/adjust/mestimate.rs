//! Covariance of a robust estimate.

use super::error::AdjustError;
use super::linearise::{Keep, linearise};
use super::pass::{Tally, Weighting};
use super::problem::Problem;
use super::reliability::{GroupQuality, survey};
use super::solve::{Solution, spread_cofactor};

/// Replaces the cofactors of a robust estimate by those of an M-estimator: every condition carries the same part of its
/// information, [`efficiency`], whatever its residual (Huber & Ronchetti 2009, eq. 7.80 ff.); priors and states carry all of theirs.
pub(super) fn with_robust_covariance(
    problem: &Problem,
    solution: Solution,
) -> Result<Solution, AdjustError> {
    let groups = survey(problem, &solution, 0)?.groups;
    robust_covariance(problem, solution, &groups)
}

/// The same when the redundancies of the groups are known.
pub(super) fn robust_covariance(
    problem: &Problem,
    mut solution: Solution,
    groups: &[GroupQuality],
) -> Result<Solution, AdjustError> {
    let redundancy = groups.iter().map(|group| group.redundancy).sum();
    solution.weighting = Weighting::Uniform(efficiency(&solution.linearisation.tally, redundancy));
    let keep = Keep::Factor(solution.linearisation.factor.take());
    solution.linearisation = linearise(problem, &solution.estimate, solution.weighting, keep)?;
    solution.cofactor = spread_cofactor(&solution.estimate, &solution.linearisation);
    Ok(solution)
}

/// Part of a condition's information that survives a kernel: `mean(psi')^2 / (K^2 sum(psi^2) / redundancy)` with Huber's
/// correction `K = 1 + (1 - redundancy / n) var(psi') / mean(psi')^2`; at most one, so that a priori variances that are too
/// large are not turned into confidence.
fn efficiency(tally: &Tally, redundancy: f64) -> f64 {
    let n = tally.conditions as f64;
    let slope = tally.slope / n;
    let spread = tally.slope_square / n - slope * slope;
    let correction = 1.0 + (1.0 - redundancy / n) * spread / (slope * slope);
    let influence = tally.influence_square / redundancy;
    (slope * slope / (correction * correction * influence)).clamp(f64::MIN_POSITIVE, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::toys::{GLOBALS, Toy};
    use super::super::*;
    use crate::math;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    /// Squared error in the metric of the reported covariance: chi-square with four degrees of freedom if that is true.
    fn distance(toy: &Toy, options: &Options) -> f64 {
        let first = Options {
            kernel: Kernel::Huber { k: 1.345 },
            ..Options::default()
        };
        let start = solve(&toy.problem(), Estimate::new(toy.parameters()), &first)
            .unwrap()
            .estimate;
        let solution = solve(&toy.problem(), start, options).unwrap();
        assert!(solution.status.was_successful(), "{:?}", solution.status);
        let value = &solution.estimate.parameters.blocks()[0].value;
        let error = nalgebra::DVector::from_fn(GLOBALS, |i, _| value[i] - toy.truth[i]);
        let inverse = solution.cofactor.try_inverse().unwrap();
        (error.transpose() * inverse * error)[0]
    }

    fn interval(seeds: u64) -> (f64, f64) {
        let chi = ChiSquared::new((GLOBALS as u64 * seeds) as f64).unwrap();
        (chi.inverse_cdf(0.0005), chi.inverse_cdf(0.9995))
    }

    /// Seeds 1 to 200, without selection.
    #[test]
    fn errors_are_as_large_as_reported() {
        let sum: f64 = (1..=200)
            .map(|seed| distance(&Toy::new(seed, 40, 6), &Options::default()))
            .sum();
        let (low, high) = interval(200);
        assert!(low < sum && sum < high, "{low} < {sum} < {high}");
    }

    fn polluted(seed: u64) -> Toy {
        let mut toy = Toy::new(seed, 40, 20);
        for (k, row) in toy.rows.iter_mut().enumerate().filter(|(k, _)| k % 10 == 3) {
            row.observed += row.variance.sqrt() * 30.0 * math::sin(k as f64 * 1.7);
        }
        toy
    }

    /// 10 % gross errors up to 30 sigma: the covariance under every kernel stays true within the scatter of 320 squared pulls (8 %), while least
    /// squares is wrong by far.
    #[test]
    fn covariance_is_true_under_a_kernel() {
        let mean = |kernel| {
            let options = Options {
                kernel,
                max_iterations: 200,
                ..Options::default()
            };
            (1..=80)
                .map(|seed| distance(&polluted(seed), &options))
                .sum::<f64>()
                / (80.0 * GLOBALS as f64)
        };
        for kernel in [
            Kernel::Huber { k: 1.345 },
            Kernel::Cauchy { k: 2.385 },
            Kernel::Tukey { k: 4.685 },
        ] {
            let mean = mean(kernel);
            println!("{kernel:?}: mean squared pull {mean:.3}");
            assert!((0.75..1.3).contains(&mean), "{kernel:?}: {mean}");
        }
        assert!(mean(Kernel::LeastSquares) > 2.0);
    }
}
