//! The LAS and LAZ reader. Seeds: `tests/data/*/lidar.laz`.
#![no_main]

use std::io::Cursor;
use std::panic;
use std::path::Path;

use boresight::formats::las;
use libfuzzer_sys::fuzz_target;

/// The decoder asserts on compressed bytes that contradict each other; our reader catches that and makes it an error of the file.
/// libFuzzer's hook would abort before: a panic that begins in the decoder is left to the reader, every other one is a finding.
fn leave_the_decoder_s_asserts_to_the_reader() {
    let abort = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let begins_in = |part| info.location().is_some_and(|l| l.file().contains(part));
        if !begins_in("/laz-") && !begins_in("/las-") {
            abort(info);
        }
    }));
}

fuzz_target!(
    init: leave_the_decoder_s_asserts_to_the_reader(),
    |data: &[u8]| {
        let size = data.len() as u64;
        drop(las::read_from(Path::new("f.laz"), Cursor::new(data.to_vec()), size));
    }
);
