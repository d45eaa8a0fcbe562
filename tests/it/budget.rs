//! Error budgets by Monte Carlo: interrupted and continued, on one and two threads, one source only, sweeps, the command line.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::budget::experiment::{Ended, Experiment, ledger_of};
use boresight::budget::{statistics, summary};
use boresight::calibrate::tried::{Acting, Trial, Tried};
use boresight::calibrate::vary::points;
use boresight::procedures::pool::budget::sources::{acting, alone};
use boresight::procedures::pool::budget::trials::{Configuration, PoolTrials, errors};
use boresight::procedures::pool::{Method, PoolInput, SequentialConfig, calibrate};
use boresight::report::budget::{from_slice, sweep_table, table, to_bytes};
use boresight::results::{BudgetResult, Figures, JOINT, SweepValue};
use boresight::simulate::{Scenario, Source, simulate};
use serde_json::Value;

/// A survey that is quickly simulated and calibrated.
fn thin() -> String {
    let text = include_str!("../../models/scenarios/single-pass-thin.toml");
    let mut text = text.to_owned();
    for (from, to) in [
        ("\nrate_hz = 25.0", "\nrate_hz = 10.0"),
        ("line_rate_hz = 10.0", "line_rate_hz = 5.0"),
        ("points_per_line = 110", "points_per_line = 80"),
        ("ping_rate_hz = 5.0", "ping_rate_hz = 4.0"),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

fn scenario() -> Scenario {
    Scenario::from_toml(&thin()).expect("a scenario")
}

fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build().expect("a pool").install(work)
}

fn tried(scenario: Scenario) -> PoolTrials {
    PoolTrials {
        scenario,
        configuration: Configuration::default(),
    }
}

/// Two sources of the five that act, to be quick, and a sweep.
fn small(tried: &PoolTrials) -> Experiment<'_> {
    let vary = ["multibeam.range_sigma_m=0.005,0.02"
        .parse()
        .expect("a sweep")];
    let mut experiment = Experiment::new(tried, 5, 6, 3);
    experiment.cells.truncate(4);
    experiment.with_sweep(points(&vary), 2).expect("points")
}

fn result(experiment: &Experiment<'_>, folder: &Path) -> BudgetResult {
    let mut result = summary::frame(experiment.tried);
    summary::fill(&mut result, experiment, folder).expect("figures");
    result
}

/// All files of a folder by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            let entry = entry.expect("an entry");
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, std::fs::read(entry.path()).expect("bytes"))
        })
        .collect();
    all.sort();
    all
}

/// Runs until about `after` trials are done in this call.
fn some(experiment: &Experiment<'_>, folder: &Path, after: u64) -> Ended {
    let done = experiment.prepare(folder, true).expect("ledgers");
    let (before, stop) = (done.iter().sum::<u64>(), AtomicBool::new(false));
    let progress = |all: u64| stop.store(all - before >= after, SeqCst);
    experiment
        .run(folder, &done, &stop, &progress)
        .expect("a run")
}

#[test]
fn an_interrupted_run_that_is_continued_gives_the_bytes_of_one_that_was_not() {
    let tried = tried(scenario());
    let experiment = small(&tried);
    let folder = tempfile::tempdir().expect("folder");
    let place = |name: &str| folder.path().join(name);
    let never = AtomicBool::new(false);
    let whole = on_threads(2, || {
        let done = experiment.prepare(&place("whole"), false).expect("ledgers");
        experiment.run(&place("whole"), &done, &never, &|_| {})
    });
    assert_eq!(whole.expect("a run"), Ended::Complete);

    // stopped within the first cell, within a later one, torn by a crash, on other numbers of threads each time
    let first = on_threads(1, || some(&experiment, &place("parts"), 2));
    assert_eq!(first, Ended::Interrupted { done: 2, of: 17 });
    let ledger = ledger_of(&place("parts"), &experiment.cells[0]);
    let bytes = std::fs::read(&ledger).expect("bytes");
    std::fs::write(&ledger, &bytes[..bytes.len() - 7]).expect("torn");
    let second = on_threads(2, || some(&experiment, &place("parts"), 7));
    assert!(
        matches!(
            second,
            Ended::Interrupted {
                done: 8 | 9,
                of: 17
            }
        ),
        "{second:?}"
    );
    let third = on_threads(1, || some(&experiment, &place("parts"), 1000));
    assert_eq!(third, Ended::Complete);

    assert_eq!(files(&place("whole")), files(&place("parts")));
    let (a, b) = (
        result(&experiment, &place("whole")),
        result(&experiment, &place("parts")),
    );
    assert_eq!(to_bytes(&a).expect("JSON"), to_bytes(&b).expect("JSON"));
    assert_eq!(table(&a), table(&b));
    assert_eq!(from_slice(&to_bytes(&a).expect("JSON")).expect("read"), a);

    // fewer trials are asked for than are there: those of the first seeds
    let fewer = Experiment::new(&tried, 5, 4, 0);
    let found = result(&fewer, &place("whole"));
    let direct: Vec<Trial> = (5..9).map(|seed| tried.trial(seed, Acting::All)).collect();
    let mut expected = statistics::Statistics::new(&tried);
    direct.iter().for_each(|t| expected.add(t));
    for (place, path) in found.paths.iter().enumerate() {
        assert_eq!(path.together, Some(expected.of(place)));
    }
    let sweep = a.sweep.as_ref().expect("a sweep");
    assert_eq!(sweep.points[1].values, [SweepValue::Number(0.02)]);
    let sigma = |k: usize| {
        let joint = &sweep.points[k].paths[0];
        let reported = joint.reported.as_ref().expect("reported");
        let sigmas = reported.standard_deviation.as_ref().expect("sigmas");
        sigmas[3].expect("lx")
    };
    assert!(sigma(1) > 1.5 * sigma(0), "{} {}", sigma(1), sigma(0));
    assert_eq!(
        sweep_table(&a.parameters, sweep).lines().count(),
        1 + 2 * 3 * 6
    );
}

/// The trial's figures are those of the calibrations that a user would run, one for each variant.
#[test]
fn a_trial_is_a_calibration_of_a_simulated_survey() {
    let found = tried(scenario()).trial(3, Acting::All);
    let survey = simulate(&scenario(), 3).expect("a survey");
    let configuration = Configuration::default();
    let run = |sequential: &SequentialConfig| {
        let input = PoolInput {
            campaign: &survey.campaign,
            target: &survey.target,
            prior: &survey.prior,
            method: Method::Both,
            sequential,
            joint: &configuration.joint,
            seed: 3,
            extras: &[],
        };
        let outcome = calibrate(&input, &boresight::watch::Unwatched).expect("a run");
        let joint = outcome.joint.expect("joint");
        let reference = outcome.sequential.expect("ran").expect("an outcome");
        let errors = |m| errors(m, &survey.truth).to_vec();
        (
            errors(&joint.mounting),
            joint.covariance,
            errors(&reference.mounting),
        )
    };
    let literal = run(&configuration.sequential);
    let projected = run(&configuration.projected());
    let said = |path: usize| found.paths[path].as_ref().expect("an answer");
    let covariance = said(0).covariance.as_ref().expect("a covariance");
    assert_eq!(said(0).error, literal.0);
    assert_eq!(covariance.as_slice(), literal.1.as_slice());
    assert_eq!(said(1).error, literal.2);
    assert_eq!(said(2).error, projected.2);
    assert_ne!(literal.2, projected.2);
    let off = |arm: &f64| arm.abs() < 0.2;
    assert!(said(0).error.iter().all(off), "{:?}", said(0).error);
}

/// Only a constant sound-speed error acts: 2 parts in 1000 of ranges around 6 m are some 12 mm off the wall, no scatter beside the
/// bias, no other source, and everything that is in the sum is of this source.
#[test]
fn a_scenario_with_one_source_only() {
    let mut only = scenario();
    only.truth.range_scale = 0.002;
    let only = alone(&only, Source::SoundSpeed);
    assert_eq!(acting(&only), [Source::SoundSpeed]);
    let tried = tried(only);
    let experiment = Experiment::new(&tried, 1, 3, 3);
    let folder = tempfile::tempdir().expect("folder");
    assert_eq!(some(&experiment, folder.path(), 1000), Ended::Complete);
    let result = result(&experiment, folder.path());
    for path in &result.paths {
        let together = path.together.as_ref().expect("trials");
        assert_eq!(together.usable, 3, "{:?}", result.refusals);
        let names: Vec<&str> = path.shares.iter().map(|s| s.source.as_str()).collect();
        assert_eq!(
            names,
            [
                "nothing",
                "sound_speed",
                "association",
                "remainder",
                "interaction"
            ]
        );
        let lx_m = |figures: &Option<Figures>| figures.as_ref().expect("figures")[3].expect("lx");
        let [own, of_source, ties, rest, beyond] =
            [0, 1, 2, 3, 4].map(|k| lx_m(&path.shares[k].bias));
        assert!((lx_m(&together.bias) - own - of_source).abs() < 1e-12);
        assert!(
            rest.abs() < 1e-12 && beyond.abs() < 1e-12 && ties == 0.0,
            "{rest} {beyond} {ties}"
        );
        // ranges are measured short by 1/1.002; off the wall all of them are between 5 and 8 m
        assert!((0.010..0.016).contains(&of_source), "{of_source}");
        assert!(lx_m(&path.shares[1].standard_deviation) < 2e-4);
    }
}

fn run(arguments: &[&str]) -> Output {
    cargo_bin_cmd!("boresight")
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn written(folder: &Path) -> String {
    let file = folder.join("thin.toml");
    std::fs::write(&file, thin()).expect("written");
    file.to_str().expect("UTF-8").to_owned()
}

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

#[test]
fn the_command_writes_its_files_and_continues_only_when_told() {
    let folder = tempfile::tempdir().expect("folder");
    let file = written(folder.path());
    let out = folder.path().join("out");
    let base = ["budget", &file, "--trials", "3", "--out", path(&out)];
    let output = run(&base);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for expected in [
        "Joint path: 3 of 3 trials usable, seeds 1 to 3",
        "Reference path (literal)",
        "Reference path (projected)",
        "NEES",
        "budget.csv",
    ] {
        assert!(said.contains(expected), "{expected} in {said}");
    }
    let three = files(&out.join("trials"));
    assert_eq!(three.len(), 1);

    let again = run(&base);
    assert_eq!(code(&again), 2);
    assert!(text(&again.stderr).contains("continue them with --resume"));
    let other = run(&[&base[..], &["--resume", "--seed", "9"]].concat());
    assert_eq!(code(&other), 2);
    assert!(text(&other.stderr).contains("another first seed: found 1, expected 9"));
    assert_eq!(files(&out.join("trials")), three, "nothing was written");

    let longer = ["budget", &file, "--trials", "5", "--out", path(&out)];
    let json = run(&[&longer[..], &["--resume", "--json"]].concat());
    assert_eq!(code(&json), 0, "{}", text(&json.stderr));
    let found = from_slice(&json.stdout).expect("a result");
    assert_eq!(found.trials, 5);
    assert_eq!(
        json.stdout,
        std::fs::read(out.join("result.json")).expect("bytes")
    );
    let fresh = folder.path().join("fresh");
    let five = [
        "budget",
        &file,
        "--trials",
        "5",
        "--out",
        path(&fresh),
        "--quiet",
    ];
    assert_eq!(code(&run(&five)), 0);
    for name in ["result.json", "budget.csv"] {
        let bytes = |f: &Path| std::fs::read(f.join(name)).expect("bytes");
        assert_eq!(bytes(&out), bytes(&fresh), "{name}");
    }
    assert_eq!(files(&out.join("trials")), files(&fresh.join("trials")));
}

#[test]
fn bad_input_ends_with_two_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    let file = written(folder.path());
    let out = folder.path().join("out");
    let vary = |what: &'static str| vec!["--trials", "3", "--vary", what];
    let cases = [
        (vec!["--trials", "0"], "--trials"),
        (vec!["--trials", "3", "--single", "1"], "--single"),
        (vary("multibeam.beam=3,4"), "nearest known one is \"beams\""),
        (
            vary("multibeam.beams=0,4"),
            "multibeam.beams = 0, expected 2",
        ),
        (vary("multibeam.beams"), "expected KEY=from:to:step"),
        (vary("target.model.wall_length_m=-1,8"), "wall_length_m"),
        (
            [vary("seed=1"), vary("seed=2"), vary("seed=3")]
                .concat()
                .into_iter()
                .filter(|a| !["--trials", "3"].contains(a))
                .chain(["--trials", "3"])
                .collect(),
            "expected one or two",
        ),
    ];
    for (arguments, expected) in cases {
        let base = ["budget", &file, "--out", path(&out)];
        let output = run(&[&base[..], &arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(code(&output), 2, "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert!(!out.exists(), "{arguments:?}");
    }
    let broken = folder.path().join("broken.toml");
    let text_of = thin() + "\n[joint]\ngate_sigma = 2.0\n";
    std::fs::write(&broken, text_of).expect("written");
    let output = run(&[
        "budget",
        path(&broken),
        "--trials",
        "2",
        "--out",
        path(&out),
    ]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("[joint] gate_sigma: found 2.0"), "{said}");
    assert!(!out.exists());
}

/// A survey's own errors propagated must give the standard deviations that its calibration reports. Both come from the same
/// adjustment, by two ways: influences of single errors summed up, and the robust covariance; the latter's factor is estimated from the
/// residuals of some thousand conditions and so known to one or two per cent.
#[test]
fn a_survey_s_budget_agrees_with_its_calibration() {
    let folder = tempfile::tempdir().expect("folder");
    let scenario = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/models/scenarios/single-pass-thin.toml"
    );
    let output = run(&["simulate", scenario, "--out", path(folder.path())]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let survey = folder.path().join("survey.toml");
    let survey = path(&survey);
    let (budget, found) = (folder.path().join("budget"), folder.path().join("found"));
    let output = run(&["budget", survey, "--out", path(&budget)]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let output = run(&["calibrate", survey, "--out", path(&found)]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let json = |folder: &Path| -> Value {
        let text = std::fs::read_to_string(folder.join("result.json")).expect("a result");
        serde_json::from_str(&text).expect("JSON")
    };
    let (budget, found) = (json(&budget), json(&found));
    let reported = &found["solutions"]["joint"]["parameters"];
    let predicted = &budget["paths"][0]["predicted"]["standard_deviation"];
    for (k, name) in ["pitch", "roll", "yaw", "lx", "ly", "lz"]
        .into_iter()
        .enumerate()
    {
        let (p, r) = (predicted[k].as_f64(), reported[k]["sigma"].as_f64());
        let (p, r) = (p.expect("a prediction"), r.expect("a sigma"));
        assert!(
            (p / r - 1.0).abs() < 0.05,
            "{name}: {p} predicted, {r} reported"
        );
    }
}

#[test]
fn a_survey_has_no_trials() {
    let survey = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/csv/survey.toml");
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let output = run(&["budget", survey, "--trials", "2", "--out", path(&out)]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 2, "{said}");
    assert!(said.contains("expected a scenario"), "{said}");
    assert!(!out.exists());
}

/// Ctrl-C while trials run: exit code 130, what is done is kept, and going on gives the bytes of an undisturbed run.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_done() {
    let folder = tempfile::tempdir().expect("folder");
    let file = written(folder.path());
    let out = folder.path().join("out");
    let arguments = ["budget", &file, "--trials", "12", "--out", path(&out)];
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("boresight"))
        .args(arguments)
        .args(["--threads", "2"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program runs");
    let ledger: PathBuf = out.join("trials/together.csv");
    let lines = || std::fs::read_to_string(&ledger).map_or(0, |t| t.lines().count());
    while lines() < 4 {
        assert!(child.try_wait().expect("a child").is_none(), "ended early");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let pid = child.id().to_string();
    let mut kill = std::process::Command::new("kill");
    let sent = kill.args(["-INT", &pid]).status();
    assert!(sent.expect("kill").success());
    let output = child.wait_with_output().expect("an end");
    assert_eq!(code(&output), 130, "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("of 12 trials are kept in"));
    assert!(text(&output.stderr).contains("continue with the same command and --resume"));
    assert_eq!(text(&output.stdout), "");
    assert!(!out.join("result.json").exists());
    let kept = lines() - 2;
    assert!((2..12).contains(&kept), "{kept}");

    let rest = run(&[&arguments[..], &["--resume", "--quiet", "--threads", "1"]].concat());
    assert_eq!(code(&rest), 0, "{}", text(&rest.stderr));
    let fresh = folder.path().join("fresh");
    let whole = [
        "budget",
        &file,
        "--trials",
        "12",
        "--out",
        path(&fresh),
        "--quiet",
    ];
    assert_eq!(code(&run(&whole)), 0);
    let bytes = |f: &Path| std::fs::read(f.join("result.json")).expect("bytes");
    assert_eq!(bytes(&out), bytes(&fresh));
    assert_eq!(files(&out.join("trials")), files(&fresh.join("trials")));
    let found = from_slice(&bytes(&out)).expect("a result");
    let joint = &found.paths[0];
    assert_eq!(joint.path, JOINT);
    assert_eq!(joint.together.as_ref().map(|t| t.trials), Some(12));
}

/// The same scenario in another folder, and under a path from elsewhere: the same bytes.
#[test]
fn the_place_of_the_scenario_leaves_no_trace() {
    let bytes = |folder: &Path| {
        let file = written(folder);
        let output = run(&[
            "budget",
            &file,
            "--trials",
            "2",
            "--out",
            path(&folder.join("out")),
        ]);
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
        ["result.json", "report.html"]
            .map(|name| std::fs::read(folder.join("out").join(name)).expect("bytes"))
    };
    let (here, there) = (
        tempfile::tempdir().expect("folder"),
        tempfile::tempdir().expect("folder"),
    );
    assert_eq!(bytes(here.path()), bytes(there.path()));
}

/// Latency and range scale as unknowns are parameters like the six: their pulls are judged too, the reference path knows nothing of
/// them, and the figures of the six stay what they are.
#[test]
fn optional_unknowns_are_parameters_of_the_budget() {
    let mut tried = tried(scenario());
    tried.configuration.joint.latency = true;
    tried.configuration.joint.range_scale = true;
    let experiment = Experiment::new(&tried, 1, 3, 0);
    let folder = tempfile::tempdir().expect("folder");
    assert_eq!(some(&experiment, folder.path(), 1000), Ended::Complete);
    let result = result(&experiment, folder.path());
    let names: Vec<&str> = result.parameters.iter().map(|p| &*p.name).collect();
    assert_eq!(names[6..], ["latency", "range scale"]);
    let [joint, reference] = [0, 1].map(|k| result.paths[k].together.as_ref().expect("figures"));
    let bias = joint.bias.as_ref().expect("a bias");
    assert!(bias.iter().all(Option::is_some), "{bias:?}");
    let reported = joint.reported.as_ref().expect("a covariance");
    assert_eq!(reported.pull_rms.len(), 8);
    assert_eq!(reported.nees.expect("NEES").parameters, 8);
    let bias = reference.bias.as_ref().expect("a bias");
    assert!(
        bias[5].is_some() && bias[6].is_none() && bias[7].is_none(),
        "{bias:?}"
    );
}

/// The C library takes the code of an older CPU; where there is no such library the variable says nothing, and the bytes are equal too.
#[test]
fn the_bytes_do_not_depend_on_the_c_library_s_code() {
    const OLDER: [(&str, &str); 2] = [
        ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"),
        ("LC_ALL", "C"),
    ];
    let folder = tempfile::tempdir().expect("folder");
    for name in ["three-pass-thin", "usbl-thin"] {
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/scenarios");
        let scenario = models.join(format!("{name}.toml"));
        let of = |out: &str, older: bool| {
            let out = folder.path().join(format!("{name}-{out}"));
            let mut command = cargo_bin_cmd!("boresight");
            command.args([
                "budget",
                path(&scenario),
                "--trials",
                "4",
                "--out",
                path(&out),
            ]);
            if older {
                command.envs(OLDER);
            }
            assert_eq!(code(&command.output().expect("a run")), 0);
            (
                files(&out.join("trials")),
                std::fs::read(out.join("result.json")).expect("bytes"),
            )
        };
        assert!(of("here", false) == of("older", true), "{name}");
    }
}
