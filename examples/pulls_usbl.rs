//! Monte Carlo check of the reported uncertainty of a USBL calibration: simulates a scenario with seeds 1 to N, calibrates each by
//! both paths, and prints errors and pulls (error / reported sigma) of every reported parameter.
//!
//! `cargo run --release --example pulls_usbl -- SCENARIO.toml [N] [FIRST]`
//!
//! A pull RMS of 1 means that the reported uncertainty is true. Nothing is selected: a seed without a usable result is listed.

use boresight::geometry::rotation;
use boresight::procedures::pool::Method;
use boresight::procedures::usbl::joint::sought;
use boresight::procedures::usbl::observed::Role;
use boresight::procedures::usbl::simulate::{Scenario, Truth, simulate};
use boresight::procedures::usbl::{JointConfig, ReferenceConfig, UsblInput, calibrate};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Errors and sigmas of one seed; `None` where a path had no usable result.
struct Trial {
    joint: Option<(Vec<f64>, Vec<f64>)>,
    reference: Option<([f64; 3], Option<[f64; 3]>)>,
    variance_factor: f64,
    /// Test statistic of the check beacon, 3 degrees of freedom.
    check: Option<f64>,
    /// Gross fixes that were used, good ones that were rejected.
    confused: (usize, usize),
    refusal: Option<String>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(path) = arguments.first() else {
        eprintln!("usage: pulls_usbl SCENARIO.toml [N] [FIRST]");
        std::process::exit(2);
    };
    let number = |k: usize, default: u64| {
        arguments
            .get(k)
            .and_then(|a| a.parse().ok())
            .unwrap_or(default)
    };
    let (count, first) = (number(1, 200), number(2, 1));
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
    let usable = trials.iter().filter(|t| t.joint.is_some()).count();
    println!(
        "{path}: seeds {first} to {}, {usable} usable",
        first + count - 1
    );
    print_table(&trials);
}

fn print_table(trials: &[Trial]) {
    let joint: Vec<_> = trials.iter().filter_map(|t| t.joint.as_ref()).collect();
    let reference: Vec<_> = trials.iter().filter_map(|t| t.reference).collect();
    let n = joint.len() as f64;
    let mean_of = |values: &mut dyn Iterator<Item = f64>| {
        let all: Vec<f64> = values.collect();
        all.iter().sum::<f64>() / all.len() as f64
    };
    println!(
        "mean variance factor {:.4}; mean test statistic of the check beacon {:.3} (expected 3); gross fixes used {:.2}, good ones rejected {:.2} a seed",
        mean_of(
            &mut trials
                .iter()
                .map(|t| t.variance_factor)
                .filter(|f| f.is_finite())
        ),
        mean_of(&mut trials.iter().filter_map(|t| t.check)),
        mean_of(&mut trials.iter().map(|t| t.confused.0 as f64)),
        mean_of(&mut trials.iter().map(|t| t.confused.1 as f64)),
    );
    println!(
        "| parameter | unit | mean error | standard error | RMS error | mean sigma | pull RMS | pull mean | reference RMS | reference pull RMS |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (i, (name, unit)) in sought().iter().enumerate() {
        let (unit, scale) = match unit {
            boresight::adjust::Unit::Radian => ("deg", 1f64.to_degrees()),
            boresight::adjust::Unit::Metre => ("mm", 1e3),
            _ => ("1e-6", 1e6),
        };
        let mean = mean_of(&mut joint.iter().map(|t| t.0[i]));
        let rms = mean_of(&mut joint.iter().map(|t| t.0[i].powi(2))).sqrt();
        let sigma = mean_of(&mut joint.iter().map(|t| t.1[i]));
        let pull = mean_of(&mut joint.iter().map(|t| (t.0[i] / t.1[i]).powi(2))).sqrt();
        let bias = mean_of(&mut joint.iter().map(|t| t.0[i] / t.1[i]));
        let old = if i < 3 {
            let rms = mean_of(&mut reference.iter().map(|r| r.0[i].powi(2))).sqrt() * scale;
            let formal = reference
                .iter()
                .filter_map(|r| Some((r.0[i] / r.1?[i]).powi(2)));
            format!("{rms:.5} | {:.2}", mean_of(&mut formal.into_iter()).sqrt())
        } else {
            "- | -".to_owned()
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

fn turn(found: &Matrix3<f64>, truth: &Truth) -> [f64; 3] {
    rotation::log(&(found * truth.rotation().transpose())).into()
}

fn trial(scenario: &Scenario, seed: u64) -> Trial {
    let survey = simulate(scenario, seed).expect("a survey");
    let truth = &survey.truth;
    let input = UsblInput {
        campaign: &survey.campaign,
        method: Method::Both,
        reference: ReferenceConfig::default(),
        joint: JointConfig::default(),
    };
    let outcome = calibrate(&input).expect("input that can be worked with");
    let solved = outcome.joint.as_ref().filter(|_| outcome.refusal.is_none());
    let joint = solved.map(|j| {
        let mut errors = turn(&j.rotation, truth).to_vec();
        errors.extend((j.transducer_m - truth.transducer()).iter());
        errors.push(j.scale - truth.range_scale);
        let sigmas = (0..errors.len())
            .map(|i| j.covariance[(i, i)].sqrt())
            .collect();
        (errors, sigmas)
    });
    let reference = outcome.reference.as_ref().and_then(|r| r.as_ref().ok());
    let is_check = |b: u32| survey.campaign.beacons[b as usize].role == Role::Check;
    Trial {
        joint,
        reference: reference.map(|r| {
            let sigmas = r.covariance.map(|c| [0, 1, 2].map(|i| c[(i, i)].sqrt()));
            (turn(&r.rotation, truth), sigmas)
        }),
        variance_factor: solved
            .and_then(|j| j.judgement.as_ref())
            .map_or(f64::NAN, |j| j.quality.global.variance_factor),
        check: outcome
            .joint_residuals
            .iter()
            .find(|r| is_check(r.beacon))
            .and_then(|r| Some(r.test()?.0)),
        confused: solved.map_or((0, 0), |j| {
            let gross = |fix: &&u32| truth.gross_fixes.contains(fix);
            (
                j.used.iter().filter(gross).count(),
                j.gross.iter().filter(|f| !gross(f)).count(),
            )
        }),
        refusal: outcome.refusal.as_ref().map(ToString::to_string),
    }
}
