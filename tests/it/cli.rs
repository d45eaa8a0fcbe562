//! The program as a user runs it: exit codes, files written, standard output.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::geometry::ellipsoid::TargetPose;
use boresight::georef::georeference;
use boresight::observe::Mounting;
use boresight::procedures::pool::Scene;
use boresight::procedures::pool::survey;
use boresight::report::json;
use boresight::results::Calibration;

fn run(arguments: &[&str]) -> Output {
    cargo_bin_cmd!("boresight")
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn result(folder: &Path) -> Calibration {
    json::from_slice(&std::fs::read(folder.join("result.json")).expect("result.json"))
        .expect("a result")
}

fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models/scenarios")
        .join(name)
}

/// A survey of a scenario.
fn simulated(name: &str, folder: &Path) -> PathBuf {
    let output = run(&[
        "simulate",
        path(&scenario(name)),
        "--out",
        path(folder),
        "--seed",
        "3",
    ]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    folder.join("survey.toml")
}

#[test]
fn the_demo_writes_a_usable_result_and_says_where() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("demo");
    let output = run(&["demo", "--out", path(&out)]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(
        said.contains("report.html") && said.contains("error against the truth"),
        "{said}"
    );
    assert_eq!(text(&output.stderr), "", "no progress in a pipe");
    let found = result(&out);
    assert!(found.usable && found.comparison.is_some());
    assert!(found.solutions.joint_simple.is_some());
    assert_eq!(found.provenance.inputs.len(), 5);
    let joint = found.solutions.joint.expect("joint");
    assert!(joint.covariance.is_some() && joint.quality.is_some());
    let page = std::fs::read_to_string(out.join("report.html")).expect("report");
    assert!(page.starts_with("<!") || page.starts_with("<html"));

    // the survey that it wrote gives the same result by itself, but for the file's own digest
    let again = folder.path().join("again");
    let output = run(&[
        "calibrate",
        path(&out.join("survey/survey.toml")),
        "--out",
        path(&again),
        "--quiet",
    ]);
    assert_eq!((code(&output), text(&output.stdout)), (0, String::new()));
    let bytes = |f: &Path| std::fs::read(f.join("result.json")).expect("bytes");
    assert_eq!(bytes(&again), bytes(&out));
}

#[test]
fn threads_change_no_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let survey = simulated("single-pass-thin.toml", &folder.path().join("survey"));
    let with = |threads: &str| {
        let out = folder.path().join(threads);
        let output = run(&[
            "calibrate",
            path(&survey),
            "--threads",
            threads,
            "--out",
            path(&out),
            "--json",
        ]);
        assert_eq!(code(&output), 0, "{}", text(&output.stderr));
        let bytes = std::fs::read(out.join("result.json")).expect("result.json");
        assert_eq!(output.stdout, bytes, "--json prints the file");
        bytes
    };
    assert_eq!(with("1"), with("2"));
}

#[test]
fn bad_input_ends_with_2_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let output = run(&[
        "calibrate",
        path(&folder.path().join("no.toml")),
        "--out",
        path(&out),
    ]);
    assert_eq!(code(&output), 2);
    let said = text(&output.stderr);
    assert!(
        said.contains("no.toml") && said.contains("no such file"),
        "{said}"
    );
    assert!(!out.exists());
    for usage in [
        &["calibrate"][..],
        &["nosuch"],
        &["demo", "--threads", "0"],
        &["calibrate", "x", "--method", "magic"],
    ] {
        // in a folder of its own: who ran the README's demo has its folder in the project's
        let output = crate::common::run(usage, folder.path());
        assert_eq!(code(&output), 2, "{usage:?}");
    }
    assert!(!folder.path().join("boresight-demo").exists());
}

#[test]
fn a_second_word_of_a_template_is_refused() {
    let output = run(&["template", "pool", "usbl"]);
    assert_eq!(code(&output), 2);
    let said = text(&output.stderr);
    assert!(said.contains("found a second word \"usbl\""), "{said}");
    assert_eq!(code(&run(&["template", "scenario", "usbl"])), 0);
}

#[test]
fn all_problems_of_a_survey_file_are_listed() {
    let folder = tempfile::tempdir().expect("folder");
    let survey = simulated("single-pass-thin.toml", &folder.path().join("survey"));
    let good = std::fs::read_to_string(&survey).expect("survey");
    let bad = good
        .replace("procedure = \"pool\"", "procedure = \"pol\"")
        .replace("range_sigma_m", "range_sigm_m");
    std::fs::write(&survey, bad).expect("written");
    let out = folder.path().join("out");
    let output = run(&["calibrate", path(&survey), "--out", path(&out)]);
    assert_eq!(code(&output), 2);
    let said = text(&output.stderr);
    assert!(
        said.contains("\"pool\"") && said.matches("nearest: range_sigma_m").count() == 2,
        "{said}"
    );
    assert!(!out.exists());
}

/// A file that does not say what it is for is never read as a pool.
#[test]
fn a_file_names_its_procedure() {
    let folder = tempfile::tempdir().expect("folder");
    let text = std::fs::read_to_string(scenario("single-pass-thin.toml")).expect("a scenario");
    let file = folder.path().join("s.toml");
    for (line, part) in [
        ("", "expected one of \"pool\""),
        ("procedure = \"railway\"", "nearest: \"rail\""),
    ] {
        let changed = text.replace("procedure = \"pool\"", line);
        assert_ne!(changed, text);
        std::fs::write(&file, changed).expect("written");
        for command in ["simulate", "calibrate", "check", "budget", "plan"] {
            let out = folder.path().join("out");
            let mut arguments = vec![command, path(&file)];
            if command != "check" {
                arguments.extend(["--out", path(&out)]);
            }
            let output = run(&arguments);
            assert_eq!(code(&output), 2, "{command}");
            let said = text_of(&output);
            assert!(
                said.contains("procedure") && said.contains(part),
                "{command}: {said}"
            );
            assert!(!out.exists(), "{command} wrote something");
        }
    }
}

fn text_of(output: &Output) -> String {
    text(&output.stderr)
}

#[test]
fn a_plain_wall_is_refused_naming_what_it_cannot_determine() {
    let folder = tempfile::tempdir().expect("folder");
    let survey = simulated("plain-wall.toml", &folder.path().join("survey"));
    let out = folder.path().join("out");
    let output = run(&["calibrate", path(&survey), "--out", path(&out)]);
    assert_eq!(code(&output), 1, "{}", text(&output.stderr));
    let found = result(&out);
    assert!(!found.usable && out.join("report.html").exists());
    let reason = found.reason.expect("a reason");
    assert!(reason.contains("yaw") && reason.contains("lz"), "{reason}");
    let joint = found.solutions.joint.expect("joint");
    assert!(!joint.usable && joint.mountings.is_empty() && joint.covariance.is_none());

    let output = run(&[
        "apply",
        path(&survey),
        "--calibration",
        path(&out.join("result.json")),
        "--out",
        path(&out.join("c.laz")),
    ]);
    assert_eq!(code(&output), 2, "an unusable solution is not applied");
    assert!(text(&output.stderr).contains("solutions.joint") && !out.join("c.laz").exists());

    let output = run(&["check", path(&survey)]);
    assert!(
        text(&output.stdout).contains("only the wall is seen"),
        "{}",
        text(&output.stdout)
    );
}

#[test]
fn help_names_every_command_and_completions_print() {
    let help = text(&run(&["--help"]).stdout);
    for command in [
        "demo",
        "calibrate",
        "simulate",
        "apply",
        "check",
        "completions",
    ] {
        assert!(
            help.contains(&format!("\n  {command} ")),
            "{command} is missing:\n{help}"
        );
        let output = run(&[command, "--help"]);
        assert_eq!(code(&output), 0);
        assert!(
            text(&output.stdout).contains("Usage: boresight"),
            "{command}"
        );
    }
    assert!(help.contains("EXIT CODES") && help.contains("EXAMPLES") && help.contains("FILES"));
    for shell in ["bash", "zsh", "fish"] {
        assert!(
            text(&run(&["completions", shell]).stdout).contains("calibrate"),
            "{shell}"
        );
    }
}

/// A joint mounting of a result.
fn mounting(found: &Calibration) -> Mounting {
    let found = &found.solutions.joint.as_ref().expect("joint").mountings[0];
    let rows = found.rotation_matrix;
    Mounting {
        rotation: nalgebra::Matrix3::from_fn(|i, j| rows[i][j]),
        lever_arm_m: found.lever_arm_m.expect("lever arm").into(),
    }
}

#[test]
fn applied_points_are_the_georeferenced_ones() {
    let folder = tempfile::tempdir().expect("folder");
    let survey = simulated("single-pass-thin.toml", &folder.path().join("survey"));
    let out = folder.path().join("out");
    assert_eq!(
        code(&run(&[
            "calibrate",
            path(&survey),
            "--out",
            path(&out),
            "--method",
            "joint"
        ])),
        0
    );
    let calibration = out.join("result.json");
    let cloud = out.join("cloud.laz");
    let arguments = [
        "apply",
        path(&survey),
        "--calibration",
        path(&calibration),
        "--out",
        path(&cloud),
        "--coordinates",
        "geocentric",
    ];
    let output = run(&arguments);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));

    let loaded = survey::load(&survey).expect("survey");
    let scene = Scene::prepare(&loaded.campaign, &loaded.target, &loaded.pose).expect("scene");
    let mounting = mounting(&result(&out));
    let pose: TargetPose = scene.pose;
    let to_ecef = pose.ecef_from_target();
    let mut reader = las::Reader::from_path(&cloud).expect("cloud");
    let points: Vec<las::Point> = reader
        .read_all()
        .expect("points")
        .points()
        .map(|p| p.expect("a point"))
        .collect();
    assert_eq!(
        points.len(),
        loaded.campaign.laser.len() + loaded.campaign.soundings.len()
    );
    let soundings: Vec<&las::Point> = points.iter().filter(|p| p.point_source_id == 2).collect();
    assert_eq!(soundings.len(), loaded.campaign.soundings.len());
    for (k, point) in soundings.iter().enumerate().step_by(97) {
        assert_eq!(point.gps_time, Some(loaded.campaign.soundings.time_s[k]));
        let at = scene.sounding_pose(k, 0.0).expect("pose");
        let u = scene.beam(k, &at, &mounting).expect("beam").vector_m();
        let expected = to_ecef.rotation.matrix * georeference(&at, &mounting, &u)
            + to_ecef.translation.coordinates;
        let found = nalgebra::Vector3::new(point.x, point.y, point.z);
        assert!((found - expected).amax() < 6e-5, "{k}: {found} {expected}");
    }
    let silent = out.join("silent.json");
    let mut json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&calibration).expect("a result")).expect("JSON");
    json.as_object_mut().expect("an object").remove("usable");
    std::fs::write(&silent, json.to_string()).expect("written");
    let arguments = [
        "apply",
        path(&survey),
        "--calibration",
        path(&silent),
        "--out",
        path(&cloud),
    ];
    let refused = run(&arguments);
    assert_eq!(code(&refused), 2, "a result that does not say it is usable");
    assert!(text(&refused.stderr).contains("usable"));
    let wrong = run(&[
        "apply",
        path(&survey),
        "--calibration",
        path(&survey),
        "--out",
        path(&cloud),
    ]);
    assert_eq!(code(&wrong), 2);
    assert!(
        text(&wrong.stderr).contains("expected a result.json"),
        "{}",
        text(&wrong.stderr)
    );
}

#[test]
fn a_closed_pipe_is_no_error() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_boresight"))
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ended");
    assert_eq!(
        (output.status.code(), text(&output.stderr)),
        (Some(0), String::new())
    );
}
