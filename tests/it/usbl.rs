//! A USBL calibration in memory: derivatives, exact recovery without errors, honest sigmas, gross fixes, layouts that leave something
//! open.

use boresight::adjust::{
    Block, ChainModel, ChainState, Component, Estimate, ParameterSet, Process, ProcessKind, Unit,
    check_derivatives,
};
use boresight::geometry::rotation;
use boresight::procedures::pool::Method;
use boresight::procedures::usbl::conditions::{Blocks, FixConditions};
use boresight::procedures::usbl::joint::SOUGHT;
use boresight::procedures::usbl::observed::{AngleModel, Role, UsblCampaign};
use boresight::procedures::usbl::simulate::scenario::{OneBeacon, Recorded};
use boresight::procedures::usbl::simulate::{
    Scenario, Simulated, Source, Sources, simulate, simulate_with,
};
use boresight::procedures::usbl::{
    JointConfig, Layout, ReferenceConfig, Refusal, Scene, UsblInput, UsblOutcome, calibrate,
};
use nalgebra::Vector3;

const THIN: &str = include_str!("../../models/scenarios/usbl-thin.toml");

fn thin() -> Scenario {
    toml::from_str(THIN).expect("a scenario")
}

fn calibrated(campaign: &UsblCampaign) -> UsblOutcome<'_> {
    let input = UsblInput {
        campaign,
        method: Method::Both,
        reference: ReferenceConfig::default(),
        joint: JointConfig::default(),
    };
    calibrate(&input).expect("input that can be worked with")
}

/// Errors of the joint path in the order of its covariance, SI and radians.
fn errors(outcome: &UsblOutcome, survey: &Simulated) -> [f64; SOUGHT] {
    let joint = outcome.joint.as_ref().expect("a joint outcome");
    let truth = &survey.truth;
    let turn = rotation::log(&(joint.rotation * truth.rotation().transpose()));
    let place = joint.transducer_m - truth.transducer();
    let scale = joint.scale - truth.range_scale;
    [turn.x, turn.y, turn.z, place.x, place.y, place.z, scale]
}

/// The seventh parameter, the range scale, was left out.
#[test]
fn an_undetected_error_has_its_effect_on_every_parameter_sought() {
    let survey = simulate(&thin(), 1).expect("a survey");
    let outcome = calibrated(&survey.campaign);
    let joint = outcome.joint.as_ref().expect("a joint outcome");
    let quality = &joint.judgement.as_ref().expect("a judgement").quality;
    assert!(quality.worst.iter().all(|w| w.effects.len() == SOUGHT));
    assert!(
        quality.effects.iter().all(|e| e.size > 0.0),
        "{:?}",
        quality.effects
    );
}

/// Simulator (Runge-Kutta) and calibration (arcs) share no ray: without errors both find the truth to the integrator's accuracy.
#[test]
fn without_errors_both_paths_find_the_truth() {
    let mut scenario = thin();
    // the reference path averages fixes as if the sensor stood still, so let it
    scenario.motion.roll.wave.clear();
    scenario.motion.pitch.wave.clear();
    scenario.motion.heading.wave.clear();
    for model in [AngleModel::DirectionCosine, AngleModel::Isotropic] {
        scenario.fixes.angle_model = model;
        let survey = simulate_with(&scenario, &Sources::none(), 1).expect("a survey");
        let outcome = calibrated(&survey.campaign);
        assert_eq!(outcome.refusal, None);
        let reference = outcome
            .reference
            .as_ref()
            .expect("ran")
            .as_ref()
            .expect("found");
        let turn = rotation::log(&(reference.rotation * survey.truth.rotation().transpose()));
        assert!(turn.norm() < 2e-7, "reference {turn}");
        let error = errors(&outcome, &survey);
        assert!(error[..3].iter().all(|e| e.abs() < 2e-7), "{error:?}");
        assert!(error[3..6].iter().all(|e| e.abs() < 2e-7), "{error:?}");
        // a step of the simulator's integrator (12 microseconds) that straddles a kink of the profile (0.75 / s) errs by up to 2e-6 rad
        let largest = outcome
            .joint_residuals
            .iter()
            .map(|r| r.rms_m)
            .fold(0.0, f64::max);
        assert!(largest < 1e-5, "{largest}");
    }
}

/// At a 90 degree mounting the rotation is found all the same, and the patent's difference of angles is not the mounting.
#[test]
fn a_quarter_turn_is_a_rotation_and_no_difference_of_angles() {
    let mut scenario = thin();
    scenario.transducer.mounting_deg.heading = 88.0;
    scenario.motion.roll.mean = 5.0;
    scenario.motion.pitch.mean = -4.0;
    let survey = simulate_with(&scenario, &Sources::none(), 1).expect("a survey");
    let outcome = calibrated(&survey.campaign);
    let error = errors(&outcome, &survey);
    assert!(error[..3].iter().all(|e| e.abs() < 1e-6), "{error:?}");
    let reference = outcome
        .reference
        .as_ref()
        .expect("ran")
        .as_ref()
        .expect("found");
    let (roll, pitch, _) = rotation::to_attitude(&reference.rotation);
    let apart = (reference.difference.r + roll).hypot(reference.difference.p + pitch);
    assert!(apart > 2f64.to_radians(), "{apart}");
}

fn block(set: &mut ParameterSet, value: &[f64], unit: Unit) -> boresight::adjust::BlockId {
    let components = (0..value.len())
        .map(|i| Component::new(format!("x{i}"), unit))
        .collect();
    set.push(Block::euclidean("block", components, value))
        .expect("a block")
}

/// Every derivative of range and both angles by mounting, transducer, scale, datum, beacon and attitude noise.
#[test]
fn the_conditions_derivatives_are_those_of_differences() {
    let mut scenario = thin();
    scenario.sound_speed.profile = vec![[0.0, 1500.0], [3.0, 1470.0], [8.0, 1490.0]];
    for model in [AngleModel::DirectionCosine, AngleModel::Isotropic] {
        scenario.fixes.angle_model = model;
        let survey = simulate_with(&scenario, &Sources::none(), 1).expect("a survey");
        let campaign = &survey.campaign;
        let scene = Scene::new(campaign).expect("a scene");
        let mut set = ParameterSet::new();
        let turn = Block::rotation("mounting", ["a", "b", "c"], &survey.truth.rotation());
        let blocks = Blocks {
            mounting: set.push(turn).expect("a block"),
            transducer: block(&mut set, &[0.0; 3], Unit::Metre),
            scale: block(&mut set, &[0.0], Unit::One),
            datum: block(&mut set, &[0.0; 3], Unit::Radian),
            beacons: campaign
                .beacons
                .iter()
                .map(|b| {
                    let place = b.point.position_m;
                    Some(block(&mut set, place.as_slice(), Unit::Metre))
                })
                .collect(),
        };
        let times = campaign.attitude.times_s().to_vec();
        let epochs: Vec<u32> = (0..times.len() as u32).collect();
        let white = |axis: usize| Process {
            component: 3 + axis,
            sigma: 1e-3,
            kind: ProcessKind::White,
        };
        let chain = ChainModel::new(times, (0..3).map(white).collect()).expect("a chain");
        let conditions = FixConditions {
            scene: &scene,
            blocks: &blocks,
            fixes: &scene.common,
            epochs: Some(&epochs),
        };
        let mut at = Estimate::new(set);
        at.chain = Some(ChainState::zero(&chain));
        let which: Vec<usize> = (0..30).collect();
        // steps of 1e-5 (rad, m): the second order is 1e-5 of the first
        let faults = check_derivatives(&conditions, &which, &at, Some(&chain), 1e-5, 1e-6);
        assert!(faults.is_empty(), "{:?}", &faults[..faults.len().min(5)]);
    }
}

/// 200 seeds, none left out: each parameter's pull has RMS 1 within three standard errors (0.15), its mean is 0 within as much, and
/// the check beacon's statistic has the mean 3 of a chi-square on 3 degrees of freedom within three standard errors (0.52).
#[test]
fn the_reported_sigmas_are_true() {
    let scenario = thin();
    let (mut squares, mut sums, mut check) = ([0.0; SOUGHT], [0.0; SOUGHT], 0.0);
    let seeds = 200;
    for seed in 1..=seeds {
        let survey = simulate(&scenario, seed).expect("a survey");
        let outcome = calibrated(&survey.campaign);
        assert_eq!(outcome.refusal, None, "seed {seed}");
        let joint = outcome.joint.as_ref().expect("a joint outcome");
        for (i, error) in errors(&outcome, &survey).iter().enumerate() {
            let pull = error / joint.covariance[(i, i)].sqrt();
            squares[i] += pull * pull;
            sums[i] += pull;
        }
        let checked = outcome
            .joint_residuals
            .iter()
            .find(|r| survey.campaign.beacons[r.beacon as usize].role == Role::Check);
        check += checked
            .and_then(|r| Some(r.test()?.0))
            .expect("a check beacon");
    }
    let n = seeds as f64;
    let rms = squares.map(|s| (s / n).sqrt());
    let mean = sums.map(|s| s / n);
    println!("pull rms {rms:.3?} mean {mean:.3?}, check {:.3}", check / n);
    assert!(rms.iter().all(|r| (r - 1.0).abs() < 0.15), "{rms:?}");
    assert!(mean.iter().all(|m| m.abs() < 3.0 / n.sqrt()), "{mean:?}");
    assert!((check / n - 3.0).abs() < 3.0 * (6.0 / n).sqrt());
}

/// The campaign without some of its fixes.
fn without(campaign: &UsblCampaign, rows: &[u32]) -> UsblCampaign {
    let mut left = campaign.clone();
    let kept = |k: usize| !rows.contains(&(k as u32));
    let keep: Vec<usize> = (0..campaign.fixes.len()).filter(|k| kept(*k)).collect();
    let (from, to) = (&campaign.fixes, &mut left.fixes);
    to.time_s = keep.iter().map(|k| from.time_s[*k]).collect();
    to.beacon = keep.iter().map(|k| from.beacon[*k]).collect();
    to.travel_time_s = keep.iter().map(|k| from.travel_time_s[*k]).collect();
    to.direction = keep.iter().map(|k| from.direction[*k]).collect();
    left
}

/// Every fifth fix late by up to 2 m and turned by up to 20 degrees: against the same survey without these fixes no parameter moves by
/// one of its sigmas, in 60 seeds; it is a quarter of one at the most.
#[test]
fn gross_fixes_do_not_move_the_result() {
    let mut scenario = thin();
    scenario.disturbance.gross_fraction = 0.2;
    let mut most = 0.0_f64;
    for seed in 1..=60 {
        let dirty = simulate(&scenario, seed).expect("a survey");
        assert!(dirty.truth.gross_fixes.len() > 30);
        let clean = without(&dirty.campaign, &dirty.truth.gross_fixes);
        let (with, without) = (calibrated(&dirty.campaign), calibrated(&clean));
        assert_eq!(with.refusal, None);
        let covariance = &with.joint.as_ref().expect("a joint outcome").covariance;
        let (a, b) = (errors(&with, &dirty), errors(&without, &dirty));
        for i in 0..SOUGHT {
            most = most.max(((a[i] - b[i]) / covariance[(i, i)].sqrt()).abs());
        }
    }
    println!("largest move {most:.3} sigmas");
    assert!(most < 0.25, "{most}");
}

/// The check beacon never enters: without it, bit for bit the same.
#[test]
fn the_check_beacon_does_not_enter() {
    let survey = simulate(&thin(), 3).expect("a survey");
    let mut moved = survey.campaign.clone();
    let check = moved
        .beacons
        .iter_mut()
        .find(|b| b.role == Role::Check)
        .expect("a check beacon");
    check.point.position_m += Vector3::new(0.5, -0.5, 0.5);
    let (a, b) = (calibrated(&survey.campaign), calibrated(&moved));
    let rotation = |o: &UsblOutcome| o.joint.as_ref().expect("a joint outcome").rotation;
    assert_eq!(rotation(&a), rotation(&b));
    let p = |o: &UsblOutcome| {
        let found = o
            .joint_residuals
            .iter()
            .find(|r| r.beacon == 4)
            .expect("residuals");
        found.test()
    };
    assert!(p(&a).expect("a test").1 > 1e-3);
    // half a metre off, every fix is an outlier or the mean is impossible
    assert!(p(&b).is_none_or(|(_, p)| p < 1e-9));
}

fn own(places: &[[f64; 3]]) -> Scenario {
    let mut scenario = thin();
    scenario.beacons.centre_to_corner_m = 0.0;
    scenario.beacons.beacon = places
        .iter()
        .enumerate()
        .map(|(k, position_m)| OneBeacon {
            name: format!("N{k}"),
            position_m: *position_m,
            check: false,
        })
        .collect();
    scenario
}

#[test]
fn layouts_that_leave_something_open_are_named() {
    let refusal = |places: &[[f64; 3]]| {
        let survey = simulate(&own(places), 1).expect("a survey");
        calibrated(&survey.campaign).refusal
    };
    let one = refusal(&[[2.0, 1.0, -6.0]]).expect("refused");
    assert!(matches!(one, Refusal::OneBeacon { .. }), "{one}");
    assert!(one.to_string().contains("line of sight"), "{one}");
    let sight = refusal(&[[1.0, 0.5, -3.0], [2.0, 1.0, -6.0]]).expect("refused");
    assert!(
        sight
            .to_string()
            .contains("all common beacons lie in one direction"),
        "{sight}"
    );
    let line = own(&[[-3.0, 1.0, -6.0], [0.0, 1.01, -6.0], [3.0, 1.0, -6.0]]);
    let survey = simulate(&line, 1).expect("a survey");
    let outcome = calibrated(&survey.campaign);
    assert_eq!(outcome.refusal, None);
    let layout = Layout::of(&outcome.scene);
    assert!(layout.is_line() && layout.in_words().contains("nearly on one line"));
    let joint = outcome.joint.as_ref().expect("a joint outcome");
    let rests =
        boresight::procedures::usbl::verdict::rests_on_survey(joint, &JointConfig::default());
    assert!(
        rests.iter().any(|words| words.starts_with("pitch rests")),
        "{rests:?}"
    );
    // without a usable survey of the transducer the same line leaves the turn about it open
    let mut loose = line.clone();
    loose.transducer.sigma_m = [5.0; 3];
    let survey = simulate_with(&loose, &Sources::none(), 1).expect("a survey");
    let refusal = calibrated(&survey.campaign)
        .refusal
        .expect("refused")
        .to_string();
    assert!(
        refusal.contains("pitch") && refusal.contains("one line"),
        "{refusal}"
    );
    let plane = simulate(&thin(), 1).expect("a survey");
    let layout = Layout::of(&calibrated(&plane.campaign).scene);
    assert!(layout.is_plane() && layout.in_words().contains("one plane"));
}

/// Mixed-up beacons and a wrong angle convention are no result.
#[test]
fn absurd_input_is_refused() {
    let survey = simulate(&thin(), 1).expect("a survey");
    let mut mixed = survey.campaign.clone();
    let (a, b) = (
        mixed.beacons[0].point.position_m,
        mixed.beacons[1].point.position_m,
    );
    (
        mixed.beacons[0].point.position_m,
        mixed.beacons[1].point.position_m,
    ) = (b, a);
    assert!(calibrated(&mixed).refusal.is_some());
    let mut mirrored = survey.campaign.clone();
    mirrored.fixes.direction.iter_mut().for_each(|d| d.x = -d.x);
    assert!(calibrated(&mirrored).refusal.is_some());
}

/// A tilt of the control hides in the mounting; the prior of the datum counts it: pitch and roll get at least its sigma.
#[test]
fn an_uncertain_vertical_widens_pitch_and_roll() {
    let mut scenario = thin();
    scenario.control.tilt_sigma_deg = 0.2;
    let survey = simulate(&scenario, 1).expect("a survey");
    let outcome = calibrated(&survey.campaign);
    let covariance = &outcome.joint.as_ref().expect("a joint outcome").covariance;
    let sigma = |i: usize| covariance[(i, i)].sqrt().to_degrees();
    assert!(
        sigma(0) > 0.19 && sigma(1) > 0.19,
        "{} {}",
        sigma(0),
        sigma(1)
    );
    assert!(sigma(2) < 0.1, "{}", sigma(2));
}

/// The sources' streams are their own: switching one off leaves the others' numbers.
#[test]
fn each_source_has_its_own_stream() {
    let scenario = thin();
    let all = simulate(&scenario, 5).expect("a survey").campaign;
    let without = |source| {
        let sources = scenario.sources.clone().with(source, 0.0);
        simulate_with(&scenario, &sources, 5)
            .expect("a survey")
            .campaign
    };
    let no_range = without(Source::Range);
    assert_eq!(no_range.fixes.direction, all.fixes.direction);
    assert_ne!(no_range.fixes.travel_time_s, all.fixes.travel_time_s);
    let no_tilt = without(Source::RollPitch);
    assert_eq!(no_tilt.fixes.direction, all.fixes.direction);
    assert_ne!(no_tilt.attitude.attitudes(), all.attitude.attitudes());
}

#[test]
fn records_change_the_file_and_not_the_survey() {
    let mut scenario = thin();
    let first = simulate(&scenario, 2).expect("a survey");
    scenario.fixes.records = Recorded::RangeAngles;
    let second = simulate(&scenario, 2).expect("a survey");
    assert_eq!(first.campaign.fixes, second.campaign.fixes);
}

/// Pulls of yaw, RMS, and its mean sigma in degrees over some seeds, each calibrated as `claimed`.
fn pull_of_yaw(scenario: &Scenario, claimed_correlation_s: f64) -> (f64, f64) {
    const SEEDS: u64 = 60;
    let (mut squares, mut sigmas) = (0.0, 0.0);
    let mut joint = JointConfig::default();
    joint.verdict.accept = vec!["attitude_scale".to_owned()]; // leaves the search for other signs out
    for seed in 1..=SEEDS {
        let mut survey = simulate(scenario, seed).expect("a survey");
        survey.campaign.attitude_noise.correlation_time_s = claimed_correlation_s;
        let input = UsblInput {
            campaign: &survey.campaign,
            method: Method::Joint,
            reference: ReferenceConfig::default(),
            joint: joint.clone(),
        };
        let outcome = calibrate(&input).expect("an outcome");
        let joint = outcome.joint.as_ref().expect("a joint outcome");
        let sigma = joint.covariance[(2, 2)].sqrt();
        squares += (errors(&outcome, &survey)[2] / sigma).powi(2);
        sigmas += sigma.to_degrees();
    }
    let n = SEEDS as f64;
    ((squares / n).sqrt(), sigmas / n)
}

/// A sensor that wanders: taken as white its sigma is too small, as a state with its correlation time the sigma is true. The standard
/// error of a pull RMS over 60 seeds is 0.09.
#[test]
fn an_attitude_that_wanders_has_a_state() {
    let mut scenario = thin();
    scenario.fixes.per_beacon = 20;
    scenario.attitude.attitude_correlation_time_s = 30.0;
    let (white, small) = pull_of_yaw(&scenario, 0.0);
    let (coloured, large) = pull_of_yaw(&scenario, 30.0);
    println!("pull {white} at {small} deg as white noise, {coloured} at {large} deg as a state");
    assert!((coloured - 1.0).abs() < 0.27, "{coloured}");
    assert!(
        white > 1.3 && large > 1.2 * small,
        "{white} {small} {large}"
    );
}

/// Errors of one record and the next hang together by `exp(-1 / (rate tau))`, and are as large as white ones.
#[test]
fn the_simulated_wandering_has_its_size_and_its_correlation() {
    let mut scenario = thin();
    scenario.fixes.per_beacon = 400;
    scenario.attitude.attitude_correlation_time_s = 1.0;
    let with = simulate(&scenario, 1).expect("a survey").attitude_rad;
    let none = Sources::none();
    let without = simulate_with(&scenario, &none, 1)
        .expect("a survey")
        .attitude_rad;
    let error: Vec<f64> = with
        .iter()
        .zip(&without)
        .map(|(a, b)| a[2] - b[2])
        .collect();
    let n = error.len() as f64;
    let variance = error.iter().map(|e| e * e).sum::<f64>() / n;
    let lagged = error.windows(2).map(|e| e[0] * e[1]).sum::<f64>() / (n - 1.0);
    let kept = (-0.1f64).exp();
    // about n / 20 independent errors
    let tolerance = 3.0 * (2.0 / (n / 20.0)).sqrt();
    let ratio = variance.sqrt().to_degrees() / scenario.attitude.heading_sigma_deg;
    assert!((ratio - 1.0).abs() < 0.5 * tolerance, "{ratio}");
    assert!(
        (lagged / variance - kept).abs() < 0.03,
        "{}",
        lagged / variance
    );
}
