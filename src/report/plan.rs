//! A survey plan for the terminal, as JSON, as a tidy CSV table and as a page.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use comfy_table::CellAlignment;

use super::format::{finer, three_digits as digits};
use super::text::ruled_table;
use super::{ReportError, html, json};
use crate::results::{BudgetParameter, Figures, PlanResult, SweepValue, write_whole};

/// Steps that the terminal shows.
const SHOWN: usize = 12;

/// Where the files are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenPlan {
    /// `plan.json`.
    pub json: PathBuf,
    /// `plan.csv`.
    pub table: PathBuf,
    /// `plan.html`.
    pub page: PathBuf,
}

/// Writes `plan.json`, `plan.csv` and `plan.html` into `folder`, each whole or not at all.
///
/// # Errors
/// [`ReportError`]; all texts are made before the first is written.
pub fn write_plan(folder: &Path, result: &PlanResult) -> Result<WrittenPlan, ReportError> {
    let bytes = to_bytes(result)?;
    let page = html::plan(result)?;
    let written = WrittenPlan {
        json: folder.join("plan.json"),
        table: folder.join("plan.csv"),
        page: folder.join("plan.html"),
    };
    write_whole(&written.json, &bytes)?;
    write_whole(&written.table, table(result).as_bytes())?;
    write_whole(&written.page, page.as_bytes())?;
    Ok(written)
}

/// The bytes of `plan.json`; the same result gives the same bytes.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &PlanResult) -> serde_json::Result<Vec<u8>> {
    json::lines(result)
}

/// One row per set of standard deviations: `plan.csv`. `kind` is `wanted`, `sailed`, `candidate`, `chosen`, `floor` or `variation`.
#[must_use]
pub fn table(result: &PlanResult) -> String {
    let column = |p: &BudgetParameter| format!("{}_sigma_{}", p.name, p.unit);
    let columns: Vec<String> = result.parameters.iter().map(column).collect();
    let mut text = format!("kind,number,what,{}\n", columns.join(","));
    let mut row = |kind: &str, number: usize, what: &str, figures: Option<&Figures>| {
        let cell = |i: usize| {
            figures
                .and_then(|f| f[i])
                .map_or_else(String::new, |v: f64| v.to_string())
        };
        let cells: Vec<String> = (0..columns.len()).map(cell).collect();
        let cells = cells.join(",");
        let _ = writeln!(
            text,
            "{kind},{number},\"{}\",{cells}",
            what.replace('"', "\"\"")
        );
    };
    row("wanted", 0, "", Some(&result.wanted));
    if let Some(six) = &result.sailed_standard_deviation {
        row("sailed", result.sailed.len(), "", Some(six));
    }
    for (k, c) in result.candidates.iter().enumerate() {
        row(
            "candidate",
            k + 1,
            &c.pass.name,
            c.standard_deviation_if_next.as_ref(),
        );
    }
    for (k, step) in result.chosen.iter().enumerate() {
        row("chosen", k + 1, &step.name, Some(&step.standard_deviation));
    }
    row("floor", 0, "", result.floor.as_ref());
    for (k, point) in result.variations.iter().flat_map(|v| &v.points).enumerate() {
        row(
            "variation",
            k + 1,
            &values(&point.values),
            point.standard_deviation.as_ref(),
        );
    }
    text
}

fn values(values: &[SweepValue]) -> String {
    let all: Vec<String> = values.iter().map(ToString::to_string).collect();
    all.join(", ")
}

/// A parameter's figure in the unit shown.
fn cell(result: &PlanResult, figures: Option<&Figures>, i: usize) -> String {
    let factor = finer(&result.parameters[i].unit).1;
    let value = figures.and_then(|f| f[i]).map(|v| digits(v * factor));
    value.unwrap_or_else(|| "-".to_owned())
}

/// What the plan comes to, in one or two sentences.
#[must_use]
pub fn verdict(result: &PlanResult) -> String {
    match (result.passes_needed, result.unreachable.as_slice()) {
        (Some(0), _) => "What is sailed reaches everything that is wanted.".to_owned(),
        (Some(1), _) => "One more pass reaches everything that is wanted.".to_owned(),
        (Some(n), _) => format!("{n} more passes reach everything that is wanted."),
        (None, []) if result.chosen.is_empty() => {
            "None of the candidates is seen by both sensors.".to_owned()
        }
        (None, []) => format!(
            "{} more passes do not reach what is wanted; --most allows more, or other candidates do better.",
            result.chosen.len()
        ),
        (None, names) => format!(
            "No number of these passes reaches what is wanted of {}.",
            names
                .iter()
                .map(|n| floor_of(result, n))
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

/// "pitch (floor 0.016 deg, wanted 0.015 deg)".
fn floor_of(result: &PlanResult, name: &str) -> String {
    let place = result.parameters.iter().position(|p| p.name == name);
    let (Some(i), Some(floor)) = (place, &result.floor) else {
        return name.to_owned();
    };
    let unit = finer(&result.parameters[i].unit).0;
    format!(
        "{name} (floor {} {unit}, wanted {} {unit})",
        cell(result, Some(floor), i),
        cell(result, Some(&result.wanted), i)
    )
}

/// The summary for the terminal. Ends with a newline.
#[must_use]
pub fn summary(result: &PlanResult) -> String {
    let mut text = format!("Plan for {}: {}\n", result.scenario, verdict(result));
    text.push_str(&state(result));
    text.push_str(&candidates(result));
    text.push_str(&order(result));
    text.push_str(&variations(result));
    for note in &result.notes {
        let _ = writeln!(text, "\nNote: {note}.");
    }
    text
}

/// A table of sigmas with some columns of words before them.
fn sigmas<'a>(
    result: &PlanResult,
    before: &[&str],
    rows: impl Iterator<Item = (Vec<String>, Option<&'a Figures>)>,
) -> String {
    let mut table = ruled_table();
    let words = before.iter().map(|w| (*w).to_owned());
    let parameters = result.parameters.iter();
    let heads = parameters.map(|p| format!("{}, {}", p.name, finer(&p.unit).0));
    table.set_header(words.chain(heads));
    for (words, figures) in rows {
        let cells = (0..result.parameters.len()).map(|i| cell(result, figures, i));
        table.add_row(words.into_iter().chain(cells));
    }
    let numbers = table.column_iter_mut().skip(before.len());
    numbers.for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let mut text = table.trim_fmt();
    text.push('\n');
    text
}

fn state(result: &PlanResult) -> String {
    let sailed = match result.sailed.len() {
        0 => "nothing sailed yet".to_owned(),
        1 => "the scenario's pass".to_owned(),
        n => format!("the scenario's {n} passes"),
    };
    let rows = [
        ("wanted".to_owned(), Some(&result.wanted)),
        (sailed, result.sailed_standard_deviation.as_ref()),
        ("a million of each".to_owned(), result.floor.as_ref()),
    ];
    let rows = rows.into_iter().map(|(word, six)| (vec![word], six));
    format!("\nStandard deviations\n{}", sigmas(result, &["with"], rows))
}

fn candidates(result: &PlanResult) -> String {
    let all = result.candidates.iter().enumerate();
    let (told, refused): (Vec<_>, Vec<_>) = all.partition(|(_, c)| c.refusal.is_empty());
    let rows = told.into_iter().map(|(k, c)| {
        let words = vec![(k + 1).to_string(), c.pass.name.clone()];
        (words, c.standard_deviation_if_next.as_ref())
    });
    let mut text = format!(
        "\nIf one of these were sailed next\n{}",
        sigmas(result, &["", "pass"], rows)
    );
    let mut reasons: Vec<(&str, Vec<&str>)> = vec![];
    for (_, c) in refused {
        match reasons.iter_mut().find(|(reason, _)| *reason == c.refusal) {
            Some((_, names)) => names.push(&c.pass.name),
            None => reasons.push((&c.refusal, vec![&c.pass.name])),
        }
    }
    for (reason, names) in reasons {
        let _ = writeln!(text, "not offered: {}: {reason}", names.join("; "));
    }
    text
}

fn order(result: &PlanResult) -> String {
    if result.chosen.is_empty() {
        return String::new();
    }
    let all = result.chosen.iter().enumerate();
    let last = result.chosen.len();
    let kept = all.filter(|(k, _)| last <= SHOWN || *k + 1 < SHOWN || *k + 1 == last);
    let rows = kept.map(|(k, step)| {
        let words = vec![(k + 1).to_string(), step.name.clone()];
        (words, Some(&step.standard_deviation))
    });
    let mut text = format!(
        "\nOrder to sail, {}\n{}",
        result.criterion.title(),
        sigmas(result, &["", "pass"], rows)
    );
    if last > SHOWN {
        let _ = writeln!(text, "passes {SHOWN} to {} are in plan.csv", last - 1);
    }
    text
}

fn variations(result: &PlanResult) -> String {
    let Some(variations) = &result.variations else {
        return String::new();
    };
    let keys: Vec<&str> = variations.keys.iter().map(String::as_str).collect();
    let rows = variations.points.iter().map(|p| {
        let words = p.values.iter().map(ToString::to_string).collect();
        (words, p.standard_deviation.as_ref())
    });
    let mut text = format!(
        "\nThe scenario's own passes, compared\n{}",
        sigmas(result, &keys, rows)
    );
    for p in variations.points.iter().filter(|p| !p.refusal.is_empty()) {
        let _ = writeln!(text, "{}: {}", values(&p.values), p.refusal);
    }
    text
}
