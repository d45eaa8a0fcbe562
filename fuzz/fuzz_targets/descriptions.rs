//! Survey, target and scenario files of every procedure: the first byte chooses which, the rest is the text.
#![no_main]

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use boresight::procedures;
use boresight::procedures::pool::survey::parse_target;
use boresight_fuzz::scratch;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<PathBuf> = LazyLock::new(scratch);

fuzz_target!(|data: &[u8]| {
    let Some((choice, bytes)) = data.split_first() else {
        return;
    };
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let choice = usize::from(*choice) % (2 * procedures::ALL.len() + 1);
    match procedures::ALL.get(choice / 2) {
        Some(procedure) if choice % 2 == 0 => drop(procedure.scenario(Path::new("f.toml"), text)),
        Some(procedure) => {
            let survey = FOLDER.join("survey.toml");
            std::fs::write(&survey, text).expect("written");
            drop(procedure.read(&survey));
        }
        None => drop(parse_target(Path::new("f.toml"), text)),
    }
});
