//! The USBL commands end to end: files, exit codes, bytes, messages.

use std::path::Path;

use crate::common::{run, simulated, words};
use nalgebra::{Matrix3, Vector3};

const THIN: &str = include_str!("../../models/scenarios/usbl-thin.toml");

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

fn matrix(value: &serde_json::Value) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| value[i][j].as_f64().expect("a number"))
}

/// Turn from the true mounting in the joint path's sigmas.
fn pulls(result: &serde_json::Value, truth: &serde_json::Value) -> Vector3<f64> {
    let joint = &result["solutions"]["joint"];
    let found = matrix(&joint["mountings"][0]["rotation_matrix"]);
    let turn = boresight::geometry::rotation::log(
        &(found * matrix(&truth["rotation_matrix"]).transpose()),
    );
    Vector3::from_fn(|i, _| turn[i] / joint["covariance"][i][i].as_f64().expect("a number").sqrt())
}

/// Every kind of record and of coordinates: simulate, calibrate, the truth within 4.5 sigmas (one in 100 000 by chance), and all the
/// same survey.
#[test]
fn every_form_of_files_gives_the_same_result() {
    let mut found = vec![];
    for (records, coordinates) in [
        ("cartesian", "geocentric"),
        ("range_angles", "geodetic"),
        ("time_angles", "local"),
    ] {
        let text = THIN
            .replace(
                "records = \"time_angles\"",
                &format!("records = \"{records}\""),
            )
            .replace(
                "coordinates = \"geocentric\"",
                &format!("coordinates = \"{coordinates}\""),
            );
        let folder = simulated(&text);
        let output = run(
            &["calibrate", "survey/survey.toml", "--out", "o"],
            folder.path(),
        );
        assert_eq!(output.status.code(), Some(0), "{}", words(&output));
        let result = json(&folder.path().join("o/result.json"));
        let truth = json(&folder.path().join("survey/truth.json"));
        assert!(pulls(&result, &truth).amax() < 4.5);
        found.push(matrix(
            &result["solutions"]["joint"]["mountings"][0]["rotation_matrix"],
        ));
    }
    // 1 micrometre or 1e-8 degrees of the files
    assert!((found[0] - found[1]).amax() < 1e-6 && (found[0] - found[2]).amax() < 1e-6);
}

#[test]
fn the_bytes_do_not_depend_on_threads_and_check_solves_nothing() {
    let folder = simulated(THIN);
    let check = run(&["check", "survey/survey.toml"], folder.path());
    assert_eq!(check.status.code(), Some(0), "{}", words(&check));
    let text = String::from_utf8_lossy(&check.stdout).into_owned();
    assert!(
        text.contains("B5 (check)") && text.contains("one plane"),
        "{text}"
    );
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let arguments = [
            "calibrate",
            "survey/survey.toml",
            "--out",
            out,
            "--threads",
            threads,
        ];
        let output = run(&arguments, folder.path());
        assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    }
    for name in ["result.json", "report.html"] {
        let read = |out: &str| std::fs::read(folder.path().join(out).join(name)).expect("written");
        assert!(read("one") == read("two"), "{name} differs");
    }
    let page = std::fs::read_to_string(folder.path().join("one/report.html")).expect("a page");
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
}

#[test]
fn one_beacon_ends_with_1_and_a_reason() {
    let text = THIN.replace("centre_to_corner_m = 4.0", "centre_to_corner_m = 0.0")
        + "\n[[beacons.beacon]]\nname = \"lonely\"\nposition_m = [2.0, 1.0, -6.0]\n";
    let folder = simulated(&text);
    let check = run(&["check", "survey/survey.toml"], folder.path());
    assert_eq!(check.status.code(), Some(1), "{}", words(&check));
    let said = String::from_utf8_lossy(&check.stdout).into_owned();
    assert!(
        said.contains("The mounting cannot be determined."),
        "{said}"
    );
    for method in ["joint", "reference", "both"] {
        let arguments = [
            "calibrate",
            "survey/survey.toml",
            "--out",
            method,
            "--method",
            method,
        ];
        let output = run(&arguments, folder.path());
        assert_eq!(
            output.status.code(),
            Some(1),
            "{method}: {}",
            words(&output)
        );
        let result = json(&folder.path().join(method).join("result.json"));
        assert_eq!(result["usable"], false);
        assert!(result["reason"].as_str().is_some_and(|r| !r.is_empty()));
        for path in ["joint", "reference"] {
            assert!(
                result["solutions"][path]["mountings"][0].is_null(),
                "{method}: {path}"
            );
        }
    }
}

fn spoiled(file: &str, change: impl Fn(&str) -> String) -> String {
    let folder = simulated(THIN);
    let path = folder.path().join("survey").join(file);
    let text = std::fs::read_to_string(&path).expect("a file");
    let changed = change(&text);
    assert_ne!(text, changed, "nothing was spoiled");
    std::fs::write(&path, changed).expect("written");
    let output = run(
        &["calibrate", "survey/survey.toml", "--out", "o"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(2), "{file}: {}", words(&output));
    assert!(!folder.path().join("o").exists(), "something was written");
    words(&output)
}

/// Exit 2, nothing written, and a message that names file and place.
#[test]
fn bad_input_is_named() {
    let keys = spoiled("survey.toml", |t| {
        t.replace("angle_sigma_deg", "angle_sigma")
            .replace("[attitude]", "[atitude]")
    });
    assert!(
        keys.contains("nearest: angle_sigma_deg") && keys.contains("atitude"),
        "{keys}"
    );
    assert!(keys.lines().count() >= 3, "{keys}");
    let role = spoiled("control.csv", |t| t.replace("B3,common", "B3,comon"));
    assert!(role.contains("control.csv: line 5, column role"), "{role}");
    let twice = spoiled("control.csv", |t| t.replace("B3,common", "B2,common"));
    assert!(twice.contains("a second time"), "{twice}");
    let none = spoiled("control.csv", |t| {
        t.replace("transducer,transducer", "transducer,common")
    });
    assert!(none.contains("no row with role transducer"), "{none}");
    let name = spoiled("fixes.csv", |t| t.replace(",B4,", ",B9,"));
    assert!(
        name.contains("line 5, column beacon: found beacon \"B9\", and in 59 more rows")
            && name.contains("B1, B2, B3, B4, B5"),
        "{name}"
    );
    let angle = spoiled("fixes.csv", |t| t.replace("x_angle_deg", "x_deg"));
    assert!(angle.contains("fixes.csv: line 1"), "{angle}");
    let gap = spoiled("attitude.csv", |t| {
        t.lines().take(20).collect::<Vec<_>>().join("\n")
    });
    assert!(
        gap.contains("without attitude") && gap.contains("outside the trajectory"),
        "{gap}"
    );
    let speed = spoiled("sound-speed.csv", |t| t.replace("1482", "148.2"));
    assert!(speed.contains("1300 to 1700"), "{speed}");
    let depth = spoiled("survey.toml", |t| t.replace("depth_m = 1.0\n", ""));
    assert!(depth.contains("[transducer] depth_m"), "{depth}");
}

/// Rows left out before the one that is named do not shift its number.
#[test]
fn lines_are_those_of_the_file_where_rows_were_left_out() {
    let folder = simulated(THIN);
    let survey = folder.path().join("survey");
    let change = |name: &str, change: &dyn Fn(String) -> String| {
        let path = survey.join(name);
        let text = std::fs::read_to_string(&path).expect("a file");
        std::fs::write(&path, change(text)).expect("written");
    };
    change("survey.toml", &|t| {
        t.replace("[fixes]", "[fixes]\ninvalid = \"drop\"")
    });
    change("fixes.csv", &|t| {
        let lines = t.lines().enumerate().map(|(k, line)| match k + 1 {
            3 | 4 => "x".to_owned() + line,
            20 => line.replace(",B", ",C"),
            _ => line.to_owned(),
        });
        lines.map(|line| line + "\n").collect()
    });
    let output = run(&["check", "survey/survey.toml"], folder.path());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("fixes.csv: line 20, column beacon: found beacon \"C"),
        "{said}"
    );
}

#[test]
fn a_bad_scenario_is_named_and_the_demo_runs() {
    let folder = tempfile::tempdir().expect("folder");
    let text = THIN
        .replace("rate_hz = 2.0", "rate = 2.0")
        .replace("range_sigma_m = 0.02", "range_sigma_m = -1.0");
    std::fs::write(folder.path().join("s.toml"), text).expect("written");
    let output = run(&["simulate", "s.toml", "--out", "survey"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(
        words(&output).contains("nearest known one is \"rate_hz\""),
        "{}",
        words(&output)
    );
    let demo = run(&["demo", "usbl", "--out", "d"], folder.path());
    assert_eq!(demo.status.code(), Some(0), "{}", words(&demo));
    let result = json(&folder.path().join("d/result.json"));
    let truth = json(&folder.path().join("d/survey/truth.json"));
    assert!(pulls(&result, &truth).amax() < 4.5);
}

/// What a procedure has no use for is refused, never ignored; nothing is written.
#[test]
fn settings_without_a_use_are_refused() {
    let folder = simulated(THIN);
    for (option, value) in [("--simple", None), ("--seed", Some("3"))] {
        let mut arguments = vec!["calibrate", "survey/survey.toml", "--out", "o", option];
        arguments.extend(value);
        let output = run(&arguments, folder.path());
        assert_eq!(output.status.code(), Some(2), "{option}");
        let said = words(&output);
        assert!(said.contains(option) && said.contains("usbl"), "{said}");
        assert!(!folder.path().join("o").exists());
    }
    let check = run(
        &["check", "survey/survey.toml", "--seed", "3"],
        folder.path(),
    );
    assert_eq!(check.status.code(), Some(2), "{}", words(&check));
}
