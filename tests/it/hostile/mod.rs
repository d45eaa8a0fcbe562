//! Nothing breaks it, nothing is lost: mutants of every kind of file (`mutants`), limits, special files and folders of the user's (`files`),
//! kills at any moment and a full disk (`kills`).
//!
//! `BORESIGHT_MUTANTS=10000 cargo test --release --test it hostile` makes so many mutants of each kind instead of the few of every day,
//! `BORESIGHT_KILLS=50` so many kills of each command.

mod files;
mod kills;
mod mutants;

use std::path::Path;
use std::process::{Command, Output, Stdio};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PROGRAM: &str = env!("CARGO_BIN_EXE_boresight");

fn count(variable: &str, usual: usize) -> usize {
    let set = std::env::var(variable).ok();
    set.and_then(|text| text.parse().ok()).unwrap_or(usual)
}

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(ROOT).join(name)).expect("fixture")
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).current_dir(folder);
    command.stdin(Stdio::null()).output().expect("ran")
}

/// What was said on standard error by a command that must end with 2.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

fn accepted(folder: &Path, arguments: &[&str]) {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{said}");
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// A folder with a copy of the pool's fixture.
pub(crate) fn survey_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    for name in [
        "survey.toml",
        "target.toml",
        "lidar.laz",
        "multibeam.csv",
        "trajectory.csv",
    ] {
        let bytes = fixture(&format!("tests/data/csv/{name}"));
        std::fs::write(folder.path().join(name), bytes).expect("written");
    }
    folder
}
