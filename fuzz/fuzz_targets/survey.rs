//! Survey, target and scenario files. Seeds: `tests/data/*/*.toml`.
#![no_main]

use std::path::Path;

use boresight::survey::{parse_survey, parse_target, scenario};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let file = Path::new("f.toml");
    drop(parse_survey(file, text, None));
    drop(parse_target(file, text));
    drop(scenario::from_text(file, text));
});
