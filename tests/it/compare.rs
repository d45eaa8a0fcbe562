//! `boresight compare`: two surveys of one mounting, the same with the mounting turned, and results that cannot be compared.

use std::path::Path;

use boresight::geometry::rotation;
use nalgebra::{Matrix3, Vector3};
use serde_json::Value;

use crate::common::{run, simulated, words};

const THIN: &str = include_str!("../../models/scenarios/usbl-thin.toml");

/// Two surveys of the same mounting under different seeds, calibrated.
fn calibrated() -> tempfile::TempDir {
    let folder = simulated(THIN);
    let here = folder.path();
    let made = run(
        &["simulate", "s.toml", "--seed", "99", "--out", "later"],
        here,
    );
    assert_eq!(made.status.code(), Some(0), "{}", words(&made));
    for (survey, out) in [("survey", "before"), ("later", "after")] {
        let survey = format!("{survey}/survey.toml");
        let done = run(
            &["calibrate", &survey, "--out", out, "--method", "joint"],
            here,
        );
        assert_eq!(done.status.code(), Some(0), "{}", words(&done));
    }
    folder
}

fn compared(folder: &Path, after: &str) -> (Option<i32>, String, String) {
    let done = run(&["compare", "before/result.json", after], folder);
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    (done.status.code(), said, words(&done))
}

/// Changes the later result and writes it as `changed.json`.
fn changed(folder: &Path, change: impl Fn(&mut Value)) {
    let text = std::fs::read_to_string(folder.join("after/result.json")).expect("a result");
    let mut result: Value = serde_json::from_str(&text).expect("JSON");
    change(&mut result);
    std::fs::write(folder.join("changed.json"), result.to_string()).expect("written");
}

/// Turns the joint mounting about the body's up axis.
fn turn(result: &mut Value, angle_rad: f64) {
    let rows = &mut result["solutions"]["joint"]["mountings"][0]["rotation_matrix"];
    let numbers = rows.as_array().into_iter().flatten();
    let numbers: Vec<f64> = numbers
        .flat_map(|row| row.as_array().into_iter().flatten())
        .filter_map(Value::as_f64)
        .collect();
    let found = Matrix3::from_row_slice(&numbers);
    let turned = rotation::exp(&(Vector3::z() * angle_rad)) * found;
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        rows[i][j] = turned[(i, j)].into();
    }
}

#[test]
fn a_mounting_that_stayed_has_not_changed_and_one_that_was_turned_has() {
    let folder = calibrated();
    let here = folder.path();
    let (code, said, error) = compared(here, "after/result.json");
    assert_eq!(code, Some(0), "{said}{error}");
    assert!(said.starts_with("No change of the mounting"), "{said}");
    assert!(
        said.lines().all(|line| line.chars().count() <= 80),
        "{said}"
    );

    // yaw has a sigma of 0.04 deg in each: half a degree is nine sigmas of the difference
    changed(here, |result| turn(result, 0.5f64.to_radians()));
    let (code, said, error) = compared(here, "changed.json");
    assert_eq!(code, Some(1), "{said}{error}");
    assert!(said.starts_with("The mounting has changed."), "{said}");
    let yaw = said.lines().find(|line| line.contains("yaw"));
    assert!(yaw.is_some_and(|line| line.ends_with("changed")), "{said}");
}

#[test]
fn a_result_with_itself_shares_its_files() {
    let folder = calibrated();
    let (code, said, error) = compared(folder.path(), "before/result.json");
    assert_eq!(code, Some(0), "{error}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("share no observations"), "{said}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = calibrated();
    let here = folder.path();
    type Spoil = fn(&mut Value);
    let wrong: [(&str, Spoil); 3] = [
        ("the second result is not usable", |r| {
            r["usable"] = false.into();
        }),
        ("without a covariance", |r| {
            r["solutions"]["joint"]["covariance"] = Value::Null;
        }),
        ("no mounting of the same name", |r| {
            r["solutions"]["joint"]["mountings"] = Value::Array(vec![]);
        }),
    ];
    for (wanted, change) in wrong {
        changed(here, change);
        let (code, said, error) = compared(here, "changed.json");
        assert_eq!((code, said.as_str()), (Some(2), ""), "{error}");
        assert!(error.contains(wanted), "{error}");
    }
}
