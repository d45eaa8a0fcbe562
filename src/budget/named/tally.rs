//! Sums over the trials of one set.

use nalgebra::{DMatrix, DVector};

use super::{JointSaid, NamedTrial};
use crate::budget::statistics::{deviation_interval, mean_interval};
use crate::calibrate::metric;
use crate::results::{Interval, NamedFigures, NamedHonesty, NamedRefusal, Nees};
use crate::stats::Moments;

/// Seeds that a count of refusals names.
const NAMED_SEEDS: usize = 10;

/// Sums over trials; their size does not depend on the number of trials.
pub(super) struct Tally {
    trials: u64,
    /// Joint path, reference path.
    errors: [Moments; 2],
    pulls: Moments,
    variances: Moments,
    nees: (u64, f64),
    factor: (u64, f64),
    refusals: Vec<NamedRefusal>,
}

impl Tally {
    pub(super) fn new(parameters: usize) -> Self {
        let moments = || Moments::new(parameters);
        Self {
            trials: 0,
            errors: [moments(), moments()],
            pulls: moments(),
            variances: moments(),
            nees: (0, 0.0),
            factor: (0, 0.0),
            refusals: vec![],
        }
    }

    /// Adds a trial; in the order of seeds.
    pub(super) fn add(&mut self, seed: u64, trial: &NamedTrial) {
        self.trials += 1;
        match &trial.joint {
            Ok(said) => {
                self.errors[0].add(&said.error);
                self.judge(said);
            }
            Err(reason) => self.refuse("joint", seed, reason),
        }
        match &trial.reference {
            Ok(error) => self.errors[1].add(error),
            Err(reason) => self.refuse("reference", seed, reason),
        }
    }

    fn judge(&mut self, said: &JointSaid) {
        let variance: Vec<f64> = said.covariance.diagonal().iter().copied().collect();
        let pull = |(e, v): (&f64, &f64)| if *v > 0.0 { e / v.sqrt() } else { 0.0 };
        let pulls: Vec<f64> = said.error.iter().zip(&variance).map(pull).collect();
        self.pulls.add(&pulls);
        self.variances.add(&variance);
        if let Some(nees) = nees(said) {
            self.nees = (self.nees.0 + 1, self.nees.1 + nees);
        }
        if let Some(factor) = said.variance_factor {
            self.factor = (self.factor.0 + 1, self.factor.1 + factor);
        }
    }

    fn refuse(&mut self, path: &str, seed: u64, reason: &str) {
        let mut known = self.refusals.iter_mut();
        // figures in a reason differ from trial to trial
        let kind =
            |text: &str| -> String { text.chars().filter(|c| !c.is_ascii_digit()).collect() };
        match known.find(|r| r.path == path && kind(&r.reason) == kind(reason)) {
            Some(known) => {
                known.count += 1;
                if known.seeds.len() < NAMED_SEEDS {
                    known.seeds.push(seed);
                }
            }
            None => self.refusals.push(NamedRefusal {
                path: path.to_owned(),
                reason: reason.to_owned(),
                count: 1,
                seeds: vec![seed],
            }),
        }
    }

    pub(super) fn trials(&self) -> u64 {
        self.trials
    }

    pub(super) fn refusals(&self) -> Vec<NamedRefusal> {
        self.refusals.clone()
    }

    /// Variance of a path's error.
    pub(super) fn variance(&self, joint: bool) -> Option<Vec<f64>> {
        self.errors[usize::from(!joint)].variance()
    }

    /// Standard deviations that the joint path states, root mean square over the trials.
    pub(super) fn claimed(&self) -> Option<Vec<f64>> {
        Some(roots(&self.variances.mean()?))
    }

    pub(super) fn figures(&self, joint: bool) -> Option<NamedFigures> {
        let errors = &self.errors[usize::from(!joint)];
        let n = errors.count();
        let variance = errors.variance();
        let of_mean = |v: &Vec<f64>| v.iter().map(|v| (v / n as f64).sqrt()).collect();
        Some(NamedFigures {
            trials: self.trials,
            usable: n,
            bias: errors.mean()?,
            bias_standard_error: variance.as_ref().map(of_mean),
            standard_deviation: variance.as_deref().map(roots),
            standard_deviation_interval: variance.and_then(|_| deviation_interval(n)),
        })
    }

    pub(super) fn honesty(&self) -> Option<NamedHonesty> {
        let squares = mean_interval(self.pulls.count(), 1)?;
        let (trials, sum) = self.nees;
        let freedom = self.pulls.mean()?.len() as u64;
        let nees = mean_interval(trials, freedom).map(|interval| Nees {
            mean: sum / trials as f64,
            interval,
            trials,
        });
        Some(NamedHonesty {
            reported: self.claimed()?,
            pull_mean: self.pulls.mean()?,
            pull_rms: self.pulls.rms()?,
            pull_rms_interval: Interval {
                lower: squares.lower.sqrt(),
                upper: squares.upper.sqrt(),
            },
            nees,
            variance_factor: (self.factor.0 > 0).then(|| self.factor.1 / self.factor.0 as f64),
        })
    }
}

fn roots(variances: &[f64]) -> Vec<f64> {
    variances.iter().map(|v| v.sqrt()).collect()
}

fn nees(said: &JointSaid) -> Option<f64> {
    let covariance: &DMatrix<f64> = &said.covariance;
    let error = DVector::from_column_slice(&said.error);
    metric::chi_square(&error, covariance).map(|found| found.0)
}
