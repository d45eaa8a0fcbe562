//! What trials say of a path: streaming sums over the trials in the order of seeds, and the intervals about them.

use nalgebra::{Matrix6, SVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::trial::{Error6, JointTrial, Reason, Trial};
use crate::results::{
    BudgetPath, Interval, Nees, PathStatistics, RefusalCount, Reported, SixFigures, SixValues,
};
use crate::stats;

/// Probability inside every interval.
pub const CONFIDENCE: f64 = 0.95;

/// Seeds that a count of refusals names.
const NAMED_SEEDS: usize = 10;

/// Streaming mean and variance of six figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments(stats::Moments);

impl Default for Moments {
    fn default() -> Self {
        Self(stats::Moments::new(6))
    }
}

impl Moments {
    /// Adds one set of figures.
    pub fn add(&mut self, six: &[f64; 6]) {
        self.0.add(six);
    }

    /// How many were added.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.count()
    }

    /// Mean; `None` of nothing.
    #[must_use]
    pub fn mean(&self) -> Option<[f64; 6]> {
        self.0.mean()?.try_into().ok()
    }

    /// Unbiased variance about the mean; `None` of fewer than two.
    #[must_use]
    pub fn variance(&self) -> Option<[f64; 6]> {
        self.0.variance()?.try_into().ok()
    }

    /// Root mean square about zero; `None` of nothing.
    #[must_use]
    pub fn rms(&self) -> Option<[f64; 6]> {
        self.0.rms()?.try_into().ok()
    }
}

/// Ends between which a chi-square variable of `freedom` degrees lies with `confidence`; `None` without freedom.
#[must_use]
pub fn chi_square(freedom: u64, confidence: f64) -> Option<Interval> {
    let tail = 0.5 * (1.0 - confidence);
    let chi = ChiSquared::new(freedom as f64).ok()?;
    Some(Interval {
        lower: chi.inverse_cdf(tail),
        upper: chi.inverse_cdf(1.0 - tail),
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

/// Where the mean of `n` values that each are chi-square with `freedom` degrees lies.
pub(super) fn mean_interval(n: u64, freedom: u64) -> Option<Interval> {
    let chi = chi_square(n * freedom, CONFIDENCE)?;
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
    let each = CONFIDENCE.powf(1.0 / comparisons.max(1) as f64);
    let chi = chi_square(freedom, each)?;
    let freedom = freedom as f64;
    Some(Interval {
        lower: chi.lower / freedom,
        upper: chi.upper / freedom,
    })
}

/// A bound's variance by a path's variance; `None` unless all are positive.
#[must_use]
pub fn efficiency(bound: &[f64; 6], variance: &[f64; 6]) -> Option<SixValues> {
    let positive = bound.iter().chain(variance).all(|v| *v > 0.0);
    positive.then(|| six_values(std::array::from_fn(|i| bound[i] / variance[i])))
}

/// In the results' form.
#[must_use]
pub fn six_values([pitch, roll, yaw, lx, ly, lz]: [f64; 6]) -> SixValues {
    SixValues {
        pitch,
        roll,
        yaw,
        lx,
        ly,
        lz,
    }
}

/// `e^T C^-1 e`; `None` when the covariance cannot be inverted.
#[must_use]
pub fn nees(error: &Error6, covariance: &Matrix6<f64>) -> Option<f64> {
    // scaled to a correlation: radians and metres differ too much for one pivot rule
    let sigma = covariance.diagonal().map(f64::sqrt);
    let scaled = Matrix6::from_fn(|i, j| covariance[(i, j)] / (sigma[i] * sigma[j]));
    let pull = SVector::<f64, 6>::from_fn(|i, _| error[i] / sigma[i]);
    let solved = scaled.cholesky()?.solve(&pull);
    Some(pull.dot(&solved)).filter(|x| x.is_finite())
}

/// What the joint path said of itself.
#[derive(Clone, Debug, Default)]
struct Honesty {
    pulls: Moments,
    variances: Moments,
    nees: (u64, f64),
    factor: (u64, f64),
}

impl Honesty {
    fn add(&mut self, joint: &JointTrial) {
        let variance: [f64; 6] = std::array::from_fn(|i| joint.covariance[(i, i)]);
        self.variances.add(&variance);
        let pull = |i: usize| match variance[i] {
            v if v > 0.0 => joint.error[i] / v.sqrt(),
            _ => 0.0,
        };
        self.pulls.add(&std::array::from_fn(pull));
        if let Some(nees) = nees(&joint.error, &joint.covariance) {
            self.nees = (self.nees.0 + 1, self.nees.1 + nees);
        }
        if let Some(factor) = joint.variance_factor {
            self.factor = (self.factor.0 + 1, self.factor.1 + factor);
        }
    }

    fn reported(&self) -> Option<Reported> {
        let n = self.pulls.count();
        let squares = mean_interval(n, 1)?;
        let variance = self.variances.mean()?;
        Some(Reported {
            standard_deviation: SixFigures::from_si(variance.map(f64::sqrt)),
            pull_mean: six_values(self.pulls.mean()?),
            pull_rms: six_values(self.pulls.rms()?),
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
            interval: mean_interval(trials, 6)?,
            trials,
        })
    }
}

/// Sums over the trials of one cell, for the three paths. Their size does not depend on the number of trials.
#[derive(Clone, Debug, Default)]
pub struct Statistics {
    trials: u64,
    errors: [Moments; 3],
    honesty: Honesty,
    refusals: Vec<RefusalCount>,
}

impl Statistics {
    /// Adds a trial; to give the same bytes always, in the order of seeds.
    pub fn add(&mut self, trial: &Trial) {
        self.trials += 1;
        match &trial.joint {
            Ok(joint) => {
                self.errors[0].add(&joint.error);
                self.honesty.add(joint);
            }
            Err(reason) => self.refuse(BudgetPath::Joint, trial.seed, reason),
        }
        let reference = [
            (BudgetPath::Sequential, &trial.sequential),
            (BudgetPath::SequentialProjected, &trial.projected),
        ];
        for (path, outcome) in reference {
            match outcome {
                Ok(error) => self.errors[path as usize].add(error),
                Err(reason) => self.refuse(path, trial.seed, reason),
            }
        }
    }

    fn refuse(&mut self, path: BudgetPath, seed: u64, reason: &Reason) {
        let mut counts = self.refusals.iter_mut();
        let known = counts.find(|r| r.path == path && r.code == reason.code);
        let Some(known) = known else {
            self.refusals.push(RefusalCount {
                path,
                code: reason.code.clone(),
                count: 1,
                seeds: vec![seed],
                example: reason.text.clone(),
            });
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

    /// Errors of a path, radians and metres.
    #[must_use]
    pub fn errors(&self, path: BudgetPath) -> &Moments {
        &self.errors[path as usize]
    }

    /// Refusals by path and reason, in the order of paths, then as they came up.
    #[must_use]
    pub fn refusals(&self) -> Vec<RefusalCount> {
        let mut all = self.refusals.clone();
        all.sort_by_key(|r| r.path);
        all
    }

    /// What the trials say of a path.
    #[must_use]
    pub fn of(&self, path: BudgetPath) -> PathStatistics {
        let errors = self.errors(path);
        let n = errors.count();
        let si = |six: Option<[f64; 6]>| six.and_then(SixFigures::from_si);
        let variance = errors.variance();
        let is_joint = path == BudgetPath::Joint;
        PathStatistics {
            path,
            trials: self.trials,
            usable: n,
            bias: si(errors.mean()),
            bias_standard_error: si(variance.map(|v| v.map(|v| (v / n as f64).sqrt()))),
            standard_deviation: si(variance.map(|v| v.map(f64::sqrt))),
            standard_deviation_interval: variance.and_then(|_| deviation_interval(n)),
            rms: si(errors.rms()),
            reported: is_joint.then(|| self.honesty.reported()).flatten(),
        }
    }
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
        let chi = ChiSquared::new(100.0).expect("freedom");
        near(
            chi.cdf(100.0 * two.lower),
            0.5 * (1.0 - 0.95_f64.sqrt()),
            1e-9,
        );
        near(
            1.0 - chi.cdf(100.0 * two.upper),
            0.5 * (1.0 - 0.95_f64.sqrt()),
            1e-9,
        );
    }

    /// By hand: covariance diag(s^2) but for a correlation r of the first two, whose part is (a^2 - 2 r a b + b^2) / (1 - r^2).
    #[test]
    fn nees_against_a_hand_value() {
        let sigma = [1e-5, 2e-4, 3.0, 0.1, 0.01, 7.0];
        let r = -0.6;
        let mut covariance = Matrix6::from_diagonal(&SVector::from(sigma.map(|s| s * s)));
        (covariance[(0, 1)], covariance[(1, 0)]) = (r * 2e-9, r * 2e-9);
        let pulls = [0.5, 1.5, -2.0, 1.0, 0.0, 3.0];
        let error = std::array::from_fn(|i| pulls[i] * sigma[i]);
        let pair = (0.25 - 2.0 * r * 0.75 + 2.25) / (1.0 - r * r);
        near(nees(&error, &covariance).expect("nees"), pair + 14.0, 1e-10);
        assert_eq!(nees(&error, &Matrix6::from_element(1.0)), None);
    }

    fn trial(seed: u64, error: f64) -> Trial {
        let reason = Reason {
            code: "no_wall".to_owned(),
            text: format!("of seed {seed}"),
        };
        let covariance = Matrix6::identity() * 4.0;
        let joint = JointTrial {
            error: [error; 6],
            covariance,
            variance_factor: (seed == 2).then_some(1.5),
            optional: vec![],
        };
        let even = seed.is_multiple_of(2);
        Trial {
            seed,
            joint: if even { Ok(joint) } else { Err(reason.clone()) },
            sequential: Ok([error; 6]),
            projected: Err(reason),
        }
    }

    #[test]
    fn each_path_has_its_own_trials_and_refusals() {
        let mut all = Statistics::default();
        for seed in 1..=24 {
            all.add(&trial(seed, seed as f64));
        }
        let joint = all.of(BudgetPath::Joint);
        assert_eq!((joint.trials, joint.usable), (24, 12));
        assert_eq!(joint.bias.map(|b| b.lx_m), Some(13.0));
        near(
            joint.bias.expect("bias").yaw_deg,
            13.0_f64.to_degrees(),
            1e-9,
        );
        let reported = joint.reported.expect("reported");
        near(reported.standard_deviation.expect("sigma").lz_m, 2.0, 1e-15);
        near(reported.pull_mean.ly, 6.5, 1e-14);
        // 2^2 + 4^2 + ... + 24^2 = 2600, of 12, by 2^2
        near(reported.pull_rms.lx, (2600.0_f64 / 48.0).sqrt(), 1e-13);
        near(
            reported.nees.expect("nees").mean,
            6.0 * 2600.0 / 48.0,
            1e-10,
        );
        assert_eq!(reported.variance_factor, Some(1.5));
        let ends = reported.pull_rms_interval;
        // chi-square of 12 degrees: 4.40379 and 23.3367
        near(ends.lower, (4.40379_f64 / 12.0).sqrt(), 1e-5);
        near(ends.upper, (23.3367_f64 / 12.0).sqrt(), 1e-5);
        assert_eq!(all.of(BudgetPath::Sequential).usable, 24);
        assert_eq!(all.of(BudgetPath::Sequential).reported, None);
        let projected = all.of(BudgetPath::SequentialProjected);
        assert_eq!((projected.usable, projected.bias), (0, None));
        let refusals = all.refusals();
        assert_eq!(refusals.len(), 2);
        assert_eq!(
            (refusals[0].path, refusals[0].count),
            (BudgetPath::Joint, 12)
        );
        assert_eq!(refusals[0].seeds, [1, 3, 5, 7, 9, 11, 13, 15, 17, 19]);
        assert_eq!(
            (refusals[1].count, &*refusals[1].example),
            (24, "of seed 1")
        );
    }

    #[test]
    fn efficiency_is_bound_by_variance() {
        let found = efficiency(&[1.0; 6], &[2.0, 4.0, 1.0, 1.0, 8.0, 1.0]).expect("six");
        assert_eq!((found.pitch, found.roll, found.ly), (0.5, 0.25, 0.125));
        assert_eq!(efficiency(&[1.0; 6], &[0.0; 6]), None);
    }
}
