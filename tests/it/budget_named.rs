//! Error budgets of USBL and rail scenarios: a source whose effect is known by hand, threads, the command line.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::AtomicBool;

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::budget::experiment::Experiment;
use boresight::budget::summary;
use boresight::calibrate::quality::readable;
use boresight::calibrate::tried::{Acting, Tried};
use boresight::procedures::rail::RailProfile;
use boresight::procedures::rail::simulate::{RailScenario, RailSource, RailSources};
use boresight::procedures::rail::trials::RailTrials;
use boresight::procedures::rail::{RailJointConfig, RailReferenceConfig};
use boresight::procedures::usbl::simulate::{DEMO, simulate};
use boresight::procedures::usbl::simulate::{Scenario, Source, Sources};
use boresight::procedures::usbl::trials::UsblTrials;
use boresight::procedures::usbl::{JointConfig, ReferenceConfig};
use boresight::results::BudgetResult;
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

fn budget(tried: &dyn Tried, (trials, single): (u64, u64), threads: usize) -> BudgetResult {
    let experiment = Experiment::new(tried, 1, trials, single);
    let folder = tempfile::tempdir().expect("folder");
    let done = experiment.prepare(folder.path(), false).expect("ledgers");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let stop = AtomicBool::new(false);
    let run = || experiment.run(folder.path(), &done, &stop, &|_| {});
    pool.expect("a pool").install(run).expect("trials");
    let mut result = summary::frame(tried);
    summary::fill(&mut result, &experiment, folder.path()).expect("figures");
    result
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
    let found = budget(&trials, (400, 0), 2);
    assert_eq!(found.sources.len(), 1);
    let allowed = 4.0 * (2.0_f64 / 399.0).sqrt() + 0.01;
    for path in &found.paths {
        let together = path.together.as_ref().expect("figures");
        let sigma = together.standard_deviation.as_ref().expect("sigmas");
        for (i, expected) in [0.05, 0.05, 0.2].into_iter().enumerate() {
            let ratio = (sigma[i].expect("a figure") / expected).powi(2);
            assert!((ratio - 1.0).abs() < allowed, "{}: {i}: {ratio}", path.path);
        }
    }
}

/// Errors of the joint and the reference path in a trial, degrees and metres.
fn errors(tried: &dyn Tried, acting: Acting) -> [Vec<f64>; 2] {
    let trial = tried.trial(3, acting);
    let units = tried.parameters();
    let shown = |path: usize| {
        let said = trial.paths[path].as_ref().expect("a result");
        let pairs = said.error.iter().zip(&units);
        pairs.map(|(e, p)| readable(*e, p.unit).0).collect()
    };
    [shown(0), shown(1)]
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
    let bytes = |threads| {
        let found = budget(&trials, (70, 3), threads);
        boresight::report::budget::to_bytes(&found).expect("JSON")
    };
    assert_eq!(bytes(1), bytes(2));
}

fn command(arguments: &[&str]) -> Output {
    cargo_bin_cmd!("boresight")
        .args(arguments)
        .output()
        .expect("the program runs")
}

/// The bytes of every file in a folder and of the ledgers in it, by name.
fn files_below(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let inner = folder.join("trials");
    let entries = [folder, &inner].map(|f| std::fs::read_dir(f).expect("a folder").flatten());
    let files = entries.into_iter().flatten().map(|entry| entry.path());
    let mut all: Vec<_> = files
        .filter(|file| file.is_file())
        .map(|file| (name_of(&file), std::fs::read(&file).expect("bytes")))
        .collect();
    all.sort();
    all
}

fn name_of(file: &Path) -> String {
    file.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
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
        // fewer than 50 trials of a source alone know no share
        assert!(said.contains("no shares of the variance"), "{said}");
        let text = std::fs::read(folder.path().join("out/result.json")).expect("a result");
        let found: BudgetResult = serde_json::from_slice(&text).expect("a budget");
        assert_eq!(
            (found.trials.to_string(), found.single_trials),
            (trials.to_owned(), 2)
        );
        let rows = std::fs::read_to_string(folder.path().join("out/budget.csv")).expect("a table");
        // together, nothing, remainder and interaction beside the sources
        let shares = 2 * (found.sources.len() + 4) * found.parameters.len();
        assert_eq!(rows.lines().count(), 1 + shares);
        assert!(folder.path().join("out/report.html").exists());
    }
}

/// A value over a range, for each procedure: the larger the noise, the larger the reported sigma; an unknown key is named.
#[test]
fn values_are_varied_for_every_procedure() {
    let cases = [
        ("usbl.toml", "fixes.angle_sigma_deg", "0.02,0.6", 0),
        (
            "rail-thin.toml",
            "profiler.*.vertical_sigma_m",
            "5e-5,2e-4",
            2,
        ),
    ];
    for (name, key, values, parameter) in cases {
        let folder = tempfile::tempdir().expect("folder");
        let (file, out) = (scenario(name), folder.path().join("out"));
        let (file, to) = (file.to_string_lossy(), out.to_string_lossy());
        let vary = format!("{key}={values}");
        let unknown = format!("{key}x=1,2");
        let output = command(&[
            "budget", &file, "--trials", "2", "--vary", &unknown, "--out", &to,
        ]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains("nearest known one") && !out.exists(),
            "{said}"
        );
        let output = command(&[
            "budget", &file, "--trials", "2", "--vary", &vary, "--out", &to,
        ]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}");
        let text = std::fs::read(out.join("result.json")).expect("a result");
        let found: BudgetResult = serde_json::from_slice(&text).expect("a budget");
        let points = found.sweep.expect("a sweep").points;
        let sigma = |k: usize| {
            let reported = points[k].paths[0].reported.clone().expect("reported");
            reported.standard_deviation.expect("sigmas")[parameter].expect("a sigma")
        };
        assert!(
            sigma(1) > 1.2 * sigma(0),
            "{name}: {} {}",
            sigma(0),
            sigma(1)
        );
        assert!(out.join("sweep.csv").exists());
    }
}

/// Ctrl-C while trials run, for each procedure: exit code 130, what is done is kept, and continuing gives the bytes of an undisturbed
/// run.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done_for_every_procedure() {
    for (name, trials) in [("usbl.toml", "40"), ("rail-thin.toml", "5")] {
        let folder = tempfile::tempdir().expect("folder");
        let file = scenario(name);
        let file = file.to_string_lossy();
        let [out, fresh] = ["out", "fresh"].map(|f| folder.path().join(f));
        let base = |to: &Path| {
            let to = to.to_string_lossy().into_owned();
            [
                "budget", &file, "--trials", trials, "--single", "2", "--out", &to, "--quiet",
            ]
            .map(str::to_owned)
            .to_vec()
        };
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("boresight"))
            .args(base(&out))
            .spawn()
            .expect("the program runs");
        let ledger = out.join("trials/together.csv");
        let lines = || std::fs::read_to_string(&ledger).map_or(0, |t| t.lines().count());
        while lines() < 4 {
            assert!(child.try_wait().expect("a child").is_none(), "ended early");
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let mut kill = std::process::Command::new("kill");
        let sent = kill.args(["-INT", &child.id().to_string()]).status();
        assert!(sent.expect("kill").success());
        let code = child.wait().expect("an end").code();
        assert_eq!(code, Some(130), "{name}");
        assert!(!out.join("result.json").exists());
        let mut resumed = base(&out);
        resumed.push("--resume".to_owned());
        for arguments in [resumed, base(&fresh)] {
            let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
            assert_eq!(command(&words).status.code(), Some(0), "{name}");
        }
        for file in [
            "result.json",
            "budget.csv",
            "trials/together.csv",
            "trials/nothing.csv",
        ] {
            let bytes = |f: &Path| std::fs::read(f.join(file)).expect("bytes");
            assert!(bytes(&out) == bytes(&fresh), "{name}: {file}");
        }
    }
}

/// Parts of an array job, joined in any order, are one run to the last byte: ledgers, tables and results, with a sweep and each source
/// alone, for every procedure.
#[test]
fn joined_parts_are_one_run_for_every_procedure() {
    let folder = tempfile::tempdir().expect("folder");
    for procedure in boresight::procedures::ALL {
        let name = procedure.name();
        let (vary, single) = match name {
            "pool" => ("multibeam.range_sigma_m=0.01,0.02", ""),
            "usbl" => ("", "2"),
            _ => ("", ""),
        };
        let file = folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, crate::common::thin(*procedure)).expect("written");
        let of = |out: &str| folder.path().join(format!("{name}-{out}"));
        let run = |out: &str, words: &[&str]| {
            let (file, to) = (file.to_string_lossy(), of(out));
            let to = to.to_string_lossy();
            let mut all = vec!["budget", &*file, "--out", &to, "--quiet"];
            all.extend(words);
            if !vary.is_empty() {
                all.extend(["--vary", vary]);
            }
            command(&all)
        };
        let parted = |seed: &'static str, trials: &'static str, single: &'static str| {
            let mut words = vec!["--trials", trials, "--seed", seed];
            if !single.is_empty() {
                words.extend(["--single", single]);
            }
            words
        };
        let ended = |output: Output| {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(0), "{name}: {said}");
        };
        for (part, words) in [("b", parted("5", "1", "")), ("a", parted("3", "2", single))] {
            ended(run(part, &[&words[..], &["--only-trials"]].concat()));
            assert!(!of(part).join("result.json").exists());
        }
        let parts = ["b", "a"].map(|part| of(part).to_string_lossy().into_owned());
        ended(run(
            "joined",
            &["--join", &parts[0], &parts[1], "--trials", "3"],
        ));
        ended(run("whole", &parted("3", "3", single)));
        let whole = files_below(&of("whole"));
        assert!(
            whole.len() > 3 && files_below(&of("joined")) == whole,
            "{name}"
        );

        let refused = run("never", &["--join", &parts[0], &parts[1], "--trials", "4"]);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            said.contains("--trials 4: found 3 trials in the parts from seed 3 on"),
            "{said}"
        );
        assert_eq!(refused.status.code(), Some(2));
        assert!(!of("never").exists(), "{said}");
    }
}

#[test]
fn a_key_varied_twice_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    for (verb, key) in [("budget", "pass.0.speed_m_s"), ("plan", "drift")] {
        let out = folder.path().join(verb);
        let (first, second) = (format!("{key}=1,2"), format!("{key}=3"));
        let file = scenario("demo.toml");
        let arguments = [
            verb,
            &file.to_string_lossy(),
            "--out",
            &out.to_string_lossy(),
        ];
        let all = [&arguments[..], &["--vary", &first, "--vary", &second]].concat();
        let output = command(&all);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(&format!("--vary {key}: found twice")),
            "{said}"
        );
        assert!(!out.exists());
    }
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
