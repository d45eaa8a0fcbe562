//! The pool calibration in memory, on simulated surveys: honesty of the reported uncertainty, and what must be refused.

use boresight::calibrate::pool::verdict::Refusal;
use boresight::calibrate::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::geometry::ellipsoid::TargetPose;
use boresight::geometry::rotation;
use boresight::observe::Campaign;
use boresight::simulate::{Scenario, Simulated, simulate};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

const THIN: &str = include_str!("../models/scenarios/three-pass-thin.toml");

fn survey(seed: u64) -> Simulated {
    let scenario = Scenario::from_toml(THIN).expect("a scenario");
    simulate(&scenario, seed).expect("a survey")
}

/// Runs the joint path and hands the outcome's errors and sigmas, or the refusal.
fn run(
    survey: &Simulated,
    campaign: &Campaign,
    prior: &TargetPose,
) -> Result<([f64; 6], [f64; 6]), Refusal> {
    let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
    let input = PoolInput {
        campaign,
        target: &survey.target,
        prior,
        method: Method::Joint,
        sequential: &sequential,
        joint: &joint,
        seed: 1,
    };
    let outcome = calibrate(&input, &|_| {}).expect("input that can be worked with");
    if let Some(refusal) = outcome.refusal {
        return Err(refusal);
    }
    let joint = outcome.joint.expect("a joint solution");
    let truth = Matrix3::from_fn(|i, j| survey.truth.rotation_matrix[i][j]);
    let turn = rotation::log(&(joint.mounting.rotation * truth.transpose()));
    let arm = joint.mounting.lever_arm_m - Vector3::from(survey.truth.lever_arm_m);
    let sigmas = std::array::from_fn(|i| joint.covariance[(i, i)].sqrt());
    Ok(([turn.x, turn.y, turn.z, arm.x, arm.y, arm.z], sigmas))
}

/// Seeds 1 to 24 without selection: the sum of squared pulls of each parameter within its 99.99 % chi-square interval.
#[test]
fn the_reported_uncertainty_is_true() {
    const SEEDS: u64 = 24;
    let trials: Vec<_> = (1..=SEEDS)
        .into_par_iter()
        .map(|seed| {
            let s = survey(seed);
            run(&s, &s.campaign, &s.prior).expect("usable")
        })
        .collect();
    let chi = ChiSquared::new(SEEDS as f64).expect("freedom");
    let (low, high) = (chi.inverse_cdf(0.00005), chi.inverse_cdf(0.99995));
    for i in 0..6 {
        let sum: f64 = trials.iter().map(|(e, s)| (e[i] / s[i]).powi(2)).sum();
        assert!(
            (low..high).contains(&sum),
            "parameter {i}: {sum:.1} outside {low:.1} to {high:.1}"
        );
    }
}

#[test]
fn a_target_200_m_away_is_not_found() {
    let s = survey(1);
    let prior = s.prior.moved(&Vector3::new(200.0, 0.0, 0.0), 0.0);
    assert!(matches!(
        run(&s, &s.campaign, &prior),
        Err(Refusal::TargetFar { .. })
    ));
}

#[test]
fn mirrored_beam_angles_are_named() {
    let s = survey(1);
    let mut campaign = s.campaign.clone();
    campaign
        .soundings
        .across_rad
        .iter_mut()
        .for_each(|a| *a = -*a);
    let found = run(&s, &campaign, &s.prior);
    assert!(
        matches!(
            found,
            Err(Refusal::Mirrored { .. } | Refusal::NoSoundings { .. })
        ),
        "{found:?}"
    );
}

/// A scanner that is turned by 1 degree about the vertical sees the wall elsewhere from each distance.
#[test]
fn a_scanner_that_is_not_calibrated_is_named() {
    let s = survey(1);
    let mut campaign = s.campaign.clone();
    let turn = Vector3::new(0.0, 1f64.to_radians(), 1f64.to_radians());
    campaign.scanner = campaign.scanner.corrected(&turn, &Vector3::zeros());
    let found = run(&s, &campaign, &s.prior);
    assert!(
        matches!(found, Err(Refusal::ScannerDisagrees(_))),
        "{found:?}"
    );
}

#[test]
fn a_plain_wall_is_refused_naming_what_only_motion_determines() {
    let text = include_str!("../models/scenarios/plain-wall.toml");
    let s = simulate(&Scenario::from_toml(text).expect("a scenario"), 1).expect("a survey");
    let Err(Refusal::Undetermined { parameters }) = run(&s, &s.campaign, &s.prior) else {
        panic!("a plain wall was not refused");
    };
    for name in ["pitch", "yaw", "ly", "lz"] {
        assert!(
            parameters.iter().any(|p| p.starts_with(name)),
            "{name} is not among {parameters:?}"
        );
    }
    assert!(
        !parameters
            .iter()
            .any(|p| p.starts_with("roll") || p.starts_with("lx")),
        "{parameters:?}"
    );
}
