//! Every reader of formats and recorders: the first byte chooses which, the rest is the file.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use boresight::formats::recorder::Sink;
use boresight::formats::recorder::table::RECORDERS;
use boresight::procedures;
use boresight_fuzz::scratch;
use libfuzzer_sys::fuzz_target;

/// Takes whatever comes.
struct Ignore;

impl Sink for Ignore {}

static FOLDER: LazyLock<PathBuf> = LazyLock::new(scratch);

fuzz_target!(|data: &[u8]| {
    let Some((choice, bytes)) = data.split_first() else {
        return;
    };
    let formats: Vec<_> = procedures::formats().collect();
    let choice = usize::from(*choice) % (formats.len() + RECORDERS.len());
    let ending = formats.get(choice).map_or("raw", |format| format.extensions[0]);
    let path = FOLDER.join(format!("f.{ending}"));
    std::fs::write(&path, bytes).expect("written");
    match formats.get(choice) {
        Some(format) => format.readers.iter().for_each(|reader| drop(reader.probe(&path))),
        None => drop((RECORDERS[choice - formats.len()].read)(&path, &mut Ignore)),
    }
});
