//! Rail scenario files.

use crate::calibrate::large::LargeConfig;
use crate::calibrate::verdict::VerdictConfig;
use std::path::Path;

use serde::Deserialize;

use super::super::profile::{BUILT_IN, built_in_model};
use super::super::profile::{RailModel, RailProfile};
use super::keys;
use super::load::{parse_model, same_names};
use crate::procedures::rail::simulate::RailScenario;
use crate::procedures::rail::{RailJointConfig, RailReferenceConfig};
use crate::survey::document::Document;
use crate::survey::problem::{Problem, SurveyError, none_of};
use crate::survey::reading::{read_text, typed};
use crate::survey::schema;

/// A scenario, its rail, and what it says of the calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct RailScenarioFile {
    /// What is simulated.
    pub scenario: RailScenario,
    /// The rail's model file.
    pub model: RailModel,
    /// The rail.
    pub rail: RailProfile,
    /// The sections `[reference]`, `[joint]`, `[verdict]` and `[large]`, handed on to the survey file.
    pub calibration: toml::Table,
}

impl RailScenarioFile {
    /// How the scenario is to be calibrated; `path` names the scenario in messages.
    ///
    /// # Errors
    /// [`SurveyError`] when a section cannot be read; its keys were checked with the scenario's.
    pub fn calibration(
        &self,
        path: &Path,
    ) -> Result<(RailReferenceConfig, RailJointConfig), SurveyError> {
        #[derive(Default, Deserialize)]
        #[serde(default)]
        struct Sections {
            reference: RailReferenceConfig,
            joint: RailJointConfig,
            verdict: VerdictConfig,
            large: LargeConfig,
        }
        let mut found: Sections = typed(path, &self.calibration.to_string())?;
        found.joint.verdict = found.verdict;
        found.joint.large = found.large.engine(path);
        Ok((found.reference, found.joint))
    }
}

/// Reads a rail scenario file; a rail that is no built-in name is read from beside it.
///
/// # Errors
/// [`SurveyError`] with every unknown key, wrong type and impossible value.
pub fn read_scenario(path: &Path) -> Result<RailScenarioFile, SurveyError> {
    let text = read_text(path)?;
    parse_scenario(path, &text, path.parent().unwrap_or(Path::new("")))
}

/// Checks and parses the text of a rail scenario; `path` names it in messages, `folder` is where its rail is looked for.
///
/// # Errors
/// As [`read_scenario`].
pub fn parse_scenario(
    path: &Path,
    text: &str,
    folder: &Path,
) -> Result<RailScenarioFile, SurveyError> {
    let document = Document::parse(path, text).map_err(|problems| SurveyError { problems })?;
    none_of(schema::check(&document, keys::SCENARIO))?;
    let mut table: toml::Table = typed(path, text)?;
    let calibration = ["reference", "joint", "verdict", "large"]
        .into_iter()
        .filter_map(|key| Some((key.to_owned(), table.remove(key)?)));
    let calibration = calibration.collect();
    let scenario: RailScenario = typed(path, &table.to_string())?;
    let place = |fault: &str| {
        let line = document.line_of_key(fault.split([':', '(']).next().unwrap_or_default());
        line.map_or("whole file".to_owned(), |line| format!("line {line}"))
    };
    let impossible =
        |fault: &String| Problem::new(path, place(fault), fault, "values that can be simulated");
    none_of(scenario.faults().iter().map(impossible).collect())?;
    none_of(same_names(
        &document,
        scenario.profiler.iter().map(|p| p.name.as_str()),
    ))?;
    let (model, rail) = match built_in_model(&scenario.rail.model) {
        Some(model) => {
            let rail = RailProfile::from_model(&model);
            let rail = rail.map_err(|e| {
                Problem::new(
                    path,
                    "[rail] model",
                    e.to_string(),
                    "a profile that can be built",
                )
            })?;
            (model, rail)
        }
        None => {
            let place = folder.join(&scenario.rail.model);
            none_of(no_model(&document, &place).into_iter().collect())?;
            parse_model(&place, &read_text(&place)?)?
        }
    };
    Ok(RailScenarioFile {
        scenario,
        model,
        rail,
        calibration,
    })
}

/// What is wrong with a name that is neither a built-in profile nor a file.
fn no_model(document: &Document<'_>, place: &Path) -> Option<Problem> {
    let known = BUILT_IN.map(|name| format!("\"{name}\"")).join(", ");
    (!place.exists()).then(|| {
        let found = format!("{}, no such file", place.display());
        let expected = format!("a built-in profile ({known}) or a file beside the scenario");
        document.problem(&["rail", "model"], found, expected)
    })
}
