//! Monte Carlo check of the reported uncertainty: simulates a scenario with seeds 1 to N, calibrates each by both paths, and
//! prints errors and pulls (error / reported sigma) of the six parameters.
//!
//! `cargo run --release --example pulls -- SCENARIO.toml [N] [FIRST] [--latency] [--range-scale]`
//!
//! The flags switch on the two optional unknowns and add their rows.
//! A pull RMS of 1 means that the reported uncertainty is true. Nothing is selected: a seed without a usable result is listed.

use boresight::budget::trial::errors;
use boresight::calibrate::pool::joint::{JointOutcome, SIX};
use boresight::calibrate::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::simulate::{Scenario, Truth, simulate};
use rayon::prelude::*;

/// Errors and sigmas of one seed, the six parameters first; `None` where a path had no usable result.
struct Trial {
    joint: Option<(Vec<f64>, Vec<f64>)>,
    sequential: Option<[f64; 6]>,
    variance_factor: f64,
    refusal: Option<String>,
}

/// A parameter's name, its unit in the table, and how many of that unit one SI unit makes.
type Row = (&'static str, &'static str, f64);

fn rows(config: &JointConfig) -> Vec<Row> {
    let six = SIX.iter().enumerate().map(|(i, name)| match i {
        0..3 => (*name, "deg", 1f64.to_degrees()),
        _ => (*name, "mm", 1e3),
    });
    let latency = config.latency.then_some(("latency", "ms", 1e3));
    let scale = config.range_scale.then_some(("range_scale", "1e-6", 1e6));
    six.chain(latency).chain(scale).collect()
}

fn main() {
    let (flags, arguments): (Vec<String>, Vec<String>) = std::env::args()
        .skip(1)
        .partition(|argument| argument.starts_with("--"));
    let known = |f: &String| f == "--latency" || f == "--range-scale";
    let (Some(path), true) = (arguments.first(), flags.iter().all(known)) else {
        eprintln!("usage: pulls SCENARIO.toml [N] [FIRST] [--latency] [--range-scale]");
        std::process::exit(2);
    };
    let number = |k: usize, default: u64| {
        arguments
            .get(k)
            .and_then(|a| a.parse().ok())
            .unwrap_or(default)
    };
    let (count, first) = (number(1, 100), number(2, 1));
    let config = JointConfig {
        latency: flags.iter().any(|f| f == "--latency"),
        range_scale: flags.iter().any(|f| f == "--range-scale"),
        ..JointConfig::default()
    };
    let text = std::fs::read_to_string(path).expect("readable scenario");
    let scenario: Scenario = toml::from_str(&text).expect("a scenario");
    let trials: Vec<Trial> = (first..first + count)
        .into_par_iter()
        .map(|seed| trial(&scenario, &config, seed))
        .collect();
    for (k, trial) in trials.iter().enumerate() {
        if let Some(reason) = &trial.refusal {
            println!("seed {}: {reason}", first + k as u64);
        }
    }
    let usable = trials.iter().filter(|t| t.joint.is_some()).count();
    println!(
        "{path}: seeds {first} to {}, {usable} usable",
        first + count - 1
    );
    print_table(&trials, &rows(&config));
}

fn print_table(trials: &[Trial], rows: &[Row]) {
    let joint: Vec<_> = trials.iter().filter_map(|t| t.joint.as_ref()).collect();
    let sequential: Vec<_> = trials.iter().filter_map(|t| t.sequential).collect();
    let n = joint.len() as f64;
    let factors = trials.iter().map(|t| t.variance_factor);
    println!(
        "mean variance factor {:.4}",
        factors.filter(|f| f.is_finite()).sum::<f64>() / n
    );
    println!(
        "| parameter | unit | mean error | standard error | RMS error | mean sigma | pull RMS | pull mean | sequential RMS |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (i, (name, unit, scale)) in rows.iter().enumerate() {
        let mean = joint.iter().map(|t| t.0[i]).sum::<f64>() / n;
        let rms = (joint.iter().map(|t| t.0[i].powi(2)).sum::<f64>() / n).sqrt();
        let sigma = joint.iter().map(|t| t.1[i]).sum::<f64>() / n;
        let pull = (joint.iter().map(|t| (t.0[i] / t.1[i]).powi(2)).sum::<f64>() / n).sqrt();
        let bias = joint.iter().map(|t| t.0[i] / t.1[i]).sum::<f64>() / n;
        let squares = sequential
            .iter()
            .filter_map(|t| Some(t.get(i)?.powi(2)))
            .sum::<f64>();
        let old = if i < 6 {
            format!("{:.4}", (squares / sequential.len() as f64).sqrt() * scale)
        } else {
            "-".to_owned()
        };
        println!(
            "| {name} | {unit} | {:.5} | {:.5} | {:.5} | {:.5} | {pull:.3} | {bias:+.3} | {old} |",
            mean * scale,
            rms * scale / n.sqrt(),
            rms * scale,
            sigma * scale,
        );
    }
}

fn trial(scenario: &Scenario, joint: &JointConfig, seed: u64) -> Trial {
    let survey = simulate(scenario, seed).expect("a survey");
    let sequential = SequentialConfig::default();
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &sequential,
        joint,
        seed,
    };
    let outcome = calibrate(&input, &|_| {}).expect("input that can be worked with");
    if std::env::var_os("PULLS_COVERAGE").is_some() {
        eprintln!(
            "{:?}",
            outcome
                .joint
                .as_ref()
                .and_then(|j| j.judgement.as_ref())
                .map(|j| (j.coverage.rotation.0, j.coverage.lever_arm.0))
        );
    }
    let refused = outcome.refusal.is_some();
    let solved = outcome.joint.as_ref().filter(|_| !refused);
    let reference = outcome.sequential.as_ref().and_then(|s| s.as_ref().ok());
    let trial = Trial {
        joint: solved.map(|j| judged(j, &survey.truth)),
        sequential: reference.map(|s| errors(&s.mounting, &survey.truth)),
        variance_factor: solved
            .and_then(JointOutcome::variance_factor)
            .unwrap_or(f64::NAN),
        refusal: outcome.refusal.as_ref().map(ToString::to_string),
    };
    if std::env::var_os("PULLS_EACH").is_some()
        && let Some((errors, sigmas)) = &trial.joint
    {
        let pulls: Vec<f64> = errors.iter().zip(sigmas).map(|(e, s)| e / s).collect();
        eprintln!("seed {seed} pulls {pulls:.2?}");
    }
    trial
}

/// Errors and sigmas of the six parameters, then of latency and range scale where they were unknowns.
fn judged(joint: &JointOutcome, truth: &Truth) -> (Vec<f64>, Vec<f64>) {
    let mut e = errors(&joint.mounting, truth).to_vec();
    let mut s: Vec<f64> = (0..6).map(|i| joint.covariance[(i, i)].sqrt()).collect();
    let x = &joint.solution.estimate.parameters;
    let optional = [
        (joint.blocks.latency, truth.latency_s),
        (joint.blocks.range_scale, truth.range_scale),
    ];
    for (id, truth) in optional {
        if let Some(id) = id {
            let column = x.offset(id);
            e.push(x.euclidean(id)[0] - truth);
            s.push(joint.solution.cofactor[(column, column)].sqrt());
        }
    }
    (e, s)
}
