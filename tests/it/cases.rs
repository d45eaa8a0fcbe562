//! Surveys and damaged files with a known right ending, read from the folder that `BORESIGHT_CASES` names; what each must end with stands
//! in the folder itself (`wrong-input/cases.json`, `files/*/expect.json`). Without the folder every test says that it is skipped.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use nalgebra::{Matrix3, Vector3};
use serde_json::Value;

use crate::common::{applied, run, words};
use crate::hostile::survey_folder;

/// The first finding, or words of the refusal, of each wrong input; the folder says it in words of its own.
const NAMED: [(&str, &str); 29] = [
    ("attitude-in-radians", "attitude_in_radians"),
    ("roll-negated", "sign_of_roll"),
    ("pitch-negated", "sign_of_pitch"),
    ("heading-negated", "sign_of_heading"),
    ("roll-and-pitch-exchanged", "roll_and_pitch_exchanged"),
    ("pitch-negated-three-passes", "sign_of_pitch"),
    ("roll-negated-three-passes", "sign_of_roll"),
    ("azimuth-180-off", "target_azimuth"),
    ("origin-50-m-off", "target_origin"),
    ("sounder-arm-forward-right-down", "axes_of_sounder_arm"),
    ("scanner-arm-forward-right-down", "axes_of_scanner_arm"),
    ("sounder-20-ms-late", "latency"),
    (
        "sounder-100-ms-late-three-passes",
        "the sensor's time stamps look late",
    ),
    ("ranges-0.3-percent-long-three-passes", "range_scale"),
    ("ranges-doubled", "range_doubled"),
    ("ranges-in-feet", "range_unit"),
    ("ranges-in-millimetres", "is it in millimetres?"),
    ("one-way-time-as-two-way", "one_way_time"),
    ("range-sigma-ten-times-too-small", "range_noise"),
    ("range-sigma-in-millimetres", "is it in millimetres?"),
    ("water-level-1.5-m-off", "water_level"),
    ("time-in-milliseconds", "taken as milliseconds"),
    ("rail/wrong-model", "other_rail"),
    ("rail/ins-heading-5-deg-off", "ins_attitude"),
    ("rail/worn-0.2-mm", "rail_element"),
    ("rail/axes-3-mm-apart", "axes_gap"),
    ("usbl/attitude-in-radians", "attitude_in_radians"),
    ("usbl/beacon-moved-1-m", "beacon"),
    (
        "usbl/unknown-beacon",
        "line 3, column beacon: found beacon \"b2\"",
    ),
];

/// The folder of the cases, or nothing, which is said.
fn cases() -> Option<PathBuf> {
    let folder = std::env::var_os("BORESIGHT_CASES");
    if folder.is_none() {
        eprintln!("skipped: BORESIGHT_CASES is not set");
    }
    folder.map(PathBuf::from)
}

fn json(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&bytes).expect("JSON")
}

/// How a joint calibration ended.
struct Ended {
    name: String,
    code: Option<i32>,
    said: String,
    /// Nothing where the survey was refused.
    result: Option<Value>,
}

impl Ended {
    fn new(name: &str, survey: &Path) -> Self {
        let folder = tempfile::tempdir().expect("folder");
        let survey = survey.join("survey.toml");
        let survey = survey.to_str().expect("a name in UTF-8");
        let arguments = ["calibrate", survey, "--method", "joint", "--out", "out"];
        let output = run(&arguments, folder.path());
        let (code, said) = (output.status.code(), words(&output));
        let written = folder.path().join("out/result.json");
        assert_eq!(written.exists(), code != Some(2), "{name}: {said}");
        let result = written.exists().then(|| json(&written));
        Self {
            name: name.to_owned(),
            code,
            said,
            result,
        }
    }

    fn codes(&self) -> Vec<&str> {
        let findings = self.result.as_ref().map(|r| &r["verdict"]["findings"]);
        let findings = findings.and_then(Value::as_array).into_iter().flatten();
        findings.filter_map(|f| f["code"].as_str()).collect()
    }

    /// Withdrawn with this as its first finding, or refused with these words.
    fn withdrawn(&self, named: &str) {
        let (name, codes) = (&self.name, self.codes());
        match self.code {
            Some(1) => assert_eq!(codes.first(), Some(&named), "{name}: {codes:?}"),
            Some(2) => assert!(self.said.contains(named), "{name}: {}", self.said),
            other => panic!("{name} ended with {other:?}: {codes:?} {}", self.said),
        }
    }

    /// Usable, with this among what there is to say.
    fn usable(&self, named: Option<&str>) {
        let (name, codes) = (&self.name, self.codes());
        assert_eq!(self.code, Some(0), "{name}: {codes:?} {}", self.said);
        if let Some(named) = named {
            assert!(codes.contains(&named), "{name}: {codes:?}");
        }
    }

    /// Largest distance of an angle or a lever arm's component of a sensor from the truth, in its sigma.
    fn pull(&self, sensor: usize, (rotation, arm_m): (&Value, &Value)) -> f64 {
        let joint = &self.result.as_ref().expect("a result")["solutions"]["joint"];
        let mounting = &joint["mountings"][sensor];
        let found = matrix(&mounting["rotation_matrix"]);
        let turn = boresight::geometry::rotation::log(&(found * matrix(rotation).transpose()));
        let arm = vector(&mounting["lever_arm_m"]) - vector(arm_m);
        let off = [turn.map(f64::to_degrees), arm];
        let sigma = |k: usize| joint["parameters"][6 * sensor + k]["sigma"].as_f64();
        let pulls = off.iter().flat_map(|v| v.iter()).enumerate();
        let pulls = pulls.map(|(k, off)| (off / sigma(k).expect("a sigma")).abs());
        pulls.fold(0.0, f64::max)
    }
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|k, _| value[k].as_f64().expect("a number"))
}

fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| value[i][j].as_f64().expect("a number"))
}

/// The pool's surveys with a mistake in each, made by the folder's own script of the development surveys beside it.
fn pool_surveys(cases: &Path) -> Option<tempfile::TempDir> {
    let made = tempfile::tempdir().expect("folder");
    let mut python = Command::new("python3");
    python.arg(cases.join("wrong-input/make.py"));
    python.arg(cases.join("../data/pool")).arg(made.path());
    match python.output() {
        Ok(output) => assert!(output.status.success(), "{}", words(&output)),
        Err(error) => {
            eprintln!("skipped: python3: {error}");
            return None;
        }
    }
    Some(made)
}

/// Every wrong input of the folder that `wanted` says, in its own place or in `made`.
fn wrong_inputs(cases: &Path, made: &Path, wanted: impl Fn(&str) -> bool) {
    let listed = json(&cases.join("wrong-input/cases.json"));
    let listed = listed.as_object().expect("cases by name");
    let own = listed
        .iter()
        .filter(|(name, case)| case.is_object() && wanted(name));
    for (name, case) in own {
        let ended = Ended::new(name, &made.join(name));
        let named = NAMED.iter().find(|(of, _)| of == name);
        let named = named.map(|(_, named)| *named);
        match (name.as_str(), case["usable"].as_bool()) {
            // withdrawn and named, for the gap of its axes is no unknown there
            ("rail/axes-3-mm-apart", _) | (_, Some(false)) => {
                ended.withdrawn(named.unwrap_or_else(|| panic!("{name}: what must be named?")));
            }
            (_, Some(true)) => ended.usable(named),
            (_, None) => panic!("{name}: usable or not?"),
        }
        if name == "rail/wrong-minimum" {
            let truth = json(&made.join(name).join("mytruth.json"));
            for sensor in 0..2 {
                let pull = ended.pull(
                    sensor,
                    (&truth["rotation"][sensor], &truth["lever"][sensor]),
                );
                assert!(pull < 4.0, "{name}: {pull} sigmas");
            }
        }
    }
}

#[test]
fn wrong_inputs_of_a_single_pass_are_named() {
    if let Some(cases) = cases()
        && let Some(made) = pool_surveys(&cases)
    {
        wrong_inputs(&cases, made.path(), |name| {
            !name.contains('/') && !name.ends_with("three-passes")
        });
    }
}

#[test]
fn wrong_inputs_of_three_passes_are_named() {
    if let Some(cases) = cases()
        && let Some(made) = pool_surveys(&cases)
    {
        wrong_inputs(&cases, made.path(), |name| name.ends_with("three-passes"));
    }
}

#[test]
fn wrong_inputs_of_rail_and_usbl_are_named() {
    if let Some(cases) = cases() {
        wrong_inputs(&cases, &cases.join("wrong-input"), |name| {
            name.contains('/')
        });
    }
}

/// The output and what was said.
fn everything(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &words(output)
}

/// Whether a pattern of alternatives of plain words, case ignored, is in a text.
fn matches(pattern: &str, text: &str) -> bool {
    let plain = pattern.replace("(?i)", "").to_lowercase();
    let text = text.to_lowercase();
    assert!(
        !plain.contains(['(', '[', '.', '*', '\\']),
        "{pattern}: more than plain words"
    );
    plain.split('|').any(|words| text.contains(words))
}

/// Bit 0 of the global encoding of a LAS file that `apply` writes: times are adjusted standard GPS time.
fn times_are_standard(survey: &str) -> bool {
    let folder = tempfile::tempdir().expect("folder");
    let calibrated = run(&["calibrate", survey, "--out", "out"], folder.path());
    assert_eq!(calibrated.status.code(), Some(0), "{}", words(&calibrated));
    applied(survey, folder.path());
    let cloud = std::fs::read(folder.path().join("cloud.laz")).expect("a cloud");
    cloud[6] & 1 == 1
}

/// One small survey of a public bug report's kind.
fn ends_as_expected(name: &str, folder: &Path) {
    let expect = json(&folder.join("expect.json"));
    let survey = folder.join("survey.toml");
    let survey = survey.to_str().expect("a name in UTF-8");
    match expect["kind"].as_str() {
        Some("pull") => {
            let ended = Ended::new(name, folder);
            if ended.code == Some(0) {
                let truth = json(&folder.join("truth.json"));
                let pull = ended.pull(0, (&truth["rotation_matrix"], &truth["lever_arm_m"]));
                let most = expect["max_pull"].as_f64().expect("a number");
                assert!(pull <= most, "{name}: usable and {pull} sigmas off");
            }
        }
        Some("count") => {
            let output = run(&["check", survey, "--json"], folder);
            let said: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            let data = said["data"].as_array().expect("files");
            let returns = data.iter().find(|file| file["name"] == "laser returns");
            let returns = returns.expect("returns");
            assert_eq!(returns["records"], expect["want_laser"], "{name}: {said}");
        }
        Some("message") => {
            let output = run(&["check", survey], folder);
            let codes = expect["ok_rc"].as_array().expect("exit codes");
            let ended_well = codes
                .iter()
                .any(|code| code.as_i64() == output.status.code().map(i64::from));
            let pattern = expect["regex"].as_str().expect("a pattern");
            let said = everything(&output);
            assert!(ended_well || matches(pattern, &said), "{name}: {said}");
        }
        Some("applybit") => assert!(times_are_standard(survey), "{name}: bit 0 is cleared"),
        other => panic!("{name}: what is {other:?}?"),
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> = entries
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn small_surveys_of_bug_reports_end_as_expected() {
    let Some(cases) = cases() else { return };
    let files = cases.join("files");
    for name in names(&files)
        .iter()
        .filter(|name| files.join(name).is_dir())
    {
        ends_as_expected(name, &files.join(name));
    }
}

/// Runs the program with a gibibyte of addresses at most, where the shell can say so.
fn within_memory(arguments: &[&str], folder: &Path) -> Output {
    let mut shell = Command::new("sh");
    shell.args([
        "-c",
        "ulimit -v 1048576; exec \"$0\" \"$@\"",
        env!("CARGO_BIN_EXE_boresight"),
    ]);
    shell
        .args(arguments)
        .args(["--threads", "2"])
        .current_dir(folder);
    shell.output().expect("ran")
}

/// Files that crashed, hung or filled the memory are refused with their names.
#[cfg(unix)]
#[test]
fn hostile_files_are_refused_by_name() {
    let Some(cases) = cases() else { return };
    let hostile = cases.join("hostile");
    for name in names(&hostile) {
        let folder = survey_folder();
        let bytes = std::fs::read(hostile.join(&name)).expect("bytes");
        let (input, arguments): (_, &[&str]) = match name.split('-').next() {
            Some("scenario") => ("s.toml", &["simulate", "s.toml", "--out", "out"]),
            Some("target") => ("target.toml", &["check", "survey.toml"]),
            _ => ("lidar.laz", &["check", "survey.toml"]),
        };
        // scenarios of that time did not name their procedure
        let begin: &[u8] = if input == "s.toml" {
            b"procedure = \"pool\"\n"
        } else {
            b""
        };
        std::fs::write(folder.path().join(input), [begin, &bytes].concat()).expect("written");
        let output = within_memory(arguments, folder.path());
        let said = words(&output);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        let named = said.starts_with(&format!("boresight: {input}: "));
        assert!(named && !said.contains("panicked"), "{name}: {said}");
        if name.contains("block-height") {
            assert!(said.contains("block_height_m"), "{name}: {said}");
        }
        assert!(!folder.path().join("out").exists(), "{name}");
    }
}
