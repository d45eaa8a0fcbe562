//! The rail calibration in memory: derivatives, the cut of an inclined plane, truth without noise, honest sigmas, outliers, and
//! what is refused.

use boresight::adjust::{ChainState, Estimate, check_derivatives};
use boresight::observe::Mounting;
use boresight::procedures::pool::Method;
use boresight::procedures::rail::RailCampaign;
use boresight::procedures::rail::RailProfile;
use boresight::procedures::rail::conditions::{AttitudeConditions, PointConditions, Tie, recorded};
use boresight::procedures::rail::model::{Turned, chain, parameters};
use boresight::procedures::rail::reference::SweepStep;
use boresight::procedures::rail::simulate::{
    DEMO, RailScenario, RailSource, RailSources, SimulatedRail, simulate,
};
use boresight::procedures::rail::trial::{RailTrial, corrections_from, trial};
use boresight::procedures::rail::{
    RailInput, RailJointConfig, RailOutcome, RailReferenceConfig, RailScene, calibrate,
};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};

fn chn60() -> RailProfile {
    RailProfile::built_in("chn60").expect("a rail")
}

/// The demo with fewer rays and positions, so that a seed takes a fraction of a second.
fn thin() -> RailScenario {
    let mut scenario = RailScenario::from_toml(DEMO).expect("a scenario");
    scenario.table.heading_sweep_deg = [-5.0, 5.0, 1.0];
    scenario.table.pitch_sweep_deg = [-5.0, 5.0, 1.0];
    for profiler in &mut scenario.profiler {
        profiler.rays = 150;
    }
    scenario
}

fn without_noise(scenario: &RailScenario) -> SimulatedRail {
    let mut scenario = scenario.clone();
    scenario.sources = RailSources::none();
    simulate(&scenario, &chn60(), 1).expect("a survey")
}

fn calibrated<'a>(
    campaign: &'a RailCampaign,
    rail: &'a RailProfile,
    configs: &'a (RailReferenceConfig, RailJointConfig),
) -> RailOutcome<'a> {
    calibrate(&RailInput {
        campaign,
        rail,
        method: Method::Both,
        reference: &configs.0,
        joint: &configs.1,
    })
}

/// The second profiler's four last parameters were left out.
#[test]
fn an_undetected_error_has_its_effect_on_every_profiler() {
    let survey = simulate(&thin(), &chn60(), 1).expect("a survey");
    let (rail, configs) = (chn60(), Default::default());
    let outcome = calibrated(&survey.campaign, &rail, &configs);
    let joint = outcome
        .joint
        .as_ref()
        .expect("ran")
        .as_ref()
        .expect("solved");
    let effects = &joint.quality.effects;
    assert_eq!(effects.len(), joint.blocks.sought());
    assert!(
        effects.len() > 6 && effects.iter().all(|e| e.size > 0.0),
        "{effects:?}"
    );
}

/// At zero lever arm and level attitude the mapping is the one of docs/rail.md: `(x, z) = [[R11, R13], [R31, R33]] (s, t) + offset`.
#[test]
fn an_inclined_plane_cuts_the_rail_as_the_rotation_says() {
    let mut survey = without_noise(&thin());
    survey.campaign.stand.pivot_rail_m = Vector2::new(0.01, -0.02);
    let rail = chn60();
    let scene = RailScene::new(&survey.campaign, &rail);
    let mounting = Mounting::from_angles(0.4, 0.02, -0.03, survey.campaign.stand.pivot_body_m);
    let (x, blocks) = parameters(&scene, &[mounting, mounting]).expect("unknowns");
    let level = scene.level_position();
    let at = Turned::at(&scene, &blocks, &x, None, level);
    let (s, t, r) = (0.1, -0.25, mounting.rotation);
    let found = at.section(&(r * Vector3::new(s, 0.0, t) + mounting.lever_arm_m));
    let cut = Vector2::new(
        r[(0, 0)] * s + r[(0, 2)] * t + 0.01,
        r[(2, 0)] * s + r[(2, 2)] * t - 0.02,
    );
    assert!((found - cut).norm() < 1e-15, "{found} {cut}");
}

/// The simulator's rays and the conditions are written apart; at the truth, without noise, they agree to rounding, and the derivatives are
/// those of the misclosure.
#[test]
fn conditions_vanish_at_the_truth_and_derive_as_differences_do() {
    vanish_and_derive(&without_noise(&thin()));
}

/// With a lateral axis that lies before the vertical one, drawn by its sigma.
#[test]
fn conditions_know_a_gap_between_the_table_s_axes() {
    let mut scenario = thin();
    scenario.table.axes_gap_sigma_m = 0.003;
    scenario.sources = RailSources::only(&[RailSource::AxesGap]);
    let survey = simulate(&scenario, &chn60(), 1).expect("a survey");
    assert!(survey.reality.axes_gap_m.abs() > 1e-4);
    vanish_and_derive(&survey);
}

fn vanish_and_derive(survey: &SimulatedRail) {
    let rail = chn60();
    let scene = RailScene::new(&survey.campaign, &rail);
    let (mut x, blocks) = parameters(&scene, &survey.reality.mountings).expect("unknowns");
    if let Some(gap) = blocks.gap {
        x.block_mut(gap).value = vec![survey.reality.axes_gap_m];
    }
    let model = chain(&scene).expect("a chain");
    let states = ChainState::zero(&model);
    let ties: Vec<Tie> = scene
        .points
        .iter()
        .filter_map(|p| {
            let at = Turned::at(&scene, &blocks, &x, None, p.position as usize);
            let m =
                &survey.reality.mountings[survey.campaign.points.profiler[p.row as usize] as usize];
            let q = at.section(
                &(m.rotation * survey.campaign.points.point(p.row as usize) + m.lever_arm_m),
            );
            let near = rail.nearest(&q)?;
            assert!(near.distance_m < 1e-12, "{}", near.distance_m);
            near.inside.then_some(Tie {
                row: p.row,
                position: p.position,
                element: near.element as u16,
            })
        })
        .collect();
    let at = Estimate {
        parameters: x,
        chain: Some(states),
    };
    let points = PointConditions {
        scene: &scene,
        blocks: &blocks,
        ties: &ties,
    };
    let some: Vec<usize> = (0..ties.len()).step_by(61).collect();
    let faults = check_derivatives(&points, &some, &at, Some(&model), 1e-6, 1e-6);
    assert!(faults.is_empty(), "{:?}", &faults[..faults.len().min(3)]);
    let positions = recorded(&scene);
    let attitude = AttitudeConditions {
        scene: &scene,
        blocks: &blocks,
        group: 2,
        positions: &positions,
    };
    let faults = check_derivatives(
        &attitude,
        &[0, 1, 2, 30, 31, 32, 61],
        &at,
        Some(&model),
        1e-6,
        1e-6,
    );
    assert!(faults.is_empty(), "{faults:?}");
}

/// The engine stops when no step exceeds 0.01 sigma; twice that is allowed.
const REST_SIGMAS: f64 = 0.02;

/// Without noise the joint path finds the truth to the engine's tolerance, and the patent's path the roll to its coarse points.
#[test]
fn without_noise_the_truth_is_found() {
    let survey = without_noise(&thin());
    let (rail, configs) = (chn60(), Default::default());
    let outcome = calibrated(&survey.campaign, &rail, &configs);
    assert_eq!(outcome.refusal, None);
    let joint = outcome
        .joint
        .as_ref()
        .expect("ran")
        .as_ref()
        .expect("solved");
    let errors = corrections_from(joint.mountings.iter(), survey.reality.mountings.iter());
    for (k, error) in errors.iter().enumerate() {
        let sigma = joint.covariance[(k, k)].sqrt();
        assert!(error.abs() < REST_SIGMAS * sigma, "{k}: {error} {sigma}");
    }
    let reference = outcome
        .reference
        .as_ref()
        .expect("ran")
        .as_ref()
        .expect("found");
    for (found, mounting) in reference.iter().zip(&survey.reality.mountings) {
        let roll = found.mounting.angles().0 - mounting.angles().0;
        assert!(roll.abs() < 0.1f64.to_radians(), "{}", roll.to_degrees());
    }
}

/// Its fillet R7, which the path used to rest on, had three points where eight were needed.
#[test]
fn the_reference_path_works_on_uic60() {
    let uic60 = RailProfile::built_in("uic60").expect("a rail");
    let survey = simulate(&thin(), &uic60, 1).expect("a survey");
    let (reference, joint) = Default::default();
    let input = RailInput {
        campaign: &survey.campaign,
        rail: &uic60,
        method: Method::Reference,
        reference: &reference,
        joint: &joint,
    };
    let outcome = calibrate(&input);
    let found = outcome.reference.expect("ran").expect("found");
    for (found, mounting) in found.iter().zip(&survey.reality.mountings) {
        let roll = found.mounting.angles().0 - mounting.angles().0;
        assert!(roll.abs() < 0.5f64.to_radians(), "{}", roll.to_degrees());
    }
}

/// A rail that runs east-south-east, leans and climbs: the same truth.
#[test]
fn the_rail_may_point_anywhere() {
    let mut scenario = thin();
    scenario.rail.orientation_deg.heading = 100.0;
    scenario.rail.orientation_deg.roll = 0.4;
    scenario.rail.orientation_deg.pitch = -0.3;
    let survey = without_noise(&scenario);
    let (rail, configs) = (chn60(), Default::default());
    let outcome = calibrated(&survey.campaign, &rail, &configs);
    assert_eq!(outcome.refusal, None);
    let joint = outcome.joint.expect("ran").expect("solved");
    let errors = corrections_from(joint.mountings.iter(), survey.reality.mountings.iter());
    for (k, error) in errors.iter().enumerate() {
        let sigma = joint.covariance[(k, k)].sqrt();
        assert!(error.abs() < REST_SIGMAS * sigma, "{k}: {error} {sigma}");
    }
    let reference = outcome.reference.expect("ran").expect("found");
    for (found, mounting) in reference.iter().zip(&survey.reality.mountings) {
        let roll = found.mounting.angles().0 - mounting.angles().0;
        assert!(roll.abs() < 0.1f64.to_radians(), "{}", roll.to_degrees());
    }
}

/// Without noise and with many rays the Hausdorff distance is small where the turn cancels the bias and at least twice as large at one end of
/// the sweep. It changes by a tenth of a millimetre in all: with noise of 0.05 mm its minimum says little.
#[test]
fn without_noise_the_hausdorff_curves_fall_towards_the_bias() {
    let mut scenario = thin();
    scenario.profiler.iter_mut().for_each(|p| p.rays = 4000);
    let survey = without_noise(&scenario);
    let reference = RailReferenceConfig {
        spacing_m: 2e-5,
        ..RailReferenceConfig::default()
    };
    let joint = RailJointConfig::default();
    let rail = chn60();
    let outcome = calibrate(&RailInput {
        campaign: &survey.campaign,
        rail: &rail,
        method: Method::Reference,
        reference: &reference,
        joint: &joint,
    });
    let found = outcome.reference.expect("ran").expect("found");
    for (found, mounting) in found.iter().zip(&survey.reality.mountings) {
        let (_, pitch, heading) = mounting.angles();
        for (sweep, bias) in [(&found.heading, heading), (&found.pitch, pitch)] {
            let off = |s: &&SweepStep| (s.turn_rad + bias).abs();
            let near = sweep.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            let near = near.expect("steps").distance_m;
            let ends = sweep[0].distance_m.max(sweep[sweep.len() - 1].distance_m);
            assert!(ends > 2.0 * near, "{ends} {near} {sweep:?}");
        }
    }
}

fn trials(scenario: &RailScenario, count: u64) -> Vec<RailTrial> {
    let one = |seed| trial(scenario, &chn60(), &scenario.sources, seed).expect("a scenario");
    (1..=count).map(one).collect()
}

/// Squared length of the joint path's error in the metric of its covariance: 12 on average.
fn nees(trial: &RailTrial) -> f64 {
    let (errors, covariance) = trial.joint.as_ref().expect("usable");
    let e = DVector::from_column_slice(errors);
    let scale = DMatrix::from_diagonal(&covariance.diagonal().map(|v| v.sqrt().recip()));
    let (e, c) = (&scale * e, &scale * covariance * &scale);
    e.dot(&c.cholesky().expect("regular").solve(&e))
}

/// Seeds 1 to 24, without selection: the normalised squared error of all twelve parameters together is chi-square, and the patent's path has the
/// larger heading error.
#[test]
fn errors_are_as_large_as_reported() {
    let trials = trials(&thin(), 24);
    let (mut sum, mut count) = (0.0, 0);
    let (mut old, mut new) = (0.0, 0.0);
    for t in &trials {
        sum += nees(t);
        count += 12;
        let (errors, _) = t.joint.as_ref().expect("usable");
        new += errors[2].powi(2);
        old += t.reference.as_ref().map_or(0.0, |r| r[2].powi(2));
    }
    let chi = ChiSquared::new(f64::from(count)).expect("a distribution");
    let (low, high) = (chi.inverse_cdf(5e-4), chi.inverse_cdf(1.0 - 5e-4));
    assert!(low < sum && sum < high, "{low} < {sum} < {high}");
    assert!(old > 100.0 * new, "{old} {new}");
}

/// Errors and covariance speak of the same turn of the mounting: where both profilers are corrected by three degrees the same way, differences
/// of corrections would mix 3 % of the seat's 0.1 deg into the other angles, which is many sigmas of the profilers' height difference.
#[test]
fn large_corrections_leave_the_uncertainty_true() {
    let mut scenario = thin();
    for profiler in &mut scenario.profiler {
        let c = &mut profiler.correction_deg;
        (c.pitch, c.roll, c.yaw) = (3.0, -2.0, 3.5);
        (profiler.lateral_sigma_m, profiler.vertical_sigma_m) = (5e-6, 5e-6);
    }
    scenario.rail.profile_sigma_m = 0.0;
    let sum: f64 = trials(&scenario, 12).iter().map(nees).sum();
    let chi = ChiSquared::new(12.0 * 12.0).expect("a distribution");
    let (low, high) = (chi.inverse_cdf(5e-4), chi.inverse_cdf(1.0 - 5e-4));
    assert!(low < sum && sum < high, "{low} < {sum} < {high}");
}

/// A fifth of the rays in dust, while every third profile is partly hidden, move no parameter by one of its sigmas.
#[test]
fn dust_does_not_move_the_result() {
    let mut scenario = thin();
    scenario.disturbance.dust_fraction = 0.2;
    scenario.disturbance.occlusion_fraction = 0.3;
    let clean = scenario.sources.clone().with(RailSource::Dust, 0.0);
    let rail = chn60();
    for seed in 1..=3 {
        let without = trial(&scenario, &rail, &clean, seed)
            .expect("a scenario")
            .joint
            .expect("usable");
        let with = trial(&scenario, &rail, &scenario.sources, seed)
            .expect("a scenario")
            .joint
            .expect("usable");
        for k in 0..12 {
            let sigma = without.1[(k, k)].sqrt();
            let moved = (with.0[k] - without.0[k]) / sigma;
            println!("seed {seed}, parameter {k}: {moved:+.2} sigmas");
            assert!(moved.abs() < 1.0, "seed {seed}, parameter {k}: {moved}");
        }
    }
}

fn refusal(scenario: &RailScenario) -> String {
    let survey = simulate(scenario, &chn60(), 1).expect("a survey");
    let (rail, configs) = (chn60(), Default::default());
    let outcome = calibrated(&survey.campaign, &rail, &configs);
    outcome.refusal.expect("a refusal").to_string()
}

/// What the data do not determine is refused by name.
#[test]
fn undetermined_parameters_are_refused_by_name() {
    let mut level = thin();
    level.table.heading_sweep_deg = [0.0, 0.0, 1.0];
    let words = refusal(&level);
    assert!(words.contains("yaw"), "{words}");
    let mut flat = thin();
    flat.table.pitch_sweep_deg = [0.0, 0.0, 1.0];
    let words = refusal(&flat);
    assert!(words.contains("pitch"), "{words}");
    let mut away = thin();
    away.profiler[1].mounting_deg.roll = -120.0;
    let words = refusal(&away);
    assert!(words.contains("right"), "{words}");
}

/// Through a slit of one degree from above, five millimetres of the crown: the heading is refused, by its sigma.
#[test]
fn a_slit_view_of_the_crown_is_refused() {
    let mut scenario = thin();
    scenario.profiler.truncate(1);
    let above = &mut scenario.profiler[0];
    above.mounting_deg.roll = 0.0;
    above.lever_arm_m = [0.0, 0.05, 0.0];
    above.field_deg = 1.0;
    let words = refusal(&scenario);
    assert!(words.contains("yaw of left (sigma"), "{words}");
}

/// A rail that is one straight face tells neither height nor heading.
#[test]
fn a_straight_line_alone_is_refused() {
    let mut scenario = thin();
    scenario.sources = RailSources::only(&[RailSource::Lateral, RailSource::Vertical]);
    let survey = simulate(&scenario, &chn60(), 1).expect("a survey");
    let mut campaign = survey.campaign.clone();
    let mut rail = chn60();
    let flank = rail.line_region[1];
    let scene = RailScene::new(&survey.campaign, &rail);
    let (x, blocks) = parameters(&scene, &survey.reality.mountings).expect("unknowns");
    let on_flank = |placed: &&boresight::procedures::rail::scene::Placed| {
        let row = placed.row as usize;
        let m = &survey.reality.mountings[survey.campaign.points.profiler[row] as usize];
        let at = Turned::at(&scene, &blocks, &x, None, placed.position as usize);
        let q = at.section(&(m.rotation * survey.campaign.points.point(row) + m.lever_arm_m));
        survey.campaign.points.profiler[row] == 1
            && rail
                .nearest(&q)
                .is_some_and(|n| n.element == flank && n.distance_m < 3e-4)
    };
    let rows: Vec<usize> = scene
        .points
        .iter()
        .filter(on_flank)
        .map(|p| p.row as usize)
        .collect();
    assert!(rows.len() > 200, "{}", rows.len());
    let of = |column: &[f64]| rows.iter().map(|&r| column[r]).collect::<Vec<f64>>();
    let p = &survey.campaign.points;
    campaign.points.time_s = of(&p.time_s);
    campaign.points.y_m = of(&p.y_m);
    campaign.points.z_m = of(&p.z_m);
    campaign.points.profiler = vec![0; rows.len()];
    campaign.profilers.remove(0);
    campaign.profilers[0].nominal = survey.reality.mountings[1];
    rail.elements = vec![rail.elements[flank]];
    rail.names = vec![rail.names[flank].clone()];
    (rail.line_region, rail.arc_region) = (vec![0], vec![]);
    let configs = Default::default();
    let outcome = calibrated(&campaign, &rail, &configs);
    let words = outcome.refusal.expect("a refusal").to_string();
    assert!(
        words.contains("lz of right") && words.contains("not determined"),
        "{words}"
    );
}
