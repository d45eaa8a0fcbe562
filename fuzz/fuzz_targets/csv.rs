//! The CSV readers: the first byte chooses which.
#![no_main]

use std::path::Path;

use boresight::formats::{laser_csv, sound_speed_csv, soundings_csv, trajectory_csv};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((choice, bytes)) = data.split_first() else {
        return;
    };
    let (file, size) = (Path::new("f.csv"), bytes.len() as u64);
    match choice % 4 {
        0 => drop(trajectory_csv::read_from(file, bytes, size)),
        1 => drop(laser_csv::read_from(file, bytes, size)),
        2 => drop(soundings_csv::read_from(file, bytes, size)),
        _ => drop(sound_speed_csv::read_from(file, bytes, size)),
    }
});
