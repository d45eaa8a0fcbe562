//! The error budget by propagation: against the engine's own cofactors, answers known by hand, surveys with one constant error,
//! and Monte Carlo.

use boresight::geometry::{Geodetic, Point};
use boresight::observe::Campaign;
use boresight::procedures::pool::budget::analytic::{
    Analytic, PathBudget, Prediction, analytic, analytic_with,
};
use boresight::procedures::pool::config::{KernelName, Variant};
use boresight::procedures::pool::frame;
use boresight::procedures::pool::influence::{self, Pull, difference};
use boresight::procedures::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
use boresight::simulate::motion::MotionModel;
use boresight::simulate::scenario::{Recorded, Water};
use boresight::simulate::{Scenario, Simulated, Source, Sources, simulate};
use boresight::target::TargetModel;
use nalgebra::{Matrix6, Vector3, Vector4, Vector6};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

fn thin() -> Scenario {
    let text = include_str!("../../models/scenarios/single-pass-thin.toml");
    Scenario::from_toml(text).expect("a scenario")
}

/// No waves: the body moves along the wall on a straight line, level.
fn calm() -> Scenario {
    let height = thin().motion.height;
    let mut scenario = thin();
    scenario.motion = MotionModel::default();
    scenario.motion.height.mean = height.mean;
    scenario
}

fn projected() -> SequentialConfig {
    SequentialConfig {
        variant: Variant::Projected,
        ..SequentialConfig::default()
    }
}

fn least_squares() -> JointConfig {
    JointConfig {
        kernel: KernelName::LeastSquares,
        ..JointConfig::default()
    }
}

fn share(path: &PathBudget, source: Source) -> (Vector6<f64>, Matrix6<f64>) {
    let found = path
        .sources
        .iter()
        .find(|s| s.0 == source)
        .expect("every source");
    match &found.1 {
        Prediction::Linear { bias, covariance } => (*bias, *covariance),
        Prediction::NotPredicted { reason } => panic!("{source:?}: {reason}"),
    }
}

fn paths(budget: &Analytic) -> [&PathBudget; 2] {
    [
        &budget.joint,
        budget.sequential.as_ref().expect("a reference path"),
    ]
}

/// Largest difference of two covariances in units of the sigmas of the second.
fn apart(a: &Matrix6<f64>, b: &Matrix6<f64>) -> f64 {
    let worst = |i: usize, j: usize| (a[(i, j)] - b[(i, j)]).abs() / (b[(i, i)] * b[(j, j)]).sqrt();
    (0..36).map(|k| worst(k / 6, k % 6)).fold(0.0, f64::max)
}

/// Where the model is the truth, the sources' covariances sum to the cofactor that the engine itself computes: Gauss-Markov drifts,
/// white records, priors of scanner and target included. Recorded roll, pitch and heading are not quite turns about the target's
/// axes, which is what the engine's states are: hence 1e-4.
#[test]
fn the_sources_sum_to_the_engines_cofactor() {
    let mut scenario = thin();
    scenario.trajectory.rate_hz = 50.0;
    scenario.trajectory.heading_drift_sigma_deg = 0.02;
    scenario.lidar.mounting_sigma_deg = [0.01, 0.02, 0.015];
    scenario.lidar.lever_arm_sigma_m = [0.002, 0.003, 0.004];
    scenario.multibeam.along_angle_sigma_deg = 0.05;
    if let TargetModel::PoolWall(wall) = &mut scenario.target.model {
        (wall.coplanarity_sigma_m, wall.height_sigma_m) = (0.002, 0.003);
    }
    let config = least_squares();
    let budget = analytic_with(&scenario, &projected(), &config).expect("a budget");
    let gap = apart(&budget.joint.covariance, &budget.claimed);
    println!("whole survey: {gap:.1e}");
    assert!(gap < 1e-4, "{gap}");
    let efficiency = budget.efficiency(&budget.joint).expect("a bound");
    assert!(
        (efficiency - Vector6::repeat(1.0)).amax() < 1e-3,
        "{efficiency}"
    );

    (
        scenario.trajectory.roll_pitch_sigma_deg,
        scenario.trajectory.heading_sigma_deg,
    ) = (0.0, 0.0);
    scenario.trajectory.heading_drift_sigma_deg = 0.0;
    let budget = analytic_with(&scenario, &projected(), &config).expect("a budget");
    let gap = apart(&budget.joint.covariance, &budget.claimed);
    println!("without attitude errors: {gap:.1e}");
    assert!(gap < 2e-5, "{gap}");
}

/// In calm water: a scanner that stands `d` off takes the multibeam's lever arm along by `-d`; a latency at the speed v moves it
/// back by `v latency`; a position error that never changes moves nothing; both paths, no angles.
#[test]
fn one_source_with_an_answer_known_by_hand() {
    let mut scenario = calm();
    let wrong_m = [0.003, -0.002, 0.004];
    (scenario.lidar.lever_arm_error_m, scenario.truth.latency_s) = (wrong_m, 0.01);
    scenario.trajectory.drift_correlation_time_s = 1e7;
    let budget = analytic(&scenario).expect("a budget");
    let speed_m_s = scenario.pass[0].speed_m_s;
    for path in paths(&budget) {
        let arm = -Vector3::from(wrong_m);
        let expected = Vector6::new(0.0, 0.0, 0.0, arm.x, arm.y, arm.z);
        let (found, _) = share(path, Source::LaserLeverArm);
        assert!((found - expected).amax() < 3e-5, "{found}");
        let expected = Vector6::new(0.0, 0.0, 0.0, 0.0, -speed_m_s * 0.01, 0.0);
        let (found, _) = share(path, Source::Latency);
        assert!((found - expected).amax() < 3e-5, "{found}");
        let (_, constant) = share(path, Source::PositionDrift);
        let (_, white) = share(path, Source::PositionWhite);
        for i in 0..6 {
            assert!(
                constant[(i, i)] < 1e-3 * white[(i, i)],
                "{i} {constant} {white}"
            );
        }
        assert_eq!(share(path, Source::GrossErrors).1, Matrix6::zeros());
    }
}

/// Errors of both paths in one simulated survey.
fn errors(scenario: &Scenario, seed: u64, joint: &JointConfig) -> [Vector6<f64>; 2] {
    let survey = simulate(scenario, seed).expect("a survey");
    let sequential = projected();
    let input = PoolInput {
        campaign: &survey.campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &sequential,
        joint,
        seed,
        extras: &[],
    };
    let outcome = calibrate(&input, &boresight::watch::Unwatched).expect("usable input");
    let joint = outcome.joint.expect("a joint result").mounting;
    let sequential = outcome
        .sequential
        .expect("a reference path")
        .expect("a result")
        .mounting;
    [joint, sequential].map(|found| difference(&found, &survey.reality.sonar))
}

/// A constant error needs no statistics: one survey with it, less one without, against the direction predicted. Within 5 % of
/// each parameter; or of 1 % of its sigma in the whole budget by the joint path, of 5 % by the reference path, which jumps by that
/// when a single sounding at an edge changes its tie (its points do not lie on planes while its lever arm is wrong).
#[test]
fn one_survey_with_each_constant_error() {
    let mut scenario = thin();
    // pings at every phase between two records: what the records' noise weighs depends on it
    scenario.multibeam.ping_rate_hz = 5.13;
    scenario.truth.latency_s = 0.004;
    scenario.truth.range_scale = 5e-4;
    scenario.lidar.mounting_error_deg.pitch = 0.01;
    scenario.lidar.mounting_error_deg.yaw = -0.02;
    scenario.lidar.lever_arm_error_m = [0.002, 0.003, -0.002];
    scenario.sound_speed = Some(Water {
        speed_m_s: Some(1480.0),
        profile: vec![],
        gradient_error_1_s: 0.1,
        gradient_sigma_1_s: 0.0,
    });
    let mut wrong: Vec<String> = vec![];
    for records in [Recorded::Range, Recorded::TravelTime] {
        scenario.multibeam.records = records;
        // without noise the kernel does not bend
        let budget = analytic_with(&scenario, &projected(), &least_squares()).expect("a budget");
        let only = |sources: &[Source]| {
            let sources = Sources::only(sources);
            errors(
                &Scenario {
                    sources,
                    ..scenario.clone()
                },
                1,
                &least_squares(),
            )
        };
        let without = only(&[]);
        for source in [
            Source::Latency,
            Source::SoundSpeed,
            Source::SoundSpeedGradient,
            Source::LaserBoresight,
            Source::LaserLeverArm,
        ] {
            let with = only(&[source]);
            for (k, path) in paths(&budget).into_iter().enumerate() {
                let (expected, covariance) = share(path, source);
                assert_eq!(covariance, Matrix6::zeros());
                let found = with[k] - without[k];
                for i in 0..6 {
                    let floor = [0.01, 0.05][k] * path.covariance[(i, i)].sqrt();
                    let off = (found[i] - expected[i]).abs();
                    let (f, e) = (found[i], expected[i]);
                    let share = off / (0.05 * e.abs() + floor);
                    let line = format!(
                        "{records:?} {source:?} path {k}, {i}: {f:+.3e}, predicted {e:+.3e}, off by {share:.2}"
                    );
                    println!("{line}");
                    if share > 1.0 {
                        wrong.push(line);
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Metres in the target frame by which a record is wrong at a time: a slow drift over the pass.
fn drift_m(time_s: f64, middle_s: f64, half_s: f64) -> Vector3<f64> {
    let s = (time_s - middle_s) / half_s;
    Vector3::new(0.01 * s, 0.005 * s * s, 0.003 * (2.0 * s).sin())
}

/// The trajectory with every position wrong by this many metres in the target frame.
fn displaced(survey: &Simulated, by: impl Fn(f64) -> Vector3<f64>) -> Campaign {
    let mut campaign = survey.campaign.clone();
    let (pose, t) = (survey.reality.target, &mut campaign.trajectory);
    let turn = pose.ecef_from_target().rotation.matrix;
    for k in 0..t.time_s.len() {
        let place = Geodetic {
            latitude_rad: t.latitude_rad[k],
            longitude_rad: t.longitude_rad[k],
            height_m: t.height_m[k],
        };
        let right = pose.ellipsoid.to_geocentric(&place).coordinates;
        let wrong = pose
            .ellipsoid
            .to_geodetic(&Point::new(right + turn * by(t.time_s[k])));
        t.latitude_rad[k] = wrong.latitude_rad;
        t.longitude_rad[k] = wrong.longitude_rad;
        t.height_m[k] = wrong.height_m;
    }
    campaign
}

/// A drift turns the target's frame with the laser points that register it: one survey with a drift, less one without, against
/// the reference path's pulls. The frame is what makes the difference: without it lx would be off by several times the limit.
#[test]
fn the_reference_path_follows_a_drift_through_the_frame() {
    let scenario = Scenario {
        sources: Sources::none(),
        ..thin()
    };
    let survey = simulate(&scenario, 1).expect("a survey");
    let (sequential, joint) = (projected(), least_squares());
    let input = |campaign| PoolInput {
        campaign,
        target: &survey.target,
        prior: &survey.prior,
        method: Method::Both,
        sequential: &sequential,
        joint: &joint,
        seed: 1,
        extras: &[],
    };
    let outcome =
        calibrate(&input(&survey.campaign), &boresight::watch::Unwatched).expect("usable input");
    let linear = influence::sequential(&input(&survey.campaign), &outcome).expect("pulls");
    let times = &survey.campaign.trajectory.time_s;
    let (first_s, last_s) = (times[0], times[times.len() - 1]);
    let by = |time_s| drift_m(time_s, 0.5 * (first_s + last_s), 0.5 * (last_s - first_s));
    let moved = |pull: &Pull, time_s: &[f64]| {
        let group = survey.target.faces[pull.face as usize].group;
        pull.six
            * survey.target.groups[group]
                .normal
                .dot(&by(time_s[pull.row as usize]))
    };
    let (soundings, returns) = (
        &survey.campaign.soundings.time_s,
        &survey.campaign.laser.time_s,
    );
    let pulls = &linear.pulls;
    let expected: Vector6<f64> = pulls
        .soundings
        .iter()
        .map(|p| moved(p, soundings))
        .sum::<Vector6<f64>>()
        + pulls
            .returns
            .iter()
            .map(|p| moved(p, returns))
            .sum::<Vector6<f64>>();
    let drifted = displaced(&survey, by);
    let wrong = calibrate(&input(&drifted), &boresight::watch::Unwatched).expect("usable input");
    let responses = frame::of_returns(&outcome.scene);
    let followed: Vector4<f64> = responses
        .iter()
        .map(|r| r.parameters * r.normal.dot(&by(returns[r.point])))
        .sum();
    let turned = wrong.scene.azimuth_shift_rad - outcome.scene.azimuth_shift_rad;
    println!("azimuth: {turned:+.3e}, predicted {:+.3e}", followed[3]);
    assert!(turned.abs() > 5e-4, "{turned}");
    assert!(
        (turned - followed[3]).abs() < 0.05 * turned.abs(),
        "{turned} {followed}"
    );
    let found = wrong
        .sequential
        .expect("a path")
        .expect("a result")
        .mounting;
    let found = difference(&found, &linear.mounting);
    for i in 0..6 {
        // one sounding at an edge moves the path by as much
        let jump = if i < 3 { 2e-5 } else { 6e-5 };
        let (f, e) = (found[i], expected[i]);
        println!("{i}: {f:+.3e}, predicted {e:+.3e}");
        assert!(
            (f - e).abs() < 0.05 * e.abs() + jump,
            "{i}: {f:+.3e}, predicted {e:+.3e}"
        );
    }
}

/// A factor scales what happens and not what is claimed: an efficiency below one, four times the covariance.
#[test]
fn a_factor_scales_one_source() {
    let once = analytic(&thin()).expect("a budget");
    let mut scenario = thin();
    scenario.sources = Sources::default()
        .with(Source::PositionDrift, 2.0)
        .with(Source::Clutter, 3.0);
    scenario.disturbance.sonar_clutter_fraction = 0.01;
    let twice = analytic(&scenario).expect("a budget");
    for (a, b) in paths(&once).into_iter().zip(paths(&twice)) {
        let (four, one) = (
            share(b, Source::PositionDrift).1,
            share(a, Source::PositionDrift).1,
        );
        assert!(apart(&four, &(one * 4.0)) < 1e-9);
        let clutter = b
            .sources
            .iter()
            .find(|s| s.0 == Source::Clutter)
            .expect("every source");
        assert!(matches!(clutter.1, Prediction::NotPredicted { .. }));
    }
    let efficiency = twice.efficiency(&twice.joint).expect("a bound");
    assert!(
        efficiency.iter().all(|e| *e < 1.0) && efficiency[2] < 0.99,
        "{efficiency}"
    );
}

/// Everything together, 48 trials of both paths: variances within the chi-square interval and means within the normal one, 1 %
/// family-wise over the 24 comparisons.
#[test]
fn monte_carlo_agrees() {
    const TRIALS: u64 = 48;
    let budget = analytic(&thin()).expect("a budget");
    let trials: Vec<_> = (1..=TRIALS)
        .into_par_iter()
        .map(|seed| errors(&thin(), seed, &JointConfig::default()))
        .collect();
    let level = 1.0 - 0.99_f64.powf(1.0 / 24.0);
    let chi = ChiSquared::new(TRIALS as f64 - 1.0).expect("trials");
    let bounds = [0.5 * level, 1.0 - 0.5 * level].map(|p| chi.inverse_cdf(p));
    let t = statrs::distribution::StudentsT::new(0.0, 1.0, TRIALS as f64 - 1.0).expect("trials");
    let largest = t.inverse_cdf(1.0 - 0.5 * level);
    for (k, path) in paths(&budget).into_iter().enumerate() {
        let mean: Vector6<f64> = trials.iter().map(|e| e[k]).sum::<Vector6<f64>>() / TRIALS as f64;
        for i in 0..6 {
            let squares: f64 = trials.iter().map(|e| (e[k][i] - mean[i]).powi(2)).sum();
            let ratio = squares / path.covariance[(i, i)];
            let error = (squares / ((TRIALS - 1) * TRIALS) as f64).sqrt();
            let shift = (mean[i] - path.bias[i]) / error;
            println!(
                "path {k} parameter {i}: variance ratio {:.3}, mean off by {shift:+.2}",
                ratio / (TRIALS - 1) as f64
            );
            assert!(
                bounds[0] < ratio && ratio < bounds[1],
                "path {k}, {i}: {ratio} {bounds:?}"
            );
            assert!(shift.abs() < largest, "path {k}, {i}: {shift}");
        }
    }
}
