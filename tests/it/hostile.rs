//! Nothing breaks it, nothing is lost: mutants of every kind of file, special files, folders of the user's, kills at any moment, a full
//! disk.
//!
//! `BORESIGHT_MUTANTS=10000 cargo test --release --test it hostile` makes so many mutants of each kind instead of the few of every day,
//! `BORESIGHT_KILLS=50` so many kills of each command.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use boresight::formats::{
    attitude_csv, las, laser_csv, rail_csv, sbet, sound_speed_csv, soundings_csv, trajectory_csv,
    usbl_control_csv, usbl_fixes_csv,
};
use boresight::procedures;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PROGRAM: &str = env!("CARGO_BIN_EXE_boresight");

fn count(variable: &str, usual: usize) -> usize {
    let set = std::env::var(variable).ok();
    set.and_then(|text| text.parse().ok()).unwrap_or(usual)
}

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(ROOT).join(name)).expect("fixture")
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).current_dir(folder);
    command.stdin(Stdio::null()).output().expect("ran")
}

/// What was said on standard error by a command that must end with 2.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

fn accepted(folder: &Path, arguments: &[&str]) {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{said}");
}

// MUTANTS

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

/// What a reader says of bytes: nothing, or a message.
type Reader = fn(&Path, &[u8]) -> Option<String>;

macro_rules! reader {
    ($read:expr) => {
        |file, bytes| {
            $read(file, bytes, bytes.len() as u64)
                .err()
                .map(|e| e.to_string())
        }
    };
}

fn read_las(file: &Path, bytes: &[u8]) -> Option<String> {
    let source = Cursor::new(bytes.to_vec());
    let read = las::read_from(file, source, bytes.len() as u64);
    read.err().map(|e| e.to_string())
}

/// As the program reads a scenario: the procedure that its text names, else the first.
fn read_scenario(file: &Path, bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let named = procedures::ALL
        .iter()
        .find(|p| text.contains(&format!("\"{}\"", p.name())));
    let read = named.unwrap_or(&procedures::ALL[0]).scenario(file, text);
    read.err().map(|e| e.to_string())
}

fn read_survey(file: &Path, bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let read = procedures::pool::survey::parse_survey(file, text, None);
    read.err().map(|e| e.to_string())
}

fn read_target(file: &Path, bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let read = procedures::pool::survey::parse_target(file, text);
    read.err().map(|e| e.to_string())
}

fn read_rail_survey(file: &Path, bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let read = procedures::rail::survey::load::parse_survey(file, text, None);
    read.err().map(|e| e.to_string())
}

/// Every kind of file with a good one of its kind.
const KINDS: &[(&str, &str, Reader)] = &[
    ("LAZ", "tests/data/csv/lidar.laz", read_las),
    (
        "SBET",
        "tests/data/sbet/trajectory.out",
        reader!(sbet::read_from),
    ),
    (
        "trajectory",
        "tests/data/csv/trajectory.csv",
        reader!(trajectory_csv::read_from),
    ),
    (
        "soundings",
        "tests/data/csv/multibeam.csv",
        reader!(soundings_csv::read_from),
    ),
    ("survey", "tests/data/csv/survey.toml", read_survey),
    ("target", "tests/data/csv/target.toml", read_target),
    (
        "rail survey",
        "tests/data/rail/survey.toml",
        read_rail_survey,
    ),
    (
        "pool scenario",
        "models/scenarios/single-pass-thin.toml",
        read_scenario,
    ),
    (
        "USBL scenario",
        "models/scenarios/usbl-thin.toml",
        read_scenario,
    ),
    (
        "rail scenario",
        "models/scenarios/rail-thin.toml",
        read_scenario,
    ),
];

/// Longest time that a mutant may take; the slowest of thousands took a fraction of it.
const LONGEST: Duration = Duration::from_secs(10);

/// A message begins with the file's name and has a place, what was found and what was expected.
fn complete(kind: &str, message: &str) {
    for line in message.lines() {
        assert!(line.starts_with("some/"), "{kind}: {line}");
        assert!(
            line.len() < 2000,
            "{kind}: a message of {} bytes",
            line.len()
        );
    }
    assert!(!message.trim().is_empty(), "{kind}: an empty message");
}

#[test]
fn mutants_of_every_kind_are_read_or_refused_in_words() {
    let wanted = count("BORESIGHT_MUTANTS", 200);
    for (kind, name, read) in KINDS {
        let mut good = fixture(name);
        assert_eq!(read(Path::new("some/file"), &good), None, "{kind} as it is");
        // a long text is mutated where most of its words are
        good.truncate(40_000);
        let (mut numbers, mut refusals) = (Numbers(0x9e37_79b9_7f4a_7c15), 0);
        for k in 0..wanted {
            let bytes = mutant(&good, &mut numbers);
            let begun = Instant::now();
            let ended = catch_unwind(AssertUnwindSafe(|| read(Path::new("some/file"), &bytes)));
            let said = ended.unwrap_or_else(|_| panic!("{kind}: mutant {k} panicked"));
            assert!(
                begun.elapsed() < LONGEST,
                "{kind}: mutant {k} took too long"
            );
            if let Some(message) = said {
                complete(kind, &message);
                refusals += 1;
            }
        }
        assert!(
            refusals * 5 > wanted,
            "{kind}: only {refusals} of {wanted} refused"
        );
    }
}

/// Readers without a fixture of their own meet another kind's bytes.
#[test]
fn other_files_are_refused_in_words() {
    let others: &[(&str, Reader)] = &[
        ("laser", reader!(laser_csv::read_from)),
        ("sound speed", reader!(sound_speed_csv::read_from)),
        ("fixes", reader!(usbl_fixes_csv::read_from)),
        ("control", reader!(usbl_control_csv::read_from)),
        ("attitude", |file, bytes| {
            let size = bytes.len() as u64;
            let read = attitude_csv::read_from(file, bytes, size, &attitude_csv::VESSEL);
            read.err().map(|e| e.to_string())
        }),
        ("profiles", |file, bytes| {
            let read = rail_csv::read_profiles_from(file, bytes, bytes.len() as u64, 2);
            read.err().map(|e| e.to_string())
        }),
    ];
    for (kind, read) in others {
        // a trajectory holds an attitude
        let others = |name: &&str| *kind != "attitude" || !name.ends_with("trajectory.csv");
        for name in KINDS.iter().map(|k| k.1).filter(others) {
            let message = read(Path::new("some/file"), &fixture(name));
            complete(
                kind,
                &message.unwrap_or_else(|| panic!("{kind} read {name}")),
            );
        }
    }
}

// LIMITS AND SPECIAL FILES

/// A folder with a copy of the pool's fixture.
fn survey_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    for name in [
        "survey.toml",
        "target.toml",
        "lidar.laz",
        "multibeam.csv",
        "trajectory.csv",
    ] {
        let bytes = fixture(&format!("tests/data/csv/{name}"));
        std::fs::write(folder.path().join(name), bytes).expect("written");
    }
    folder
}

#[test]
fn a_slip_of_the_pen_costs_neither_time_nor_memory() {
    let folder = survey_folder();
    let target = folder.path().join("target.toml");
    let good = std::fs::read_to_string(&target).expect("text");
    let scenario =
        String::from_utf8(fixture("models/scenarios/single-pass-thin.toml")).expect("text");
    for height in ["0.001", "6e-13"] {
        let slip = |text: &str| {
            text.replace(
                "block_height_m = 0.6",
                &format!("block_height_m = {height}"),
            )
        };
        assert_ne!(slip(&good), good);
        std::fs::write(&target, slip(&good)).expect("written");
        let said = refused(folder.path(), &["check", "survey.toml"]);
        assert!(
            said.contains("target.toml: ") && said.contains("block_height_m"),
            "{said}"
        );
        std::fs::write(folder.path().join("s.toml"), slip(&scenario)).expect("written");
        let said = refused(folder.path(), &["simulate", "s.toml", "--out", "out"]);
        assert!(
            said.contains("s.toml: line ") && said.contains("at most 100 blocks"),
            "{said}"
        );
        assert!(!folder.path().join("out").exists());
    }
    let slip = scenario
        .replace("beams = 77", "beams = 30000")
        .replace("ping_rate_hz = 5.0", "ping_rate_hz = 10000.0");
    std::fs::write(folder.path().join("s.toml"), slip).expect("written");
    let said = refused(folder.path(), &["simulate", "s.toml", "--out", "out"]);
    assert!(said.contains("soundings, expected at most"), "{said}");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_inputs() {
    let folder = survey_folder();
    for input in ["survey.toml", "lidar.laz"] {
        let path = folder.path().join(input);
        let kept = std::fs::read(&path).expect("bytes");
        std::fs::remove_file(&path).expect("removed");
        std::os::unix::fs::symlink("/dev/zero", &path).expect("a link");
        let said = refused(folder.path(), &["check", "survey.toml"]);
        assert!(
            said.contains(&format!("{input}: ")) && said.contains("special file"),
            "{said}"
        );
        std::fs::remove_file(&path).expect("removed");
        let made = Command::new("mkfifo").arg(&path).status();
        if made.is_ok_and(|status| status.success()) {
            let said = refused(folder.path(), &["check", "survey.toml"]);
            assert!(said.contains("special file"), "{said}");
            std::fs::remove_file(&path).expect("removed");
        }
        std::fs::write(&path, kept).expect("written");
    }
}

// THE USER'S FILES

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn a_survey_is_never_simulated_over() {
    let folder = survey_folder();
    let scenario = Path::new(ROOT).join("models/scenarios/usbl-thin.toml");
    let scenario = scenario.to_str().expect("a path");
    let before = names(folder.path());
    for force in [
        &["simulate", scenario, "--out", "."][..],
        &["simulate", scenario, "--out", ".", "--force"],
    ] {
        let said = refused(folder.path(), force);
        assert!(
            said.contains("survey.toml: ") && said.contains("did not write"),
            "{said}"
        );
    }
    assert_eq!(names(folder.path()), before);
    accepted(folder.path(), &["simulate", scenario, "--out", "new"]);
    accepted(folder.path(), &["simulate", scenario, "--out", "new"]);
    let said = refused(
        folder.path(),
        &["simulate", scenario, "--out", "new", "--seed", "77"],
    );
    assert!(said.contains("--force"), "{said}");
    accepted(
        folder.path(),
        &[
            "simulate", scenario, "--out", "new", "--seed", "77", "--force",
        ],
    );
}

#[test]
fn apply_never_writes_over_an_input() {
    let folder = survey_folder();
    std::fs::write(folder.path().join("notes.laz"), b"mine").expect("written");
    let apply = |out: &'static str| {
        let arguments = [
            "apply",
            "survey.toml",
            "--calibration",
            "none.json",
            "--out",
            out,
        ];
        refused(folder.path(), &[&arguments[..], &["--force"]].concat())
    };
    let said = apply("lidar.laz");
    assert!(
        said.contains("lidar.laz: ") && said.contains("which this run reads"),
        "{said}"
    );
    let said = apply("notes.laz");
    assert!(
        said.contains("notes.laz: ") && said.contains("did not write"),
        "{said}"
    );
    let said = apply("new.laz");
    assert!(said.contains("none.json: "), "{said}");
    let kept = std::fs::read(folder.path().join("lidar.laz")).expect("bytes");
    assert_eq!(kept, fixture("tests/data/csv/lidar.laz"));
    assert_eq!(
        std::fs::read(folder.path().join("notes.laz")).expect("bytes"),
        b"mine"
    );
}

// KILLS

/// Commands that write, with the folder that they write into; all are quick on these files.
const COMMANDS: [&[&str]; 3] = [
    &["simulate", "scenario.toml", "--out", "out"],
    &["calibrate", "survey/survey.toml", "--out", "out"],
    &["budget", "scenario.toml", "--trials", "2", "--out", "out"],
];

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| {
        let bytes = std::fs::read(folder.join(&name)).unwrap_or_default();
        (name, bytes)
    };
    names(folder).into_iter().map(read).collect()
}

fn kill_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    let scenario = fixture("models/scenarios/usbl-thin.toml");
    std::fs::write(folder.path().join("scenario.toml"), scenario).expect("written");
    accepted(
        folder.path(),
        &["simulate", "scenario.toml", "--out", "survey"],
    );
    folder
}

/// Starts a command and kills it after a while.
fn killed(folder: &Path, arguments: &[&str], after: Duration) {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).current_dir(folder);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("started");
    std::thread::sleep(after);
    let _ = child.kill();
    let _ = child.wait();
}

#[test]
fn a_killed_run_leaves_no_half_file_and_the_next_makes_the_same() {
    let kills = count("BORESIGHT_KILLS", 4);
    let folder = kill_folder();
    let out = folder.path().join("out");
    for arguments in COMMANDS {
        let begun = Instant::now();
        accepted(folder.path(), arguments);
        let (whole, length) = (contents(&out), begun.elapsed());
        for k in 0..kills {
            std::fs::remove_dir_all(&out).expect("removed");
            let part = (k as f64 + 0.5) / kills as f64;
            killed(folder.path(), arguments, length.mul_f64(part));
            for (name, bytes) in contents(&out) {
                let good = whole.iter().find(|(n, _)| *n == name);
                let temporary = name.starts_with(".boresight");
                assert!(
                    temporary || good.is_some_and(|g| g.1 == bytes),
                    "{arguments:?}: half a {name}"
                );
            }
            let mut again = arguments.to_vec();
            if out.join("trials").exists() {
                again.push("--resume"); // trials done are kept
            }
            accepted(folder.path(), &again);
            assert!(contents(&out) == whole, "{arguments:?}: {:?}", names(&out));
        }
        std::fs::remove_dir_all(&out).expect("removed");
    }
}

// A FULL DISK

/// A file system of 64 KiB, where root allows one.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn new(place: &Path) -> Option<Self> {
        let mut mount = Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
            .arg(place);
        let mounted = mount.stderr(Stdio::null()).status();
        mounted
            .is_ok_and(|s| s.success())
            .then(|| Self(place.to_owned()))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing() {
    let folder = kill_folder();
    let place = folder.path().join("disk");
    std::fs::create_dir(&place).expect("folder");
    let Some(_disk) = SmallDisk::new(&place) else {
        eprintln!("skipped: no file system can be mounted here");
        return;
    };
    for arguments in [
        ["calibrate", "survey/survey.toml", "--out", "disk/out"],
        ["simulate", "scenario.toml", "--out", "disk/out"],
    ] {
        let said = refused(folder.path(), &arguments);
        assert!(said.contains("disk/out"), "{said}");
        assert_eq!(names(&place), Vec::<String>::new(), "{arguments:?}");
    }
}
