//! The LAS and LAZ reader. Seeds: `tests/data/*/lidar.laz`.
#![no_main]

use std::io::Cursor;
use std::path::Path;

use boresight::formats::las;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let size = data.len() as u64;
    drop(las::read_from(Path::new("f.laz"), Cursor::new(data.to_vec()), size));
});
