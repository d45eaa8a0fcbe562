//! Monte Carlo check of the rail calibration: simulates a scenario with seeds 1 to N, calibrates each by both paths, prints errors and
//! pulls (error / reported sigma).
//!
//! `cargo run --release --example pulls_rail -- SCENARIO.toml [N] [FIRST]`
//!
//! A pull RMS of 1 means that the reported uncertainty is true. Nothing is selected: a seed without a usable result is listed.

use boresight::procedures::rail::RailProfile;
use boresight::procedures::rail::simulate::RailScenario;
use boresight::procedures::rail::trial::{RailTrial, trial};
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

/// Errors and sigmas of one parameter, or of a difference of two, over the trials.
struct Column {
    name: String,
    angle: bool,
    joint: Vec<(f64, f64)>,
    reference: Vec<f64>,
}

fn column(trials: &[RailTrial], name: String, weights: &[(usize, f64)]) -> Column {
    let error = |errors: &[f64]| -> f64 { weights.iter().map(|(i, w)| w * errors[*i]).sum() };
    let joint = |t: &RailTrial| {
        let (values, c) = t.joint.as_ref()?;
        let pairs = weights
            .iter()
            .flat_map(|a| weights.iter().map(move |b| (a, b)));
        let variance: f64 = pairs.map(|(a, b)| a.1 * b.1 * c[(a.0, b.0)]).sum();
        Some((error(values), variance.sqrt()))
    };
    Column {
        name,
        angle: trials[0].units[weights[0].0] == "rad",
        joint: trials.iter().filter_map(joint).collect(),
        reference: trials
            .iter()
            .filter_map(|t| Some(error(t.reference.as_ref()?)))
            .collect(),
    }
}

fn print_table(path: &str, trials: &[RailTrial]) {
    let usable = trials.iter().filter(|t| t.joint.is_some()).count();
    let factor = trials.iter().filter_map(|t| t.variance_factor).sum::<f64>() / usable as f64;
    let references = trials.iter().filter(|t| t.reference.is_some()).count();
    println!(
        "{path}: {} trials, {usable} usable joint, {references} reference; mean variance factor {factor:.4}",
        trials.len()
    );
    println!(
        "| parameter | unit | mean error | standard error | RMS error | mean sigma | pull RMS | pull mean | reference mean | reference RMS |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let names = &trials[0].names;
    for (i, name) in names.iter().enumerate() {
        print_row(&column(trials, name.clone(), &[(i, 1.0)]));
    }
    if names.len() >= 12 {
        for i in 0..5 {
            let name = format!("{} - {}", names[i], names[i + 5]);
            print_row(&column(trials, name, &[(i, 1.0), (i + 5, -1.0)]));
        }
    }
}

fn print_row(c: &Column) {
    let (unit, scale) = if c.angle {
        ("deg", 1f64.to_degrees())
    } else {
        ("mm", 1e3)
    };
    let n = c.joint.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| c.joint.iter().map(of).sum::<f64>() / n;
    let rms = mean(&|e| e.0 * e.0).sqrt();
    let m = c.reference.len() as f64;
    println!(
        "| {} | {unit} | {:.5} | {:.5} | {:.5} | {:.5} | {:.3} | {:+.3} | {:.4} | {:.4} |",
        c.name,
        mean(&|e| e.0) * scale,
        rms * scale / n.sqrt(),
        rms * scale,
        mean(&|e| e.1) * scale,
        mean(&|e| (e.0 / e.1).powi(2)).sqrt(),
        mean(&|e| e.0 / e.1),
        c.reference.iter().sum::<f64>() / m * scale,
        (c.reference.iter().map(|e| e * e).sum::<f64>() / m).sqrt() * scale
    );
}
