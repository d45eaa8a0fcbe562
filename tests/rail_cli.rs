//! The rail commands end to end: files, exit codes, bytes, messages.

mod common;

use std::path::Path;

use common::{run, simulated, words};

const THIN: &str = include_str!("../models/scenarios/rail-thin.toml");

fn result(folder: &Path, out: &str) -> serde_json::Value {
    let bytes = std::fs::read(folder.join(out).join("result.json")).expect("a result");
    serde_json::from_slice(&bytes).expect("JSON")
}

/// Simulate, check, calibrate: exit 0, the truth within five sigmas, the same bytes on one and two threads, a page that needs no network.
#[test]
fn a_survey_is_calibrated_and_the_bytes_do_not_depend_on_threads() {
    let folder = simulated(THIN);
    let check = run(&["check", "survey/survey.toml"], folder.path());
    assert_eq!(check.status.code(), Some(0), "{}", words(&check));
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let output = run(
            &[
                "calibrate",
                "survey/survey.toml",
                "--out",
                out,
                "--threads",
                threads,
            ],
            folder.path(),
        );
        assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    }
    for name in ["result.json", "report.html"] {
        let read = |out: &str| std::fs::read(folder.path().join(out).join(name)).expect("written");
        assert!(read("one") == read("two"), "{name} differs");
    }
    let page = std::fs::read_to_string(folder.path().join("one/report.html")).expect("a page");
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    let truth = std::fs::read(folder.path().join("survey/truth.json")).expect("a truth");
    let truth: serde_json::Value = serde_json::from_slice(&truth).expect("JSON");
    let found = result(folder.path(), "one");
    let yaw = &found["solutions"]["joint"]["parameters"][2];
    let error = yaw["correction"].as_f64().expect("a yaw")
        - truth["profilers"][0]["correction_deg"]["yaw"]
            .as_f64()
            .expect("a truth");
    assert!(
        error.abs() < 5.0 * yaw["sigma"].as_f64().expect("a sigma"),
        "{error}"
    );
}

/// A table that did not turn about the vertical: exit 1, a written result that is not usable and says why, matrices empty.
#[test]
fn what_is_not_determined_ends_with_one_and_a_reason() {
    let text = THIN.replace(
        "heading_sweep_deg = [-5.0, 5.0, 1.0]",
        "heading_sweep_deg = [0.0, 0.0, 1.0]",
    );
    let folder = simulated(&text);
    let output = run(
        &["calibrate", "survey/survey.toml", "--out", "out"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    let found = result(folder.path(), "out");
    assert_eq!(found["usable"], false);
    assert!(found["reason"].as_str().expect("a reason").contains("yaw"));
    assert_eq!(
        found["solutions"]["joint"]["covariance"],
        serde_json::Value::Null
    );
    let check = run(&["check", "survey/survey.toml"], folder.path());
    assert_eq!(check.status.code(), Some(1), "{}", words(&check));
}

fn replaced(folder: &Path, file: &str, from: &str, to: &str) {
    let path = folder.join("survey").join(file);
    let text = std::fs::read_to_string(&path).expect("readable");
    assert!(text.contains(from), "{file} has no {from}");
    std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
}

/// Every fault of the survey file at once, with line, found and expected; nothing is written.
#[test]
fn faults_of_a_survey_file_are_listed_together() {
    let folder = simulated(THIN);
    replaced(
        folder.path(),
        "survey.toml",
        "lateral_sigma_m",
        "latteral_sigma_m",
    );
    replaced(
        folder.path(),
        "survey.toml",
        "angle_sigma_deg = 0.005",
        "angle_sigma_deg = -1.0",
    );
    replaced(folder.path(), "survey.toml", "attitude.csv", "nowhere.csv");
    let output = run(
        &["calibrate", "survey/survey.toml", "--out", "out"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(2));
    let said = words(&output);
    for part in [
        "nearest: lateral_sigma_m",
        "angle_sigma_deg",
        "no such file",
        "survey.toml: line",
    ] {
        assert!(said.contains(part), "{part} missing in {said}");
    }
    assert!(!folder.path().join("out").exists());
}

/// Faults of the tables name file, line and column.
#[test]
fn faults_of_the_tables_name_their_place() {
    let cases = [
        (
            "profiles.csv",
            "time_s,profiler",
            "time_s,profile",
            "a column profiler",
        ),
        (
            "table.csv",
            "heading_deg",
            "heading",
            "a column heading_deg",
        ),
        ("attitude.csv", "\n", "\nx", "line 2, column time_s"),
    ];
    for (file, from, to, expected) in cases {
        let folder = simulated(THIN);
        replaced(folder.path(), file, from, to);
        let output = run(
            &["calibrate", "survey/survey.toml", "--out", "out"],
            folder.path(),
        );
        assert_eq!(output.status.code(), Some(2));
        let said = words(&output);
        assert!(said.contains(file) && said.contains(expected), "{said}");
    }
}

#[test]
fn clocks_that_never_meet_are_a_fault() {
    let folder = simulated(THIN);
    let path = folder.path().join("survey/table.csv");
    let text = std::fs::read_to_string(&path).expect("readable");
    let late = text.lines().enumerate().map(|(k, line)| {
        if k == 0 {
            line.to_owned()
        } else {
            format!("9{}", line.replacen(',', ",9", 1))
        }
    });
    let late: Vec<String> = late.collect();
    std::fs::write(&path, late.join("\n")).expect("written");
    let output = run(
        &["calibrate", "survey/survey.toml", "--out", "out"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    assert!(
        words(&output).contains("while the table rests"),
        "{}",
        words(&output)
    );
}

#[test]
fn an_impossible_rail_model_is_refused() {
    let folder = simulated(THIN);
    replaced(
        folder.path(),
        "rail.toml",
        "radius_mm = 13.0",
        "radius_mm = 1.0",
    );
    let output = run(
        &["calibrate", "survey/survey.toml", "--out", "out"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output).contains("corner R13"), "{}", words(&output));
}

#[test]
fn the_demo_needs_no_input() {
    let folder = tempfile::tempdir().expect("folder");
    for time in ["first", "again"] {
        let output = run(&["demo", "rail"], folder.path());
        assert_eq!(output.status.code(), Some(0), "{time}: {}", words(&output));
    }
    assert_eq!(
        result(folder.path(), "boresight-demo-rail")["procedure"],
        "rail"
    );
    let foreign = run(&["demo", "rail", "--out", "."], folder.path());
    assert_eq!(foreign.status.code(), Some(2), "a folder with other files");
    assert!(
        words(&foreign).contains("did not write"),
        "{}",
        words(&foreign)
    );
    assert!(!folder.path().join("result.json").exists());
}
