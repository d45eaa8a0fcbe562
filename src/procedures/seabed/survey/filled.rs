//! The survey file of recorder files: what it leaves out, and with which values it goes on.

use std::path::Path;

use super::file::SeabedSurveyFile;
use super::tide;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::missing_files;
use crate::survey::recorded::files::missing_recorders;
use crate::survey::recorded::mounted::Placed;
use crate::survey::schema;

/// What the survey file itself gives.
#[derive(Clone, Debug, Default)]
pub(super) struct Given {
    /// `[site] origin`.
    pub(super) origin: bool,
    /// `[site] water_level_m`.
    pub(super) level: bool,
    /// Of the first head, under `[multibeam]`.
    pub(super) first: Placed,
    /// Of each `[[head]]`.
    pub(super) further: Vec<Placed>,
    /// `[[line]]`.
    pub(super) lines: bool,
    /// The keys of `[trajectory]`.
    pub(super) trajectory: Vec<String>,
    /// Sigmas that were not given, with what they are taken to be.
    pub(super) assumed: Vec<(&'static str, f64)>,
    /// Sigmas of which a tenth of that is taken, as the records show less.
    pub(super) least: Vec<&'static str>,
}

impl Given {
    /// Keys of the noise that was not given, the drift apart.
    pub(super) fn noise(&self) -> Vec<&'static str> {
        let all = self.assumed.iter().map(|(key, _)| *key);
        all.chain(self.least.iter().copied())
            .filter(|key| !key.contains("drift"))
            .collect()
    }

    /// Whether a sigma is that of an ordinary installation.
    pub(super) fn assumes(&self, key: &str) -> bool {
        self.assumed.iter().any(|(own, _)| *own == key)
    }

    /// A sigma is no longer an ordinary installation's; one that was not measured either is still nobody's statement.
    pub(super) fn take_out(&mut self, key: &'static str, is_least: bool) {
        self.assumed.retain(|(own, _)| *own != key);
        self.least.extend(is_least.then_some(key));
    }
}

/// Keys that recorder files supply, or that have a value to go on with.
const SUPPLIED: &[&[&str]] = &[
    &["site"],
    &["site", "origin"],
    &["trajectory"],
    &["trajectory", "position_sigma_m"],
    &["trajectory", "position_drift_sigma_m"],
    &["trajectory", "height_drift_sigma_m"],
    &["trajectory", "drift_correlation_time_s"],
    &["trajectory", "roll_pitch_sigma_deg"],
    &["trajectory", "heading_sigma_deg"],
    &["sound_speed"],
    &["sound_speed", "profile"],
    &["multibeam", "lever_arm_m"],
    &["multibeam", "mounting_deg"],
    &["multibeam", "range_sigma_m"],
    &["multibeam", "angle_sigma_deg"],
    &["head", "lever_arm_m"],
    &["head", "mounting_deg"],
    &["line"],
    &["line", "start_s"],
    &["line", "end_s"],
];

/// Sigmas of an ordinary installation (RTK or post-processed positions, an INS of a hundredth of a degree), for what is not given.
const ASSUMED: &[(&str, &str, f64)] = &[
    ("trajectory", "position_sigma_m", 0.01),
    ("trajectory", "position_drift_sigma_m", 0.02),
    ("trajectory", "height_drift_sigma_m", 0.03),
    ("trajectory", "drift_correlation_time_s", 120.0),
    ("trajectory", "roll_pitch_sigma_deg", 0.005),
    ("trajectory", "roll_pitch_drift_sigma_deg", 0.01),
    ("trajectory", "heading_sigma_deg", 0.01),
    ("trajectory", "heading_drift_sigma_deg", 0.03),
    ("multibeam", "range_sigma_m", 0.02),
    ("multibeam", "angle_sigma_deg", 0.05),
    ("multibeam", "angle_sigma_growth", 1.0),
];

/// The survey file with values for everything that it leaves out; what the recorders supply is zero for now.
pub(super) fn draft(
    path: &Path,
    text: &str,
    folder: &Path,
    names: &[String],
) -> Result<(SeabedSurveyFile, Given), SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    let mut problems = schema::check_but(&document, SeabedSurveyFile::KEYS, SUPPLIED);
    let files = [
        ["trajectory", "path"],
        ["trajectory", "accuracies"],
        ["sound_speed", "profile"],
        tide::PATH,
    ];
    problems.extend(missing_files(&document, folder, &files));
    problems.extend(missing_recorders(&document, folder, names));
    problems.extend(half_lines(&document));
    none_of(problems)?;
    let unreadable = |words: &str| {
        let found = format!("\"{}\"", words.replace('\n', " "));
        Problem::new(path, "whole file", found, "values of the right kind")
    };
    let mut root: toml::Table = toml::from_str(text).map_err(|e| unreadable(e.message()))?;
    let given = fill(&mut root);
    let file: Result<SeabedSurveyFile, toml::de::Error> = root.try_into();
    Ok((file.map_err(|e| unreadable(e.message()))?, given))
}

/// Lines that say neither their files nor their times.
fn half_lines(document: &Document<'_>) -> Vec<Problem> {
    let lines = document.get(&["line"]);
    let lines = lines.and_then(|value| value.get_ref().as_array());
    let tables = lines.into_iter().flat_map(|list| list.iter());
    let half = tables.filter(|line| {
        let has = |key: &str| {
            line.get_ref()
                .as_table()
                .is_some_and(|t| t.contains_key(key))
        };
        !(has("files") || has("start_s") && has("end_s"))
    });
    let problem = |_| {
        let expected = "files, or start_s and end_s (seconds since 1970, UTC)";
        document.problem(&["line"], "neither times nor files", expected)
    };
    half.map(problem).collect()
}

/// The table under a key, made where there is none.
fn section<'t>(root: &'t mut toml::Table, name: &str) -> Option<&'t mut toml::Table> {
    let entry = root
        .entry(name)
        .or_insert_with(|| toml::Table::new().into());
    entry.as_table_mut()
}

/// Puts a value where there is none; whether there was one.
fn put(root: &mut toml::Table, name: &str, key: &str, value: impl Into<toml::Value>) -> bool {
    let Some(table) = section(root, name) else {
        return false;
    };
    let there = table.contains_key(key);
    table.entry(key).or_insert_with(|| value.into());
    there
}

fn zeros(keys: [&str; 3]) -> toml::Value {
    let zero = |key: &str| (key.to_owned(), toml::Value::Float(0.0));
    toml::Value::Table(keys.map(zero).into_iter().collect())
}

fn fill(root: &mut toml::Table) -> Given {
    let own = section(root, "trajectory").map(|t| t.keys().cloned().collect());
    let trajectory: Vec<String> = own.unwrap_or_default();
    let accuracies = trajectory.iter().any(|key| key == "accuracies");
    let mut assumed = vec![];
    for (name, key, value) in ASSUMED {
        let measured = accuracies && super::external::MEASURED.contains(key);
        if !put(root, name, key, *value) && !measured {
            assumed.push((*key, *value));
        }
    }
    section(root, "sound_speed");
    let level = section(root, "site").is_some_and(|t| t.contains_key("water_level_m"));
    let lines = root.contains_key("line");
    let table = root
        .entry("line")
        .or_insert_with(|| toml::Value::Array(vec![]));
    for line in table.as_array_mut().into_iter().flatten() {
        for key in ["start_s", "end_s"] {
            let line = line.as_table_mut();
            line.map(|l| l.entry(key).or_insert(toml::Value::Float(0.0)).clone());
        }
    }
    let origin = zeros(["latitude_deg", "longitude_deg", "height_m"]);
    let mounting = zeros(["roll", "pitch", "heading"]);
    let arm = toml::Value::Array(vec![toml::Value::Float(0.0); 3]);
    let further = root.get_mut("head").and_then(toml::Value::as_array_mut);
    let further = further.into_iter().flatten().filter_map(|head| {
        let table = head.as_table_mut()?;
        let mut put = |key: &str, value: &toml::Value| {
            let there = table.contains_key(key);
            table.entry(key).or_insert_with(|| value.clone());
            there
        };
        Some(Placed {
            arm: put("lever_arm_m", &arm),
            mounting: put("mounting_deg", &mounting),
        })
    });
    let further = further.collect();
    Given {
        origin: put(root, "site", "origin", origin),
        level,
        first: Placed {
            arm: put(root, "multibeam", "lever_arm_m", arm),
            mounting: put(root, "multibeam", "mounting_deg", mounting),
        },
        further,
        lines,
        trajectory,
        assumed,
        least: vec![],
    }
}

/// Says which sigmas were not given.
pub(super) fn note_defaults(given: &Given, notes: &mut Vec<String>) {
    if !given.assumed.is_empty() {
        let each = given.assumed.iter();
        let each: Vec<String> = each
            .map(|(key, value)| format!("{key} = {value}"))
            .collect();
        notes.push(format!(
            "not given in the survey file, taken as those of an ordinary installation: {}",
            each.join(", ")
        ));
    }
}
