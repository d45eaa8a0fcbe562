//! Scenarios whose faults are all named at once: what readers share that deserialise a scenario from its TOML tree.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};

use super::document::Document;
use super::problem::{Problem, ScenarioError};
use super::schema::{self, Key};
use crate::simulate::scenario::complaint;

impl ScenarioError {
    /// These problems of a scenario, under one file.
    pub(crate) fn of(file: &Path, problems: &[Problem]) -> Self {
        Self {
            file: file.to_owned(),
            faults: problems.iter().map(in_words).collect(),
        }
    }

    /// One fault.
    pub(crate) fn one(file: &Path, fault: String) -> Self {
        Self {
            file: file.to_owned(),
            faults: vec![fault],
        }
    }
}

fn in_words(p: &Problem) -> String {
    format!("{}: found {}, expected {}", p.place, p.found, p.expected)
}

/// Removes sections that are meant for the calibration; the survey file's reader judges them.
pub(crate) fn take_calibration(root: &mut Spanned<DeTable<'_>>, sections: &[&str]) -> toml::Table {
    let take = |key: &&str| {
        let value = root.get_mut().remove(*key)?;
        let value = toml::Value::deserialize(ValueDeserializer::from(value)).ok()?;
        Some(((*key).to_owned(), value))
    };
    sections.iter().filter_map(take).collect()
}

/// Faults of such sections, judged by the keys of a survey file.
pub(crate) fn calibration_faults(
    document: &Document<'_>,
    keys: &[Key],
    sections: &[&str],
) -> Vec<String> {
    let heads: Vec<String> = sections.iter().map(|name| format!("[{name}]")).collect();
    let own = |p: &&Problem| heads.iter().any(|head| p.place.contains(head));
    let problems = schema::check(document, keys);
    problems.iter().filter(own).map(in_words).collect()
}

/// The scenario, or every unknown key, then the first other misfit, then what `check` says of impossible values.
pub(crate) fn deserialised<T: DeserializeOwned>(
    text: &str,
    root: &mut Spanned<DeTable<'_>>,
    check: impl Fn(&T) -> Vec<String>,
) -> Result<T, Vec<String>> {
    let mut faults = vec![];
    loop {
        let error = match T::deserialize(Deserializer::from(root.clone())) {
            Ok(scenario) => {
                faults.extend(check(&scenario));
                return if faults.is_empty() {
                    Ok(scenario)
                } else {
                    Err(faults)
                };
            }
            Err(error) => error,
        };
        let words = complaint(error.message());
        faults.push(format!("line {}: {words}", line_of(text, &error)));
        let unknown = error.message().starts_with("unknown field");
        let span = error.span().filter(|_| unknown);
        if !span.is_some_and(|span| remove(root.get_mut(), &span)) {
            return Err(faults);
        }
    }
}

/// The line of the text that an error is in.
pub(crate) fn line_of(text: &str, error: &toml::de::Error) -> usize {
    let begin = error.span().map_or(0, |span| span.start);
    1 + text.bytes().take(begin).filter(|&b| b == b'\n').count()
}

/// Removes the key at this place of the text, wherever it is; false if there is none.
fn remove(table: &mut DeTable<'_>, span: &Range<usize>) -> bool {
    let here = table.keys().find(|key| key.span() == *span);
    if let Some(name) = here.map(|key| key.get_ref().to_string()) {
        return table.remove(name.as_str()).is_some();
    }
    let mut values = table.iter_mut().map(|(_, value)| value.get_mut());
    values.any(|value| remove_below(value, span))
}

fn remove_below(value: &mut DeValue<'_>, span: &Range<usize>) -> bool {
    match value {
        DeValue::Table(table) => remove(table, span),
        DeValue::Array(values) => values.iter_mut().any(|v| remove_below(v.get_mut(), span)),
        _ => false,
    }
}
