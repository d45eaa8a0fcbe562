//! Monte Carlo check of the reported uncertainty: simulates a scenario with seeds 1 to N, calibrates each by both paths, and
//! prints errors and pulls (error / reported sigma) of the six parameters.
//!
//! `cargo run --release --example pulls -- SCENARIO.toml [N] [FIRST]`
//!
//! A pull RMS of 1 means that the reported uncertainty is true. Nothing is selected: a seed without a usable result is listed.

use boresight::calibrate::pool::joint::SIX;
use boresight::calibrate::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::geometry::rotation;
use boresight::observe::Mounting;
use boresight::simulate::{Scenario, Truth, simulate};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Errors and sigmas of one seed; `None` where a path had no usable result.
struct Trial {
    joint: Option<([f64; 6], [f64; 6])>,
    sequential: Option<[f64; 6]>,
    variance_factor: f64,
    refusal: Option<String>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(path) = arguments.first() else {
        eprintln!("usage: pulls SCENARIO.toml [N] [FIRST]");
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
    let scenario: Scenario = toml::from_str(&text).expect("a scenario");
    let trials: Vec<Trial> = (first..first + count)
        .into_par_iter()
        .map(|seed| trial(&scenario, seed))
        .collect();
    for (k, trial) in trials.iter().enumerate() {
        if let Some(reason) = &trial.refusal {
            println!("seed {}: {reason}", first + k as u64);
        }
    }
    let joint: Vec<_> = trials.iter().filter_map(|t| t.joint).collect();
    let sequential: Vec<_> = trials.iter().filter_map(|t| t.sequential).collect();
    println!(
        "{path}: seeds {first} to {}, {} usable",
        first + count - 1,
        joint.len()
    );
    println!(
        "mean variance factor {:.4}",
        trials.iter().map(|t| t.variance_factor).sum::<f64>() / trials.len() as f64
    );
    println!(
        "| parameter | unit | mean error | standard error | RMS error | mean sigma | pull RMS | pull mean | sequential RMS |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for i in 0..6 {
        let (unit, scale) = if i < 3 {
            ("deg", 1f64.to_degrees())
        } else {
            ("mm", 1e3)
        };
        let n = joint.len() as f64;
        let mean = joint.iter().map(|t| t.0[i]).sum::<f64>() / n;
        let rms = (joint.iter().map(|t| t.0[i].powi(2)).sum::<f64>() / n).sqrt();
        let sigma = joint.iter().map(|t| t.1[i]).sum::<f64>() / n;
        let pull = (joint.iter().map(|t| (t.0[i] / t.1[i]).powi(2)).sum::<f64>() / n).sqrt();
        let bias = joint.iter().map(|t| t.0[i] / t.1[i]).sum::<f64>() / n;
        let old =
            (sequential.iter().map(|t| t[i].powi(2)).sum::<f64>() / sequential.len() as f64).sqrt();
        println!(
            "| {} | {unit} | {:.5} | {:.5} | {:.5} | {:.5} | {pull:.3} | {bias:+.3} | {:.4} |",
            SIX[i],
            mean * scale,
            rms * scale / n.sqrt(),
            rms * scale,
            sigma * scale,
            old * scale
        );
    }
}

fn trial(scenario: &Scenario, seed: u64) -> Trial {
    let survey = simulate(scenario, seed).expect("a survey");
    let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &sequential,
        joint: &joint,
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
    let sigmas = |c: &nalgebra::Matrix6<f64>| std::array::from_fn(|i| c[(i, i)].sqrt());
    let solved = outcome.joint.as_ref().filter(|_| !refused);
    let reference = outcome.sequential.as_ref().and_then(|s| s.as_ref().ok());
    Trial {
        joint: solved.map(|j| (errors(&j.mounting, &survey.truth), sigmas(&j.covariance))),
        sequential: reference.map(|s| errors(&s.mounting, &survey.truth)),
        variance_factor: solved.and_then(|j| j.variance_factor()).unwrap_or(f64::NAN),
        refusal: outcome.refusal.as_ref().map(ToString::to_string),
    }
}

fn errors(found: &Mounting, truth: &Truth) -> [f64; 6] {
    let r = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let turn = rotation::log(&(found.rotation * r.transpose()));
    let arm = found.lever_arm_m - Vector3::from(truth.lever_arm_m);
    [turn.x, turn.y, turn.z, arm.x, arm.y, arm.z]
}
