//! Limits, special files and the user's files.

use std::path::Path;
use std::process::Command;

use boresight::procedures;

use super::{ROOT, accepted, fixture, names, refused, survey_folder};
use crate::common::thin;

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

/// What a command says that must end with 2, and soon: whoever opens a pipe waits for a writer who never comes.
#[cfg(unix)]
fn refused_soon(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(super::PROGRAM);
    command.args(arguments).current_dir(folder);
    command.stdout(std::process::Stdio::null());
    command.stderr(std::process::Stdio::piped());
    let mut child = command.spawn().expect("started");
    let begun = std::time::Instant::now();
    while child.try_wait().expect("a state").is_none() {
        if begun.elapsed().as_secs() > 60 {
            let _ = child.kill();
            panic!("{arguments:?} waits");
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let output = child.wait_with_output().expect("output");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    said
}

#[cfg(unix)]
#[test]
fn no_procedure_waits_for_a_pipe() {
    for procedure in procedures::ALL {
        let scenario = procedure.name();
        let folder = tempfile::tempdir().expect("folder");
        std::fs::write(folder.path().join("scenario.toml"), thin(*procedure)).expect("written");
        accepted(folder.path(), &["simulate", "scenario.toml", "--out", "s"]);
        let survey = folder.path().join("s");
        let text = std::fs::read_to_string(survey.join("survey.toml")).expect("text");
        let inputs = names(&survey);
        let inputs = inputs.iter().filter(|n| text.contains(&format!("\"{n}\"")));
        let inputs: Vec<&String> = inputs.collect();
        assert!(!inputs.is_empty(), "{scenario}: {text}");
        for input in inputs {
            let (path, kept) = (survey.join(input), folder.path().join("kept"));
            std::fs::rename(&path, &kept).expect("renamed");
            let made = Command::new("mkfifo").arg(&path).status();
            if !made.is_ok_and(|status| status.success()) {
                eprintln!("skipped: no pipes can be made here");
                return;
            }
            let said = refused_soon(&survey, &["check", "survey.toml"]);
            assert!(
                said.contains(input.as_str()) && said.contains("special file"),
                "{scenario}, {input}: {said}"
            );
            std::fs::remove_file(&path).expect("removed");
            std::fs::rename(&kept, &path).expect("renamed");
        }
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
