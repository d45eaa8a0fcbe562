//! Monte Carlo check of the rail calibration: simulates a scenario with seeds 1 to N, calibrates each by both paths, prints errors and
//! pulls (error / reported sigma).
//!
//! `cargo run --release --example pulls_rail -- SCENARIO.toml [N] [FIRST]`
//!
//! A pull RMS of 1 means that the reported uncertainty is true. Nothing is selected: a seed without a usable result is listed.

use boresight::calibrate::rail::trial::{RailTrial, trial};
use boresight::simulate::rail::RailScenario;
use boresight::target::RailProfile;
use rayon::prelude::*;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(path) = arguments.first() else {
        eprintln!("usage: pulls_rail SCENARIO.toml [N] [FIRST]");
        std::process::exit(2);
    };
    let number = |k: usize, default: u64| {
        arguments
            .get(k)
            .and_then(|a| a.parse().ok())
            .unwrap_or(default)
    };
    let (count, first) = (number(1, 100), number(2, 1));
    let text = std::fs::read_to_string(path).expect("readable scenario");
    let scenario = RailScenario::from_toml(&text).expect("a scenario");
    let rail = RailProfile::built_in(&scenario.rail.model).expect("a built-in rail");
    let trials: Vec<RailTrial> = (first..first + count)
        .into_par_iter()
        .map(|seed| trial(&scenario, &rail, &scenario.sources, seed).expect("a scenario"))
        .collect();
    for (k, trial) in trials.iter().enumerate() {
        if let Some(reason) = &trial.refusal {
            println!("seed {}: {reason}", first + k as u64);
        }
    }
    print_table(path, &trials);
}

fn print_table(path: &str, trials: &[RailTrial]) {
    let joint: Vec<_> = trials
        .iter()
        .filter_map(|t| Some((t, t.joint.as_ref()?)))
        .collect();
    let n = joint.len() as f64;
    let factor = trials.iter().filter_map(|t| t.variance_factor).sum::<f64>() / n;
    let references = trials.iter().filter(|t| t.reference.is_some()).count();
    println!(
        "{path}: {} trials, {n} usable joint, {references} reference; mean variance factor {factor:.4}",
        trials.len()
    );
    println!(
        "| parameter | unit | mean error | standard error | RMS error | mean sigma | pull RMS | pull mean | reference bias | reference RMS |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (i, name) in trials[0].names.iter().enumerate() {
        let angle = trials[0].units[i] == "rad";
        let (unit, scale) = if angle {
            ("deg", 1f64.to_degrees())
        } else {
            ("mm", 1e3)
        };
        let errors: Vec<(f64, f64)> = joint
            .iter()
            .map(|(t, j)| (j.0[i] - t.truth[i], j.1[(i, i)].sqrt()))
            .collect();
        let mean = errors.iter().map(|e| e.0).sum::<f64>() / n;
        let rms = (errors.iter().map(|e| e.0.powi(2)).sum::<f64>() / n).sqrt();
        let sigma = errors.iter().map(|e| e.1).sum::<f64>() / n;
        let pull = (errors.iter().map(|e| (e.0 / e.1).powi(2)).sum::<f64>() / n).sqrt();
        let bias = errors.iter().map(|e| e.0 / e.1).sum::<f64>() / n;
        let old: Vec<f64> = trials
            .iter()
            .filter_map(|t| Some(t.reference.as_ref()?[i] - t.truth[i]))
            .collect();
        let m = old.len() as f64;
        println!(
            "| {name} | {unit} | {:.5} | {:.5} | {:.5} | {:.5} | {pull:.3} | {bias:+.3} | {:.4} | {:.4} |",
            mean * scale,
            rms * scale / n.sqrt(),
            rms * scale,
            sigma * scale,
            old.iter().sum::<f64>() / m * scale,
            (old.iter().map(|e| e * e).sum::<f64>() / m).sqrt() * scale
        );
    }
}
