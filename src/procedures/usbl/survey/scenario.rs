//! A USBL scenario file: the scenario, and the sections that are handed on to the survey file.

use crate::calibrate::verdict::VerdictConfig;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};

use crate::procedures::usbl::simulate::Scenario;
use crate::procedures::usbl::{JointConfig, ReferenceConfig};
use crate::simulate::scenario::complaint;
use crate::survey::ScenarioError;
use crate::survey::document::Document;
use crate::survey::schema::{self, Kind};
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

/// Reads a scenario file.
///
/// # Errors
/// [`ScenarioError`]: unreadable, not TOML, unknown keys, wrong types, impossible values.
pub fn read(file: &Path) -> Result<UsblScenarioFile, ScenarioError> {
    let unread = |e: crate::formats::FormatError| {
        let fault = format!("{}: found {}, expected {}", e.place, e.found, e.expected);
        failed(file, vec![fault])
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
    let document = Document::parse(file, text).map_err(|problems| {
        let fault = problems
            .iter()
            .map(|p| format!("{}: found {}, expected {}", p.place, p.found, p.expected));
        failed(file, fault.collect())
    })?;
    let mut faults = calibration_faults(&document);
    let (mut root, _) = DeTable::parse_recoverable(text);
    let calibration = take_calibration(&mut root);
    match deserialise(text, &mut root) {
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
            toml::from_str(&text).map_err(|e| failed(file, vec![e.message().to_owned()]))?;
        found.joint.verdict = found.verdict.clone();
        Ok(found)
    }
}

/// Faults of `[reference]`, `[joint]` and `[verdict]`.
fn calibration_faults(document: &Document<'_>) -> Vec<String> {
    let problems = schema::check(document, Calibration::KEYS);
    let own = |place: &str| {
        ["[reference]", "[joint]", "[verdict]"]
            .iter()
            .any(|section| place.contains(section))
    };
    problems
        .into_iter()
        .filter(|p| own(&p.place))
        .map(|p| format!("{}: found {}, expected {}", p.place, p.found, p.expected))
        .collect()
}

fn take_calibration(root: &mut Spanned<DeTable<'_>>) -> toml::Table {
    let mut take = |key: &str| {
        let value = root.get_mut().remove(key)?;
        let value = toml::Value::deserialize(ValueDeserializer::from(value)).ok()?;
        Some((key.to_owned(), value))
    };
    ["reference", "joint", "verdict"]
        .into_iter()
        .filter_map(&mut take)
        .collect()
}

/// The scenario, or every unknown key, then the first other misfit, then impossible values.
fn deserialise(text: &str, root: &mut Spanned<DeTable<'_>>) -> Result<Scenario, Vec<String>> {
    let mut faults = vec![];
    loop {
        let error = match Scenario::deserialize(Deserializer::from(root.clone())) {
            Ok(scenario) => {
                faults.extend(scenario.check());
                return if faults.is_empty() {
                    Ok(scenario)
                } else {
                    Err(faults)
                };
            }
            Err(error) => error,
        };
        let span = error.span();
        let begin = span.as_ref().map_or(0, |s| s.start);
        let line = 1 + text.bytes().take(begin).filter(|&b| b == b'\n').count();
        faults.push(format!("line {line}: {}", complaint(error.message())));
        let unknown = error.message().starts_with("unknown field");
        if !(unknown && span.is_some_and(|span| remove(root.get_mut(), &span))) {
            return Err(faults);
        }
    }
}

/// Removes the key at this place of the text, wherever it is; false if there is none.
fn remove(table: &mut DeTable<'_>, span: &std::ops::Range<usize>) -> bool {
    let here = table.keys().find(|key| key.span() == *span);
    if let Some(name) = here.map(|key| key.get_ref().to_string()) {
        return table.remove(name.as_str()).is_some();
    }
    let mut values = table.iter_mut().map(|(_, value)| value.get_mut());
    values.any(|value| match value {
        DeValue::Table(inner) => remove(inner, span),
        DeValue::Array(items) => items.iter_mut().any(|item| match item.get_mut() {
            DeValue::Table(inner) => remove(inner, span),
            _ => false,
        }),
        _ => false,
    })
}
