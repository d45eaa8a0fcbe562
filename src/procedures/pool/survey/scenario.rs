//! Scenario files: a survey file's keys plus what only the simulator needs; read with every fault named at once.

use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::large::LargePoolConfig;
use super::rules::another;
use crate::calibrate::verdict::VerdictConfig;
use crate::formats::FormatError;
use crate::formats::error::read_text;
use crate::procedures::pool::{JointConfig, SequentialConfig};
use crate::recorders::recording::Kongsberg;
use crate::simulate::Scenario;
use crate::survey::document::Document;
use crate::survey::problem::{ScenarioError, SurveyError};
use crate::survey::procedure::OF_SCENARIO;
use crate::survey::scenario::{calibration_faults, deserialised, line_of, take_calibration};
use crate::survey::schema::Kind;
use crate::survey::section::section;

/// A scenario, and what it says of the survey files and the calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenarioFile {
    /// The file, for messages.
    pub file: PathBuf,
    /// What is simulated.
    pub scenario: Scenario,
    /// Name of the trajectory file to write: `.csv`, `.out` or `.sbet`.
    pub trajectory: String,
    /// Name of the laser file to write: `.laz`, `.las` or `.csv`.
    pub lidar: String,
    /// Name of the soundings file to write: `.csv`, or `.all` or `.kmall` as a recorder's.
    pub multibeam: String,
    /// The sections `[sequential]`, `[joint]`, `[verdict]` and `[large]`, copied to the survey file as they are.
    pub calibration: toml::Table,
}

/// Reads a scenario file; a target given as a path is read from beside it.
///
/// # Errors
/// [`ScenarioError`]: unreadable, not TOML, unknown keys (all of them, with the nearest known one), wrong types, impossible values.
pub fn read(file: &Path) -> Result<ScenarioFile, ScenarioError> {
    let text = read_text(file).map_err(unread)?;
    beside(file, &text)
}

/// The scenario in the text of a file; a target given as a path is read from beside the file.
///
/// # Errors
/// As [`read`].
pub fn beside(file: &Path, text: &str) -> Result<ScenarioFile, ScenarioError> {
    let folder = file.parent().unwrap_or(Path::new("."));
    parse(file, text, |model| {
        read_text(&folder.join(model)).map_err(unread)
    })
}

/// The scenario in a text that names no other file, such as the demo's; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn from_text(file: &Path, text: &str) -> Result<ScenarioFile, ScenarioError> {
    let absent = |model: &str| {
        FormatError::unreadable(Path::new(model), &std::io::ErrorKind::NotFound.into())
    };
    parse(file, text, |model| Err(unread(absent(model))))
}

section! {
    #[settings]
    /// The sections `[sequential]`, `[joint]`, `[verdict]` and `[large]` with every default.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Calibration {
        /// The reference path.
        sequential: SequentialConfig = or (SequentialConfig::default()), Kind::Table(SequentialConfig::KEYS);
        /// The joint path.
        joint: JointConfig = or (JointConfig::default()), Kind::Table(JointConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
        /// Surveys with long trajectories.
        #[serde(skip_serializing_if = "Option::is_none")]
        large: Option<LargePoolConfig> = or (None), Kind::Table(LargePoolConfig::KEYS);
    }
}

impl ScenarioFile {
    /// How the scenario is to be calibrated; `file` names the scenario in messages.
    ///
    /// # Errors
    /// [`ScenarioError`] for what reading the file let through, which is nothing.
    pub fn calibration(&self, file: &Path) -> Result<Calibration, ScenarioError> {
        let mut found: Calibration = toml::from_str(&self.calibration.to_string())
            .map_err(|e| ScenarioError::one(file, e.message().to_owned()))?;
        found.joint.verdict = found.verdict.clone();
        if let Some(large) = &found.large {
            found.joint.large = large.engine(file);
        }
        Ok(found)
    }
}

/// What is wrong with a file that cannot be read, under its own name.
fn unread(error: FormatError) -> ScenarioError {
    let place = error.place;
    let (found, expected) = (error.found, error.expected);
    ScenarioError::one(
        &error.file,
        format!("{place}: found {found}, expected {expected}"),
    )
}

/// What is wrong with a target file that a scenario names, under its own name.
fn in_target(error: &SurveyError) -> ScenarioError {
    let file = error.problems.first().map(|p| p.file.clone());
    ScenarioError::of(&file.unwrap_or_default(), &error.problems)
}

/// The faults with their lines.
fn placed(document: &Document<'_>, faults: &[String]) -> ScenarioError {
    ScenarioError {
        file: document.file().to_owned(),
        faults: faults.iter().map(|fault| document.placed(fault)).collect(),
    }
}

/// Names of files to write that would lead out of the survey's folder.
fn paths_out(paths: &[(&str, Option<&str>)]) -> Vec<String> {
    let leads_out =
        |name: &str| name.contains(['/', '\\', ':']) || name.starts_with('.') || name.is_empty();
    let named = paths.iter().filter_map(|(key, name)| Some((key, (*name)?)));
    named
        .filter(|(_, name)| leads_out(name))
        .map(|(key, name)| {
            format!("{key} = \"{name}\", expected the name of a file, without folders")
        })
        .collect()
}

/// Sections that are handed on to the survey file.
const OF_CALIBRATION: &[&str] = &["sequential", "joint", "verdict", "large"];

fn parse(
    file: &Path,
    text: &str,
    open: impl Fn(&str) -> Result<String, ScenarioError>,
) -> Result<ScenarioFile, ScenarioError> {
    let mut root = table_of(file, text)?;
    let document =
        Document::parse(file, text).map_err(|problems| ScenarioError::of(file, &problems))?;
    if let Some(found) = other_kind(&root) {
        return Err(ScenarioError::one(
            file,
            format!("found {found}, expected a scenario of a pool survey"),
        ));
    }
    let model_text = match path_of_model(&root) {
        Some(path) => Some((
            open(&path)?,
            file.parent().unwrap_or(Path::new("")).join(path),
        )),
        None => None,
    };
    if let Some((model_text, model_file)) = &model_text {
        super::load::parse_target(model_file, model_text).map_err(|e| in_target(&e))?;
        insert_model(&mut root, table_of(model_file, model_text)?);
    }
    let name = |root: &mut Spanned<DeTable<'_>>, section, default: &str| {
        take_text(root, section, "path").unwrap_or_else(|| default.to_owned())
    };
    let trajectory = take_text(&mut root, "trajectory", "path");
    let (lidar, multibeam) = (
        name(&mut root, "lidar", "lidar.laz"),
        name(&mut root, "multibeam", "multibeam.csv"),
    );
    root.get_mut().remove("procedure");
    let calibration = take_calibration(&mut root, OF_CALIBRATION);
    let mut faults = calibration_faults(&document, Calibration::KEYS, OF_CALIBRATION);
    faults.extend(paths_out(&[
        ("trajectory.path", trajectory.as_deref()),
        ("lidar.path", Some(&lidar)),
        ("multibeam.path", Some(&multibeam)),
    ]));
    let found = deserialised(text, &mut root, Scenario::check).map_err(|more| faults.extend(more));
    let Ok(mut scenario) = found else {
        return Err(placed(&document, &faults));
    };
    if recorder(&multibeam).is_some() {
        scenario.multibeam.arrays.get_or_insert_default();
    }
    if !faults.is_empty() {
        return Err(placed(&document, &faults));
    }
    let recorded = if scenario.trajectory.velocity {
        "trajectory.out"
    } else {
        "trajectory.csv"
    };
    Ok(ScenarioFile {
        file: file.to_owned(),
        trajectory: trajectory.unwrap_or_else(|| recorded.to_owned()),
        lidar,
        multibeam,
        calibration,
        scenario,
    })
}

/// The recorder's format that a soundings file's name asks for.
pub(super) fn recorder(name: &str) -> Option<Kongsberg> {
    Kongsberg::of_ending(name.rsplit_once('.')?.1)
}

fn table_of<'t>(file: &Path, text: &'t str) -> Result<Spanned<DeTable<'t>>, ScenarioError> {
    let (root, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(root);
    }
    let faults = errors
        .iter()
        .map(|e| format!("line {}: {}", line_of(text, e), e.message()))
        .collect();
    Err(ScenarioError {
        file: file.to_owned(),
        faults,
    })
}

/// What a file is that is no pool scenario but has the keys of another kind.
fn other_kind(root: &Spanned<DeTable<'_>>) -> Option<String> {
    let has = |key: &&str| root.get_ref().contains_key(*key);
    let value = root.get_ref().get("procedure");
    let procedure = value.and_then(|v| v.get_ref().as_str());
    if let Some(other) = procedure.and_then(another) {
        let words = "for which there are demo, simulate, calibrate, check and budget";
        return Some(format!("a {other} file (procedure = \"{other}\"), {words}"));
    }
    match procedure {
        _ if OF_SCENARIO.iter().any(has) => None,
        Some(procedure) => Some(format!(
            "a survey file (procedure = \"{procedure}\", no [[pass]]): what was measured, for `boresight calibrate`"
        )),
        None => has(&"kind").then(|| "a target file (kind, no [[pass]])".to_owned()),
    }
}

fn path_of_model(root: &Spanned<DeTable<'_>>) -> Option<String> {
    let target = root.get_ref().get("target")?.get_ref().as_table()?;
    Some(target.get("model")?.get_ref().as_str()?.to_owned())
}

fn insert_model<'t>(root: &mut Spanned<DeTable<'t>>, model: Spanned<DeTable<'t>>) {
    let target = root.get_mut().get_mut("target").map(Spanned::get_mut);
    if let Some(DeValue::Table(target)) = target
        && let Some(value) = target.get_mut("model")
    {
        *value.get_mut() = DeValue::Table(model.into_inner());
    }
}

/// Removes a text from a section and returns it.
fn take_text(root: &mut Spanned<DeTable<'_>>, section: &str, key: &str) -> Option<String> {
    let DeValue::Table(table) = root.get_mut().get_mut(section)?.get_mut() else {
        return None;
    };
    let text = table.get(key)?.get_ref().as_str()?.to_owned();
    table.remove(key);
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::DEMO;

    fn faults_of(text: &str) -> Vec<String> {
        from_text(Path::new("s.toml"), text)
            .expect_err("faults")
            .faults
    }

    #[test]
    fn every_unknown_key_is_named_with_its_line_and_the_nearest_one() {
        let text = DEMO
            .replace("line_rate_hz", "line_rate")
            .replace("floor_m", "flor_m")
            .replace("[motion]", "[motoin]");
        let faults = faults_of(&text);
        assert_eq!(faults.len(), 3, "{faults:?}");
        let line = 1 + text
            .lines()
            .position(|l| l.starts_with("line_rate ="))
            .expect("the line");
        let expected = format!(
            "line {line}: unknown key \"line_rate\", the nearest known one is \"line_rate_hz\""
        );
        assert!(faults.contains(&expected), "{faults:?}");
        assert!(
            faults
                .iter()
                .any(|f| f.ends_with("the nearest known one is \"floor_m\""))
        );
        assert!(
            faults
                .iter()
                .any(|f| f.ends_with("the nearest known one is \"motion\""))
        );
    }

    #[test]
    fn impossible_values_are_listed_together() {
        let text = DEMO
            .replace("beams = 256", "beams = 1")
            .replace("speed_m_s = 0.8", "speed_m_s = -1.0");
        let faults = faults_of(&text);
        assert!(
            faults.iter().any(|f| f.starts_with("line ")
                && f.ends_with("multibeam.beams = 1, expected 2 to 30000")),
            "{faults:?}"
        );
        assert!(
            faults
                .iter()
                .filter(|f| f.contains("speed_m_s = -1"))
                .count()
                == 3,
            "{faults:?}"
        );
    }

    #[test]
    fn files_of_another_kind_are_called_what_they_are() {
        let survey = faults_of("procedure = \"pool\"\n[target]\nmodel = \"target.toml\"\n");
        assert_eq!(survey.len(), 1, "{survey:?}");
        assert!(
            survey[0].starts_with("found a survey file (procedure = \"pool\""),
            "{survey:?}"
        );
        assert!(
            survey[0].ends_with("expected a scenario of a pool survey"),
            "{survey:?}"
        );
        let target = faults_of("kind = \"pool-wall\"\n");
        assert!(target[0].starts_with("found a target file"), "{target:?}");
        let usbl = faults_of(&DEMO.replace("procedure = \"pool\"", "procedure = \"usbl\""));
        assert!(usbl[0].starts_with("found a usbl file"), "{}", usbl[0]);
        let seabed = faults_of(&DEMO.replace("procedure = \"pool\"", "procedure = \"seabed\""));
        assert!(seabed[0].starts_with("found a seabed file"), "{seabed:?}");
        assert!(from_text(Path::new("s.toml"), DEMO).is_ok());
    }

    #[test]
    fn broken_toml_names_its_line() {
        assert!(
            faults_of("name = \n\n")
                .first()
                .is_some_and(|f| f.starts_with("line 1"))
        );
    }

    #[test]
    fn calibration_sections_and_paths_are_handed_on() {
        let text = DEMO.replace(
            "[lidar]",
            "[joint]\ndrift = \"off\"\n\n[lidar]\npath = \"points.las\"",
        );
        let file = from_text(Path::new("s.toml"), &text).expect("a scenario");
        assert_eq!(file.lidar, "points.las");
        assert_eq!(file.calibration["joint"]["drift"].as_str(), Some("off"));
        assert_eq!(file.trajectory, "trajectory.csv");
        let found = file.calibration(Path::new("s.toml")).expect("sections");
        assert_eq!(
            found.joint.drift,
            crate::procedures::pool::config::Drift::Off
        );
        assert_eq!(found.sequential, SequentialConfig::default());
    }

    #[test]
    fn wrong_calibration_sections_are_listed() {
        let text = DEMO.replace(
            "[lidar]",
            "[joint]\ndrift = \"of\"\ngate_sigma = 2.0\n[sequential]\nvariants = \"literal\"\n\n[lidar]",
        );
        let error = from_text(Path::new("s.toml"), &text).expect_err("faults");
        let text = error.to_string();
        assert_eq!(error.faults.len(), 3, "{text}");
        for expected in [
            "[joint] drift: found \"of\"",
            "[joint] gate_sigma",
            "nearest: variant",
        ] {
            assert!(text.contains(expected), "{expected} in {text}");
        }
    }
}
