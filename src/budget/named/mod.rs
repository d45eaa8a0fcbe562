//! The error budget of a procedure whose parameters are named: Monte Carlo of all sources together and of each alone, by the joint
//! and the reference path.
//!
//! A procedure implements [`Tried`]; [`run`] does the rest. Trials are summed up in the order of seeds, so that the result has the
//! same bytes on any number of threads, and memory does not grow with their number.

mod tally;

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use rayon::prelude::*;

use super::statistics::CONFIDENCE;
pub use crate::calibrate::tried::{Acting, JointSaid, NamedTrial, Tried};
use crate::results::{
    NAMED_BUDGET_FORMAT_VERSION, NamedBudget, NamedPath, NamedShare, NamedSource, Software,
};
use tally::Tally;

/// Trials between two looks at the stop flag.
const CHUNK: u64 = 64;

/// How many trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// First seed of every set.
    pub first_seed: u64,
    /// Of all sources together.
    pub trials: u64,
    /// Of each source alone.
    pub single: u64,
}

/// Runs the trials on the threads of the current pool and sums them up. Once `stop` is set no further ones are begun and what is
/// done is the result. `progress` is told how many trials are done, of how many.
pub fn run(
    tried: &dyn Tried,
    wanted: &Wanted,
    stop: &AtomicBool,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> NamedBudget {
    let (parameters, sources) = (tried.parameters(), tried.sources());
    let all = wanted.trials + wanted.single * sources.len() as u64 + 1;
    let mut done = 0;
    let mut tallied = |acting, trials| {
        let mut tally = Tally::new(parameters.len());
        let mut seed = wanted.first_seed;
        let end = seed + trials;
        while seed < end && !stop.load(SeqCst) {
            let chunk: Vec<NamedTrial> = (seed..end.min(seed + CHUNK))
                .into_par_iter()
                .map(|seed| tried.trial(seed, acting))
                .collect();
            for trial in &chunk {
                tally.add(seed, trial);
                seed += 1;
            }
            done += chunk.len() as u64;
            progress(done, all);
        }
        tally
    };
    let nothing = tallied(Acting::None, 1);
    let together = tallied(Acting::All, wanted.trials);
    let alone: Vec<Tally> = (0..sources.len())
        .map(|place| tallied(Acting::Only(place), wanted.single))
        .collect();
    let path = |joint: bool| path(joint, &nothing, &together, &sources, &alone);
    NamedBudget {
        format_version: NAMED_BUDGET_FORMAT_VERSION,
        procedure: tried.procedure().to_owned(),
        scenario: tried.scenario().to_owned(),
        software: Software::this(),
        first_seed: wanted.first_seed,
        trials: together.trials(),
        single_trials: alone.iter().map(Tally::trials).min().unwrap_or(0),
        confidence: CONFIDENCE,
        parameters,
        paths: vec![path(true), path(false)],
        sources,
        refusals: together.refusals(),
        command: String::new(),
        notes: vec![],
    }
}

fn path(
    joint: bool,
    nothing: &Tally,
    together: &Tally,
    sources: &[NamedSource],
    alone: &[Tally],
) -> NamedPath {
    let total = together.variance(joint);
    let share = |source: &str, tally: &Tally| NamedShare {
        source: source.to_owned(),
        figures: tally.figures(joint),
        share: total
            .as_ref()
            .zip(tally.variance(joint))
            .map(|(total, part)| part.iter().zip(total).map(|(p, t)| p / t).collect()),
    };
    let mut shares = vec![share("nothing", nothing)];
    let tried = sources.iter().zip(alone).filter(|(_, t)| t.trials() > 0);
    shares.extend(tried.map(|(s, t)| share(&s.source, t)));
    let best = together.variance(true);
    NamedPath {
        path: if joint { "joint" } else { "reference" }.to_owned(),
        claimed: nothing.claimed().filter(|_| joint),
        together: together.figures(joint),
        shares,
        honesty: together.honesty().filter(|_| joint),
        efficiency: best
            .zip(total)
            .map(|(best, own)| best.iter().zip(&own).map(|(b, o)| b / o).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::NamedParameter;
    use crate::stats::stream;
    use nalgebra::DMatrix;
    use rand_distr::{Distribution, Normal};

    /// Two sources of 1 and 2 on a first parameter, 3 and 0 on a second; the joint path claims exactly that, the reference path has
    /// twice the error and a bias, and no answer on every tenth seed.
    struct Toy;

    impl Tried for Toy {
        fn procedure(&self) -> &'static str {
            "toy"
        }
        fn scenario(&self) -> &str {
            "toy"
        }
        fn parameters(&self) -> Vec<NamedParameter> {
            let parameter = |name: &str| NamedParameter {
                name: name.to_owned(),
                unit: "m".to_owned(),
            };
            ["a", "b"].map(parameter).into()
        }
        fn sources(&self) -> Vec<NamedSource> {
            let source = |name: &str| NamedSource {
                source: name.to_owned(),
                title: name.to_owned(),
                description: String::new(),
            };
            ["first", "second"].map(source).into()
        }
        fn trial(&self, seed: u64, acting: Acting) -> NamedTrial {
            let mut random = stream(seed, 7);
            let normal = Normal::new(0.0, 1.0).expect("a deviation");
            let mut draw = |place| {
                let acts = acting == Acting::All || acting == Acting::Only(place);
                normal.sample(&mut random) * f64::from(u8::from(acts))
            };
            let (first, second) = (draw(0), draw(1));
            let error = vec![first + 2.0 * second, 3.0 * first];
            NamedTrial {
                reference: if seed.is_multiple_of(10) {
                    Err("tenth".to_owned())
                } else {
                    Ok(error.iter().map(|e| 2.0 * e + 1.0).collect())
                },
                joint: Ok(JointSaid {
                    error,
                    covariance: DMatrix::from_row_slice(2, 2, &[5.0, 3.0, 3.0, 9.0]),
                    variance_factor: Some(1.0),
                }),
            }
        }
    }

    fn toy(threads: usize) -> NamedBudget {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let wanted = Wanted {
            first_seed: 1,
            trials: 2000,
            single: 1000,
        };
        let stop = AtomicBool::new(false);
        let run = || run(&Toy, &wanted, &stop, &|_, _| {});
        pool.expect("a pool").install(run)
    }

    /// One sigma of a variance over n trials is sqrt(2 / (n - 1)); four of them are allowed.
    #[test]
    fn shares_pulls_and_refusals_are_those_of_the_toy() {
        let found = toy(2);
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
        near(sigma[0].powi(2), 5.0, 2000.0);
        near(sigma[1].powi(2), 9.0, 2000.0);
        let second = joint.shares[2].share.as_ref().expect("a share");
        near(second[0], 0.8, 1000.0);
        assert_eq!(second[1], 0.0);
        let honesty = joint.honesty.as_ref().expect("honesty");
        near(honesty.pull_rms[0].powi(2), 1.0, 2000.0);
        near(honesty.nees.as_ref().expect("nees").mean, 2.0, 2000.0);
        assert!((honesty.reported[1] - 3.0).abs() < 1e-12);
        let reference = &found.paths[1];
        let efficiency = reference.efficiency.as_ref().expect("efficiency");
        near(efficiency[0], 0.25, 1800.0);
        let figures = reference.together.as_ref().expect("figures");
        assert_eq!((figures.trials, figures.usable), (2000, 1800));
        assert!(reference.honesty.is_none() && reference.claimed.is_none());
        assert_eq!((found.refusals.len(), found.refusals[0].count), (1, 200));
        assert_eq!(found.refusals[0].seeds[..2], [10, 20]);
        assert_eq!(joint.claimed, Some(vec![5.0_f64.sqrt(), 3.0]));
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        assert_eq!(toy(1), toy(2));
    }
}
