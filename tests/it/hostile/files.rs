//! Limits, special files and the user's files.

use std::path::Path;
use std::process::Command;

use super::{ROOT, accepted, fixture, names, refused, survey_folder};

#[test]
fn a_slip_of_the_pen_costs_neither_time_nor_memory() {
    let folder = survey_folder();
    let target = folder.path().join("target.toml");
    let good = std::fs::read_to_string(&target).expect("text");
    let scenario =
        String::from_utf8(fixture("models/scenarios/single-pass-thin.toml")).expect("text");
    for height in ["0.001", "6e-13"] {
        let slip = |text: &str| {
            text.replace(
                "block_height_m = 0.6",
                &format!("block_height_m = {height}"),
            )
        };
        assert_ne!(slip(&good), good);
        std::fs::write(&target, slip(&good)).expect("written");
        let said = refused(folder.path(), &["check", "survey.toml"]);
        assert!(
            said.contains("target.toml: ") && said.contains("block_height_m"),
            "{said}"
        );
        std::fs::write(folder.path().join("s.toml"), slip(&scenario)).expect("written");
        let said = refused(folder.path(), &["simulate", "s.toml", "--out", "out"]);
        assert!(
            said.contains("s.toml: line ") && said.contains("at most 100 blocks"),
            "{said}"
        );
        assert!(!folder.path().join("out").exists());
    }
    let slip = scenario
        .replace("beams = 77", "beams = 30000")
        .replace("ping_rate_hz = 5.0", "ping_rate_hz = 10000.0");
    std::fs::write(folder.path().join("s.toml"), slip).expect("written");
    let said = refused(folder.path(), &["simulate", "s.toml", "--out", "out"]);
    assert!(said.contains("soundings, expected at most"), "{said}");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_inputs() {
    let folder = survey_folder();
    for input in ["survey.toml", "lidar.laz"] {
        let path = folder.path().join(input);
        let kept = std::fs::read(&path).expect("bytes");
        std::fs::remove_file(&path).expect("removed");
        std::os::unix::fs::symlink("/dev/zero", &path).expect("a link");
        let said = refused(folder.path(), &["check", "survey.toml"]);
        assert!(
            said.contains(&format!("{input}: ")) && said.contains("special file"),
            "{said}"
        );
        std::fs::remove_file(&path).expect("removed");
        let made = Command::new("mkfifo").arg(&path).status();
        if made.is_ok_and(|status| status.success()) {
            let said = refused(folder.path(), &["check", "survey.toml"]);
            assert!(said.contains("special file"), "{said}");
            std::fs::remove_file(&path).expect("removed");
        }
        std::fs::write(&path, kept).expect("written");
    }
}

// THE USER'S FILES

#[test]
fn a_survey_is_never_simulated_over() {
    let folder = survey_folder();
    let scenario = Path::new(ROOT).join("models/scenarios/usbl-thin.toml");
    let scenario = scenario.to_str().expect("a path");
    let before = names(folder.path());
    for force in [
        &["simulate", scenario, "--out", "."][..],
        &["simulate", scenario, "--out", ".", "--force"],
    ] {
        let said = refused(folder.path(), force);
        assert!(
            said.contains("survey.toml: ") && said.contains("did not write"),
            "{said}"
        );
    }
    assert_eq!(names(folder.path()), before);
    accepted(folder.path(), &["simulate", scenario, "--out", "new"]);
    accepted(folder.path(), &["simulate", scenario, "--out", "new"]);
    let said = refused(
        folder.path(),
        &["simulate", scenario, "--out", "new", "--seed", "77"],
    );
    assert!(said.contains("--force"), "{said}");
    accepted(
        folder.path(),
        &[
            "simulate", scenario, "--out", "new", "--seed", "77", "--force",
        ],
    );
}

#[test]
fn apply_never_writes_over_an_input() {
    let folder = survey_folder();
    std::fs::write(folder.path().join("notes.laz"), b"mine").expect("written");
    let apply = |out: &'static str| {
        let arguments = [
            "apply",
            "survey.toml",
            "--calibration",
            "none.json",
            "--out",
            out,
        ];
        refused(folder.path(), &[&arguments[..], &["--force"]].concat())
    };
    let said = apply("lidar.laz");
    assert!(
        said.contains("lidar.laz: ") && said.contains("which this run reads"),
        "{said}"
    );
    let said = apply("notes.laz");
    assert!(
        said.contains("notes.laz: ") && said.contains("did not write"),
        "{said}"
    );
    let said = apply("new.laz");
    assert!(said.contains("none.json: "), "{said}");
    let kept = std::fs::read(folder.path().join("lidar.laz")).expect("bytes");
    assert_eq!(kept, fixture("tests/data/csv/lidar.laz"));
    assert_eq!(
        std::fs::read(folder.path().join("notes.laz")).expect("bytes"),
        b"mine"
    );
}

/// A survey may name any file of the machine: what is in it is nobody's business.
#[test]
fn nothing_of_a_foreign_file_is_shown() {
    let folder = survey_folder();
    let secret = "password hunter2\n".repeat(40);
    std::fs::write(folder.path().join("secret"), &secret).expect("written");
    let survey = folder.path().join("survey.toml");
    let good = std::fs::read_to_string(&survey).expect("text");
    for input in [
        "target.toml",
        "trajectory.csv",
        "lidar.laz",
        "multibeam.csv",
    ] {
        let other = good.replace(&format!("\"{input}\""), "\"secret\"");
        assert_ne!(other, good);
        std::fs::write(&survey, other).expect("written");
        let said = refused(folder.path(), &["check", "survey.toml"]);
        assert!(
            said.contains("secret") && !said.contains("hunter2"),
            "{said}"
        );
        assert!(said.lines().count() < 6, "{said}");
    }
    for arguments in [
        &["info", "secret"][..],
        &["check", "secret"],
        &["compare", "secret", "secret"],
    ] {
        let said = refused(folder.path(), arguments);
        assert!(
            said.contains("secret") && !said.contains("hunter2"),
            "{said}"
        );
    }
}
