//! Mutants: every format of the table and every TOML is read, or refused in words that name the file.

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use boresight::calibrate::seam::Procedure;
use boresight::formats::registry::Format;
use boresight::procedures;

use super::{accepted, count, fixture, names, run, survey_folder};
use crate::common::{formats, thin};

/// Numbers that are the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 as usize
    }
}

/// Pieces of text that readers of numbers and keys stumble over.
const PIECES: [&str; 12] = [
    "nan",
    "inf",
    "-1",
    "1e308",
    "1e-308",
    "999999999999",
    "\"",
    "[",
    "=",
    "\u{fffd}",
    "",
    "0",
];

/// Changed, lost and repeated bytes; in a text also whole words.
fn mutant(good: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..1 + numbers.next() % 3 {
        let at = numbers.next() % bytes.len().max(1);
        let end = (at + 1 + numbers.next() % 12).min(bytes.len());
        match numbers.next() % 6 {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            3 => {
                let piece = PIECES[numbers.next() % PIECES.len()];
                bytes.splice(at..end, piece.bytes());
            }
            _ if at < bytes.len() => bytes[at] = numbers.next() as u8,
            _ => {}
        }
    }
    bytes
}

/// Longest time that a mutant may take; the slowest of thousands took a fraction of it.
const LONGEST: Duration = Duration::from_secs(10);

/// A message begins with a file of the folder, or with the file's name where nothing was read from a disk.
fn complete(kind: &str, message: &str, begins: &Path) {
    let begins = begins.display().to_string();
    for line in message.lines() {
        assert!(line.starts_with(&begins), "{kind}: {line}");
        assert!(
            line.len() < 2000,
            "{kind}: a message of {} bytes",
            line.len()
        );
    }
    assert!(!message.trim().is_empty(), "{kind}: an empty message");
}

/// Reads a good file, then `wanted` mutants of it; `read` gives what is said of one, nothing where it is taken. At least one in
/// `at_least` must be refused: a reader that takes everything reads nothing.
fn survive(
    kind: &str,
    good: &[u8],
    begins: &Path,
    (wanted, at_least): (usize, usize),
    read: impl Fn(&[u8]) -> Option<String>,
) {
    assert_eq!(read(good), None, "{kind} as it is");
    let (mut numbers, mut refusals) = (Numbers(0x9e37_79b9_7f4a_7c15), 0);
    for k in 0..wanted {
        let bytes = mutant(good, &mut numbers);
        let begun = Instant::now();
        let ended = catch_unwind(AssertUnwindSafe(|| read(&bytes)));
        let said = ended.unwrap_or_else(|_| panic!("{kind}: mutant {k} panicked"));
        assert!(
            begun.elapsed() < LONGEST,
            "{kind}: mutant {k} took too long"
        );
        if let Some(message) = said {
            complete(kind, &message, begins);
            refusals += 1;
        }
    }
    assert!(
        refusals * at_least > wanted,
        "{kind}: only {refusals} of {wanted} refused"
    );
}

/// A small survey of a procedure by its own simulator.
fn simulated(procedure: &dyn Procedure) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    let scenario = procedure
        .scenario(Path::new("scenario.toml"), &thin(procedure))
        .expect("a scenario");
    scenario
        .write(1, folder.path(), &boresight::watch::Unwatched)
        .expect("a survey");
    folder
}

/// A short text table: what a person types.
fn typed(header: &str, row: fn(f64) -> String) -> Vec<u8> {
    let mut text = format!("{header}\n");
    for k in 0..60 {
        let _ = writeln!(text, "{}", row(f64::from(k)));
    }
    text.into_bytes()
}

/// Returns in point format 1, whose compression is one stream.
fn las_of_format_1(compressed: bool) -> Vec<u8> {
    let mut builder = las::Builder::from((1, 2));
    builder.point_format = las::point::Format::new(1).expect("a format");
    builder.point_format.is_compressed = compressed;
    let header = builder.into_header().expect("a header");
    let file = std::io::Cursor::new(vec![]);
    let mut writer = las::Writer::new(file, header).expect("a writer");
    for k in 0..500 {
        let point = las::Point {
            x: 0.01 * f64::from(k % 40),
            y: 5.0 + 0.003 * f64::from(k),
            z: -1.0,
            gps_time: Some(400_000.0 + 0.001 * f64::from(k)),
            ..las::Point::default()
        };
        writer.write_point(point).expect("written");
    }
    writer.close().expect("closed");
    let file = writer.into_inner().expect("the file");
    file.into_inner()
}

/// The file of a procedure's survey that its own format reads.
fn own_sample(format: &Format) -> Vec<Vec<u8>> {
    let own = |p: &&&dyn Procedure| p.formats().iter().any(|own| own.name == format.name);
    let procedure = procedures::ALL.iter().find(own);
    let procedure = procedure.unwrap_or_else(|| panic!("no sample of {}", format.name));
    let folder = simulated(*procedure);
    let files = names(folder.path())
        .into_iter()
        .map(|name| folder.path().join(name));
    let read = |path: &PathBuf| format.readers.iter().all(|r| r.probe(path).is_ok());
    let path = files.filter(|path| path.is_file()).find(read);
    let path = path.unwrap_or_else(|| panic!("no survey holds a {}", format.name));
    vec![std::fs::read(path).expect("bytes")]
}

/// Good files of a format. A new format of the table needs a line here; a procedure's own is in the survey that it simulates.
fn samples(format: &Format) -> Vec<Vec<u8>> {
    let simulated = |procedure: &str, file: &str| {
        let of = procedures::ALL.iter().find(|p| p.name() == procedure);
        let folder = simulated(*of.expect("a procedure"));
        std::fs::read(folder.path().join(file)).expect("simulated")
    };
    match format.name {
        "trajectory CSV" => vec![fixture("tests/data/csv/trajectory.csv")],
        "SBET" => vec![fixture("tests/data/sbet/trajectory.out")],
        // layers, one stream, and no compression
        "LAS, LAZ" => vec![
            fixture("tests/data/csv/lidar.laz"),
            las_of_format_1(true),
            las_of_format_1(false),
        ],
        "laser CSV" => vec![typed("time_s,x_m,y_m,z_m", |k| {
            format!("{},{},5.0,-1.25", 100.0 + 0.01 * k, 0.1 * k)
        })],
        "soundings CSV" => vec![fixture("tests/data/csv/multibeam.csv")],
        "sound-speed CSV" => vec![typed("depth_m,sound_speed_m_s", |k| {
            format!("{k},{}", 1480.0 + 0.1 * k)
        })],
        "tide CSV" => vec![typed("time_s,height_m", |k| {
            format!("{},{}", 1000.0 + 600.0 * k, 1.5 - 0.02 * k)
        })],
        "attitude CSV" => vec![fixture("tests/data/rail/attitude.csv")],
        "acoustic fixes CSV" => vec![simulated("usbl", "fixes.csv")],
        "control points CSV" => vec![simulated("usbl", "control.csv")],
        "rail profiles CSV" => vec![fixture("tests/data/rail/profiles.csv")],
        "rail profiles Parquet" => vec![fixture("tests/data/rail/profiles.parquet")],
        "table positions CSV" => vec![fixture("tests/data/rail/table.csv")],
        _ => own_sample(format),
    }
}

#[test]
fn mutants_of_every_format_are_read_or_refused_in_words() {
    let wanted = count("BORESIGHT_MUTANTS", 200);
    let folder = tempfile::tempdir().expect("folder");
    let built = |f: &&Format| cfg!(feature = "parquet") || !f.extensions.contains(&"parquet");
    for format in formats().into_iter().filter(built) {
        let path = folder
            .path()
            .join(format!("mutant.{}", format.extensions[0]));
        for mut good in samples(format) {
            // a long text is mutated where most of its words are; a binary file must stay whole
            if !good.contains(&0) {
                let lines = good.iter().take(40_000).rposition(|b| *b == b'\n');
                good.truncate(lines.map_or(good.len(), |end| end + 1));
            }
            // a column of doubles shows little of what was done to it
            survive(format.name, &good, &path, (wanted, 20), |bytes| {
                std::fs::write(&path, bytes).expect("written");
                let read = format.readers.iter().map(|r| r.probe(&path));
                let errors: Vec<_> = read.filter_map(Result::err).collect();
                errors.first().map(ToString::to_string)
            });
        }
    }
}

/// Readers without a fixture of their own meet another kind's bytes.
#[test]
fn other_formats_are_refused_in_words() {
    let folder = tempfile::tempdir().expect("folder");
    let built = |f: &&Format| cfg!(feature = "parquet") || !f.extensions.contains(&"parquet");
    let all: Vec<_> = formats().into_iter().filter(built).collect();
    for format in &all {
        let path = folder
            .path()
            .join(format!("other.{}", format.extensions[0]));
        for other in all.iter().filter(|o| o.name != format.name) {
            // a trajectory holds an attitude
            if (format.name, other.name) == ("attitude CSV", "trajectory CSV") {
                continue;
            }
            std::fs::write(&path, &samples(other)[0]).expect("written");
            for reader in format.readers {
                let said = reader.probe(&path).err();
                let said = said.unwrap_or_else(|| panic!("{} read {}", format.name, other.name));
                complete(format.name, &said.to_string(), &path);
            }
        }
    }
}

fn in_words<T, E: std::fmt::Display>(read: Result<T, E>) -> Option<String> {
    read.err().map(|e| e.to_string())
}

#[test]
fn mutants_of_every_scenario_are_read_or_refused_in_words() {
    let wanted = count("BORESIGHT_MUTANTS", 200);
    let file = Path::new("some/file");
    for procedure in procedures::ALL {
        let good = procedure.demo().into_bytes();
        let kind = format!("{} scenario", procedure.name());
        survive(&kind, &good, file, (wanted, 5), |bytes| {
            let text = std::str::from_utf8(bytes).ok()?;
            in_words(procedure.scenario(file, text))
        });
    }
}

#[test]
fn a_rail_that_is_neither_built_in_nor_a_file_is_named_with_its_line() {
    let rail = procedures::ALL.iter().find(|p| p.name() == "rail");
    let rail = rail.expect("a procedure");
    let text = rail.demo();
    let typo = text.replace("model = \"chn60\"", "model = \"chn06\"");
    assert_ne!(typo, text);
    let said = in_words(rail.scenario(Path::new("some/file"), &typo)).expect("refused");
    assert!(
        said.starts_with("some/file: line ") && said.contains("\"chn60\", \"uic60\""),
        "{said}"
    );
}

/// Every TOML of a survey, read as the program reads it: with the files that it names.
#[test]
fn mutants_of_every_survey_are_read_or_refused_in_words() {
    let wanted = count("BORESIGHT_MUTANTS", 60);
    for procedure in procedures::ALL {
        let folder = match procedure.name() {
            "pool" => survey_folder(), // its own simulator's survey is large
            _ => simulated(*procedure),
        };
        let survey = folder.path().join("survey.toml");
        let tables = names(folder.path()).into_iter();
        for name in tables.filter(|n| n.ends_with(".toml") && n != "scenario.toml") {
            let path: PathBuf = folder.path().join(&name);
            let good = std::fs::read(&path).expect("bytes");
            let kind = format!("{} {name}", procedure.name());
            survive(&kind, &good, folder.path(), (wanted, 5), |bytes| {
                std::fs::write(&path, bytes).expect("written");
                in_words(procedure.read(&survey))
            });
            std::fs::write(&path, good).expect("written");
        }
    }
}

/// The whole command on mutants of files of a survey: it ends with 0, 1 or 2, panics never, and writes nothing where it refuses.
fn calibrations_end_in_order(folder: &Path, files: &[String], wanted: usize) {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    for name in files {
        let path = folder.join(name);
        let good = std::fs::read(&path).expect("bytes");
        for k in 0..wanted {
            std::fs::write(&path, mutant(&good, &mut numbers)).expect("written");
            let output = run(folder, &["calibrate", "survey.toml", "--out", "out"]);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let code = output.status.code();
            assert!(
                matches!(code, Some(0..=2)) && !said.contains("panicked"),
                "{name}, mutant {k}: {code:?} {said}"
            );
            let out = folder.join("out");
            assert_eq!(out.exists(), code != Some(2), "{name}, mutant {k}: {said}");
            let _ = std::fs::remove_dir_all(out);
        }
        std::fs::write(&path, good).expect("written");
    }
}

#[test]
fn a_calibration_of_mutants_ends_in_order() {
    let wanted = count("BORESIGHT_MUTANTS", 100).div_ceil(20);
    let folder = survey_folder();
    calibrations_end_in_order(folder.path(), &names(folder.path()), wanted);
}

/// The same of a seabed survey in a recorder's files.
#[test]
fn a_calibration_of_a_recorder_s_mutants_ends_in_order() {
    let wanted = count("BORESIGHT_MUTANTS", 100).div_ceil(100);
    let thin = String::from_utf8(fixture("models/scenarios/seabed-thin.toml")).expect("text");
    for format in ["all", "kmall"] {
        let folder = tempfile::tempdir().expect("folder");
        let text = thin.replace("seed = 1", &format!("seed = 1\nformat = \"{format}\""));
        assert_ne!(text, thin);
        std::fs::write(folder.path().join("s.toml"), text).expect("written");
        accepted(folder.path(), &["simulate", "s.toml", "--out", "survey"]);
        let survey = folder.path().join("survey");
        let mut files = names(&survey);
        files.retain(|name| name.ends_with(format));
        assert_eq!(files.len(), 4, "{files:?}");
        calibrations_end_in_order(&survey, &files, wanted);
    }
}
