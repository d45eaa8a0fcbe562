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

/// The first finding of a calibration by the joint path of a survey that is changed before; it must not be usable.
fn first_finding(scenario: &str, change: impl Fn(&Path)) -> Value {
    let folder = simulated(scenario);
    change(&folder.path().join("survey"));
    let arguments = "calibrate survey/survey.toml --method joint --out out";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let output = run(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    let result = std::fs::read(folder.path().join("out/result.json")).expect("a result");
    let result: Value = serde_json::from_slice(&result).expect("JSON");
    result["verdict"]["findings"][0].clone()
}

/// Puts another line in place of the sonar's first one that begins like this.
fn put(survey: &Path, begin: &str, line: &str) {
    let path = survey.join("survey.toml");
    let text = std::fs::read_to_string(&path).expect("a file");
    let (before, sonar) = text.split_once("[multibeam]").expect("a sonar");
    let old = sonar.lines().find(|l| l.starts_with(begin)).expect(begin);
    let sonar = sonar.replacen(old, line, 1);
    std::fs::write(&path, format!("{before}[multibeam]{sonar}")).expect("written");
}

/// "No two lines share enough seabed", "the profile cannot be used" and "no piece of seabed was sounded by two lines" was all that was said of the
/// arms, of angles from the horizontal and of gon.
#[test]
fn axes_of_a_seabed_survey_s_arm_and_the_zero_of_its_angles_are_named() {
    for (arm, words) in [
        ("[-1.2, 0.35, 1.1]", "read as forward, right, down"),
        ("[0.35, -1.2, 1.1]", "read as right, forward, down"),
        ("[-0.35, 1.2, 1.1]", "taken the other way round"),
    ] {
        let line = format!("lever_arm_m = {arm}");
        let found = first_finding(SEABED, |survey| put(survey, "lever_arm_m", &line));
        assert_eq!(found["code"], "axes_of_sounder_arm", "{found}");
        let seen = found["seen"].as_str().expect("words");
        assert!(seen.contains(words), "{seen}");
    }
    type Change = fn(f64) -> f64;
    let changes: [(Change, &str); 2] = [
        (|a| (90.0 - a.abs()).copysign(a), "from the horizontal"),
        (|a| a / 0.9, "as gon"),
    ];
    for (change, words) in changes {
        let found = first_finding(SEABED, |survey| {
            let path = survey.join("multibeam.csv");
            change_column(&path, "across_angle_deg", |_, angle| change(angle));
        });
        assert_eq!(found["code"], "beam_angle_unit", "{found}");
        let seen = found["seen"].as_str().expect("words");
        assert!(seen.contains(words), "{seen}");
    }
}

#[test]
fn angles_from_the_horizontal_and_depths_for_ranges_are_named_in_a_pool() {
    let found = first_finding(POOL, |survey| {
        let path = survey.join("multibeam.csv");
        change_column(&path, "across_angle_deg", |_, a: f64| {
            (90.0 - a.abs()).copysign(a)
        });
    });
    assert_eq!(found["code"], "beam_angle_unit", "{found}");
    let found = first_finding(POOL, |survey| {
        let path = survey.join("multibeam.csv");
        let text = std::fs::read_to_string(&path).expect("a file");
        let depth = |line: &str| {
            let (rest, range) = line.rsplit_once(',')?;
            let angle: f64 = rest.split(',').nth(3)?.parse().ok()?;
            let range: f64 = range.parse().ok()?;
            Some(format!("{rest},{}", range * angle.to_radians().cos()))
        };
        let rows = text
            .lines()
            .map(|line| depth(line).unwrap_or(line.to_owned()));
        std::fs::write(&path, rows.collect::<Vec<_>>().join("\n")).expect("written");
    });
    assert_eq!(found["code"], "range_unit", "{found}");
    let seen = found["seen"].as_str().expect("words");
    assert!(seen.contains("taken as depths"), "{seen}");
}

#[test]
fn columns_with_too_few_decimals_are_named() {
    for (scenario, file, column, step) in [
        (POOL, "trajectory.csv", "height_m", 0.1),
        (SEABED, "trajectory.csv", "latitude_deg", 1e-6),
        (USBL, "attitude.csv", "heading_deg", 1.0),
        (RAIL, "attitude.csv", "pitch_deg", 0.1),
    ] {
        let folder = simulated(scenario);
        let path = folder.path().join("survey").join(file);
        let arguments = "calibrate survey/survey.toml --method joint --out out";
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let said = || {
            let output = run(&arguments, folder.path());
            String::from_utf8_lossy(&output.stdout).into_owned()
        };
        let of = format!("{column} comes in steps of {step}");
        assert!(!said().contains("comes in steps of"), "{}", said());
        change_column(&path, column, |_, value| (value / step).round() * step);
        let said: String = said().split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(&of), "{said}");
    }
}

/// "The sound-speed profile cannot be used" was all that was said.
#[test]
fn a_seabed_survey_at_another_place_than_its_origin_is_refused() {
    let folder = simulated(SEABED);
    negate(
        &folder.path().join("survey/trajectory.csv"),
        "longitude_deg",
    );
    let output = run(
        &["calibrate", "survey/survey.toml", "--out", "out"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(2));
    let said = words(&output);
    assert!(
        said.contains("trajectory.csv") && said.contains("km from [site] origin"),
        "{said}"
    );
    assert!(!folder.path().join("out").exists());
}
