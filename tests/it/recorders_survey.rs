//! Seabed surveys of recorder files end to end: the same simulated survey as CSV, `.all` and `.kmall`, and what is said of wrong files.

use std::path::Path;

use crate::common::{run, simulated, words};
use boresight::formats::kongsberg_all::write::Writer;
use nalgebra::{Matrix3, Vector3};
use serde_json::Value;

const THIN: &str = include_str!("../../models/scenarios/seabed-thin.toml");
/// Two arrays, each mounted on its own, three sectors with tilt and delay.
const ARRAYS: &str = "mounting_deg = { roll = -0.8, pitch = 1.1, heading = 0.3 }
arrays = { receiver_mounting_deg = { roll = 1.5, pitch = -0.4, heading = 0.6 }, receiver_offset_m = [0.1, -0.25, 0.02], sectors = 3, sector_tilt_deg = 1.5, sector_delay_s = 0.004 }";
const SURVEY: &str = "survey/survey.toml";

fn scenario(format: &str) -> String {
    let nominal = "mounting_deg = { roll = 0.0, pitch = 0.0, heading = 0.0 }";
    let text = THIN.replace(nominal, ARRAYS);
    text.replace("seed = 1", &format!("seed = 1\nformat = \"{format}\""))
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| value[i][j].as_f64().expect("a number"))
}

/// The mounting that was found from the true one (radians), and the stated sigmas (degrees).
fn calibrated(format: &str) -> (Vector3<f64>, Vector3<f64>) {
    let folder = simulated(&scenario(format));
    let output = run(
        &["calibrate", SURVEY, "--method", "joint", "--out", "out"],
        folder.path(),
    );
    assert_eq!(
        output.status.code(),
        Some(0),
        "{format}: {}",
        words(&output)
    );
    let result = json(&folder.path().join("out/result.json"));
    let truth = json(&folder.path().join("survey/truth.json"));
    let joint = &result["solutions"]["joint"];
    let found = matrix(&joint["mountings"][0]["rotation_matrix"]);
    let due = matrix(&truth["rotation_matrix"]);
    let sigma = |k: usize| joint["parameters"][k]["sigma"].as_f64().expect("a sigma");
    let off = boresight::geometry::rotation::log(&(found * due.transpose()));
    (off, Vector3::new(sigma(0), sigma(1), sigma(2)))
}

/// One survey in three formats: the truth within 4.5 sigmas, and the same result but for what the formats round. `.kmall` rounds next to
/// nothing; `.all` rounds attitude and angles to 0.01 deg and positions to a centimetre, as much noise as the INS of this survey has.
#[test]
fn one_survey_as_csv_all_and_kmall_has_one_result() {
    let [csv, all, kmall] = ["csv", "all", "kmall"].map(calibrated);
    for (off, sigma) in [&csv, &all, &kmall] {
        let pulls = off.map(f64::to_degrees).component_div(sigma);
        assert!(pulls.amax() < 4.5, "{off} {sigma}");
    }
    for (other, most) in [(&all, 2.0), (&kmall, 0.3)] {
        let apart = (other.0 - csv.0).map(f64::to_degrees);
        let apart = apart.component_div(&csv.1);
        assert!(apart.amax() < most, "{apart}");
    }
}

/// What `check` says of a survey that is changed before, with its exit code.
fn checked(format: &str, change: impl Fn(&Path)) -> (Option<i32>, String) {
    let folder = simulated(&scenario(format));
    change(&folder.path().join("survey"));
    let output = run(&["check", SURVEY], folder.path());
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &words(&output);
    (output.status.code(), said)
}

/// The datagrams of a `.all` file that `keep` wants by their kind.
fn datagrams(path: &Path, keep: impl Fn(u8) -> bool) -> Vec<u8> {
    let bytes = std::fs::read(path).expect("a file");
    let (mut at, mut kept) = (0, vec![]);
    while at + 6 <= bytes.len() {
        let length = u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        let end = at + 4 + length as usize;
        if keep(bytes[at + 5]) {
            kept.extend_from_slice(&bytes[at..end]);
        }
        at = end;
    }
    kept
}

fn recorded(survey: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(survey).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut own: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|e| e == "all"))
        .collect();
    own.sort();
    own
}

/// Every file without the datagrams of these kinds.
fn without(survey: &Path, kinds: &[u8]) {
    for path in recorded(survey) {
        let kept = datagrams(&path, |kind| !kinds.contains(&kind));
        std::fs::write(path, kept).expect("written");
    }
}

fn appended(survey: &Path, section: &str, line: &str) {
    let path = survey.join("survey.toml");
    let text = std::fs::read_to_string(&path).expect("a file");
    let header = format!("[{section}]");
    let changed = text.replace(&header, &format!("{header}\n{line}"));
    assert_ne!(text, changed);
    std::fs::write(path, changed).expect("written");
}

#[test]
fn a_survey_of_recorder_files_is_held_against_the_sounders_own_points() {
    let (code, said) = checked("kmall", |_| {});
    assert_eq!(code, Some(0), "{said}");
    for words in ["minus the sounder's own", "receive array", "0001_1.kmall"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!said.contains("They do not agree"), "{said}");
}

#[test]
fn what_is_missing_is_said_with_what_supplies_it() {
    let cases: [(&[u8], [&str; 2]); 4] = [
        (b"A", ["no attitude", "an SBET"]),
        (b"P", ["no positions", "an SBET"]),
        (b"U", ["no sound-speed profile", "as [sound_speed] profile"]),
        (b"I", ["no installation record", "lever_arm_m"]),
    ];
    for (kinds, expected) in cases {
        let (code, said) = checked("all", |survey| without(survey, kinds));
        assert_eq!(code, Some(2), "{said}");
        assert!(expected.iter().all(|w| said.contains(w)), "{said}");
    }
    let (code, said) = checked("all", |survey| without(survey, b"N"));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("no raw range and angle datagrams"), "{said}");
}

/// Every other ping under the serial number 102: both heads are taken together, one alone where it is asked for, and what is left out of
/// the other is said.
#[test]
fn of_two_heads_both_are_taken_or_the_one_that_is_asked_for() {
    let split = |survey: &Path| {
        for path in recorded(survey) {
            let mut bytes = std::fs::read(&path).expect("a file");
            let (mut at, mut pings) = (0, 0);
            while at + 20 <= bytes.len() {
                let length = u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
                let end = at + 4 + length as usize;
                if bytes[at + 5] == b'N' {
                    pings += 1;
                    if pings % 2 == 0 {
                        bytes[at + 18..at + 20].copy_from_slice(&102u16.to_le_bytes());
                        // a sum that was not written
                        bytes[end - 2..end].fill(0);
                    }
                }
                at = end;
            }
            std::fs::write(&path, bytes).expect("written");
        }
    };
    let (code, said) = checked("all", split);
    assert_eq!(code, Some(0), "{said}");
    let said: Vec<&str> = said.split_whitespace().collect();
    let said = said.join(" ");
    let both = "2 heads are calibrated together, each with its own mounting; soundings: 6420 of head 101, 6420 of head 102";
    assert!(said.contains(both), "{said}");
    let (code, said) = checked("all", |survey| {
        split(survey);
        appended(survey, "multibeam", "head = 101");
    });
    assert_eq!(code, Some(0), "{said}");
    let said: Vec<&str> = said.split_whitespace().collect();
    let said = said.join(" ");
    let due =
        "head 101 is calibrated; soundings of the other heads are left out: 6420 of head 102;";
    assert!(said.contains(due), "{said}");
}

#[test]
fn two_heads_under_one_serial_number_are_refused() {
    let (code, said) = checked("all", |survey| {
        for path in recorded(survey) {
            let mut writer = Writer::new(vec![], 2040, 101);
            let text = "STC=2,S1X=0,S1Y=0,S1Z=1,S1R=40,S2X=0,S2Y=0,S2Z=1,S2R=-40,";
            writer
                .installation(1_717_201_000.0, text, 101)
                .expect("written");
            let rest = datagrams(&path, |kind| kind != b'I');
            let whole = [writer.into_inner(), rest].concat();
            std::fs::write(path, whole).expect("written");
        }
    });
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("two heads with the serial number 101"),
        "{said}"
    );
}

#[test]
fn a_trajectory_of_another_week_or_of_no_named_clock_is_refused() {
    let row = |k: u32, base_s: f64| format!("{},31.4,121.8,12,0,0,0\n", base_s + f64::from(k));
    let head = "time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg\n";
    let (code, said) = checked("all", |survey| {
        let begin_s = 1_717_200_900.0 - 604_800.0;
        let rows: String = (0..1000).map(|k| row(k, begin_s)).collect();
        std::fs::write(survey.join("other.csv"), head.to_owned() + &rows).expect("written");
        appended(survey, "trajectory", "path = \"other.csv\"");
    });
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("whole GPS weeks") && said.contains("2024-06-01"),
        "{said}"
    );
    let (code, said) = checked("all", |survey| {
        let record = |k: u32| {
            let mut values = [0.0; 17];
            (values[0], values[1], values[2]) = (519_400.0 + f64::from(k), 0.548, 2.126);
            values.map(f64::to_le_bytes).concat()
        };
        let bytes: Vec<u8> = (0..100).flat_map(record).collect();
        std::fs::write(survey.join("sbet.out"), bytes).expect("written");
        appended(survey, "trajectory", "path = \"sbet.out\"");
    });
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("[trajectory] time") && said.contains("gps-week"),
        "{said}"
    );
}

/// A file given twice overlaps itself; a survey of one line has nothing to compare.
#[test]
fn lines_that_are_one_are_refused() {
    let (code, said) = checked("all", |survey| {
        let path = survey.join("survey.toml");
        let text = std::fs::read_to_string(&path).expect("a file");
        let twice = text.replace("\"0002_2.all\"", "\"0001_1.all\"");
        assert_ne!(text, twice);
        std::fs::write(path, twice).expect("written");
    });
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("no pings of its own"), "{said}");
    let (code, said) = checked("all", |survey| {
        let path = survey.join("survey.toml");
        let text = std::fs::read_to_string(&path).expect("a file");
        let one = text.replace(", \"0002_2.all\", \"0003_3.all\", \"0004_4.all\"", "");
        assert_ne!(text, one);
        std::fs::write(path, one).expect("written");
    });
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("Nothing can be determined"), "{said}");
}

/// The heave instead of heights above the ellipsoid: asked for, it serves; the template names the files and what they say.
#[test]
fn heave_serves_where_no_height_is_and_a_template_comes_from_the_files() {
    let (code, said) = checked("all", |survey| {
        appended(survey, "trajectory", "heights = \"heave\"");
    });
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("heave above the water level"), "{said}");
    let folder = simulated(&scenario("all"));
    let survey = folder.path().join("survey");
    let names = recorded(&survey);
    let names: Vec<&str> = names
        .iter()
        .map(|path| path.file_name().and_then(|n| n.to_str()).expect("a name"))
        .collect();
    let arguments = [&["template", "seabed", "--from"], names.as_slice()].concat();
    let output = run(&arguments, &survey);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    let lines = text
        .lines()
        .filter(|l| !l.starts_with('#') && !l.is_empty());
    assert!(lines.count() <= 10, "{text}");
    assert!(text.contains("#receiver_mounting_deg"), "{text}");
    std::fs::write(survey.join("from.toml"), &text).expect("written");
    let output = run(&["check", "from.toml"], &survey);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
}

/// Position, height (metres), roll and pitch, heading (degrees): drifts of the thin scenario.
const DRIFTS: [(&str, f64); 4] = [
    ("position_drift_sigma_m", 0.01),
    ("height_drift_sigma_m", 0.015),
    ("roll_pitch_drift_sigma_deg", 0.004),
    ("heading_drift_sigma_deg", 0.012),
];

/// An SMRMSG once a second: the scenario's drifts times a factor of the seconds since the first sounding.
fn smrmsg(survey: &Path, factor: impl Fn(f64) -> f64) {
    let first = std::fs::read(survey.join("0001_1.kmall")).expect("a file");
    let unix_s = u32::from_le_bytes(first[12..16].try_into().expect("four bytes"));
    let week_s = (f64::from(unix_s) - 315_964_800.0) % 604_800.0;
    let [position_m, height_m, tilt, heading] = DRIFTS.map(|(_, sigma)| sigma);
    let mut bytes = vec![];
    for second in -60..3000 {
        let second = f64::from(second);
        let sigmas = [position_m, position_m, height_m, 0.01, 0.01, 0.01];
        let angles = [tilt, tilt, heading].map(|degrees| 60.0 * degrees);
        let sigmas = sigmas.iter().chain(&angles).map(|s| s * factor(second));
        for value in std::iter::once(week_s + second).chain(sigmas) {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }
    std::fs::write(survey.join("smrmsg.out"), bytes).expect("written");
}

/// Values and sigmas of the parameters with the drifts as stated, or from accuracies that change as `factor` does.
fn with_accuracies(factor: Option<fn(f64) -> f64>) -> Vec<[f64; 2]> {
    let folder = simulated(&scenario("kmall"));
    let survey = folder.path().join("survey");
    if let Some(factor) = factor {
        smrmsg(&survey, factor);
        let path = survey.join("survey.toml");
        let mut text = std::fs::read_to_string(&path).expect("a file");
        for (key, sigma) in DRIFTS {
            let line = format!("{key} = {sigma}\n");
            assert!(text.contains(&line), "{line}{text}");
            text = text.replace(&line, "");
        }
        std::fs::write(&path, text).expect("written");
        let keys = "accuracies = \"smrmsg.out\"\ntime = \"utc-week\"";
        appended(&survey, "trajectory", keys);
    }
    let arguments = ["calibrate", SURVEY, "--method", "joint", "--out", "out"];
    let output = run(&arguments, folder.path());
    assert!(folder.path().join("out").exists(), "{}", words(&output));
    let result = json(&folder.path().join("out/result.json"));
    let parameters = result["solutions"]["joint"]["parameters"].as_array();
    let number = |value: &Value| value.as_f64().unwrap_or(0.0);
    let parameters = parameters.expect("parameters").iter();
    parameters
        .map(|p| [number(&p["value"]), number(&p["sigma"])])
        .collect()
}

/// Accuracies that do not change are the same as those sigmas in the survey file; ones that change give other weights.
#[test]
fn accuracies_of_an_sbet_count_moment_by_moment() {
    let stated = with_accuracies(None);
    let apart = |other: &[[f64; 2]], k: usize| {
        let each = stated.iter().zip(other).filter(|(a, _)| a[1] > 0.0);
        each.map(|(a, b)| (a[k] - b[k]).abs() / a[1])
            .fold(0.0, f64::max)
    };
    let constant = with_accuracies(Some(|_| 1.0));
    assert!(
        apart(&constant, 0).max(apart(&constant, 1)) < 1e-6,
        "{constant:?} {stated:?}"
    );
    // the same root mean square over the file's 210 and 2850 records
    let changing = with_accuracies(Some(|second| if second < 150.0 { 0.1 } else { 1.035_834 }));
    assert!(apart(&changing, 1) > 0.02, "{changing:?} {stated:?}");
    assert!(apart(&changing, 0) > 1e-3, "{changing:?} {stated:?}");
}

/// What `info` says of files, with its exit code.
fn told(folder: &Path, files: &[&str]) -> (Option<i32>, String) {
    let arguments = [&["info"], files].concat();
    let output = run(&arguments, folder);
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &words(&output);
    (output.status.code(), said)
}

/// A recorder's file is one by its records, whatever stands before them and whatever it is called.
#[test]
fn a_file_with_a_damaged_beginning_or_another_name_is_read() {
    for format in ["all", "kmall"] {
        let folder = simulated(&scenario(format));
        let survey = folder.path().join("survey");
        let good = std::fs::read(survey.join(format!("0001_1.{format}"))).expect("a file");
        let write = |name: &str, bytes: &[u8]| {
            std::fs::write(folder.path().join(name), bytes).expect("written");
        };
        write("cut", &good[100..]);
        write("behind", &[&[0; 5000], &good[..]].concat());
        write("line.out", &good);
        write("far", &[&[0; 1 << 19], &good[..]].concat());
        let whole = told(&survey, &[&format!("0001_1.{format}")]).1;
        let pings = |said: &str| {
            let line = said
                .lines()
                .find(|line| line.contains("pings  "))
                .expect("pings");
            line.split_whitespace().nth(1).expect("a number").to_owned()
        };
        for (name, lost) in [
            ("cut", "bytes skipped"),
            ("behind", "5000 bytes skipped"),
            ("line.out", "pings"),
        ] {
            let (code, said) = told(folder.path(), &[name]);
            assert_eq!(code, Some(0), "{format} {name}: {said}");
            assert!(said.contains(lost), "{format} {name}: {said}");
            assert_eq!(pings(&said), pings(&whole), "{format} {name}: {said}");
        }
        assert_eq!(told(folder.path(), &["far"]).0, Some(2), "{format}");
    }
}

#[test]
fn info_of_a_folder_tells_of_its_recorder_files() {
    let folder = simulated(&scenario("all"));
    let (code, said) = told(folder.path(), &["survey"]);
    assert_eq!(code, Some(0), "{said}");
    for file in recorded(&folder.path().join("survey")) {
        let name = file
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        assert!(said.contains(&name), "{name}: {said}");
    }
    assert!(!said.contains("survey.toml"), "{said}");
    let template = ["template", "seabed", "--from", "survey"];
    let output = run(&template, folder.path());
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &words(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("survey/0001_1.all"), "{said}");
    assert!(!said.contains("cannot be calibrated"), "{said}");
    std::fs::create_dir(folder.path().join("none")).expect("a folder");
    let (code, said) = told(folder.path(), &["none"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("a folder without a recorder's file"),
        "{said}"
    );
}

/// Points of zeros were never written: nothing is compared with them.
#[test]
fn own_points_of_zeros_are_none() {
    let zeros = |survey: &Path| {
        for path in recorded(survey) {
            let mut bytes = std::fs::read(&path).expect("a file");
            let mut at = 0;
            while at + 6 <= bytes.len() {
                let four = bytes[at..at + 4].try_into().expect("four bytes");
                let end = at + 4 + u32::from_le_bytes(four) as usize;
                if bytes[at + 5] == b'X' {
                    for beam in bytes[at + 40..end - 3].chunks_exact_mut(20) {
                        beam[..12].fill(0);
                    }
                    let sum = bytes[at + 5..end - 3]
                        .iter()
                        .map(|b| u32::from(*b))
                        .sum::<u32>();
                    bytes[end - 2..end].copy_from_slice(&(sum as u16).to_le_bytes());
                }
                at = end;
            }
            std::fs::write(path, bytes).expect("written");
        }
    };
    let (code, said) = checked("all", zeros);
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("checksum"), "{said}");
    assert!(!said.contains("They do not agree"), "{said}");
    assert!(!said.contains("minus the sounder's own"), "{said}");
}

/// The survey file with these lines changed, calibrated by the joint path.
fn calibrated_with(folder: &Path, edit: impl Fn(&str) -> Option<String>) -> Value {
    let survey = folder.join(SURVEY);
    let text = std::fs::read_to_string(&survey).expect("a file");
    let text: Vec<String> = text.lines().filter_map(edit).collect();
    std::fs::write(&survey, text.join("\n")).expect("written");
    let output = run(
        &["calibrate", SURVEY, "--method", "joint", "--out", "out"],
        folder,
    );
    assert!(output.status.code() < Some(2), "{}", words(&output));
    json(&folder.join("out/result.json"))
}

/// Truth: 2 mm, 0.003 and 0.005 deg; some 3000 records know it to 2 % each.
#[test]
fn noise_that_nobody_states_is_measured_and_what_is_assumed_is_named() {
    let folder = simulated(&scenario("kmall"));
    let measured = [
        "position_sigma_m",
        "roll_pitch_sigma_deg",
        "heading_sigma_deg",
    ];
    let result = calibrated_with(folder.path(), |line| {
        let of = |key: &str| line.starts_with(&format!("{key} ="));
        if of("angle_sigma_deg") {
            return Some("angle_sigma_deg = 0.1".to_owned());
        }
        let left_out = of("angle_sigma_growth") || measured.iter().any(|key| of(key));
        (!left_out).then(|| line.to_owned())
    });
    for (key, truth) in measured.iter().zip([0.002, 0.003, 0.005]) {
        let taken = &result["configuration"]["trajectory"][key];
        let taken = taken.as_f64().expect("a sigma");
        assert!((taken / truth - 1.0).abs() < 0.1, "{key}: {taken}");
    }
    let findings = result["verdict"]["findings"].as_array().expect("a list");
    let claim = findings.iter().find(|f| f["code"] == "noise_claim");
    let advice = claim.expect("a finding")["advice"].as_str().expect("words");
    let assumed = "(not in the survey file, taken by what is usual: angle_sigma_growth)";
    assert!(advice.contains(assumed), "{advice}");
}
