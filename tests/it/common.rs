//! What the command tests of USBL and rail share.

use std::path::Path;
use std::process::Output;

use assert_cmd::cargo::cargo_bin_cmd;

/// Runs the program in a folder.
pub fn run(arguments: &[&str], folder: &Path) -> Output {
    let mut command = cargo_bin_cmd!("boresight");
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("ran")
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
