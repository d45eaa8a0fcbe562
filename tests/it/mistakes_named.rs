//! Mistakes in the files of a survey, named by the commands: `check` before anything is solved, and `calibrate` of a seabed survey.

use std::path::Path;

use crate::common::{change_column, run, simulated, words};
use serde_json::Value;

const POOL: &str = include_str!("../../models/scenarios/single-pass-thin.toml");
const USBL: &str = include_str!("../../models/scenarios/usbl-thin.toml");
const RAIL: &str = include_str!("../../models/scenarios/rail-thin.toml");
const SEABED: &str = include_str!("../../models/scenarios/seabed-thin.toml");

/// Reverses the sign of a column of a CSV file.
fn negate(path: &Path, column: &str) {
    change_column(path, column, |_, value| -value);
}

/// What `check` says of a survey with a column's sign reversed, and that it says no such thing of the survey as it is.
fn checked(scenario: &str, file: &str, column: &str) -> (Value, String) {
    let folder = simulated(scenario);
    let check = |arguments: &[&str]| run(arguments, folder.path());
    let right = check(&["check", "survey/survey.toml"]);
    assert_eq!(right.status.code(), Some(0), "{}", words(&right));
    let said = String::from_utf8_lossy(&right.stdout).into_owned();
    assert!(!said.contains("mistake"), "{said}");
    negate(&folder.path().join("survey").join(file), column);
    let wrong = check(&["check", "survey/survey.toml"]);
    assert_eq!(wrong.status.code(), Some(1), "{}", words(&wrong));
    let json = check(&["check", "survey/survey.toml", "--json"]);
    let json = serde_json::from_slice(&json.stdout).expect("JSON");
    (json, String::from_utf8_lossy(&wrong.stdout).into_owned())
}

#[test]
fn check_names_a_sign_of_the_pool_s_roll() {
    let (json, said) = checked(POOL, "trajectory.csv", "roll_deg");
    assert_eq!(json["mistake"]["code"], "sign_of_roll", "{said}");
    assert!(
        said.contains("It looks like a mistake: with the sign of roll reversed"),
        "{said}"
    );
}

#[test]
fn check_names_a_sign_of_the_rail_s_table() {
    let (json, said) = checked(RAIL, "table.csv", "heading_deg");
    assert_eq!(json["mistake"]["code"], "sign_of_table_heading", "{said}");
}

#[test]
fn check_names_what_is_wrong_with_the_fixes() {
    let folder = simulated(USBL);
    let path = folder.path().join("survey/fixes.csv");
    let text = std::fs::read_to_string(&path).expect("a file");
    let swapped = |line: &str| match line {
        line if line.contains(",B1,") => line.replace(",B1,", ",B2,"),
        line => line.replace(",B2,", ",B1,"),
    };
    let all: Vec<String> = text.lines().map(swapped).collect();
    std::fs::write(&path, all.join("\n") + "\n").expect("written");
    let check = run(&["check", "survey/survey.toml"], folder.path());
    assert_eq!(check.status.code(), Some(1), "{}", words(&check));
    let said = String::from_utf8_lossy(&check.stdout).into_owned();
    assert!(said.contains("beacons B1 and B2 exchanged"), "{said}");
}

/// The lines' own surfaces fall apart, and the adjustment does not come to rest: that used to be all that was said.
#[test]
fn a_sign_of_a_seabed_survey_s_roll_is_named() {
    let folder = simulated(SEABED);
    negate(&folder.path().join("survey/trajectory.csv"), "roll_deg");
    let arguments = [
        "calibrate",
        "survey/survey.toml",
        "--method",
        "joint",
        "--out",
        "out",
    ];
    let output = run(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    let result = std::fs::read(folder.path().join("out/result.json")).expect("written");
    let result: Value = serde_json::from_slice(&result).expect("JSON");
    let first = &result["verdict"]["findings"][0];
    assert_eq!(first["code"], "sign_of_roll", "{first:#}");
}
