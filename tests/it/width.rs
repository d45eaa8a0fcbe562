//! Everything that is printed fits 80 columns: every command, every procedure, on the thin scenarios.

use std::path::Path;

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::procedures;
use boresight::results::Calibration;

use crate::common::thin;

/// Widest line, columns.
const WIDTH: usize = 80;

/// What a command prints in a folder, under a locale; the exit code must be one of a run that went through.
fn printed(arguments: &[&str], folder: &Path, locale: &str) -> String {
    let mut command = cargo_bin_cmd!("boresight");
    command.args(arguments).current_dir(folder);
    command.env("COLUMNS", "80").env("LC_ALL", locale);
    let output = command.output().expect("ran");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code().is_some_and(|code| code < 2),
        "{arguments:?}: {said}"
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Fails with the lines that are too wide.
fn fits(arguments: &[&str], folder: &Path) {
    let text = printed(arguments, folder, "C.UTF-8");
    assert!(!text.is_empty(), "{arguments:?}");
    let wide = |line: &&str| line.chars().count() > WIDTH;
    let wide: Vec<&str> = text.lines().filter(wide).collect();
    assert!(wide.is_empty(), "{arguments:?}:\n{}", wide.join("\n"));
}

/// A folder with the scenario `s.toml` and its survey in `v`.
fn surveyed(scenario: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("s.toml"), scenario).expect("written");
    fits(&["simulate", "s.toml", "--out", "v"], folder.path());
    folder
}

#[test]
fn help_fits() {
    let folder = tempfile::tempdir().expect("a folder");
    fits(&["--help"], folder.path());
    for command in [
        "demo",
        "calibrate",
        "simulate",
        "apply",
        "compare",
        "check",
        "info",
        "budget",
        "plan",
        "template",
        "completions",
    ] {
        fits(&[command, "--help"], folder.path());
    }
}

/// Whether a calibration found a mounting: what two calibrations are compared by.
fn has_mounting(result: &Path) -> bool {
    let text = std::fs::read(result).expect("a result");
    let result: Calibration = serde_json::from_slice(&text).expect("JSON");
    let deciding = result.deciding().expect("a solution");
    !deciding.mountings.is_empty()
}

#[test]
fn calibrations_of_every_procedure_fit() {
    for procedure in procedures::ALL {
        let (name, scenario) = (procedure.name(), thin(*procedure));
        let folder = surveyed(&scenario);
        fits(&["check", "v/survey.toml"], folder.path());
        fits(&["calibrate", "v/survey.toml", "--out", "a"], folder.path());
        if name == "pool" {
            let of_reference = [
                "calibrate",
                "v/survey.toml",
                "--method",
                "reference",
                "--out",
                "b",
            ];
            fits(&of_reference, folder.path());
        }
        if has_mounting(&folder.path().join("a/result.json")) {
            fits(
                &["compare", "a/result.json", "a/result.json"],
                folder.path(),
            );
        }
    }
}

#[test]
fn budgets_and_plans_fit() {
    for procedure in procedures::ALL {
        let (name, folder) = (procedure.name(), surveyed(&thin(*procedure)));
        // the pool's is below, without trials
        if name != "pool" {
            fits(
                &["budget", "s.toml", "--trials", "2", "--out", "b"],
                folder.path(),
            );
        }
        if name == "pool" {
            let key = "trajectory.position_drift_sigma_m=0.005,0.01";
            fits(
                &["budget", "s.toml", "--vary", key, "--out", "c"],
                folder.path(),
            );
            fits(&["budget", "v/survey.toml", "--out", "d"], folder.path());
            let narrow = ["--distance", "4,8", "--crab", "-10,0", "--out"];
            for (file, out) in [("s.toml", "p"), ("v/survey.toml", "q")] {
                let all = ["plan", file].into_iter().chain(narrow).chain([out]);
                fits(&all.collect::<Vec<_>>(), folder.path());
            }
        }
    }
}

#[test]
fn an_ascii_locale_gets_ascii() {
    let folder = surveyed(&thin(procedures::ALL[0]));
    let arguments = ["calibrate", "v/survey.toml", "--out", "a"];
    let text = printed(&arguments, folder.path(), "C");
    assert!(text.is_ascii(), "{text}");
    assert!(
        text.contains("Enter these values") && text.contains("----"),
        "{text}"
    );
    let text = printed(&arguments, folder.path(), "C.UTF-8");
    assert!(text.contains("─"), "{text}");
}
