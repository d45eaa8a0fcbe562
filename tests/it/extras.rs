//! Unknowns of the caller's own in a pool calibration: found where they are in the data, with sigmas that hold, and refused where they
//! cannot be.

use boresight::calibrate::seam::{Settings, provenance};
use boresight::observe::{Acts, Campaign, Extra, Mounting, SoundingRange};
use boresight::procedures::pool::joint::JointOutcome;
use boresight::procedures::pool::{
    JointConfig, Method, PoolInput, SequentialConfig, calibrate, summary,
};
use boresight::simulate::{Scenario, Simulated, simulate};
use boresight::watch::Unwatched;
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::common::extra;

const THIN: &str = include_str!("../../models/scenarios/three-pass-thin.toml");
/// What is put in: ranges that lengthen over the survey, metres, and beams that turn outward with the speed of time, radians.
const PUT_IN: [f64; 2] = [0.02, -0.002];

fn survey(seed: u64) -> Simulated {
    let scenario = Scenario::from_toml(THIN).expect("a scenario");
    simulate(&scenario, seed).expect("a survey")
}

/// From -1 at the first sounding to 1 at the last.
fn since(campaign: &Campaign) -> Vec<f64> {
    let times = &campaign.soundings.time_s;
    let (first, last) = (times[0], times[times.len() - 1]);
    let part = |t: &f64| 2.0 * (t - first) / (last - first) - 1.0;
    times.iter().map(part).collect()
}

fn input<'a>(
    survey: &'a Simulated,
    (sequential, joint): &'a (SequentialConfig, JointConfig),
    extras: &'a [Extra],
) -> PoolInput<'a> {
    PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Joint,
        sequential,
        joint,
        seed: 1,
        extras,
    }
}

/// The joint path's end, and whether the survey is usable.
fn ended(
    survey: &Simulated,
    joint: &JointConfig,
    extras: &[Extra],
) -> (Option<JointOutcome>, bool) {
    let config = (SequentialConfig::default(), joint.clone());
    let found = calibrate(&input(survey, &config, extras), &Unwatched).expect("a run");
    (found.joint, found.refusal.is_none())
}

fn solved(survey: &Simulated, joint: &JointConfig, extras: &[Extra]) -> Option<JointOutcome> {
    let (joint, usable) = ended(survey, joint, extras);
    joint.filter(|_| usable)
}

/// The effects that are put in, as unknowns.
fn unknowns(campaign: &Campaign) -> [Extra; 2] {
    let part = since(campaign);
    let outward: Vec<f64> = part
        .iter()
        .zip(&campaign.soundings.across_rad)
        .map(|(part, across)| part * across.signum())
        .collect();
    [
        extra("slow clock", Acts::Range, part),
        extra("widening", Acts::Across, outward),
    ]
}

/// Takes the effects out of what was measured, so that the unknowns that put them back are [`PUT_IN`].
fn spoilt(mut survey: Simulated) -> Simulated {
    let [clock, widening] = unknowns(&survey.campaign);
    let soundings = &mut survey.campaign.soundings;
    let SoundingRange::Metres(range_m) = &mut soundings.range else {
        panic!("ranges in metres");
    };
    for (k, range_m) in range_m.iter_mut().enumerate() {
        *range_m -= PUT_IN[0] * clock.derivative[k];
        soundings.across_rad[k] -= PUT_IN[1] * widening.derivative[k];
    }
    survey
}

/// Six seeds: pulls of the two, and what a survey without the unknowns ends with.
#[test]
fn what_is_put_in_is_found_with_sigmas_that_hold() {
    let of = |seed: u64| {
        let survey = spoilt(survey(seed));
        let config = JointConfig::default();
        let joint = solved(&survey, &config, &unknowns(&survey.campaign));
        let joint = joint.expect("a usable result");
        let without = solved(&survey, &config, &[]).is_some();
        let columns = joint.columns();
        let sigma = |i: usize| joint.solution.cofactor[(columns[6 + i], columns[6 + i])].sqrt();
        let pull = |i: usize| (joint.extras[i] - PUT_IN[i]) / sigma(i);
        let truth = Mounting {
            rotation: Matrix3::from_fn(|i, j| survey.truth.rotation_matrix[i][j]),
            lever_arm_m: survey.truth.lever_arm(),
        };
        let turn = joint.mounting.correction_from(&truth);
        let yaw = turn.z / joint.covariance[(2, 2)].sqrt();
        ([pull(0), pull(1), yaw], without)
    };
    let all: Vec<_> = (1..=6u64).into_par_iter().map(of).collect();
    println!("{all:?}");
    // chi-square on 6 lies beyond 22.5 once in a thousand
    for i in 0..3 {
        let square: f64 = all.iter().map(|(pulls, _)| pulls[i].powi(2)).sum();
        assert!(square < 22.5, "pull {i}: {square} of 6");
    }
    assert!(all.iter().all(|(_, without)| !without), "{all:?}");
}

/// A height of the soundings alone takes the place of the lever arm's height, where that is held at its nominal value; but for the
/// boat's tilt, which turns the one and not the other: the verdict says so.
#[test]
fn a_height_is_a_lever_arm_s_height() {
    let survey = survey(3);
    let free = solved(&survey, &JointConfig::default(), &[]).expect("usable");
    let held = JointConfig {
        hold: vec!["lz".to_owned()],
        ..JointConfig::default()
    };
    let ones = vec![1.0; survey.campaign.soundings.len()];
    let (found, usable) = ended(&survey, &held, &[extra("height", Acts::Up, ones)]);
    let found = found.expect("joint");
    let by_arm = free.mounting.lever_arm_m.z - survey.campaign.sonar.lever_arm_m.z;
    let sigma = free.covariance[(5, 5)].sqrt();
    println!("{by_arm} {} {sigma}", found.extras[0]);
    assert!(
        (found.extras[0] - by_arm).abs() < sigma,
        "{} {by_arm}",
        found.extras[0]
    );
    let codes: Vec<&str> = found.doubted.findings.iter().map(|f| &*f.code).collect();
    assert!(!usable && codes.contains(&"attitude_scale"), "{codes:?}");
}

/// They stand in the result by their names, with their units and sigmas.
#[test]
fn the_result_names_them() {
    let survey = spoilt(survey(1));
    let extras = unknowns(&survey.campaign);
    let config = Default::default();
    let input = PoolInput {
        method: Method::Both,
        ..input(&survey, &config, &extras)
    };
    let outcome = calibrate(&input, &Unwatched).expect("a run");
    let provenance = provenance(&"", &[], &Settings::default()).expect("a provenance");
    let none = summary::Dropped::default();
    let result = summary::result(&outcome, &input, none, &[], provenance).expect("a result");
    let joint = result.solutions.joint.expect("joint");
    let clock = joint.parameter("slow clock").expect("named");
    assert_eq!(clock.unit, "m");
    let (value, sigma) = (clock.value.expect("a value"), clock.sigma.expect("a sigma"));
    assert!(
        (value - PUT_IN[0]).abs() < 4.0 * sigma && sigma < 0.005,
        "{value} {sigma}"
    );
    assert_eq!(joint.covariance.expect("a covariance").len(), 8);
    assert_eq!(joint.details["extra"][0], "slow clock");
}

#[test]
fn one_that_cannot_be_used_is_refused() {
    let survey = survey(1);
    let rows = survey.campaign.soundings.len();
    let config = Default::default();
    let error = |extras: &[Extra]| {
        calibrate(&input(&survey, &config, extras), &Unwatched)
            .expect_err("refused")
            .to_string()
    };
    let squat = |derivative| extra("squat", Acts::Up, derivative);
    assert_eq!(
        error(&[squat(vec![1.0; 3])]),
        format!("extra squat: found 3 rows, expected {rows} rows, one a sounding")
    );
    assert_eq!(
        error(&[squat(vec![f64::NAN; rows])]),
        "extra squat: found an effect on no sounding, expected a derivative other than zero somewhere"
    );
    let endless = error(&[squat(vec![f64::INFINITY; rows])]);
    assert!(endless.contains("found inf in row 0"), "{endless}");
    let twice = error(&[squat(vec![1.0; rows]), squat(vec![1.0; rows])]);
    assert!(twice.contains("a name of its own"), "{twice}");
    let taken = error(&[extra("yaw", Acts::Up, vec![1.0; rows])]);
    assert!(taken.contains("none of pitch, roll, yaw"), "{taken}");
    let many: Vec<Extra> = (0..13)
        .map(|k| extra(&format!("e{k}"), Acts::Up, vec![1.0; rows]))
        .collect();
    assert_eq!(error(&many), "extra e12: found 13, expected at most 12");
    let mut loose = squat(vec![1.0; rows]);
    loose.prior_sigma = Some(-1.0);
    assert!(error(&[loose]).contains("found prior_sigma -1"));
}
