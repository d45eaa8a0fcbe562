//! Error budgets: which error source costs how much of which parameter, by which path. Of any procedure that can be tried
//! ([`crate::calibrate::tried::Tried`]); parameters have names, and nothing here knows which there are.
//!
//! | file | what |
//! |---|---|
//! | [`budget`] | the whole: trials, propagation, swath, as a result |
//! | [`experiment`] | which trials are run, on all cores, interrupted and continued |
//! | [`ledger`] | the file of trials |
//! | [`join`] | ledgers of parts joined into those of one run |
//! | [`statistics`] | what the trials say of each path |
//! | [`interaction`] | what the sources do to each other |
//! | [`summary`] | the trials as `result.json` |
//! | [`predicted`] | the analytic figures in the result, compared with the trials |
//! | [`covariances`] | covariances of the calibrations, for the swath |

pub mod covariances;
pub mod experiment;
pub mod interaction;
pub mod join;
pub mod ledger;
pub mod predicted;
pub mod statistics;
pub mod summary;
#[cfg(test)]
mod toy;

use std::path::Path;

use rayon::prelude::*;

use crate::calibrate::tried::Tried;
use crate::calibrate::vary::{Point, VaryError};
use crate::results::{BudgetResult, JOINT, RefusalCount, Sweep, SweepPoint};
use experiment::Experiment;
use ledger::LedgerError;

/// Depths below the sonar where nobody says others, metres.
pub const DEPTHS_M: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

/// The budget of an experiment whose trials are done, in `folder`, and of what the procedure can say without any. Without trials,
/// `experiment` is `None`. `progress` is told what is being done.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn budget(
    tried: &dyn Tried,
    experiment: Option<(&Experiment<'_>, &Path)>,
    depths_m: &[f64],
    progress: &dyn Fn(&str),
) -> Result<BudgetResult, LedgerError> {
    let mut result = summary::frame(tried);
    let mut known = vec![];
    if let Some((experiment, folder)) = experiment {
        progress("summing up");
        summary::fill(&mut result, experiment, folder)?;
        known = covariances::of_trials(experiment, folder)?;
    }
    progress("propagating every source through the paths");
    match tried.propagated() {
        Some(Ok(propagated)) => {
            predicted::add(&mut result, tried, &propagated);
            known = covariances::or_propagated(known, tried, &propagated);
        }
        Some(Err(reason)) => result.notes.push(format!("no analytic budget: {reason}")),
        None => {}
    }
    result.swath = tried.swath(known, depths_m);
    Ok(result)
}

/// The budget at several values by propagation, on all cores: no trials, the RMS error of each path from its bias and covariance.
///
/// # Errors
/// [`VaryError`]: an unknown key, or a value that makes the scenario impossible.
pub fn propagated_sweep(tried: &dyn Tried, points: Vec<Point>) -> Result<Sweep, VaryError> {
    let keys = points.first().map_or_else(Vec::new, |point| {
        point.0.iter().map(|(key, _)| key.clone()).collect()
    });
    let varied: Result<Vec<_>, VaryError> = points
        .into_iter()
        .map(|point| tried.varied(&point).map(|there| (point, there)))
        .collect();
    let points = varied?
        .par_iter()
        .map(|(point, there)| {
            let values = point.0.iter().map(|(_, value)| value.plain()).collect();
            let (paths, refusals) = match predicted::statistics(&**there) {
                Ok(paths) => (paths, vec![]),
                Err(reason) => (vec![], vec![unpropagated(reason)]),
            };
            SweepPoint {
                values,
                paths,
                refusals,
            }
        })
        .collect();
    Ok(Sweep {
        keys,
        trials: 0,
        points,
    })
}

/// The refusal of a point without figures.
fn unpropagated(example: String) -> RefusalCount {
    RefusalCount {
        path: JOINT.to_owned(),
        code: "unpropagated".to_owned(),
        count: 1,
        seeds: vec![],
        example,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;
    use toy::Toy;

    fn tried(threads: usize, trials: u64, single: u64) -> BudgetResult {
        let toy = Toy::default();
        let experiment = Experiment::new(&toy, 1, trials, single);
        let folder = tempfile::tempdir().expect("folder");
        let done = experiment.prepare(folder.path(), false).expect("ledgers");
        let workers = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let stop = AtomicBool::new(false);
        let run = || experiment.run(folder.path(), &done, &stop, &|_| {});
        workers.expect("threads").install(run).expect("trials");
        budget(&toy, Some((&experiment, folder.path())), &[], &|_| {}).expect("a budget")
    }

    /// One sigma of a variance over n trials is sqrt(2 / (n - 1)); four of them are allowed.
    #[test]
    fn shares_pulls_and_refusals_are_those_of_the_toy() {
        let found = tried(2, 2000, 1000);
        let joint = &found.paths[0];
        let near = |found: f64, expected: f64, n: f64| {
            let four_sigmas = 4.0 * (2.0 / (n - 1.0)).sqrt();
            assert!(
                (found / expected - 1.0).abs() < four_sigmas,
                "{found} for {expected}"
            );
        };
        let together = joint.together.as_ref().expect("figures");
        let sigma = together.standard_deviation.as_ref().expect("sigmas");
        let deg = 1.0_f64.to_degrees();
        near((sigma[0].expect("a") / deg).powi(2), 5.0, 2000.0);
        near(sigma[1].expect("b").powi(2), 9.0, 2000.0);
        let of = |source: &str| {
            let share = joint.shares.iter().find(|s| s.source == source);
            share.expect("a share").share.clone().expect("parts")
        };
        near(of("second")[0].expect("a"), 0.8, 1000.0);
        assert_eq!(of("second")[1], Some(0.0));
        let reported = together.reported.as_ref().expect("honesty");
        near(reported.pull_rms[0].powi(2), 1.0, 2000.0);
        near(reported.nees.expect("nees").mean, 2.0, 2000.0);
        let stated = reported.standard_deviation.as_ref().expect("sigmas");
        assert!((stated[1].expect("b") - 3.0).abs() < 1e-12);
        assert_eq!(
            joint.claimed,
            Some(vec![Some(5.0_f64.sqrt() * deg), Some(3.0)])
        );
        let reference = found.paths[1].together.as_ref().expect("figures");
        assert_eq!((reference.trials, reference.usable), (2000, 1800));
        assert_eq!(
            (&reference.reported, &found.paths[1].claimed),
            (&None, &None)
        );
        assert_eq!((found.refusals.len(), found.refusals[0].count), (1, 200));
        assert_eq!(found.refusals[0].seeds[..2], [10, 20]);
        assert_eq!(found.paths[0].path, JOINT);
        // the sources add up: nothing is left to their interaction
        let rest = joint.shares.iter().find(|s| s.source == "interaction");
        let rest = rest
            .expect("a row")
            .standard_deviation
            .clone()
            .expect("figures");
        assert!(
            rest.iter().all(|r| r.expect("a figure").abs() < 1e-12),
            "{rest:?}"
        );
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        assert_eq!(tried(1, 100, 30), tried(2, 100, 30));
    }
}
