//! Whatever stands in `procedures::ALL` has every command, and none of them was told of it: demo, template, simulate, check, calibrate,
//! budget, report, verdict, completion, help, and messages for bad input.

use std::path::Path;

use boresight::calibrate::seam::Procedure;
use boresight::procedures;

use crate::common::{run, simulated, thin, words};

/// Runs a command that must end with this code; what it printed.
fn ended(arguments: &[&str], folder: &Path, code: i32) -> String {
    let output = run(arguments, folder);
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}: {}",
        words(&output)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn each(what: impl Fn(&str, &dyn Procedure, &Path)) {
    for procedure in procedures::ALL {
        let folder = tempfile::tempdir().expect("a folder");
        what(procedure.name(), *procedure, folder.path());
    }
}

fn json(file: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(file).expect("a file");
    serde_json::from_str(&text).expect("JSON")
}

/// A result that may be used, with its report and the procedure's own script on the page.
fn reported(name: &str, out: &Path) {
    let result = json(&out.join("result.json"));
    assert_eq!(result["procedure"], name);
    assert_eq!(result["usable"], true, "{}", result["reason"]);
    let state = result["verdict"]["state"].as_str().unwrap_or_default();
    assert!(state.starts_with("usable"), "{name}: {state}");
    let solutions = result["solutions"].as_object().expect("solutions");
    for path in ["joint", "reference"] {
        assert!(
            solutions[path]["parameters"]
                .as_array()
                .is_some_and(|all| !all.is_empty())
        );
    }
    let page = std::fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(
        page.contains("OWN.push("),
        "{name} adds nothing to the report"
    );
    let table = std::fs::read_to_string(out.join("parameters.csv")).expect("a table");
    assert!(table.lines().count() > 1, "{table}");
}

#[test]
fn every_procedure_has_a_demo_that_ends_with_a_usable_result() {
    each(|name, _, folder| {
        let said = ended(&["demo", name, "--out", "d"], folder, 0);
        assert!(said.contains("truth"), "{name}: {said}");
        reported(name, &folder.join("d"));
    });
}

#[test]
fn every_procedure_simulates_checks_and_calibrates() {
    each(|name, procedure, _| {
        let folder = simulated(&thin(procedure));
        let folder = folder.path();
        assert!(folder.join("survey/truth.json").exists());
        let said = ended(&["check", "survey/survey.toml"], folder, 0);
        assert!(!said.trim().is_empty(), "{name}");
        ended(
            &["calibrate", "survey/survey.toml", "--out", "c"],
            folder,
            0,
        );
        reported(name, &folder.join("c"));
        if !procedure.uses().seed {
            let seeded = ["calibrate", "survey/survey.toml", "--seed", "3"];
            ended(&seeded, folder, 2);
        }
    });
}

#[test]
fn every_procedure_has_a_budget_of_trials() {
    each(|name, procedure, folder| {
        std::fs::write(folder.join("s.toml"), thin(procedure)).expect("written");
        ended(
            &["budget", "s.toml", "--trials", "2", "--out", "b"],
            folder,
            0,
        );
        let result = json(&folder.join("b/result.json"));
        assert_eq!(
            (&result["procedure"], &result["trials"]),
            (&name.into(), &2.into())
        );
        assert!(
            result["sources"]
                .as_array()
                .is_some_and(|all| !all.is_empty())
        );
        assert!(folder.join("b/report.html").exists() && folder.join("b/budget.csv").exists());
    });
}

#[test]
fn every_procedure_stands_in_help_templates_and_completions() {
    each(|name, procedure, folder| {
        let line = format!("  {name:8} {}", procedure.about());
        let help = ended(&["--help"], folder, 0);
        assert!(help.contains(&line), "{help}");
        let template = ended(&["template", name], folder, 0);
        assert!(
            template.contains(&format!("procedure = \"{name}\"")),
            "{template}"
        );
        let scenario = ended(&["template", "scenario", name], folder, 0);
        assert_eq!(scenario, procedure.demo());
        let script = ended(&["completions", "bash"], folder, 0);
        assert!(script.contains(name), "no {name} among the completions");
    });
}

/// A key mistyped in a survey and in a scenario is named with its file and line, and nothing is written.
#[test]
fn every_procedure_names_a_mistyped_key() {
    each(|name, procedure, _| {
        let folder = simulated(&thin(procedure));
        let folder = folder.path();
        let survey = folder.join("survey/survey.toml");
        for (file, arguments) in [
            (survey, ["calibrate", "survey/survey.toml"]),
            (folder.join("s.toml"), ["simulate", "s.toml"]),
        ] {
            let text = std::fs::read_to_string(&file).expect("text");
            std::fs::write(&file, format!("nmae = \"x\"\n{text}")).expect("written");
            let output = run(&[&arguments[..], &["--out", "never"]].concat(), folder);
            let said = words(&output);
            assert_eq!(output.status.code(), Some(2), "{name}: {said}");
            for part in [arguments[1], "line 1", "nmae", "name"] {
                assert!(said.contains(part), "{name}: {part} in {said}");
            }
            assert!(!folder.join("never").exists(), "{name}");
        }
    });
}
