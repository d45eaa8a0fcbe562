//! The SBET reader. Seed: `tests/data/sbet/trajectory.out`.
#![no_main]

use std::path::Path;

use boresight::formats::sbet;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    drop(sbet::read_from(Path::new("f.out"), data, data.len() as u64));
});
