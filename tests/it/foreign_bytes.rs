//! Readers of foreign bytes never panic and always say which file: arbitrary bytes, and good files with bytes changed or cut off.

use std::io::Cursor;
use std::path::Path;

use boresight::formats::Invalid;
use boresight::formats::{
    FormatError, las, laser_csv, sbet, sound_speed_csv, soundings_csv, tide_csv, trajectory_csv,
};
use boresight::procedures::pool::survey::{parse_survey, parse_target};
use boresight::survey::SurveyError;
use proptest::prelude::*;

const NAME: &str = "some/file";

/// Reads the bytes in every way; an error must name the file and say what was found and expected.
fn read_all(bytes: &[u8]) {
    let (file, size) = (Path::new(NAME), bytes.len() as u64);
    complete(trajectory_csv::read_from(file, bytes, size, Invalid::Error).err());
    complete(laser_csv::read_from(file, bytes, size, Invalid::Error).err());
    complete(soundings_csv::read_from(file, bytes, size, Invalid::Error).err());
    complete(sound_speed_csv::read_from(file, bytes, size).err());
    complete(tide_csv::read_from(file, bytes, size).err());
    complete(sbet::read_from(file, bytes, size, Invalid::Error).err());
    complete(las::read_from(file, Cursor::new(bytes.to_vec()), size, Invalid::Error).err());
    if let Ok(text) = std::str::from_utf8(bytes) {
        listed(parse_survey(file, text, None).err());
        listed(parse_target(file, text).err());
    }
}

fn complete(error: Option<FormatError>) {
    if let Some(error) = error {
        let message = error.to_string();
        assert!(
            message.starts_with("some/file: ")
                && !error.found.is_empty()
                && !error.expected.is_empty(),
            "{message}"
        );
    }
}

fn listed(error: Option<SurveyError>) {
    if let Some(error) = error {
        assert!(!error.problems.is_empty());
        for problem in &error.problems {
            assert!(
                problem.file == Path::new(NAME)
                    && !problem.place.is_empty()
                    && !problem.expected.is_empty(),
                "{problem}"
            );
        }
    }
}

fn fixture(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name);
    let mut bytes = std::fs::read(path).expect("fixture");
    if name.ends_with("csv") {
        bytes.truncate(3000);
    }
    bytes
}

const FIXTURES: [&str; 8] = [
    "csv/trajectory.csv",
    "csv/multibeam.csv",
    "csv/lidar.laz",
    "sbet/lidar.laz",
    "sbet/trajectory.out",
    "csv/survey.toml",
    "csv/target.toml",
    "uncompressed",
];

/// A good file: a fixture, or the first fixture's points as LAS.
fn good(k: usize) -> Vec<u8> {
    if k + 1 < FIXTURES.len() {
        return fixture(FIXTURES[k]);
    }
    let laz = fixture("csv/lidar.laz");
    let size = laz.len() as u64;
    let points =
        las::read_from(Path::new(NAME), Cursor::new(laz), size, Invalid::Error).expect("good");
    let columns = las::PointColumns {
        time_s: &points.time_s,
        x_m: &points.x_m,
        y_m: &points.y_m,
        z_m: &points.z_m,
        point_source_id: &[],
    };
    las::write_to(&columns, false, None).expect("write")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn arbitrary_bytes(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        read_all(&bytes);
    }

    #[test]
    fn arbitrary_text(text in "[a-z_,.0-9\\-\n\"\\[\\]={} ]{0,300}") {
        read_all(text.as_bytes());
    }

    #[test]
    fn good_files_with_bytes_changed(k in 0..FIXTURES.len(), changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), in_header in any::<bool>()) {
        let mut bytes = good(k);
        let reach = if in_header { bytes.len().min(600) } else { bytes.len() };
        for (at, value) in changes {
            bytes[at.index(reach)] = value;
        }
        read_all(&bytes);
    }

    #[test]
    fn good_files_cut_off(k in 0..FIXTURES.len(), at in any::<prop::sample::Index>()) {
        let bytes = good(k);
        read_all(&bytes[..at.index(bytes.len())]);
    }
}

#[test]
fn good_files_are_good() {
    let size = |bytes: &[u8]| bytes.len() as u64;
    let file = Path::new(NAME);
    for k in [2, 3, 7] {
        let bytes = good(k);
        let n = size(&bytes);
        las::read_from(file, Cursor::new(bytes), n, Invalid::Error).expect("laser points");
    }
    let bytes = good(4);
    sbet::read_from(file, &bytes[..], size(&bytes), Invalid::Error).expect("SBET");
    parse_survey(file, std::str::from_utf8(&good(5)).expect("text"), None).expect("survey");
    parse_target(file, std::str::from_utf8(&good(6)).expect("text")).expect("target");
}

/// A layer of two gigabytes in a file of four kilobytes is refused before room is made for it.
#[test]
fn a_damaged_layer_size_is_found_before_room_is_made() {
    let mut bytes = good(2);
    let points_at = u32::from_le_bytes([bytes[96], bytes[97], bytes[98], bytes[99]]) as usize;
    // the chunk table's offset, the first point, the number of points; then the layers' sizes
    let size_at = points_at + 8 + 30 + 4;
    bytes[size_at + 3] = 0x7f;
    let size = bytes.len() as u64;
    let error = las::read_from(Path::new(NAME), Cursor::new(bytes), size, Invalid::Error)
        .expect_err("damaged");
    assert_eq!(error.found, "the end of the compressed points", "{error}");
}
