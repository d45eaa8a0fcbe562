//! A USBL scenario file: the scenario, and the sections that are handed on to the survey file.

use crate::calibrate::verdict::VerdictConfig;
use std::path::Path;

use toml::de::DeTable;

use crate::procedures::usbl::simulate::Scenario;
use crate::procedures::usbl::{JointConfig, ReferenceConfig};
use crate::survey::ScenarioError;
use crate::survey::document::Document;
use crate::survey::scenario::{calibration_faults, deserialised, take_calibration};
use crate::survey::schema::Kind;
use crate::survey::section::section;

/// A scenario and how its survey is to be calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct UsblScenarioFile {
    /// What is simulated.
    pub scenario: Scenario,
    /// The sections `[reference]`, `[joint]` and `[verdict]` as they stand.
    pub calibration: toml::Table,
}

section! {
    #[settings]
    /// The sections with every default.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Calibration {
        /// The reference path.
        reference: ReferenceConfig = or (ReferenceConfig::default()), Kind::Table(ReferenceConfig::KEYS);
        /// The joint path.
        joint: JointConfig = or (JointConfig::default()), Kind::Table(JointConfig::KEYS);
        /// Limits of the verdict, and findings that the surveyor accepts.
        verdict: VerdictConfig = or (VerdictConfig::default()), Kind::Table(VerdictConfig::KEYS);
    }
}

/// Sections that are handed on to the survey file.
const OF_CALIBRATION: &[&str] = &["reference", "joint", "verdict"];

/// Reads a scenario file.
///
/// # Errors
/// [`ScenarioError`]: unreadable, not TOML, unknown keys, wrong types, impossible values.
pub fn read(file: &Path) -> Result<UsblScenarioFile, ScenarioError> {
    let unread = |e: crate::formats::FormatError| {
        let fault = format!("{}: found {}, expected {}", e.place, e.found, e.expected);
        ScenarioError::one(file, fault)
    };
    let text = crate::formats::error::read_text(file).map_err(unread)?;
    from_text(file, &text)
}

fn failed(file: &Path, faults: Vec<String>) -> ScenarioError {
    ScenarioError {
        file: file.to_owned(),
        faults,
    }
}

/// The scenario in a text; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn from_text(file: &Path, text: &str) -> Result<UsblScenarioFile, ScenarioError> {
    let document =
        Document::parse(file, text).map_err(|problems| ScenarioError::of(file, &problems))?;
    let mut faults = calibration_faults(&document, Calibration::KEYS, OF_CALIBRATION);
    let (mut root, _) = DeTable::parse_recoverable(text);
    let calibration = take_calibration(&mut root, OF_CALIBRATION);
    match deserialised(text, &mut root, Scenario::check) {
        Ok(scenario) if faults.is_empty() => Ok(UsblScenarioFile {
            scenario,
            calibration,
        }),
        Ok(_) => Err(failed(file, faults)),
        Err(more) => {
            faults.extend(more.iter().map(|fault| document.placed(fault)));
            Err(failed(file, faults))
        }
    }
}

impl UsblScenarioFile {
    /// How the scenario is to be calibrated.
    ///
    /// # Errors
    /// [`ScenarioError`] for what reading the file let through, which is nothing.
    pub fn calibration(&self, file: &Path) -> Result<Calibration, ScenarioError> {
        let text = self.calibration.to_string();
        let mut found: Calibration =
            toml::from_str(&text).map_err(|e| ScenarioError::one(file, e.message().to_owned()))?;
        found.joint.verdict = found.verdict.clone();
        Ok(found)
    }
}
