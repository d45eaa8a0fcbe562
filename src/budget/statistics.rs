//! What trials say of a path: streaming sums over the trials in the order of seeds, and the intervals about them.

use nalgebra::{DMatrix, DVector};

use crate::adjust::Unit;
use crate::calibrate::metric;
use crate::calibrate::quality::readable;
use crate::calibrate::tried::{Reason, Said, Trial, Tried};
use crate::math;
use crate::results::{Figures, Interval, Nees, PathStatistics, RefusalCount, Reported};
use crate::stats::{ChiSquare, Moments};

/// Probability inside every interval.
pub const CONFIDENCE: f64 = 0.95;

/// Seeds that a count of refusals names.
const NAMED_SEEDS: usize = 10;

/// Ends between which a chi-square variable of `freedom` degrees lies with `confidence`; `None` without freedom.
#[must_use]
pub fn chi_square(freedom: u64, confidence: f64) -> Option<Interval> {
    let tail = 0.5 * (1.0 - confidence);
    let chi = ChiSquare::new(freedom as f64)?;
    Some(Interval {
        lower: chi.quantile(tail),
        upper: chi.quantile(1.0 - tail),
    })
}

/// Factors from a standard deviation of `n` samples to the ends of its interval; `None` of fewer than two.
#[must_use]
pub fn deviation_interval(n: u64) -> Option<Interval> {
    let freedom = n.checked_sub(1)?;
    let chi = chi_square(freedom, CONFIDENCE)?;
    let freedom = freedom as f64;
    Some(Interval {
        lower: (freedom / chi.upper).sqrt(),
        upper: (freedom / chi.lower).sqrt(),
    })
}

/// Where the mean of `n` chi-square values lies that together have so many degrees of freedom.
fn mean_interval(n: u64, freedom: u64) -> Option<Interval> {
    let chi = chi_square(freedom, CONFIDENCE)?;
    let n = n as f64;
    Some(Interval {
        lower: chi.lower / n,
        upper: chi.upper / n,
    })
}

/// Where the ratio of `n` samples' variance to the true one lies, for `comparisons` of them at once (Sidak); `None` of fewer than two.
#[must_use]
pub fn variance_ratio_interval(n: u64, comparisons: u64) -> Option<Interval> {
    let freedom = n.checked_sub(1)?;
    let each = math::powf(CONFIDENCE, 1.0 / comparisons.max(1) as f64);
    let chi = chi_square(freedom, each)?;
    let freedom = freedom as f64;
    Some(Interval {
        lower: chi.lower / freedom,
        upper: chi.upper / freedom,
    })
}

/// One list by another, entry by entry; `None` where the quotient is no number.
#[must_use]
pub fn ratios(part: &[f64], of: &[f64]) -> Figures {
    let each = part.iter().zip(of).map(|(part, of)| part / of);
    each.map(|ratio| ratio.is_finite().then_some(ratio))
        .collect()
}

/// Square root of each.
pub(super) fn roots(variances: &[f64]) -> Vec<f64> {
    variances.iter().map(|v| v.sqrt()).collect()
}

/// `a - b`, entry by entry.
pub(super) fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// `e^T C^-1 e` over the parameters that were not held, and their number; `None` when the covariance cannot be inverted.
#[must_use]
pub fn nees(error: &[f64], covariance: &DMatrix<f64>) -> Option<(f64, u64)> {
    let error = DVector::from_column_slice(error);
    let (nees, parameters, _) = metric::chi_square(&error, covariance)?;
    nees.is_finite().then_some((nees, parameters as u64))
}

/// Figures in SI units in the units of the result; `None` when none of them is a number.
#[must_use]
pub fn shown(units: &[Unit], figures: &[f64]) -> Option<Figures> {
    let pairs = figures.iter().zip(units);
    let values = pairs.map(|(value, unit)| readable(*value, *unit).0);
    known(
        values
            .map(|value| value.is_finite().then_some(value))
            .collect(),
    )
}

/// The figures, unless none is known.
pub(super) fn known(figures: Figures) -> Option<Figures> {
    figures.iter().any(Option::is_some).then_some(figures)
}

/// What a path said of itself.
#[derive(Clone, Debug)]
struct Honesty {
    pulls: Moments,
    variances: Moments,
    nees: (u64, f64),
    /// Degrees of freedom of all together, and of the last.
    freedom: (u64, u64),
    factor: (u64, f64),
}

impl Honesty {
    fn new(parameters: usize) -> Self {
        Self {
            pulls: Moments::new(parameters),
            variances: Moments::new(parameters),
            nees: (0, 0.0),
            freedom: (0, 0),
            factor: (0, 0.0),
        }
    }

    fn add(&mut self, said: &Said, covariance: &DMatrix<f64>) {
        let variance: Vec<f64> = covariance.diagonal().iter().copied().collect();
        self.variances.add(&variance);
        let pull = |(error, v): (&f64, &f64)| if *v > 0.0 { error / v.sqrt() } else { 0.0 };
        let pulls: Vec<f64> = said.error.iter().zip(&variance).map(pull).collect();
        self.pulls.add(&pulls);
        if let Some((nees, freedom)) = nees(&said.error, covariance) {
            self.nees = (self.nees.0 + 1, self.nees.1 + nees);
            self.freedom = (self.freedom.0 + freedom, freedom);
        }
        if let Some(factor) = said.variance_factor {
            self.factor = (self.factor.0 + 1, self.factor.1 + factor);
        }
    }

    fn reported(&self, units: &[Unit]) -> Option<Reported> {
        let n = self.pulls.count();
        let squares = mean_interval(n, n)?;
        Some(Reported {
            standard_deviation: shown(units, &roots(&self.variances.mean()?)),
            pull_mean: self.pulls.mean()?,
            pull_rms: self.pulls.rms()?,
            pull_rms_interval: Interval {
                lower: squares.lower.sqrt(),
                upper: squares.upper.sqrt(),
            },
            nees: self.nees(),
            variance_factor: (self.factor.0 > 0).then(|| self.factor.1 / self.factor.0 as f64),
        })
    }

    fn nees(&self) -> Option<Nees> {
        let (trials, sum) = self.nees;
        Some(Nees {
            mean: sum / trials as f64,
            interval: mean_interval(trials, self.freedom.0)?,
            trials,
            parameters: self.freedom.1,
        })
    }
}

/// Sums over the trials of one cell, for every path. Their size does not depend on the number of trials.
#[derive(Clone, Debug)]
pub struct Statistics {
    units: Vec<Unit>,
    paths: Vec<&'static str>,
    trials: u64,
    errors: Vec<Moments>,
    honesty: Vec<Honesty>,
    /// With the index of its path.
    refusals: Vec<(usize, RefusalCount)>,
}

impl Statistics {
    /// Of nothing yet.
    #[must_use]
    pub fn new(tried: &dyn Tried) -> Self {
        let units: Vec<Unit> = tried.parameters().iter().map(|p| p.unit).collect();
        let paths: Vec<&'static str> = tried.paths().iter().map(|p| p.name).collect();
        Self {
            trials: 0,
            errors: vec![Moments::new(units.len()); paths.len()],
            honesty: vec![Honesty::new(units.len()); paths.len()],
            refusals: vec![],
            units,
            paths,
        }
    }

    /// Adds a trial; to give the same bytes always, in the order of seeds.
    pub fn add(&mut self, trial: &Trial) {
        self.trials += 1;
        for (path, outcome) in trial.paths.iter().enumerate() {
            match outcome {
                Ok(said) => {
                    self.errors[path].add(&said.error);
                    if let Some(covariance) = &said.covariance {
                        self.honesty[path].add(said, covariance);
                    }
                }
                Err(reason) => self.refuse(path, trial.seed, reason),
            }
        }
    }

    fn refuse(&mut self, path: usize, seed: u64, reason: &Reason) {
        let mut counts = self.refusals.iter_mut();
        let known = counts.find(|(of, r)| *of == path && r.code == reason.code);
        let Some((_, known)) = known else {
            let first = RefusalCount {
                path: self.paths[path].to_owned(),
                code: reason.code.clone(),
                count: 1,
                seeds: vec![seed],
                example: reason.text.clone(),
            };
            self.refusals.push((path, first));
            return;
        };
        known.count += 1;
        if known.seeds.len() < NAMED_SEEDS {
            known.seeds.push(seed);
        }
    }

    /// Trials added.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.trials
    }

    /// Errors of a path, in SI units and radians.
    #[must_use]
    pub fn errors(&self, path: usize) -> &Moments {
        &self.errors[path]
    }

    /// Figures in the units of the result.
    #[must_use]
    pub fn shown(&self, figures: &[f64]) -> Option<Figures> {
        shown(&self.units, figures)
    }

    /// Standard deviations that a path states, root mean square over the trials; `None` for a path that states none.
    #[must_use]
    pub fn claimed(&self, path: usize) -> Option<Figures> {
        self.shown(&roots(&self.honesty[path].variances.mean()?))
    }

    /// Refusals by path and reason, in the order of paths, then as they came up.
    #[must_use]
    pub fn refusals(&self) -> Vec<RefusalCount> {
        let mut all = self.refusals.clone();
        all.sort_by_key(|(path, _)| *path);
        all.into_iter().map(|(_, count)| count).collect()
    }

    /// What the trials say of a path.
    #[must_use]
    pub fn of(&self, path: usize) -> PathStatistics {
        let errors = self.errors(path);
        let n = errors.count();
        let si = |figures: Option<Vec<f64>>| figures.and_then(|f| self.shown(&f));
        let variance = errors.variance();
        PathStatistics {
            path: self.paths[path].to_owned(),
            trials: self.trials,
            usable: n,
            bias: si(errors.mean()),
            bias_standard_error: si(variance.as_deref().map(|v| of_mean(v, n))),
            standard_deviation: si(variance.as_deref().map(roots)),
            standard_deviation_interval: variance.and_then(|_| deviation_interval(n)),
            rms: si(errors.rms()),
            reported: self.honesty[path].reported(&self.units),
        }
    }
}

/// One sigma of the mean of `n` values of these variances.
pub(super) fn of_mean(variance: &[f64], n: u64) -> Vec<f64> {
    variance.iter().map(|v| (v / n as f64).sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found - expected).abs() < tolerance,
            "found {found}, expected {expected}"
        );
    }

    /// Chi-square quantiles of printed tables (Abramowitz and Stegun, table 26.8): 10 degrees, 2.5 % and 97.5 %: 3.24697, 20.4831;
    /// 100 degrees: 74.2219, 129.561.
    #[test]
    fn intervals_against_printed_tables() {
        let ten = chi_square(10, 0.95).expect("interval");
        near(ten.lower, 3.24697, 1e-5);
        near(ten.upper, 20.4831, 1e-4);
        let deviation = deviation_interval(101).expect("interval");
        near(deviation.lower, (100.0_f64 / 129.561).sqrt(), 1e-5);
        near(deviation.upper, (100.0_f64 / 74.2219).sqrt(), 1e-5);
        let ratio = variance_ratio_interval(101, 1).expect("interval");
        near(ratio.lower, 0.742219, 1e-6);
        near(ratio.upper, 1.29561, 1e-5);
        assert_eq!(deviation_interval(1), None);
        assert_eq!(deviation_interval(0), None);
        assert_eq!(variance_ratio_interval(0, 3), None);
    }

    /// Sidak for two comparisons: each at sqrt(0.95) = 0.974679; the wider interval is the one of 1.26604 % in each tail.
    #[test]
    fn more_comparisons_widen_the_interval() {
        let one = variance_ratio_interval(101, 1).expect("interval");
        let two = variance_ratio_interval(101, 2).expect("interval");
        assert!(two.lower < one.lower && two.upper > one.upper);
        let chi = ChiSquare::new(100.0).expect("freedom");
        near(
            chi.below(100.0 * two.lower),
            0.5 * (1.0 - 0.95_f64.sqrt()),
            1e-9,
        );
        near(
            1.0 - chi.below(100.0 * two.upper),
            0.5 * (1.0 - 0.95_f64.sqrt()),
            1e-9,
        );
    }

    /// By hand: covariance diag(s^2) but for a correlation r of the first two, whose part is (a^2 - 2 r a b + b^2) / (1 - r^2).
    #[test]
    fn nees_against_a_hand_value() {
        use nalgebra::{Matrix6, SVector};
        let sigma = [1e-5, 2e-4, 3.0, 0.1, 0.01, 7.0];
        let r = -0.6;
        let mut covariance = Matrix6::from_diagonal(&SVector::from(sigma.map(|s| s * s)));
        (covariance[(0, 1)], covariance[(1, 0)]) = (r * 2e-9, r * 2e-9);
        let pulls = [0.5, 1.5, -2.0, 1.0, 0.0, 3.0];
        let error: [f64; 6] = std::array::from_fn(|i| pulls[i] * sigma[i]);
        let whole = DMatrix::from_column_slice(6, 6, covariance.as_slice());
        let pair = (0.25 - 2.0 * r * 0.75 + 2.25) / (1.0 - r * r);
        let (found, parameters) = nees(&error, &whole).expect("nees");
        near(found, pair + 14.0, 1e-10);
        assert_eq!(parameters, 6);
        assert_eq!(nees(&error, &DMatrix::from_element(6, 6, 1.0)), None);
    }

    /// Three paths over an angle and two lengths; nothing is ever tried.
    fn empty() -> Statistics {
        Statistics {
            units: vec![Unit::Radian, Unit::Metre, Unit::Metre],
            paths: vec!["joint", "reference", "reference_projected"],
            trials: 0,
            errors: vec![Moments::new(3); 3],
            honesty: vec![Honesty::new(3); 3],
            refusals: vec![],
        }
    }

    fn trial(seed: u64, error: f64) -> Trial {
        let reason = Reason::new("no_wall", &format!("of seed {seed}"));
        let said = |covariance, variance_factor| Said {
            error: vec![error; 3],
            covariance,
            variance_factor,
        };
        let covariance = DMatrix::identity(3, 3) * 4.0;
        let joint = said(Some(covariance), (seed == 2).then_some(1.5));
        let even = seed.is_multiple_of(2);
        Trial {
            seed,
            paths: vec![
                if even { Ok(joint) } else { Err(reason.clone()) },
                Ok(said(None, None)),
                Err(reason),
            ],
        }
    }

    #[test]
    fn each_path_has_its_own_trials_and_refusals() {
        let mut all = empty();
        for seed in 1..=24 {
            all.add(&trial(seed, seed as f64));
        }
        let joint = all.of(0);
        assert_eq!((joint.trials, joint.usable), (24, 12));
        let bias = joint.bias.expect("bias");
        assert_eq!(bias[1], Some(13.0));
        near(bias[0].expect("an angle"), 13.0_f64.to_degrees(), 1e-9);
        let reported = joint.reported.expect("reported");
        assert_eq!(reported.standard_deviation.expect("sigma")[2], Some(2.0));
        near(reported.pull_mean[1], 6.5, 1e-14);
        // 2^2 + 4^2 + ... + 24^2 = 2600, of 12, by 2^2
        near(reported.pull_rms[1], (2600.0_f64 / 48.0).sqrt(), 1e-13);
        let nees = reported.nees.expect("nees");
        near(nees.mean, 3.0 * 2600.0 / 48.0, 1e-10);
        assert_eq!((nees.trials, nees.parameters), (12, 3));
        assert_eq!(reported.variance_factor, Some(1.5));
        let ends = reported.pull_rms_interval;
        // chi-square of 12 degrees: 4.40379 and 23.3367
        near(ends.lower, (4.40379_f64 / 12.0).sqrt(), 1e-5);
        near(ends.upper, (23.3367_f64 / 12.0).sqrt(), 1e-5);
        assert_eq!(all.of(1).usable, 24);
        assert_eq!(all.of(1).reported, None);
        assert_eq!((all.of(2).usable, all.of(2).bias), (0, None));
        let refusals = all.refusals();
        assert_eq!(refusals.len(), 2);
        assert_eq!((&*refusals[0].path, refusals[0].count), ("joint", 12));
        assert_eq!(refusals[0].seeds, [1, 3, 5, 7, 9, 11, 13, 15, 17, 19]);
        assert_eq!(
            (refusals[1].count, &*refusals[1].example),
            (24, "of seed 1")
        );
    }

    /// A held parameter has no part in the mean of NEES nor in its degrees of freedom.
    #[test]
    fn a_held_parameter_does_not_count() {
        let mut all = empty();
        for seed in 1..=10 {
            let mut covariance = DMatrix::identity(3, 3);
            covariance[(1, 1)] = 0.0;
            let said = Said {
                error: vec![1.0, 0.0, -1.0],
                covariance: Some(covariance),
                variance_factor: None,
            };
            let paths = vec![Ok(said)];
            all.add(&Trial { seed, paths });
        }
        let nees = all.of(0).reported.expect("reported").nees.expect("nees");
        assert_eq!((nees.mean, nees.parameters), (2.0, 2));
        // chi-square of 20 degrees: 9.59078 and 34.1696
        near(nees.interval.lower, 0.959078, 1e-6);
        near(nees.interval.upper, 3.41696, 1e-5);
    }

    #[test]
    fn ratios_that_are_no_numbers_are_left_out() {
        assert_eq!(
            ratios(&[1.0, 1.0, 0.0], &[2.0, 0.0, 0.0]),
            [Some(0.5), None, None]
        );
    }
}
