//! "Is that enough?": an error budget answers yes or no.

use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn budget(arguments: &[&str]) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().expect("folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_boresight"));
    command.args([
        "budget",
        &format!("{ROOT}/models/scenarios/single-pass-thin.toml"),
    ]);
    command
        .args(arguments)
        .arg("--out")
        .arg(folder.path().join("out"));
    let output = command.output().expect("ran");
    let text = |bytes: &[u8]| {
        String::from_utf8_lossy(bytes)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

#[test]
fn the_budget_says_at_which_values_the_wanted_is_reached() {
    // yaw of the joint path is 0.109 deg at 1 mm of drift and 0.118 deg at 5 mm; at 20 mm the single pass gives nothing
    let vary = "trajectory.position_drift_sigma_m=0.001,0.005,0.02";
    let (code, said, _) = budget(&["--vary", vary, "--wanted", "yaw=0.115"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("Wanted: yaw 0.115 deg."), "{said}");
    assert!(said.contains("The joint path reaches it at 0.001 and does not at 0.005 (yaw 0.118 deg), 0.02 (no result) (trajectory position drift sigma, m)."), "{said}");
    assert!(
        said.contains("No figures at 0.02: "),
        "a value without figures is said: {said}"
    );
}

#[test]
fn a_budget_without_a_sweep_answers_too() {
    let (_, said, _) = budget(&["--wanted", "yaw=0.2,lx=1"]);
    assert!(
        said.contains("Wanted: yaw 0.200 deg, lx 1.00 mm. The joint path reaches it."),
        "{said}"
    );
    let (_, said, _) = budget(&["--wanted", "yaw=0.02"]);
    assert!(
        said.contains("The joint path does not reach it: yaw 0.1"),
        "{said}"
    );
}

#[test]
fn an_answer_by_trials_says_how_good_it_is() {
    let (_, said, _) = budget(&["--trials", "3", "--wanted", "yaw=5"]);
    assert!(
        said.contains(
            "The joint path reaches it. By 3 usable of 3 trials: a figure is good to 50 %."
        ),
        "{said}"
    );
}

#[test]
fn a_wanted_of_nothing_that_is_estimated_is_refused() {
    let (code, _, said) = budget(&["--wanted", "heading=0.2"]);
    assert_eq!(code, Some(2));
    assert!(
        said.contains("--wanted: found \"heading\", expected one of pitch, roll, yaw"),
        "{said}"
    );
    let (code, _, said) = budget(&["--wanted", "yaw=1,yaw=2"]);
    assert!(
        code == Some(2) && said.contains("found \"yaw\" twice"),
        "{said}"
    );
    let (code, _, said) = budget(&["--wanted", "yaw=-1"]);
    assert_eq!(code, Some(2), "{said}");
}

/// A sweep needs a scenario: a survey says so instead of being read as one.
#[test]
fn a_survey_with_vary_is_refused_in_words() {
    let thin = include_str!("../../models/scenarios/single-pass-thin.toml");
    let folder = crate::common::simulated(thin);
    let vary = "trajectory.position_drift_sigma_m=0.001,0.005";
    let arguments = ["budget", "survey/survey.toml", "--vary", vary];
    let output = crate::common::run(&arguments, folder.path());
    let said = crate::common::words(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("expected a scenario (or demo) with --vary"),
        "{said}"
    );
}

/// A folder that a demo left behind does not stand in the way of the built-in scenario.
#[test]
fn a_folder_called_demo_is_no_scenario() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("demo")).expect("a folder");
    let arguments = ["simulate", "demo", "--out", "survey"];
    let output = crate::common::run(&arguments, folder.path());
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        crate::common::words(&output)
    );
}
