//! Rules of a survey file that concern more than one key.

use std::path::Path;

use super::keys;
use crate::survey::document::Document;
use crate::survey::problem::Problem;
use crate::survey::reading::missing_files;
use crate::survey::schema::{self, Key};

/// Every fault of a survey file's text; where `folder` is given, also of the paths in it.
pub(crate) fn survey_problems(document: &Document<'_>, folder: Option<&Path>) -> Vec<Problem> {
    if let Some(problem) = other_procedure(document) {
        return vec![problem];
    }
    let mut problems = schema::check(document, keys::SURVEY);
    problems.extend(lidar_problems(document));
    problems.extend(sound_speed_problems(document));
    if let Some(folder) = folder {
        problems.extend(missing_files(document, folder, FILES));
    }
    problems
}

/// Keys that name a file.
const FILES: &[[&str; 2]] = &[
    ["target", "model"],
    ["trajectory", "path"],
    ["lidar", "path"],
    ["multibeam", "path"],
    ["sound_speed", "profile"],
];

fn other_procedure(document: &Document<'_>) -> Option<Problem> {
    let procedure = document.string(&["procedure"])?;
    let (found, expected) = match procedure {
        "seabed" => (
            "which is not built yet",
            "one that is built: \"pool\", \"usbl\", \"rail\"",
        ),
        "usbl" | "rail" => ("another procedure's survey", "\"pool\""),
        _ => return None,
    };
    let found = format!("\"{procedure}\", {found}");
    Some(document.problem(&["procedure"], found, expected))
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
