//! Planning without data, against calibrations of simulated surveys and against itself.

use boresight::calibrate::planning::PlanAsk;
use boresight::calibrate::tried::{Acting, Tried};
use boresight::calibrate::vary::{Point, Vary, at, points};
use boresight::procedures::pool::JointConfig;
use boresight::procedures::pool::budget::fusion::sigmas;
use boresight::procedures::pool::budget::passes::{PassError, predicted};
use boresight::procedures::pool::budget::plan::{Plan, PlanRequest, plan, worth};
use boresight::procedures::pool::budget::planned::planned;
use boresight::procedures::pool::budget::trials::{ALIASES, Configuration, PoolTrials};
use boresight::results::{PlanCriterion, PlanResult};
use boresight::simulate::Scenario;

/// A survey that is quickly simulated and calibrated.
fn thin() -> Scenario {
    let text = include_str!("../../models/scenarios/single-pass-thin.toml");
    Scenario::from_toml(text).expect("a scenario")
}

/// Half of [`thin`]'s records again, for plans of many passes.
fn thinner() -> Scenario {
    let mut scenario = thin();
    scenario.trajectory.rate_hz = 10.0;
    scenario.lidar.line_rate_hz = 5.0;
    scenario.lidar.points_per_line = 80;
    scenario.multibeam.ping_rate_hz = 4.0;
    scenario
}

/// [`thinner`] at every point.
fn swept(vary: &[Vary]) -> Vec<(Point, Scenario)> {
    let with_scenario = |point: Point| {
        let scenario = at(&thinner(), &point, &ALIASES, Scenario::check).expect("a scenario");
        (point, scenario)
    };
    points(vary).into_iter().map(with_scenario).collect()
}

/// Mean of what the joint path reports over some seeds.
fn reported(scenario: &Scenario, seeds: std::ops::Range<u64>) -> [f64; 6] {
    let count = (seeds.end - seeds.start) as f64;
    let mut variance = [0.0; 6];
    for seed in seeds {
        let tried = PoolTrials {
            scenario: scenario.clone(),
            configuration: Configuration::default(),
        };
        let joint = tried.trial(seed, Acting::All).paths.swap_remove(0);
        let said = joint.expect("a usable joint result");
        let covariance = said.covariance.expect("a covariance");
        for (i, v) in variance.iter_mut().enumerate() {
            *v += covariance[(i, i)] / count;
        }
    }
    variance.map(f64::sqrt)
}

fn promised(scenario: &Scenario) -> [f64; 6] {
    sigmas(&predicted(scenario, &JointConfig::default()).expect("a prediction"))
}

fn within(found: [f64; 6], expected: [f64; 6], part: f64) {
    let ratio: Vec<f64> = found.iter().zip(&expected).map(|(f, e)| f / e).collect();
    println!("promised by reported: {ratio:.4?}");
    assert!(
        ratio.iter().all(|r| (r - 1.0).abs() < part),
        "promised {found:?}, reported {expected:?}, ratio {ratio:?}"
    );
}

/// One error-free linearisation promises what the adjustment of a survey with all its errors reports. The kernel (Huber, 2 sigmas)
/// has an efficiency of 0.99 with normal errors, half a per cent of a standard deviation.
#[test]
fn one_pass_is_promised_what_it_reports() {
    within(promised(&thin()), reported(&thin(), 1..6), 0.05);
}

/// Two passes far enough apart in time that their drift is not the same, each with the phase of the motion at its time. At 9 m the
/// thin survey has so few soundings on the small faces that a pass alone ties other ones than the two together: 7 % of lx.
#[test]
fn two_passes_are_promised_what_they_report() {
    let mut scenario = thinner();
    let mut second = scenario.pass[0].clone();
    second.gap_s = 600.0;
    scenario.pass.push(second.clone());
    within(promised(&scenario), reported(&scenario, 1..4), 0.02);
    second.distance_m = 9.0;
    scenario.pass[1] = second;
    within(promised(&scenario), reported(&scenario, 1..4), 0.1);
}

fn request() -> PlanRequest {
    PlanRequest {
        distances_m: vec![4.5, 6.0, 9.0],
        speeds_m_s: vec![],
        crabs_deg: vec![-10.0, 0.0, 10.0],
        both_directions: false,
        keep_passes: true,
        criterion: PlanCriterion::D,
        wanted: [1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-3],
        most: 5,
    }
}

fn made(request: &PlanRequest) -> Plan {
    plan(&thinner(), request, &JointConfig::default(), &|| {}).expect("a plan")
}

#[test]
fn the_chosen_pass_is_never_worse_than_any_other_candidate() {
    let mut first = vec![];
    for criterion in [PlanCriterion::D, PlanCriterion::A] {
        let request = PlanRequest {
            criterion,
            ..request()
        };
        let plan = made(&request);
        assert_eq!(plan.candidates.len(), 9);
        let step = &plan.steps[0];
        let chosen = worth(&step.covariance, &request);
        for candidate in &plan.candidates {
            let next = candidate.next.expect("a candidate that sees the wall");
            assert!(chosen <= worth(&next, &request), "{}", candidate.name);
        }
        let best = plan.candidates[step.candidate]
            .next
            .expect("the chosen one");
        assert_eq!(best, step.covariance);
        // another distance than the scenario's 6 m, as the checks advise
        assert_ne!(plan.candidates[step.candidate].pass.distance_m, 6.0);
        first.push(chosen);
    }
    // each criterion's own choice is in its own measure
    assert_ne!(first[0], first[1]);
}

/// More passes never make anything worse, nothing goes below the floor, and a repeated pass gains at most the square root of 2.
#[test]
fn passes_only_help_and_the_floor_holds() {
    let plan = made(&request());
    let start = sigmas(&plan.start.expect("a pass is sailed"));
    let mut before = start;
    for step in &plan.steps {
        let now = sigmas(&step.covariance);
        for i in 0..6 {
            assert!(now[i] <= before[i] * (1.0 + 1e-9), "parameter {i}");
            assert!(now[i] >= plan.floor[i], "parameter {i} below its floor");
        }
        before = now;
    }
    let again = plan
        .candidates
        .iter()
        .find(|c| c.name == "6 m, 0.5 m/s, +Y");
    let again = sigmas(&again.expect("the same pass").next.expect("seen"));
    for i in 0..6 {
        let gain = start[i] / again[i];
        assert!(
            (1.0..=std::f64::consts::SQRT_2 + 1e-6).contains(&gain),
            "{gain}"
        );
    }
}

/// Horizontal faces that are known to 3 mm only: the vertical lever arm cannot be known better than they average out, however many
/// passes; twice the doubt, twice the floor. A boat that does not move, as any motion would tell, however little, and endless passes
/// add up.
#[test]
fn nobody_gets_below_what_is_known_of_the_target() {
    let floor_at = |sigma_m: f64| {
        let vary = [format!("target.model.height_sigma_m={sigma_m}")
            .parse()
            .expect("a value")];
        let scenario = swept(&vary)[0].1.clone();
        let scenario = still(scenario);
        let request = PlanRequest {
            wanted: [1e-4, 1e-3, 1e-3, 5e-3, 5e-3, 1e-4],
            most: 3,
            ..request()
        };
        let result = planned(&scenario, &request, &[], &JointConfig::default(), &|| {});
        let result = result.expect("a plan");
        println!("floor {:?}", result.floor);
        assert_eq!(result.unreachable, ["lz"]);
        assert_eq!(result.passes_needed, None);
        assert_eq!(result.chosen.len(), 3);
        let floor = result.floor.expect("a floor");
        let of = |name: &str| {
            let place = result.parameters.iter().position(|p| p.name == name);
            floor[place.expect("a parameter")].expect("a bound")
        };
        (of("lz"), of("roll"))
    };
    let (one, two) = (floor_at(0.003), floor_at(0.006));
    // as of two independent doubts of this size that are averaged
    let expected = 0.003 / std::f64::consts::SQRT_2;
    assert!((one.0 / expected - 1.0).abs() < 0.01, "{one:?}");
    assert!((two.0 / one.0 - 2.0).abs() < 0.02, "{one:?} {two:?}");
    assert!(one.1 < 1e-3, "{one:?}");
}

fn still(mut scenario: Scenario) -> Scenario {
    let m = &mut scenario.motion;
    let all = [
        &mut m.sway,
        &mut m.surge,
        &mut m.height,
        &mut m.roll,
        &mut m.pitch,
        &mut m.heading,
    ];
    all.into_iter().for_each(|o| o.wave.clear());
    scenario
}

/// What is not known of the scanner makes the sonar's mounting worse, never better.
#[test]
fn doubt_about_the_scanner_is_counted() {
    let mut scenario = thinner();
    let known = promised(&scenario);
    scenario.lidar.mounting_sigma_deg = [0.02; 3];
    scenario.lidar.lever_arm_sigma_m = [0.003; 3];
    let doubted = promised(&scenario);
    println!("known {known:?}, doubted {doubted:?}");
    assert!(
        (0..6).all(|i| doubted[i] > known[i]),
        "{known:?} {doubted:?}"
    );
    within(doubted, reported(&scenario, 1..6), 0.1);
}

#[test]
fn the_number_of_passes_is_the_first_that_reaches_what_is_wanted() {
    let enough = made(&PlanRequest {
        wanted: [1.0; 6],
        ..request()
    });
    assert_eq!((enough.needed, enough.steps.len()), (Some(0), 0));
    let all = made(&request());
    let third = sigmas(&all.steps[2].covariance);
    let wanted = third.map(|s| s * (1.0 + 1e-9));
    let plan = made(&PlanRequest {
        wanted,
        ..request()
    });
    let needed = plan.needed.expect("reached");
    assert!(needed <= 3, "{needed}");
    assert_eq!(plan.steps.len(), needed);
    let from_nothing = made(&PlanRequest {
        keep_passes: false,
        ..request()
    });
    assert_eq!(from_nothing.start, None);
    assert_eq!(from_nothing.steps.len(), 5);
}

/// A candidate that one sensor does not see the wall from is offered with its refusal; a pass that is sailed must be seen.
#[test]
fn a_pass_that_sees_nothing_is_refused_with_its_reason() {
    let mut request = request();
    request.distances_m = vec![6.0, 80.0];
    let plan = made(&request);
    for candidate in &plan.candidates {
        let far = candidate.pass.distance_m > 70.0;
        assert_eq!(candidate.information.is_err(), far, "{}", candidate.name);
        assert_eq!(candidate.next.is_none(), far);
    }
    assert!(
        plan.steps
            .iter()
            .all(|s| plan.candidates[s.candidate].next.is_some())
    );
    let mut scenario = thinner();
    scenario.pass[0].distance_m = 80.0;
    let error = plan_error(&scenario, &request);
    assert!(!error.to_string().is_empty());
    scenario.pass[0].speed_m_s = -1.0;
    let error = plan_error(&scenario, &request).to_string();
    assert!(error.contains("speed_m_s = -1"), "{error}");
}

fn plan_error(scenario: &Scenario, request: &PlanRequest) -> PassError {
    plan(scenario, request, &JointConfig::default(), &|| {}).expect_err("no plan")
}

/// Common sense that is known beforehand: halved range noise helps, and each value's prediction is that of its own scenario.
#[test]
fn scenario_values_are_compared_each_in_its_own_survey() {
    let vary = ["multibeam.tilt_deg=35,45,55".parse().expect("a sweep")];
    let points = swept(&vary);
    let request = PlanRequest {
        distances_m: vec![6.0],
        crabs_deg: vec![],
        both_directions: false,
        most: 1,
        ..request()
    };
    let result = planned(
        &thinner(),
        &request,
        &points,
        &JointConfig::default(),
        &|| {},
    );
    let variations = result.expect("a plan").variations.expect("variations");
    assert_eq!(variations.keys, ["multibeam.tilt_deg"]);
    assert_eq!(variations.points.len(), 3);
    for ((_, scenario), point) in points.iter().zip(&variations.points) {
        let six = point.standard_deviation.as_ref().expect("seen");
        let expected = promised(scenario);
        for i in 0..6 {
            let expected = if i < 3 {
                expected[i].to_degrees()
            } else {
                expected[i]
            };
            let found = six[i].expect("a sigma");
            assert!((found / expected - 1.0).abs() < 1e-12, "{six:?}");
        }
    }
    let sigma = |k: usize| {
        variations.points[k]
            .standard_deviation
            .clone()
            .expect("seen")
    };
    assert_ne!(sigma(0), sigma(2));
}

/// Waves that have turned for minutes before a later pass begins still have a phase within its limits.
#[test]
fn later_passes_can_be_planned() {
    let text = include_str!("../../models/scenarios/three-pass-thin.toml");
    let scenario = Scenario::from_toml(text).expect("a scenario");
    let request = PlanRequest {
        most: 1,
        ..request()
    };
    let result = planned(&scenario, &request, &[], &JointConfig::default(), &|| {});
    assert!(result.is_ok(), "{result:?}");
}

/// The same bytes on one thread and on two.
#[test]
fn threads_leave_no_trace() {
    let on = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        let request = PlanRequest {
            most: 2,
            ..request()
        };
        pool.expect("a pool").install(|| {
            let result = planned(&thinner(), &request, &[], &JointConfig::default(), &|| {});
            serde_json::to_string(&result.expect("a plan")).expect("JSON")
        })
    };
    assert_eq!(on(1), on(2));
}

fn command(arguments: &[&str], out: &std::path::Path) -> std::process::Output {
    let scenario = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/models/scenarios/single-pass-thin.toml"
    );
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("boresight");
    command
        .args(["plan", scenario, "--quiet", "--out"])
        .arg(out)
        .args(arguments);
    command.output().expect("a run")
}

/// A scenario may name its target's file, which stands beside it.
#[test]
fn a_target_beside_the_scenario_is_planned_on_like_one_within() {
    let within = include_str!("../../models/scenarios/single-pass-thin.toml");
    let (before, rest) = within.split_once("[target.model]\n").expect("a model");
    let (model, after) = rest.split_once("\n[basin]").expect("a section behind it");
    let named = before.replace("[target]\n", "[target]\nmodel = \"wall.toml\"\n");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scenario.toml");
    std::fs::write(folder.path().join("wall.toml"), model).expect("written");
    let pool = boresight::procedures::find("pool").expect("a procedure");
    let ask = PlanAsk {
        distances_m: vec![6.0],
        speeds_m_s: vec![],
        crabs_deg: vec![],
        both_directions: false,
        keep_passes: true,
        criterion: PlanCriterion::D,
        wanted: vec![],
        most: 1,
        vary: vec![],
    };
    let plan = |text: &str| {
        let planner = pool.planner(&file, text, &ask).expect("a scenario");
        let plan = planner.expect("a pool is planned").plan(&|| {});
        plan.expect("a plan").chosen
    };
    assert_eq!(plan(&format!("{named}[basin]{after}")), plan(within));
}

#[test]
fn the_command_writes_a_plan_as_json_table_and_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("plan");
    let arguments = [
        "--distance",
        "6,9",
        "--crab",
        "-10,0",
        "--wanted",
        "pitch=1,lx=20",
        "--json",
        "--most",
        "2",
    ];
    let ended = command(&arguments, &out);
    assert_eq!(
        ended.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&ended.stderr)
    );
    let written = std::fs::read(out.join("plan.json")).expect("plan.json");
    assert_eq!(ended.stdout, written);
    let result: PlanResult = serde_json::from_slice(&written).expect("a plan");
    assert_eq!((result.candidates.len(), result.sailed.len()), (4, 1));
    assert_eq!(result.wanted[3], Some(0.02));
    assert!((result.wanted[0].expect("pitch") - 1.0).abs() < 1e-12);
    assert!(
        result
            .command
            .contains("--crab -10,0 --wanted pitch=1,lx=20 --most 2"),
        "{}",
        result.command
    );
    let table = std::fs::read_to_string(out.join("plan.csv")).expect("plan.csv");
    let rows = |kind: &str| table.lines().filter(|l| l.starts_with(kind)).count();
    assert_eq!(
        (
            rows("candidate"),
            rows("wanted"),
            rows("sailed"),
            rows("floor")
        ),
        (4, 1, 1, 1)
    );
    assert_eq!(rows("chosen"), result.chosen.len());
    assert!(out.join("plan.html").exists());
}

#[test]
fn bad_input_ends_with_two_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("plan");
    for (arguments, part) in [
        (vec!["--distance", "0"], "above 0"),
        (vec!["--crab", "95"], "between -90 and 90"),
        (vec!["--wanted", "heading=1"], "expected one of pitch"),
        (
            vec!["--vary", "multibeam.beam=3,4"],
            "nearest known one is \"beams\"",
        ),
        (
            vec!["--vary", "a=1", "--vary", "b=1", "--vary", "c=1"],
            "expected one or two",
        ),
    ] {
        let ended = command(&arguments, &out);
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(part), "{arguments:?}: {said}");
        assert!(!out.exists());
    }
}
