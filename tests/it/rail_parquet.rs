//! Profiles as Parquet, written by pyarrow (`tests/recipes/rail_parquet.py`): the same numbers as the CSV, and a message for what is wrong.
#![cfg(feature = "parquet")]

use std::path::{Path, PathBuf};

use assert_cmd::cargo::cargo_bin_cmd;
use boresight::formats::columns::Columns;
use boresight::formats::rows::Rows;
use boresight::formats::table::Limits;
use boresight::formats::{FaultKind, FormatError};
use boresight::procedures::rail::formats::read_profiles;
use boresight::procedures::rail::observed::ProfilePoints;
use proptest::prelude::*;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/rail")
        .join(name)
}

fn read(name: &str) -> ProfilePoints {
    read_profiles(&fixture(name), 2).expect("profiles")
}

/// The error of reading a file; it must name the file.
fn refused(path: &Path) -> FormatError {
    let error = read_profiles(path, 2).expect_err("a fault");
    assert_eq!(*error.file, *path);
    error
}

/// Bytes under a name that ends in `.Parquet`.
fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("p.Parquet");
    std::fs::write(&path, bytes).expect("written");
    (folder, path)
}

// READ

#[test]
fn doubles_are_those_of_the_csv_bit_by_bit() {
    let csv = read("profiles.csv");
    assert_eq!(csv.len(), 1462);
    assert_eq!(read("profiles.parquet"), csv);
}

/// `FLOAT`, `INT64`, other order, three row groups, many pages of version 2, Zstandard, delta and byte-stream encodings.
#[test]
fn narrow_types_are_the_csv_rounded_to_them() {
    let (csv, narrow) = (read("profiles.csv"), read("narrow.parquet"));
    let rounded = |values: &[f64]| -> Vec<f64> {
        let each = values.iter();
        each.map(|value| f64::from(*value as f32)).collect()
    };
    assert_eq!(narrow.time_s, csv.time_s);
    assert_eq!(narrow.profiler, csv.profiler);
    assert_eq!(narrow.y_m, rounded(&csv.y_m));
    assert_eq!(narrow.z_m, rounded(&csv.z_m));
}

fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = cargo_bin_cmd!("boresight")
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("ran");
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    (output.status.code(), said)
}

fn result(path: &Path) -> serde_json::Value {
    let bytes = std::fs::read(path).expect("a result");
    serde_json::from_slice(&bytes).expect("JSON")
}

/// The result differs in its list of input files and in nothing else; the list has the Parquet file's digest.
#[test]
fn a_survey_with_parquet_gives_the_csv_s_result() {
    let folder = tempfile::tempdir().expect("folder");
    let folder = folder.path();
    let names = [
        "survey.toml",
        "rail.toml",
        "attitude.csv",
        "table.csv",
        "profiles.csv",
    ];
    for name in names.into_iter().chain(["profiles.parquet"]) {
        std::fs::copy(fixture(name), folder.join(name)).expect("copied");
    }
    let survey = std::fs::read_to_string(folder.join("survey.toml")).expect("a survey");
    let results = ["profiles.csv", "profiles.parquet"].map(|name| {
        let text = survey.replace("profiles.csv", name);
        std::fs::write(folder.join("survey.toml"), text).expect("written");
        let (code, said) = run(folder, &["check", "survey.toml"]);
        assert_eq!(code, Some(0), "{said}");
        let out = format!("of-{name}");
        let (code, said) = run(folder, &["calibrate", "survey.toml", "--out", &out]);
        assert_eq!(code, Some(0), "{said}");
        result(&folder.join(out).join("result.json"))
    });
    let [mut csv, mut parquet] = results;
    let digest = boresight::formats::digest::sha256(&fixture("profiles.parquet"));
    let named = |result: &mut serde_json::Value| {
        let path = result["configuration"]["profiles"]["path"].take();
        (path, result["inputs"].take())
    };
    let (of_csv, of_parquet) = (named(&mut csv), named(&mut parquet));
    assert_eq!(of_csv.0, "profiles.csv");
    let listed =
        serde_json::json!({"path": "profiles.parquet", "sha256": digest.expect("a digest")});
    let files = of_parquet.1.as_array().expect("input files");
    assert!(files.contains(&listed), "{files:?}");
    assert!(csv["solutions"]["joint"]["parameters"][0]["value"].is_number());
    assert_eq!(csv, parquet);
}

// REFUSE

#[test]
fn a_bad_value_is_named_by_row_and_column() {
    let cases = [
        ("null.parquet", "row 17, column z_m: found null"),
        (
            "nan.parquet",
            "row 5, column y_m: found NaN, expected metres",
        ),
    ];
    for (name, expected) in cases {
        let said = refused(&fixture(name)).to_string();
        assert!(said.contains(expected), "{said}");
    }
    let one = read_profiles(&fixture("profiles.parquet"), 1).expect_err("a fault");
    let csv = read("profiles.csv");
    let row = csv.profiler.iter().position(|p| *p == 1).expect("a second") + 1;
    let expected =
        format!("row {row}, column profiler: found 2, expected a profiler of the survey");
    assert!(one.to_string().contains(&expected), "{one}");
}

#[test]
fn what_is_no_plain_number_is_refused_by_its_type() {
    let cases = [
        ("text.parquet", "column y_m of type BYTE_ARRAY (String)"),
        ("list.parquet", "column y_m of type list or group"),
        (
            "timestamp.parquet",
            "column time_s of type INT64 (Timestamp)",
        ),
        ("decimal.parquet", "column time_s of type INT64 (Decimal)"),
        (
            "gzip.parquet",
            "row group 1, column time_s: found compression GZIP",
        ),
    ];
    for (name, expected) in cases {
        let said = refused(&fixture(name)).to_string();
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_missing_column_is_named_with_the_nearest() {
    let opened = Columns::open(&fixture("profiles.parquet"), &["time_s", "y_mm"]);
    let error = opened.err().expect("a fault");
    assert_eq!(error.kind, FaultKind::MissingColumn);
    let said = error.to_string();
    assert!(said.contains("expected a column y_mm"), "{said}");
    assert!(
        said.contains("time_s,profiler,y_m,z_m\" (nearest column: y_m)"),
        "{said}"
    );
}

#[test]
fn what_is_no_whole_parquet_file_is_refused() {
    let whole = std::fs::read(fixture("profiles.parquet")).expect("a fixture");
    let csv = std::fs::read(fixture("profiles.csv")).expect("a fixture");
    let cases: [(&[u8], FaultKind, &str); 5] = [
        (
            &csv,
            FaultKind::UnknownFormat,
            "\"time_s,profi\" at its beginning",
        ),
        (&whole[..20_000], FaultKind::Truncated, "at its end"),
        (&whole[..4], FaultKind::Truncated, "at its end"),
        (b"", FaultKind::Empty, "an empty file"),
        (
            b"PARE0123456789PARE",
            FaultKind::UnknownFormat,
            "an encrypted",
        ),
    ];
    for (bytes, kind, expected) in cases {
        let (_folder, path) = written(bytes);
        let error = refused(&path);
        assert_eq!(error.kind, kind, "{error}");
        assert!(error.found.contains(expected), "{error}");
    }
}

#[test]
fn a_file_without_its_middle_is_refused() {
    let whole = std::fs::read(fixture("profiles.parquet")).expect("a fixture");
    let (_folder, path) = written(&[b"PAR1", &whole[20_000..]].concat());
    assert!(refused(&path).found.starts_with("damage"));
    let mut last = Columns::open(&path, &["z_m"]).expect("a good footer");
    let error = last.next_row().expect_err("a fault");
    assert!(error.found.contains("bytes from byte"), "{error}");
    assert_eq!(error.kind, FaultKind::Truncated);
}

/// 1462 rows as Thrift writes them: 2 * 1462 in groups of seven bits.
const COUNT: [u8; 2] = [0xec, 0x16];

/// The default fixture with another count everywhere in its footer.
fn with_rows(count: &[u8]) -> Vec<u8> {
    let whole = std::fs::read(fixture("profiles.parquet")).expect("a fixture");
    let (rest, end) = whole.split_at(whole.len() - 8);
    let length = u32::from_le_bytes([end[0], end[1], end[2], end[3]]) as usize;
    let (pages, old) = rest.split_at(rest.len() - length);
    let mut footer = vec![];
    let mut at = 0;
    while at < old.len() {
        let here = old[at..].starts_with(&COUNT);
        footer.extend(if here { count } else { &old[at..=at] });
        at += if here { 2 } else { 1 };
    }
    let length = u32::try_from(footer.len()).expect("short").to_le_bytes();
    [pages, &footer, &length, b"PAR1"].concat()
}

#[test]
fn counts_of_the_footer_are_not_believed() {
    let cases: [(&[u8], &str); 4] = [
        (
            &[0x80, 0x80, 0x80, 0x80, 0x80, 0x20],
            "549755813888 rows in",
        ),
        (&[0x01], "impossibly many rows in"),
        (
            &[0xee, 0x16],
            "column time_s: found 1462 values, expected 1463",
        ),
        (&[0xea, 0x16], "column time_s: found more than 1461 values"),
    ];
    assert_eq!(
        with_rows(&COUNT),
        std::fs::read(fixture("profiles.parquet")).expect("a fixture")
    );
    for (count, expected) in cases {
        let (_folder, path) = written(&with_rows(count));
        let said = refused(&path).to_string();
        assert!(said.contains(expected), "{said}");
    }
}

/// The first page's header says that it unpacks to a gigabyte.
#[test]
fn a_page_s_size_is_not_believed() {
    let mut bytes = std::fs::read(fixture("profiles.parquet")).expect("a fixture");
    assert_eq!((bytes[4], bytes[6]), (0x15, 0x15));
    let size = bytes[7..].iter().take_while(|b| **b & 0x80 != 0).count() + 1;
    bytes.splice(7..7 + size, [0x80, 0x80, 0x80, 0x80, 0x08]);
    let (_folder, path) = written(&bytes);
    let error = refused(&path);
    assert!(
        error.found.contains("a page of 1073741824 bytes"),
        "{error}"
    );
}

/// Reads a file in every way; an error must name the file and say what was found and expected.
fn never_panics(bytes: &[u8]) {
    let (_folder, path) = written(bytes);
    if let Err(error) = read_profiles(&path, 2) {
        let said = error.to_string();
        assert!(
            !error.found.is_empty() && !error.expected.is_empty(),
            "{said}"
        );
        assert_eq!(*error.file, *path);
    }
    let Ok(mut columns) = Columns::open(&path, &["profiler", "z_m"]) else {
        return;
    };
    while let Ok(true) = columns.next_row() {
        let _ = (columns.count(0), columns.number(1, &Limits::FINITE));
    }
}

/// The same of a dictionary: its header (type, two sizes, then field 7, of which the first field is the count) says a million.
#[test]
fn a_dictionary_s_size_is_not_believed() {
    let mut bytes = std::fs::read(fixture("profiles.parquet")).expect("a fixture");
    let header = &bytes[4..24];
    let at = header.windows(2).position(|two| two == [0x4c, 0x15]);
    let count = 4 + at.expect("a dictionary") + 2;
    // 22 positions, each with a time of its own; zigzag doubles
    assert_eq!(bytes[count], 44);
    bytes.splice(count..=count, [0x80, 0x89, 0x7a]);
    let (_folder, path) = written(&bytes);
    let error = refused(&path);
    assert!(error.found.contains("a dictionary longer"), "{error}");
}

/// A damaged size in the footer of the third row group, at which the parquet crate (60.1) indexes past the end of a page.
#[test]
fn a_panic_of_the_decoder_is_a_fault_of_the_file() {
    let mut bytes = std::fs::read(fixture("narrow.parquet")).expect("a fixture");
    bytes[12_024] = 25;
    let (_folder, path) = written(&bytes);
    let error = refused(&path);
    assert!(
        error
            .found
            .contains("compressed data that cannot be decoded"),
        "{error}"
    );
}

const FIXTURES: [&str; 3] = ["profiles.parquet", "narrow.parquet", "null.parquet"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_do_not_panic(
        k in 0..FIXTURES.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        in_footer in any::<bool>(),
    ) {
        let mut bytes = std::fs::read(fixture(FIXTURES[k])).expect("a fixture");
        let first = if in_footer { bytes.len().saturating_sub(2000) } else { 4 };
        let reach = bytes.len() - first;
        for (at, value) in changes {
            bytes[first + at.index(reach)] = value;
        }
        never_panics(&bytes);
    }
}
