//! From the path of a rail survey file to everything in memory.

use std::path::Path;

use super::super::formats::{rail_csv, read_profiles, read_table};
use super::super::observed::RailCampaign;
use super::super::profile::{RailModel, RailProfile};
use super::file::RailSurveyFile;
use super::keys;
use crate::formats::digest::Stamps;
use crate::formats::read_attitude;
use crate::results::InputFile;
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{digests, keep, missing_files, read_text, typed};
use crate::survey::schema;

/// A rail survey in memory.
#[derive(Clone, Debug)]
pub struct LoadedRail {
    /// The survey file with every default filled in.
    pub file: RailSurveyFile,
    /// The observations.
    pub campaign: RailCampaign,
    /// The standard profile.
    pub rail: RailProfile,
    /// Every file that was read, the survey file first.
    pub inputs: Vec<InputFile>,
}

/// Reads a rail survey file and every file that it names.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong: first with the survey file itself, then with the files.
pub fn load(path: &Path) -> Result<LoadedRail, SurveyError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut stamps = Stamps::begin(path);
    let file = parse_survey(path, &read_text(path)?, Some(folder))?;
    let named = [
        &file.rail.model,
        &file.profiles.path,
        &file.attitude.path,
        &file.table.path,
    ];
    let [model, profiles, attitude, table] = named.map(|name| folder.join(name));
    stamps.add(named.map(|name| folder.join(name)));
    let mut problems = vec![];
    let rail = keep(
        &mut problems,
        read_text(&model).and_then(|text| parse_model(&model, &text)),
    );
    let points = read_profiles(&profiles, file.profiler.len());
    let points = keep(&mut problems, points.map_err(SurveyError::from));
    let record = keep(
        &mut problems,
        read_attitude(&attitude, &rail_csv::BEAM).map_err(SurveyError::from),
    );
    let positions = keep(&mut problems, read_table(&table).map_err(SurveyError::from));
    let (Some((_, rail)), Some(points), Some(attitude), Some(positions)) =
        (rail, points, record, positions)
    else {
        return Err(SurveyError { problems });
    };
    let campaign = RailCampaign {
        profilers: file.profilers(),
        attitude_noise: file.attitude_noise(),
        stand: file.stand(),
        points,
        attitude,
        table: positions,
    };
    none_of(clock_problems(&campaign, &profiles, &table))?;
    let inputs = digests(path, folder, &named.map(String::as_str))?;
    stamps.unchanged()?;
    Ok(LoadedRail {
        campaign,
        rail,
        inputs,
        file,
    })
}

/// Clocks that never meet: no point while the table rests.
fn clock_problems(campaign: &RailCampaign, profiles: &Path, table: &Path) -> Vec<Problem> {
    let times = &campaign.points.time_s;
    if times.iter().any(|&t| campaign.table.at(t).is_some()) {
        return vec![];
    }
    let range = |first: Option<&f64>, last: Option<&f64>| {
        let shown = |t: Option<&f64>| t.copied().unwrap_or(f64::NAN);
        format!("{} to {} s", shown(first), shown(last))
    };
    let found = range(times.first(), times.last());
    let rests = range(campaign.table.from_s.first(), campaign.table.to_s.last());
    let expected = format!(
        "profiles while the table rests ({}: {rests})",
        table.display()
    );
    vec![Problem::new(profiles, "column time_s", found, expected)]
}

/// Checks and parses the text of a rail survey file; with a folder, also that the paths in it lead to files.
///
/// # Errors
/// [`SurveyError`] with everything that is wrong with it.
pub fn parse_survey(
    path: &Path,
    text: &str,
    folder: Option<&Path>,
) -> Result<RailSurveyFile, SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    let mut problems = schema::check(&document, RailSurveyFile::KEYS);
    problems.extend(
        folder
            .iter()
            .flat_map(|folder| missing_files(&document, folder, FILES)),
    );
    none_of(problems)?;
    let mut file: RailSurveyFile = typed(path, text)?;
    file.joint.verdict = file.verdict.clone();
    if let Some(large) = &file.large {
        file.joint.large = large.engine(path);
    }
    none_of(same_names(
        &document,
        file.profiler.iter().map(|p| p.name.as_str()),
    ))?;
    Ok(file)
}

/// Profilers of the same name could not be told apart in a result.
pub(super) fn same_names<'n>(
    document: &Document<'_>,
    names: impl Iterator<Item = &'n str>,
) -> Vec<Problem> {
    let mut seen: Vec<&str> = vec![];
    let mut problems = vec![];
    for name in names {
        if seen.contains(&name) {
            problems.push(document.problem(
                &["profiler"],
                format!("two profilers named \"{name}\""),
                "a name of its own for each",
            ));
        }
        seen.push(name);
    }
    problems
}

/// Keys that name a file.
const FILES: &[[&str; 2]] = &[
    ["rail", "model"],
    ["profiles", "path"],
    ["attitude", "path"],
    ["table", "path"],
];

/// Checks and parses the text of a rail model file; `path` names it in messages.
///
/// # Errors
/// [`SurveyError`] with every unknown key and every impossible element.
pub fn parse_model(path: &Path, text: &str) -> Result<(RailModel, RailProfile), SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    none_of(schema::check(&document, keys::MODEL))?;
    let model: RailModel = typed(path, text)?;
    let profile = RailProfile::from_model(&model).map_err(|error| SurveyError {
        problems: error
            .faults
            .iter()
            .map(|fault| Problem::new(path, "elements", fault, "a profile that can be built"))
            .collect(),
    })?;
    Ok((model, profile))
}
