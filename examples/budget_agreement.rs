//! Error budget by propagation against Monte Carlo: one source alone, several together, or all, through both paths.
//!
//! `cargo run --release --example budget_agreement -- SCENARIO.toml N SOURCE...`
//!
//! A SOURCE is a name as in `[sources]` (`position_drift`), several joined by `+`, or `all`. Seeds 1 to N, nothing selected. Per
//! parameter: predicted and found standard deviation, the ratio of variances with its chi-square interval (5 % family-wise, after
//! Sidak, over everything in this run), and predicted and found mean.

#![allow(
    clippy::disallowed_methods,
    reason = "no result of the program hangs on these"
)]

use boresight::observe::Mounting;
use boresight::procedures::pool::budget::analytic::{PathBudget, analytic_with};
use boresight::procedures::pool::config::Variant;
use boresight::procedures::pool::influence::difference;
use boresight::procedures::pool::joint::SIX;
use boresight::procedures::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::simulate::{Scenario, Source, Sources, simulate};
use nalgebra::Vector6;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

type Errors = Vector6<f64>;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, count, sets @ ..] = arguments.as_slice() else {
        eprintln!("usage: budget_agreement SCENARIO.toml N SOURCE...");
        std::process::exit(2);
    };
    let text = std::fs::read_to_string(path).expect("readable scenario");
    let scenario: Scenario = toml::from_str(&text).expect("a scenario");
    let count: u64 = count.parse().expect("number of trials");
    // two paths, six parameters, variance and mean
    let level = 1.0 - 0.95_f64.powf(1.0 / (24 * sets.len()) as f64);
    for set in sets {
        compare(&scenario, set, count, level);
    }
}

fn sources(set: &str, scenario: &Scenario) -> Sources {
    if set == "all" {
        return scenario.sources.clone();
    }
    let named = |name: &str| {
        let quoted = format!("\"{name}\"");
        serde_json::from_str::<Source>(&quoted).expect("a source's name")
    };
    Sources::only(&set.split('+').map(named).collect::<Vec<_>>())
}

fn compare(scenario: &Scenario, set: &str, count: u64, level: f64) {
    let scenario = Scenario {
        sources: sources(set, scenario),
        ..scenario.clone()
    };
    let begin = std::time::Instant::now();
    let (projected, joint) = configurations();
    let budget = analytic_with(&scenario, &projected, &joint).expect("a budget");
    let seconds = begin.elapsed().as_secs_f64();
    let trials: Vec<[Option<Errors>; 2]> = (1..=count)
        .into_par_iter()
        .map(|seed| trial(&scenario, seed))
        .collect();
    println!("## {set}: {count} trials, predicted in {seconds:.2} s");
    println!(
        "| path | parameter | predicted sigma | found | variance ratio | interval | predicted mean | found | t |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let sequential = budget.sequential.as_ref().expect("a reference path");
    for (k, (name, path)) in [("joint", &budget.joint), ("projected", sequential)]
        .into_iter()
        .enumerate()
    {
        let errors: Vec<Errors> = trials.iter().filter_map(|t| t[k]).collect();
        table(name, path, &errors, level);
    }
    if let Some(efficiency) = budget.efficiency(&budget.joint) {
        println!("efficiency of the joint path {:.3?}", efficiency.as_slice());
    }
}

fn table(name: &str, path: &PathBudget, errors: &[Errors], level: f64) {
    let n = errors.len() as f64;
    let chi = ChiSquared::new(n - 1.0).expect("trials");
    let interval = [0.5 * level, 1.0 - 0.5 * level].map(|p| chi.inverse_cdf(p) / (n - 1.0));
    let mean: Errors = errors.iter().sum::<Errors>() / n;
    for (i, parameter) in SIX.iter().enumerate() {
        let (unit, scale) = if i < 3 {
            ("deg", 1f64.to_degrees())
        } else {
            ("mm", 1e3)
        };
        let sum: f64 = errors.iter().map(|e| (e[i] - mean[i]).powi(2)).sum();
        let found = (sum / (n - 1.0)).sqrt();
        let predicted = path.covariance[(i, i)].sqrt();
        if predicted < 1e-9 {
            println!(
                "| {name} | {parameter} ({unit}) | 0 | {:.6} | - | - | - | - | - |",
                found * scale
            );
            continue;
        }
        let ratio = (found / predicted).powi(2);
        let out = if ratio < interval[0] || ratio > interval[1] {
            " OUT"
        } else {
            ""
        };
        let t = (mean[i] - path.bias[i]) / (found / n.sqrt());
        println!(
            "| {name} | {parameter} ({unit}) | {:.5} | {:.5} | {ratio:.3}{out} | {:.3} {:.3} | {:.5} | {:.5} | {t:+.2} |",
            predicted * scale,
            found * scale,
            interval[0],
            interval[1],
            path.bias[i] * scale,
            mean[i] * scale,
        );
    }
}

/// Both paths as they come, the reference path projected; the environment's `THRESHOLD_DEG` says where it ends.
fn configurations() -> (SequentialConfig, JointConfig) {
    let mut projected = SequentialConfig {
        variant: Variant::Projected,
        ..SequentialConfig::default()
    };
    if let Ok(threshold) = std::env::var("THRESHOLD_DEG") {
        projected.threshold_deg = threshold.parse().expect("degrees");
    }
    (projected, JointConfig::default())
}

fn trial(scenario: &Scenario, seed: u64) -> [Option<Errors>; 2] {
    let survey = simulate(scenario, seed).expect("a survey");
    let (projected, joint) = configurations();
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &projected,
        joint: &joint,
        seed,
        extras: &[],
    };
    let outcome =
        calibrate(&input, &boresight::watch::Unwatched).expect("input that can be worked with");
    let error = |found: &Mounting| difference(found, &survey.reality.sonar);
    let reference = outcome.sequential.as_ref().and_then(|s| s.as_ref().ok());
    [
        outcome.joint.as_ref().map(|j| error(&j.mounting)),
        reference.map(|s| error(&s.mounting)),
    ]
}
