//! What tests of the command share.

use std::path::Path;
use std::process::Output;

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::calibrate::seam::Procedure;
use boresight::formats::{FORMATS, Format};
use boresight::observe::{Acts, Extra};
use boresight::procedures;

/// Runs the program in a folder.
pub fn run(arguments: &[&str], folder: &Path) -> Output {
    let mut command = cargo_bin_cmd!("boresight");
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("ran")
}

/// An unknown of the caller's own, in metres.
pub fn extra(name: &str, acts: Acts, derivative: Vec<f64>) -> Extra {
    Extra {
        name: name.to_owned(),
        unit: "m".to_owned(),
        acts,
        derivative,
        prior_sigma: None,
    }
}

/// The scenario with which a procedure is tried quickly: `NAME-thin.toml` of `models/scenarios`, the thin one of a single pass, or the
/// built-in one.
pub fn thin(procedure: &dyn Procedure) -> String {
    let name = procedure.name();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/scenarios");
    let of = |file: String| std::fs::read_to_string(folder.join(file)).ok();
    let own = |text: &String| {
        let found = procedures::of_text(Path::new("thin.toml"), text);
        found.is_ok_and(|found| found.name() == name)
    };
    of(format!("{name}-thin.toml"))
        .or_else(|| of("single-pass-thin.toml".to_owned()).filter(own))
        .unwrap_or_else(|| procedure.demo())
}

/// What it said on standard error.
pub fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a scenario of this text and the survey that it makes, in `survey`.
pub fn simulated(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("s.toml"), text).expect("written");
    let output = run(&["simulate", "s.toml", "--out", "survey"], folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    folder
}

/// Writes the points of a survey with the calibration in `out` to `cloud.laz`.
pub fn applied(survey: &str, folder: &Path) {
    let apply = [
        "apply",
        survey,
        "--calibration",
        "out/result.json",
        "--out",
        "cloud.laz",
    ];
    let output = run(&apply, folder);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
}

/// Changes a column of a CSV, given the row's time (not a number where the file has none) and its value.
pub fn change_column(path: &Path, column: &str, change: impl Fn(f64, f64) -> f64) {
    let text = std::fs::read_to_string(path).expect("a file");
    let mut lines = text.lines();
    let head = lines.next().expect("a header");
    let place = |name: &str| head.split(',').position(|other| other == name);
    let at = place(column).unwrap_or_else(|| panic!("no {column} in {head}"));
    let time = place("time_s");
    let changed = lines.map(|line| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        let number = |k: usize| fields[k].parse::<f64>().expect("a number");
        fields[at] = change(time.map_or(f64::NAN, number), number(at)).to_string();
        fields.join(",")
    });
    let all: Vec<String> = std::iter::once(head.to_owned()).chain(changed).collect();
    std::fs::write(path, all.join("\n") + "\n").expect("written");
}

/// Formats that one procedure alone reads, from its own folder.
const OWN: [&str; 5] = [
    "acoustic fixes CSV",
    "control points CSV",
    "rail profiles CSV",
    "rail profiles Parquet",
    "table positions CSV",
];

/// Every format, for the suites that go through all of them: the table's and each procedure's own, none twice.
pub fn formats() -> Vec<&'static Format> {
    let all: Vec<_> = procedures::formats().collect();
    let names: Vec<_> = all.iter().map(|format| format.name).collect();
    let once = |name: &&str| names.iter().filter(|other| *other == name).count() == 1;
    assert!(names.iter().all(once), "{names:?}");
    assert!(OWN.iter().all(|own| names.contains(own)), "{names:?}");
    let shared = |format: &Format| OWN.contains(&format.name);
    assert!(!FORMATS.iter().any(shared), "on the lower floor too");
    all
}
