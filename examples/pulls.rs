//! Monte Carlo check of the reported uncertainty: simulates a scenario with seeds 1 to N, calibrates each by both paths, and
//! prints errors and pulls (error / reported sigma) of the six parameters.
//!
//! `cargo run --release --example pulls -- SCENARIO.toml [N] [FIRST] [--latency] [--range-scale]`
//!
//! The flags switch on the two optional unknowns and add their rows.
//! A pull RMS of 1 means that the reported uncertainty is true. Nothing is selected: a seed without a usable result is listed.

use boresight::budget::trial::{Configuration, JointTrial, Trial, trial};
use boresight::procedures::pool::JointConfig;
use boresight::procedures::pool::joint::SIX;
use boresight::simulate::Scenario;
use rayon::prelude::*;

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
    let rows = rows(&config);
    let configuration = Configuration {
        joint: config,
        ..Configuration::default()
    };
    let trials: Vec<Trial> = (first..first + count)
        .into_par_iter()
        .map(|seed| trial(&scenario, &configuration, seed))
        .collect();
    for trial in &trials {
        if let Err(reason) = &trial.joint {
            println!("seed {}: {}", trial.seed, reason.text);
        }
    }
    let usable = trials.iter().filter(|t| t.joint.is_ok()).count();
    println!(
        "{path}: seeds {first} to {}, {usable} usable",
        first + count - 1
    );
    print_table(&trials, &rows);
}

/// Errors of all unknowns with their sigmas, the six parameters first.
fn judged(joint: &JointTrial) -> Vec<(f64, f64)> {
    let six = (0..6).map(|i| (joint.error[i], joint.covariance[(i, i)].sqrt()));
    let optional = joint.optional.iter().map(|o| (o.error, o.sigma));
    six.chain(optional).collect()
}

fn print_table(trials: &[Trial], rows: &[Row]) {
    let solved: Vec<&JointTrial> = trials
        .iter()
        .filter_map(|t| t.joint.as_ref().ok())
        .collect();
    let joint: Vec<_> = solved.iter().map(|j| judged(j)).collect();
    let sequential: Vec<_> = trials
        .iter()
        .filter_map(|t| t.sequential.as_ref().ok())
        .collect();
    let n = joint.len() as f64;
    let factors = solved.iter().filter_map(|j| j.variance_factor);
    println!("mean variance factor {:.4}", factors.sum::<f64>() / n);
    println!(
        "| parameter | unit | mean error | standard error | RMS error | mean sigma | pull RMS | pull mean | sequential RMS |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (i, (name, unit, scale)) in rows.iter().enumerate() {
        let over = |of: &dyn Fn((f64, f64)) -> f64| joint.iter().map(|t| of(t[i])).sum::<f64>() / n;
        let (mean, sigma) = (over(&|(e, _)| e), over(&|(_, s)| s));
        let (rms, bias) = (over(&|(e, _)| e * e).sqrt(), over(&|(e, s)| e / s));
        let pull = over(&|(e, s)| (e / s).powi(2)).sqrt();
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
