//! The pool calibration in memory, on simulated surveys: honesty of the reported uncertainty, and what must be refused.

use boresight::geometry::ellipsoid::TargetPose;
use boresight::geometry::rotation;
use boresight::observe::{Campaign, LaserScan};
use boresight::procedures::pool::joint::JointOutcome;
use boresight::procedures::pool::sequential::SequentialError;
use boresight::procedures::pool::ties::TieSet;
use boresight::procedures::pool::verdict::Refusal;
use boresight::procedures::pool::{
    JointConfig, Method, PoolInput, Scene, SequentialConfig, calibrate, calibrate_with_true_ties,
};
use boresight::simulate::{Scenario, Simulated, Sources, simulate};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

const THIN: &str = include_str!("../../models/scenarios/disturbed-thin.toml");

fn survey(seed: u64) -> Simulated {
    let scenario = Scenario::from_toml(THIN).expect("a scenario");
    simulate(&scenario, seed).expect("a survey")
}

/// With true ties no observation stands on a face that it did not strike, and nothing else is lost: of disturbed data, where the association
/// errs, these are its ties without the wrong ones but for those that a slightly different estimate changes; of data without errors all
/// ties are true already.
#[test]
fn true_ties_are_those_of_the_faces_struck() {
    let of = |scenario: &Scenario| {
        let survey = simulate(scenario, 4).expect("a survey");
        let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
        let input = PoolInput {
            campaign: &survey.campaign,
            target: &survey.target,
            prior: &survey.prior,
            method: Method::Joint,
            sequential: &sequential,
            joint: &joint,
            seed: 1,
            extras: &[],
        };
        let found = calibrate(&input, &boresight::watch::Unwatched)
            .expect("a run")
            .joint
            .expect("joint");
        let truly = calibrate_with_true_ties(&input, &survey.struck, &[]).expect("a run");
        let truly = truly.joint.expect("joint");
        let wrong = |ties: &TieSet, struck: &[u16]| {
            let off = ties.iter().filter(|t| struck[t.row as usize] != t.face);
            off.count()
        };
        let of = |j: &JointOutcome| {
            let returns = wrong(&j.returns, &survey.struck.returns);
            (wrong(&j.soundings, &survey.struck.soundings), returns)
        };
        let lost = found.soundings.len() as f64 - truly.soundings.len() as f64;
        (of(&found), of(&truly), lost)
    };
    let disturbed = Scenario::from_toml(THIN).expect("a scenario");
    let (found, truly, lost) = of(&disturbed);
    println!("{found:?} {truly:?} {lost}");
    assert!(found.0 > 0, "{found:?}");
    assert_eq!(truly, (0, 0));
    assert!((lost - found.0 as f64).abs() < 20.0, "{found:?} {lost}");
    let clean = Scenario {
        sources: Sources::none(),
        ..disturbed
    };
    assert_eq!(of(&clean), ((0, 0), (0, 0), 0.0));
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
        extras: &[],
    };
    let outcome =
        calibrate(&input, &boresight::watch::Unwatched).expect("input that can be worked with");
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
    let found = run(&s, &s.campaign, &prior);
    assert!(
        matches!(&found, Err(Refusal::DoesNotFit(f)) if f.code == "target_origin" && f.seen.contains("200")),
        "{found:?}"
    );
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
            &found,
            Err(Refusal::DoesNotFit(finding)) if finding.code == "sign_of_across_angle"
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
    let text = include_str!("../../models/scenarios/plain-wall.toml");
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

/// The reference path alone, on a survey whose scanner never saw the column at +Y.
#[test]
fn a_plane_that_the_scanner_did_not_see_is_named() {
    let s = survey(1);
    let scene = Scene::prepare(&s.campaign, &s.target, &s.prior).expect("a scene");
    let seen: Vec<usize> = (0..s.campaign.laser.len())
        .filter(|&j| scene.laser_point(j).is_some_and(|(p, _)| p.y < 3.9))
        .collect();
    let mut campaign = s.campaign.clone();
    let kept = |column: &[f64]| seen.iter().map(|&j| column[j]).collect();
    campaign.laser = LaserScan {
        time_s: kept(&s.campaign.laser.time_s),
        x_m: kept(&s.campaign.laser.x_m),
        y_m: kept(&s.campaign.laser.y_m),
        z_m: kept(&s.campaign.laser.z_m),
        ..campaign.laser
    };
    let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
    let input = PoolInput {
        campaign: &campaign,
        target: &s.target,
        prior: &s.prior,
        method: Method::Reference,
        sequential: &sequential,
        joint: &joint,
        seed: 1,
        extras: &[],
    };
    let outcome =
        calibrate(&input, &boresight::watch::Unwatched).expect("input that can be worked with");
    let missing = SequentialError::NoScannerPlane { plane: "P3" };
    let Some(Refusal::Sequential { message }) = &outcome.refusal else {
        panic!("{:?}", outcome.refusal);
    };
    assert_eq!(message, &missing.to_string());
    assert_eq!(outcome.sequential.map(Result::err), Some(Some(missing)));
}

/// An engine that cannot go on (here: a drift without correlation time) is a refusal with a result, not a fault of the input.
#[test]
fn an_adjustment_that_fails_is_a_result_with_the_reason() {
    let s = survey(1);
    let mut campaign = s.campaign.clone();
    campaign.trajectory.noise.drift_correlation_time_s = 0.0;
    let found = run(&s, &campaign, &s.prior);
    let Err(Refusal::NotSolved { how }) = found else {
        panic!("{found:?}");
    };
    assert!(how.contains("correlation"), "{how}");
}

/// The two surveys of the first thousand that a limit of four sigmas refused although their scanner is good.
#[test]
fn a_good_scanner_under_a_rare_drift_is_not_refused() {
    for seed in [503, 770] {
        let s = survey(seed);
        assert!(run(&s, &s.campaign, &s.prior).is_ok(), "seed {seed}");
    }
}
