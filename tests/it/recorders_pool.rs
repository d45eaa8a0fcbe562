//! Pool surveys of recorder files end to end: one simulated survey as CSV, `.all` and `.kmall`, and what is said of wrong files.

use std::path::Path;

use crate::common::{run, simulated, words};
use boresight::formats::Invalid;
use boresight::formats::las::read as read_las;
use nalgebra::{Matrix3, Vector3};
use serde_json::Value;

pub const THIN: &str = include_str!("../../models/scenarios/three-pass-thin.toml");
/// Two arrays, each mounted on its own, three sectors with tilt and delay.
const ARRAYS: &str = "mounting_deg = { roll = -45.0, pitch = 1.1, heading = 0.3 }
arrays = { receiver_mounting_deg = { roll = -43.5, pitch = -0.4, heading = 0.6 }, receiver_offset_m = [0.1, -0.25, 0.02], sectors = 3, sector_tilt_deg = 1.5, sector_delay_s = 0.004 }";
pub const SURVEY: &str = "survey/survey.toml";

fn scenario(format: &str) -> String {
    let arrays = format!("path = \"soundings.{format}\"\n{ARRAYS}");
    let text = THIN.replace("mounting_deg = { roll = -45.0 }", &arrays);
    text.replace("[truth]", "[sound_speed]\nspeed_m_s = 1480.0\n\n[truth]")
}

/// The survey's own file, with a part of it replaced.
pub fn changed(folder: &Path, from: &str, to: &str) {
    let path = folder.join(SURVEY);
    let text = std::fs::read_to_string(&path).expect("a file");
    assert!(text.contains(from), "{from}: {text}");
    std::fs::write(path, text.replace(from, to)).expect("written");
}

/// Sigmas and corrections of the six of a joint solution, and the true corrections; degrees and metres.
pub struct Six {
    pub found: [f64; 6],
    pub sigma: [f64; 6],
    pub truth: [f64; 6],
}

fn calibrated(format: &str, change: impl Fn(&Path)) -> Six {
    calibrated_of(&scenario(format), format, change)
}

/// Of a scenario, whose survey is changed before.
pub fn calibrated_of(text: &str, format: &str, change: impl Fn(&Path)) -> Six {
    let folder = simulated(text);
    change(folder.path());
    let calibrate = ["calibrate", SURVEY, "--method", "joint", "--out", "out"];
    let output = run(&calibrate, folder.path());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(0), "{format}: {said}");
    let json = |name: &str| -> Value {
        let bytes = std::fs::read(folder.path().join(name)).expect("a file");
        serde_json::from_slice(&bytes).expect("JSON")
    };
    let (result, truth) = (json("out/result.json"), json("survey/truth.json"));
    let of = |k: usize, key: &str| {
        let parameter = &result["solutions"]["joint"]["parameters"][k];
        parameter[key].as_f64().expect("a number")
    };
    let turn = ["pitch", "roll", "yaw"];
    let arm = |k: usize, key: &str| truth[key][k].as_f64().expect("metres");
    let true_value = |k: usize| match turn.get(k) {
        Some(name) => truth["correction_deg"][name].as_f64().expect("degrees"),
        None => arm(k - 3, "lever_arm_m") - arm(k - 3, "nominal_lever_arm_m"),
    };
    Six {
        found: std::array::from_fn(|k| of(k, "correction")),
        sigma: std::array::from_fn(|k| of(k, "sigma")),
        truth: std::array::from_fn(true_value),
    }
}

/// Largest difference in sigmas.
pub fn apart(a: &[f64; 6], b: &[f64; 6], sigma: &[f64; 6]) -> f64 {
    let each = (0..6).map(|k| (a[k] - b[k]).abs() / sigma[k]);
    each.fold(0.0, f64::max)
}

/// The truth within 4.5 sigmas, and one result but for what the formats round. `.all` rounds angles to 0.01 deg: uniform, 0.0029 deg beside
/// 0.06 deg of the sounder, 5 % of a sigma as one standard deviation of a parameter, 4.5 of those at the most. `.kmall` rounds angles to
/// 4e-6 deg and times to 5e-10 s, a ten-thousandth. With the recorder's own navigation `.kmall` also rounds the attitude: headings to
/// 1.5e-5 deg beside 0.005 deg, and the sensor's arm and angles to their last written digit; of the soundings at the edge of a face a few
/// are tied by one and not by the other, and each of ten thousand moves a parameter by a hundredth of its sigma.
#[test]
fn one_pool_survey_as_csv_all_and_kmall_has_one_result() {
    let [csv, all, kmall] = ["csv", "all", "kmall"].map(|format| calibrated(format, |_| {}));
    let own = calibrated("kmall", |folder| {
        changed(
            folder,
            "path = \"trajectory.csv\"\ntime = \"utc-day\"\n",
            "",
        );
        changed(
            folder,
            "path = \"lidar.laz\"",
            "path = \"lidar.laz\"\ntime = \"utc-day\"",
        );
    });
    let off = apart(&csv.found, &csv.truth, &csv.sigma);
    assert!(off < 4.5, "{off}: {:?} {:?}", csv.found, csv.truth);
    for (name, other, most) in [
        ("all", &all, 0.22),
        ("kmall", &kmall, 2e-3),
        ("own", &own, 0.06),
    ] {
        let off = apart(&other.found, &csv.found, &csv.sigma);
        assert!(off < most, "{name}: {off}");
    }
}

/// What `check` says of a survey that is changed before, in one line, with its exit code.
fn checked(format: &str, change: impl Fn(&Path)) -> (Option<i32>, String) {
    let folder = simulated(&scenario(format));
    change(folder.path());
    let output = run(&["check", SURVEY], folder.path());
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &words(&output);
    let said: Vec<&str> = said.split_whitespace().collect();
    (output.status.code(), said.join(" "))
}

#[test]
fn a_pool_survey_of_recorder_files_is_held_against_the_sounders_own_points() {
    for format in ["all", "kmall"] {
        let (code, said) = checked(format, |_| {});
        assert_eq!(code, Some(0), "{said}");
        for words in [
            "minus the sounder's own",
            "installation record, receive array: 0.600 m right, -0.450 m forward, -1.580 m up",
            "the soundings are put on that clock",
        ] {
            assert!(said.contains(words), "{words}: {said}");
        }
        assert!(!said.contains("They do not agree"), "{said}");
    }
}

/// The file of soundings with its datagrams changed or left out.
fn rewritten(folder: &Path, keep: impl Fn(&mut Vec<u8>, u8) -> bool) {
    let path = folder.join("survey/soundings.all");
    let bytes = std::fs::read(&path).expect("a file");
    let (mut at, mut kept) = (0, vec![]);
    while at + 6 <= bytes.len() {
        let length = u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        let end = at + 4 + length as usize;
        let mut datagram = bytes[at..end].to_vec();
        let kind = datagram[5];
        if keep(&mut datagram, kind) {
            kept.extend(datagram);
        }
        at = end;
    }
    std::fs::write(path, kept).expect("written");
}

fn without(folder: &Path, kinds: &[u8]) {
    rewritten(folder, |_, kind| !kinds.contains(&kind));
}

#[test]
fn what_a_pool_survey_lacks_is_said_with_what_supplies_it() {
    let own = |folder: &Path| {
        changed(
            folder,
            "path = \"trajectory.csv\"\ntime = \"utc-day\"\n",
            "",
        );
    };
    type Change<'c> = &'c dyn Fn(&Path);
    let cases: [(&str, Change<'_>, [&str; 2]); 9] = [
        (
            "all",
            &|f| (own(f), without(f, b"A")).0,
            ["no attitude", "an SBET"],
        ),
        (
            "all",
            &|f| (own(f), without(f, b"P")).0,
            ["no positions", "an SBET"],
        ),
        (
            "all",
            &|f| without(f, b"U"),
            ["no sound-speed profile", "under [sound_speed]"],
        ),
        (
            "all",
            &|f| without(f, b"I"),
            ["no installation record", "lever_arm_m"],
        ),
        (
            "all",
            &|f| without(f, b"N"),
            ["no raw range and angle datagrams", "soundings"],
        ),
        (
            "all",
            &|f| changed(f, "time = \"utc-day\"", "time = \"utc\""),
            [
                "times that meet those of the soundings",
                "under [trajectory]",
            ],
        ),
        (
            "kmall",
            &|f| own(f),
            ["times from 1003.", "an overlap with the trajectory"],
        ),
        (
            "csv",
            &|f| {
                changed(
                    f,
                    "path = \"trajectory.csv\"",
                    "path = \"trajectory.csv\"\ntime = \"utc-day\"",
                );
            },
            ["soundings of a CSV", "this key with recorder files only"],
        ),
        (
            "all",
            &|f| {
                changed(
                    f,
                    "path = \"soundings.all\"",
                    "path = \"soundings.all\"\ninvalid = \"drop\"",
                );
            },
            [
                "[multibeam] invalid: found recorder files",
                "with a CSV only",
            ],
        ),
    ];
    for (k, (format, change, expected)) in cases.into_iter().enumerate() {
        let (code, said) = checked(format, change);
        assert_eq!(code, Some(2), "{k}: {said}");
        assert!(expected.iter().all(|w| said.contains(w)), "{k}: {said}");
    }
}

/// Every other ping under the serial number 102: refused with both numbers, and taken alone where it is asked for.
#[test]
fn of_two_heads_a_pool_survey_takes_the_one_that_is_asked_for() {
    let split = |folder: &Path| {
        let pings = std::cell::Cell::new(0);
        rewritten(folder, |datagram, kind| {
            if kind == b'N' {
                pings.set(pings.get() + 1);
                if pings.get() % 2 == 0 {
                    datagram[18..20].copy_from_slice(&102u16.to_le_bytes());
                    // a sum that was not written
                    let end = datagram.len();
                    datagram[end - 2..].fill(0);
                }
            }
            true
        });
    };
    let (code, said) = checked("all", split);
    assert_eq!(code, Some(2), "{said}");
    let due = "found soundings of the heads 101, 102, expected [multibeam] head = one of them";
    assert!(said.contains(due), "{said}");
    let alone = |number: u32| {
        move |folder: &Path| {
            split(folder);
            let path = "path = \"soundings.all\"";
            changed(folder, path, &format!("{path}\nhead = {number}"));
        }
    };
    let (code, said) = checked("all", alone(101));
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("head 101 is calibrated; "), "{said}");
    assert!(
        said.contains("soundings of other heads are left out"),
        "{said}"
    );
    let (code, said) = checked("all", alone(7));
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("head 7; there are soundings of 101, 102"),
        "{said}"
    );
}

/// A survey file made from the files names what they say, and `apply` places every sounding.
#[test]
fn recorder_files_of_a_pool_have_a_template_and_a_cloud() {
    let folder = simulated(&scenario("kmall"));
    let template = ["template", "pool", "--from", "survey/soundings.kmall"];
    let output = run(&template, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for words in [
        "paths = [\"survey/soundings.kmall\"]",
        "#lever_arm_m = [0.5, -0.2, -1.6]",
        "#receiver_mounting_deg = { roll = -43.5, pitch = -0.4, heading = 0.6 }",
        "model = \"target.toml\"",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let calibrate = ["calibrate", SURVEY, "--method", "joint", "--out", "out"];
    let output = run(&calibrate, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    crate::common::applied(SURVEY, folder.path());
    let cloud = read_las(&folder.path().join("cloud.laz"), Invalid::Error).expect("points");
    assert!(cloud.len() > 20_000, "{}", cloud.len());
}

/// Two arrays are two records in other programs: each stands on the card, moved by the one correction, with its own place.
#[test]
fn the_card_of_two_arrays_has_a_record_of_each() {
    let folder = simulated(&scenario("kmall"));
    let calibrate = [
        "calibrate",
        SURVEY,
        "--out",
        "out",
        "--export",
        "kongsberg,csv",
    ];
    let output = run(&calibrate, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
    let result: Value = serde_json::from_str(&read("out/result.json")).expect("JSON");
    let matrix = |value: &Value| {
        Matrix3::from_fn(|i, j| value[i][j].as_f64().expect("a number in three rows"))
    };
    let arm = |value: &Value| Vector3::from_fn(|i, _| value[i].as_f64().expect("metres"));
    for path in ["reference", "joint"] {
        let mounting = &result["solutions"][path]["mountings"][0];
        let turned = |of: &Value| {
            matrix(&of["rotation_matrix"]) * matrix(&of["nominal_rotation_matrix"]).transpose()
        };
        let moved = |of: &Value| arm(&of["lever_arm_m"]) - arm(&of["nominal_lever_arm_m"]);
        let nominal = [[-45.0, 1.1, 0.3], [-43.5, -0.4, 0.6]];
        for (array, [roll, pitch, heading]) in mounting["arrays"]
            .as_array()
            .expect("two")
            .iter()
            .zip(nominal)
        {
            assert!((turned(array) - turned(mounting)).norm() < 1e-12, "{path}");
            assert!((moved(array) - moved(mounting)).norm() < 1e-12, "{path}");
            let before = &array["nominal_mounting_deg"];
            for (name, due) in [("roll", roll), ("pitch", pitch), ("heading", heading)] {
                let said = before[name].as_f64().expect("degrees");
                assert!((said - due).abs() < 1e-4, "{path} {name}: {said}");
            }
        }
    }
    // Kongsberg's axes: forward, starboard, down
    let cards = result["conventions"].as_array().expect("a list");
    let card = |array: &str| {
        let found = cards.iter().find(|card| {
            card["software"]
                .as_str()
                .is_some_and(|s| s.starts_with("Kongsberg"))
                && card["mounting"] == format!("multibeam, {array} array")
        });
        let fields = &found.expect("a record of the array")["lever_arm_m"];
        Vector3::from_fn(|i, _| fields[i]["value"].as_f64().expect("metres"))
    };
    let apart = card("receive") - card("transmit");
    assert!(
        (apart - Vector3::new(-0.25, 0.1, -0.02)).norm() < 1e-4,
        "{apart}"
    );
    let text = read("out/card-sis.txt");
    for array in ["transmit", "receive"] {
        assert!(
            text.contains(&format!("parameters: multibeam, {array} array")),
            "{text}"
        );
        assert!(read("out/card.csv").contains(&format!("{array} array roll,deg,")));
    }
}
