//! Error budgets of USBL and rail scenarios: a source whose effect is known by hand, threads, the command line.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::AtomicBool;

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::budget::named::{Acting, Tried, Wanted, run};
use boresight::procedures::rail::simulate::{RailScenario, RailSource, RailSources};
use boresight::procedures::rail::trials::RailTrials;
use boresight::procedures::rail::{RailJointConfig, RailReferenceConfig};
use boresight::procedures::usbl::simulate::{DEMO, simulate};
use boresight::procedures::usbl::simulate::{Scenario, Source, Sources};
use boresight::procedures::usbl::trials::UsblTrials;
use boresight::procedures::usbl::{JointConfig, ReferenceConfig};
use boresight::results::NamedBudget;
use boresight::target::RailProfile;
use nalgebra::Vector3;

fn usbl(change: impl FnOnce(&mut Scenario)) -> UsblTrials {
    let mut scenario: Scenario = toml::from_str(DEMO).expect("a scenario");
    scenario.fixes.per_beacon = 20;
    change(&mut scenario);
    UsblTrials {
        scenario,
        reference: ReferenceConfig::default(),
        joint: JointConfig::default(),
    }
}

fn budget(trials: &UsblTrials, wanted: Wanted, threads: usize) -> NamedBudget {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let stop = AtomicBool::new(false);
    pool.expect("a pool")
        .install(|| run(trials, &wanted, &stop, &|_, _| {}))
}

/// The control turned against the attitude sensor's level frame by 0.05 degrees about east and north and 0.2 about up, and nothing
/// else: whatever the layout, both paths' pitch and roll are wrong by 0.05 and yaw by 0.2. A variance over n trials is known to
/// sqrt(2 / (n - 1)); four of those are allowed, and 1 % for the body's tilt, which mixes the axes.
#[test]
fn a_turn_of_the_control_goes_into_the_mounting_whole() {
    let trials = usbl(|scenario| {
        scenario.control.tilt_sigma_deg = 0.05;
        scenario.control.azimuth_sigma_deg = 0.2;
        scenario.sources = Sources::only(&[Source::Datum]);
    });
    let wanted = Wanted {
        first_seed: 1,
        trials: 400,
        single: 0,
    };
    let found = budget(&trials, wanted, 2);
    assert_eq!(found.sources.len(), 1);
    let allowed = 4.0 * (2.0_f64 / 399.0).sqrt() + 0.01;
    for path in &found.paths {
        let together = path.together.as_ref().expect("figures");
        let sigma = together.standard_deviation.as_ref().expect("sigmas");
        for (i, expected) in [0.05, 0.05, 0.2].into_iter().enumerate() {
            let ratio = (sigma[i] / expected).powi(2);
            assert!((ratio - 1.0).abs() < allowed, "{}: {i}: {ratio}", path.path);
        }
    }
}

/// Errors of the joint and the reference path in a trial.
fn errors(tried: &dyn Tried, acting: Acting) -> [Vec<f64>; 2] {
    let trial = tried.trial(3, acting);
    let joint = trial.joint.expect("a joint result").error;
    [joint, trial.reference.expect("a reference result")]
}

/// What the only source of which each seed draws once does alone, beside what is there without it (interpolated attitudes).
fn effect(tried: &dyn Tried) -> [Vec<f64>; 2] {
    assert_eq!(tried.sources().len(), 1);
    let ([joint, reference], [joint_without, reference_without]) =
        (errors(tried, Acting::Only(0)), errors(tried, Acting::None));
    let less = |with: Vec<f64>, without: Vec<f64>| {
        let pairs = with.iter().zip(&without);
        pairs.map(|(with, without)| with - without).collect()
    };
    [
        less(joint, joint_without),
        less(reference, reference_without),
    ]
}

/// Effects are linear in a turn of a twentieth of a degree but for some 1e-3 of it.
fn is_twice(twice: &[f64], once: &[f64]) {
    let largest = once.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
    assert!(largest > 1e-3, "{once:?}");
    for (once, twice) in once.iter().zip(twice) {
        let off = twice - 2.0 * once;
        assert!(off.abs() < 0.01 * largest, "{twice} for twice {once}");
    }
}

/// The scenario says that an error is twice what the survey claims: alone it is twice, too.
#[test]
fn a_source_alone_keeps_its_factor() {
    let [once, twice] = [1.0, 2.0].map(|factor| {
        let tried = usbl(|scenario| {
            scenario.control.tilt_sigma_deg = 0.05;
            scenario.control.azimuth_sigma_deg = 0.05;
            scenario.sources = Sources::none().with(Source::Datum, factor);
        });
        effect(&tried)
    });
    for path in 0..2 {
        is_twice(&twice[path][..3], &once[path][..3]);
    }
}

#[test]
fn a_source_of_a_rail_alone_keeps_its_factor() {
    let text = std::fs::read_to_string(scenario("rail-thin.toml")).expect("a scenario");
    let [once, twice] = [1.0, 2.0].map(|factor| {
        let mut scenario = RailScenario::from_toml(&text).expect("a scenario");
        scenario.sources = RailSources::none().with(RailSource::RailAttitude, factor);
        effect(&RailTrials {
            scenario,
            rail: RailProfile::built_in("chn60").expect("a rail"),
            reference: RailReferenceConfig::default(),
            joint: RailJointConfig::default(),
        })
    });
    is_twice(&twice[0], &once[0]);
}

/// Only the transducer's survey is wrong. The beacons stand about the true transducer, 6 m below it, their mean at `centre_m`; the
/// control has them from the surveyed one. What their mean is off is true minus surveyed, and the reference path, which takes the
/// surveyed place, errs by its opposite.
#[test]
fn the_reference_path_takes_the_transducer_as_surveyed() {
    let tried = usbl(|scenario| {
        scenario.transducer.sigma_m = [0.1, 0.2, 0.3];
        scenario.sources = Sources::only(&[Source::TransducerSurvey]);
    });
    let [_, reference] = errors(&tried, Acting::Only(0));
    let survey = simulate(&tried.scenario, 3).expect("a survey");
    let beacons = &survey.campaign.beacons;
    let sum: Vector3<f64> = beacons.iter().map(|b| b.point.position_m).sum();
    let off = sum / beacons.len() as f64 - Vector3::new(0.3, -0.2, -6.0);
    assert!(off.norm() > 0.05, "{off}");
    for axis in 0..3 {
        assert!(
            (reference[3 + axis] + off[axis]).abs() < 1e-9,
            "{reference:?} {off}"
        );
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let trials = usbl(|_| {});
    let wanted = Wanted {
        first_seed: 5,
        trials: 70,
        single: 3,
    };
    let bytes = |threads| {
        let found = budget(&trials, wanted, threads);
        boresight::report::named_budget::to_bytes(&found).expect("JSON")
    };
    assert_eq!(bytes(1), bytes(2));
}

fn command(arguments: &[&str]) -> Output {
    cargo_bin_cmd!("boresight")
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models/scenarios")
        .join(name)
}

#[test]
fn both_procedures_have_a_budget_on_the_command_line() {
    for (name, trials) in [("usbl.toml", "6"), ("rail-thin.toml", "3")] {
        let folder = tempfile::tempdir().expect("folder");
        let (file, out) = (scenario(name), folder.path().join("out"));
        let (file, out) = (file.to_string_lossy(), out.to_string_lossy());
        let output = command(&[
            "budget", &file, "--trials", trials, "--single", "2", "--out", &out,
        ]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("share of variance"), "{said}");
        let text = std::fs::read(folder.path().join("out/result.json")).expect("a result");
        let found: NamedBudget = serde_json::from_slice(&text).expect("a budget");
        assert_eq!(
            (found.trials.to_string(), found.single_trials),
            (trials.to_owned(), 2)
        );
        let rows = std::fs::read_to_string(folder.path().join("out/budget.csv")).expect("a table");
        let shares = 2 * (found.sources.len() + 2) * found.parameters.len();
        assert_eq!(rows.lines().count(), 1 + shares);
        assert!(folder.path().join("out/report.html").exists());
    }
}

#[test]
fn what_only_a_pool_s_budget_has_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let (file, out) = (scenario("usbl.toml"), folder.path().join("out"));
    let (file, out) = (file.to_string_lossy(), out.to_string_lossy());
    let vary = "attitude.rate_hz=1:2:1";
    let output = command(&[
        "budget", &file, "--trials", "2", "--vary", vary, "--out", &out,
    ]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("--vary: found with a usbl scenario"),
        "{said}"
    );
    assert!(!Path::new(&*out).exists());
}

#[test]
fn a_survey_without_truth_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let (file, out) = (folder.path().join("survey.toml"), folder.path().join("out"));
    std::fs::write(&file, "name = \"x\"\nprocedure = \"usbl\"\n").expect("written");
    let (file, out) = (file.to_string_lossy(), out.to_string_lossy());
    let output = command(&["budget", &file, "--out", &out]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("expected a usbl scenario"), "{said}");
    assert!(!Path::new(&*out).exists());
}
