//! A seabed survey with a tide over time: right, wrong, and refused.

use std::path::Path;

use crate::common::{change_column, run, simulated, words};
use serde_json::Value;

const THIN: &str = include_str!("../../models/scenarios/seabed-thin.toml");
const SURVEY: &str = "survey/survey.toml";

/// Half tide: the water rises by 0.56 mm/s, 25 cm over the survey. Recorder files, since a CSV holds no heights of the heave.
fn scenario(format: &str, heights: &str) -> String {
    let text = THIN.replace(
        "[errors]",
        "[tide]\nrange_m = 8.0\nhigh_water_s = 11000\n\n[errors]",
    );
    let text = text.replace("seed = 1\n", &format!("seed = 1\nformat = \"{format}\"\n"));
    text.replace(
        "[trajectory]\n",
        &format!("[trajectory]\nheights = \"{heights}\"\n"),
    )
}

fn tide(folder: &Path) -> std::path::PathBuf {
    folder.join("survey/tide.csv")
}

/// Pitch, roll, yaw as found and their sigmas, degrees, and what is said of the tide, by code.
struct Found {
    angles: Vec<[f64; 2]>,
    tide: Vec<(String, String)>,
}

fn calibrated(text: &str, change: impl Fn(&Path)) -> Found {
    let folder = simulated(text);
    change(folder.path());
    let arguments = ["calibrate", SURVEY, "--method", "joint", "--out", "out"];
    let output = run(&arguments, folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    let bytes = std::fs::read(folder.path().join("out/result.json")).expect("a result");
    let result: Value = serde_json::from_slice(&bytes).expect("JSON");
    let parameters = result["solutions"]["joint"]["parameters"].as_array();
    let angle = |p: &Value| ["correction", "sigma"].map(|key| p[key].as_f64().expect("a number"));
    let findings = result["verdict"]["findings"].as_array();
    let all = findings.expect("findings").iter().map(|f| {
        let text = |key: &str| f[key].as_str().expect("text").to_owned();
        (text("code"), text("seen"))
    });
    Found {
        angles: parameters
            .expect("parameters")
            .iter()
            .take(3)
            .map(angle)
            .collect(),
        tide: all
            .filter(|(code, _)| code == "tide" || code == "line_heights")
            .collect(),
    }
}

/// Largest difference in sigmas.
fn apart(a: &Found, b: &Found) -> f64 {
    let each = a.angles.iter().zip(&b.angles);
    each.map(|(a, b)| (a[0] - b[0]).abs() / a[1])
        .fold(0.0, f64::max)
}

/// Heave and tide make the heights above the ellipsoid: the same result but for straight lines over ten minutes of tide (0.9 mm) and the
/// height's digits in the file. Without the tide, or with its sign reversed, it is another; reversed it is named. An hour late at half
/// tide it shifts all lines alike: nothing is said, and nothing moves by more than a fifth of a sigma.
#[test]
fn heave_and_tide_are_the_heights_and_what_is_wrong_is_said_where_it_shows() {
    let heave = scenario("kmall", "heave");
    let whole = calibrated(&scenario("kmall", "ellipsoid"), |_| {});
    let right = calibrated(&heave, |_| {});
    assert!(apart(&right, &whole) < 0.02, "{}", apart(&right, &whole));
    assert!(right.tide.is_empty(), "{:?}", right.tide);
    let reversed = calibrated(&heave, |folder| {
        change_column(&tide(folder), "height_m", |_, h| -h);
    });
    assert!(
        apart(&reversed, &right) > 0.3,
        "{}",
        apart(&reversed, &right)
    );
    let [(code, seen)] = &reversed.tide[..] else {
        panic!("{:?}", reversed.tide);
    };
    assert!(
        code == "tide" && seen.contains("with the tide reversed in sign"),
        "{seen}"
    );
    let late = calibrated(&heave, |folder| {
        change_column(&tide(folder), "time_s", |_, t| t + 3600.0);
    });
    assert!(
        late.tide.is_empty() && apart(&late, &right) < 0.3,
        "{}",
        apart(&late, &right)
    );
}

/// What `check` says, in one line, with its exit code.
fn checked(text: &str, change: impl Fn(&Path)) -> (Option<i32>, String) {
    let folder = simulated(text);
    change(folder.path());
    let output = run(&["check", SURVEY], folder.path());
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &words(&output);
    let said: Vec<&str> = said.split_whitespace().collect();
    (output.status.code(), said.join(" "))
}

fn survey_file(folder: &Path, from: &str, to: &str) {
    let path = folder.join(SURVEY);
    let text = std::fs::read_to_string(&path).expect("a file");
    assert!(text.contains(from), "{from}: {text}");
    std::fs::write(path, text.replace(from, to)).expect("written");
}

#[test]
fn check_says_what_the_tide_is_and_what_it_does() {
    let (code, said) = checked(&scenario("csv", "ellipsoid"), |_| {});
    assert_eq!(code, Some(0), "{said}");
    let due = "tide of tide.csv: 1 0.10 to 0.14 m, 2 0.18 to 0.22 m, 3 0.25 to 0.28 m, 4 0.31 to 0.35 m; heights above the ellipsoid have it already";
    assert!(said.contains(due), "{said}");
    let (code, said) = checked(&scenario("all", "heave"), |_| {});
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("lifted by it moment by moment"), "{said}");
    assert!(!said.contains("They do not agree"), "{said}");
}

/// Every row of a tide, written anew.
fn rewritten(folder: &Path, rows: impl IntoIterator<Item = [f64; 2]>) {
    let rows = rows.into_iter().map(|[t, h]| format!("{t},{h}\n"));
    let text: String = std::iter::once("time_s,height_m\n".to_owned())
        .chain(rows)
        .collect();
    std::fs::write(tide(folder), text).expect("written");
}

#[test]
fn a_tide_that_cannot_be_is_refused_with_file_place_and_what_was_expected() {
    type Change<'c> = &'c dyn Fn(&Path);
    let cases: [(Change<'_>, &[&str]); 8] = [
        (
            &|f| rewritten(f, [[0.0, 0.1], [600.0, 0.2], [1200.0, 0.3]]),
            &[
                "tide.csv: column time_s: found times from 0 to 1200 s, expected times that cover line \"2\", 1134",
            ],
        ),
        (
            &|f| change_column(&tide(f), "time_s", |_, t| t + 604_800.0),
            &[
                "found times from 597400 to 614800 s",
                "[tide] time_offset_s = -604800 would reach it: whole GPS weeks",
            ],
        ),
        (
            &|f| rewritten(f, [[0.0, 0.1], [1800.0, 0.2], [1200.0, 0.3], [3600.0, 0.1]]),
            &[
                "tide.csv: line 4, column time_s: found 1200 after 1800, expected strictly ascending times",
            ],
        ),
        (
            &|f| rewritten(f, [[-9000.0, -1.0], [12_000.0, 4.0], [34_000.0, -4.0]]),
            &[
                "a step of 5.8 h before 12000 s, where line \"1\" is",
                "rows at most an hour apart",
            ],
        ),
        (
            &|f| change_column(&tide(f), "height_m", |_, h| h / 0.3048),
            &["column height_m: found", "m an hour (in feet?"],
        ),
        (
            &|f| change_column(&tide(f), "height_m", |_, h| -h),
            &[
                "found the boat's heights above the ellipsoid go 0.19 m (root mean square) off it, known to 0.03 m",
                "0.02 m is left with it reversed in sign",
            ],
        ),
        (
            &|f| change_column(&tide(f), "height_m", |_, h| h - 2.0),
            &[
                "found a tide by which the transducer is 0.",
                "expected heights over [site] water_level_m",
            ],
        ),
        (
            &|f| survey_file(f, "tide_m = 0.0", "tide_m = 0.3"),
            &[
                "survey.toml",
                "found line \"1\" with a tide_m, and [tide], expected one of the two",
            ],
        ),
    ];
    for (k, (change, expected)) in cases.into_iter().enumerate() {
        let (code, said) = checked(&scenario("csv", "ellipsoid"), change);
        assert_eq!(code, Some(2), "{k}: {said}");
        assert!(expected.iter().all(|w| said.contains(w)), "{k}: {said}");
    }
}

/// Times may be dates beside recorder files, whose clock is UTC; an offset is added to them.
#[test]
fn a_tide_may_be_written_with_dates() {
    let (code, said) = checked(&scenario("kmall", "heave"), |folder| {
        let rows = [
            "2024-06-01T02:00:00+02:00,0.00",
            "2024-06-01T03:00:00+02:00,0.36",
        ];
        let text = format!("time_s,height_m\n{}\n", rows.join("\n"));
        std::fs::write(tide(folder), text).expect("written");
    });
    assert_eq!(code, Some(0), "{said}");
    // 16 min 40 s of an hour at 36 cm an hour
    assert!(
        said.contains("tide of tide.csv: 0001_1 0.10 to 0.11 m"),
        "{said}"
    );
}

#[test]
fn a_csv_has_no_heights_of_the_heave() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("s.toml"), scenario("csv", "heave")).expect("written");
    let output = run(&["simulate", "s.toml", "--out", "survey"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output).contains("heights from the heave in a CSV"));
}
