//! Rules of a survey file that concern more than one key.

use std::path::Path;

use super::file::SurveyFile;
use super::keys;
use crate::procedures;
use crate::survey::document::Document;
use crate::survey::problem::Problem;
use crate::survey::reading::missing_files;
use crate::survey::recorded::files::missing_recorders;
use crate::survey::schema::{self, Key};

/// Every fault of a survey file's text; where `folder` is given, also of the paths in it.
pub(crate) fn survey_problems(document: &Document<'_>, folder: Option<&Path>) -> Vec<Problem> {
    if let Some(problem) = other_procedure(document) {
        return vec![problem];
    }
    let mut problems = schema::check(document, SurveyFile::KEYS);
    problems.extend(lidar_problems(document));
    problems.extend(sound_speed_problems(document));
    problems.extend(of_columns(document));
    if let Some(folder) = folder {
        problems.extend(missing_files(document, folder, FILES));
    }
    problems
}

/// What a survey without recorder files must say, and what it must not.
fn of_columns(document: &Document<'_>) -> Vec<Problem> {
    let lacks =
        |key: &&[&str; 2]| document.get(&key[..1]).is_some() && document.get(*key).is_none();
    let expected = "a file, or recorder files as paths under [multibeam]";
    let absent = [["trajectory", "path"], ["multibeam", "path"]];
    let absent = absent.iter().filter(lacks);
    let mut problems: Vec<Problem> = absent
        .map(|key| document.problem(key, "nothing", expected))
        .collect();
    let only = OF_RECORDERS
        .iter()
        .filter(|key| document.get(*key).is_some());
    problems.extend(only.map(|key| {
        let expected = "this key with recorder files only; a CSV has the clock of its trajectory";
        document.problem(key, "soundings of a CSV", expected)
    }));
    problems
}

/// Keys that say something of recorder files only.
const OF_RECORDERS: &[[&str; 2]] = &[
    ["trajectory", "time"],
    ["trajectory", "week"],
    ["trajectory", "leap_seconds"],
    ["lidar", "time"],
];

/// Keys that recorder files supply.
const SUPPLIED: &[&[&str]] = &[
    &["multibeam", "lever_arm_m"],
    &["multibeam", "mounting_deg"],
];

/// Every fault of the text of a survey file of recorder files, and of the paths in it.
pub(super) fn recorder_problems(
    document: &Document<'_>,
    folder: &Path,
    names: &[String],
) -> Vec<Problem> {
    let mut problems = schema::check_but(document, SurveyFile::KEYS, SUPPLIED);
    problems.extend(lidar_problems(document));
    problems.extend(sound_speed_problems(document));
    problems.extend(useless_keys(document));
    let files = FILES.iter().filter(|key| key[0] != "multibeam");
    let files: Vec<[&str; 2]> = files.copied().collect();
    problems.extend(missing_files(document, folder, &files));
    problems.extend(missing_recorders(document, folder, names));
    problems
}

/// Keys that would do nothing beside others.
fn useless_keys(document: &Document<'_>) -> Vec<Problem> {
    let has = |key: &[&str; 2]| document.get(key).is_some();
    let georeferenced = document
        .string(&["lidar", "coordinates"])
        .is_some_and(|frame| frame != "sensor");
    let own = !has(&["trajectory", "path"]);
    let path = "this key beside a path under [trajectory]";
    let cases: [([&str; 2], bool, &str, &str); 6] = [
        (
            ["trajectory", "time"],
            own,
            "the recorder's own navigation",
            path,
        ),
        (
            ["trajectory", "week"],
            own,
            "the recorder's own navigation",
            path,
        ),
        (
            ["trajectory", "lever_arm_m"],
            own,
            "the recorder's own navigation",
            path,
        ),
        (
            ["trajectory", "time_offset_s"],
            own,
            "the recorder's own navigation",
            path,
        ),
        (
            ["lidar", "time"],
            georeferenced,
            "points that are georeferenced",
            "this key with coordinates = \"sensor\"",
        ),
        (
            ["multibeam", "invalid"],
            true,
            "recorder files",
            "this key with a CSV only; beams that the sounder holds invalid are left out and counted",
        ),
    ];
    let useless = cases.iter().filter(|case| case.1 && has(&case.0));
    useless
        .map(|(key, _, found, expected)| document.problem(key, *found, *expected))
        .collect()
}

/// Keys that name a file.
const FILES: &[[&str; 2]] = &[
    ["target", "model"],
    ["trajectory", "path"],
    ["lidar", "path"],
    ["multibeam", "path"],
    ["sound_speed", "profile"],
];

/// The name, where it is that of another procedure.
pub(super) fn another(name: &str) -> Option<&str> {
    (name != "pool" && procedures::find(name).is_some()).then_some(name)
}

fn other_procedure(document: &Document<'_>) -> Option<Problem> {
    let other = another(document.string(&["procedure"])?)?;
    let found = format!("\"{other}\", another procedure's survey");
    Some(document.problem(&["procedure"], found, "\"pool\""))
}

/// What each frame of laser points needs and what it excludes.
fn lidar_problems(document: &Document<'_>) -> Vec<Problem> {
    if document.get(&["lidar"]).is_none() {
        return vec![];
    }
    let coordinates = document
        .string(&["lidar", "coordinates"])
        .unwrap_or("sensor");
    let needed: &[&str] = match coordinates {
        "sensor" => &[
            "lever_arm_m",
            "mounting_deg",
            "range_sigma_m",
            "angle_sigma_deg",
        ],
        "target" | "geocentric" => &["point_sigma_m"],
        "utm" => &["utm_zone", "point_sigma_m"],
        _ => &[],
    };
    let has = |key: &str| document.get(&["lidar", key]).is_some();
    let mut problems: Vec<_> = needed
        .iter()
        .filter(|key| !has(key))
        .map(|key| {
            let expected = format!("this key with coordinates = \"{coordinates}\"");
            document.problem(&["lidar", key], "nothing", expected)
        })
        .collect();
    let pair = ["mounting_sigma_deg", "lever_arm_sigma_m"];
    if has(pair[0]) != has(pair[1]) {
        let (there, missing) = if has(pair[0]) {
            (pair[0], pair[1])
        } else {
            (pair[1], pair[0])
        };
        let expected = format!("it beside {there}: the scanner's calibration has both");
        problems.push(document.problem(&["lidar", missing], "nothing", expected));
    }
    problems
}

fn sound_speed_problems(document: &Document<'_>) -> Vec<Problem> {
    let section = ["sound_speed"];
    if document.get(&section).is_none() {
        return vec![];
    }
    let has = |key| document.get(&["sound_speed", key]).is_some();
    let found = match (has("speed_m_s"), has("profile")) {
        (true, true) => "both speed_m_s and profile",
        (false, false) => "neither speed_m_s nor profile",
        _ => return vec![],
    };
    vec![document.problem(&section, found, "one of them")]
}

/// Every fault of a target file's text.
pub(crate) fn target_problems(document: &Document<'_>) -> Vec<Problem> {
    let keys: &[Key] = match document.string(&["kind"]) {
        Some("pool-wall") => keys::WALL,
        Some("faces") => keys::FACES,
        _ => {
            let of_kind = |p: &Problem| p.place.ends_with(", kind");
            let mut problems = schema::check(document, keys::NO_KIND);
            problems.retain(of_kind);
            return problems;
        }
    };
    schema::check(document, keys)
}
