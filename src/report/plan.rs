//! A survey plan for the terminal, as JSON, as a tidy CSV table and as a page.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::format::{finer, two_digits as digits};
use super::{ReportError, courses, html, json};
use crate::files::land;
use crate::results::{BudgetParameter, Figures, PlanCandidate, PlanResult, SweepValue};
use crate::ruled::Ruled;

/// Figures below this are shown as zero: a ten-thousandth of a degree or of a millimetre.
const SMALL: f64 = 1e-4;

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
    /// `plan.kml`, `plan.gpx` and `plan.geojson`.
    pub courses: [PathBuf; 3],
}

/// Files of a plan.
pub const PLAN_FILES: [&str; 6] = [
    "plan.json",
    "plan.csv",
    "plan.html",
    "plan.kml",
    "plan.gpx",
    "plan.geojson",
];

/// Writes `plan.json`, `plan.csv`, `plan.html` and the courses as KML, GPX and `GeoJSON` into `folder`, together or not at all.
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
        courses: ["plan.kml", "plan.gpx", "plan.geojson"].map(|name| folder.join(name)),
    };
    let (table, kml, gpx) = (table(result), courses::kml(result), courses::gpx(result));
    let geojson = courses::geojson(result)?;
    let texts: [&[u8]; 6] = [
        &bytes,
        table.as_bytes(),
        page.as_bytes(),
        kml.as_bytes(),
        gpx.as_bytes(),
        &geojson,
    ];
    let files: Vec<(&str, &[u8])> = PLAN_FILES.into_iter().zip(texts).collect();
    land(folder, &files)?;
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
    match figures.and_then(|f| f[i]).map(|v| v * factor) {
        None => "-".to_owned(),
        Some(value) if value < SMALL => "0.000".to_owned(),
        Some(value) => digits(value),
    }
}

/// What the plan comes to, in one or two sentences.
#[must_use]
pub fn verdict(result: &PlanResult) -> String {
    match (result.passes_needed, result.unreachable.as_slice()) {
        (Some(0), _) => "The passes sailed already reach everything that is wanted.".to_owned(),
        (Some(1), _) => format!(
            "One more pass reaches everything that is wanted: {}.",
            to_sail(result)
        ),
        (Some(n), _) => format!(
            "{n} more passes reach everything that is wanted: {}.",
            to_sail(result)
        ),
        (None, []) if result.chosen.is_empty() => {
            "None of the candidates adds any information.".to_owned()
        }
        (None, []) => format!(
            "{} more passes do not reach what is wanted; allow more with --most, or try other candidates.",
            result.chosen.len()
        ),
        (None, names) => format!(
            "No number of these passes reaches what is wanted for {}.",
            names
                .iter()
                .map(|n| floor_of(result, n))
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

/// "2 times 12 m, 0.5 m/s, +Y and 6 m, 0.5 m/s, +Y (3.6 min of passes)".
fn to_sail(result: &PlanResult) -> String {
    let mut order: Vec<(u64, usize)> = vec![];
    for step in &result.chosen {
        match order.iter_mut().find(|(c, _)| *c == step.candidate) {
            Some((_, times)) => *times += 1,
            None => order.push((step.candidate, 1)),
        }
    }
    let seconds: f64 = order
        .iter()
        .filter_map(|(c, times)| {
            let pass = &result.candidates.get(*c as usize)?.pass;
            Some(pass.duration_s() * *times as f64)
        })
        .sum();
    let names: Vec<String> = order
        .iter()
        .filter_map(|(c, times)| {
            let name = &result.candidates.get(*c as usize)?.pass.name;
            Some(match times {
                1 => name.clone(),
                n => format!("{n} times {name}"),
            })
        })
        .collect();
    format!("{} ({:.1} min of passes)", names.join("; "), seconds / 60.0)
}

/// "pitch (floor 0.016 deg, wanted 0.015 deg)".
fn floor_of(result: &PlanResult, name: &str) -> String {
    let place = result.parameters.iter().position(|p| p.name == name);
    let (Some(i), Some(floor)) = (place, &result.floor) else {
        return name.to_owned();
    };
    let unit = finer(&result.parameters[i].unit).0;
    format!(
        "{name} (limit {} {unit}, wanted {} {unit})",
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
    let words = before.iter().map(|w| (*w).to_owned());
    let parameters = result.parameters.iter();
    let heads = parameters.map(|p| p.name.clone());
    let mut table = Ruled::new(words.chain(heads)).texts(before.len());
    for (words, figures) in rows {
        let cells = (0..result.parameters.len()).map(|i| cell(result, figures, i));
        table.row(words.into_iter().chain(cells));
    }
    format!("{table}\n")
}

/// "deg and mm".
fn units(result: &PlanResult) -> String {
    let mut all: Vec<&str> = result.parameters.iter().map(|p| finer(&p.unit).0).collect();
    all.dedup();
    all.join(" and ")
}

/// A pass's name without the unit of its crab angle, for narrow tables.
fn narrow(name: &str) -> String {
    name.trim_end_matches(" deg").to_owned()
}

fn state(result: &PlanResult) -> String {
    let sailed = match result.sailed.len() {
        0 => "nothing sailed yet".to_owned(),
        1 => "the pass sailed".to_owned(),
        n => format!("the {n} passes sailed"),
    };
    let rows = [
        ("wanted".to_owned(), Some(&result.wanted)),
        (sailed, result.sailed_standard_deviation.as_ref()),
        ("the limit".to_owned(), result.floor.as_ref()),
    ];
    let rows = rows
        .into_iter()
        .filter(|(word, six)| six.is_some() || word != "the limit")
        .map(|(word, six)| (vec![word], six));
    let title = format!("Standard deviations, {}", units(result));
    format!("\n{title}\n{}", sigmas(result, &["with"], rows))
}

fn candidates(result: &PlanResult) -> String {
    let all = result.candidates.iter().enumerate();
    let (told, refused): (Vec<_>, Vec<_>) = all.partition(|(_, c)| c.refusal.is_empty());
    let best = best(result, told);
    let more = result.candidates.len() - refused.len() - best.len();
    let rows = best.into_iter().map(|(k, c)| {
        let words = vec![(k + 1).to_string(), narrow(&c.pass.name)];
        (words, c.standard_deviation_if_next.as_ref())
    });
    let mut text = format!(
        "\nIf one of these were sailed next\n{}",
        sigmas(result, &["", "pass"], rows)
    );
    if more > 0 {
        let _ = writeln!(text, "and {more} more candidates in plan.csv");
    }
    let mut reasons: Vec<(&str, Vec<&str>)> = vec![];
    for (_, c) in refused {
        match reasons.iter_mut().find(|(reason, _)| *reason == c.refusal) {
            Some((_, names)) => names.push(&c.pass.name),
            None => reasons.push((&c.refusal, vec![&c.pass.name])),
        }
    }
    for (reason, names) in reasons {
        let which = match names.len() {
            n if n > FEW => format!("{n} candidates such as {}", names[0]),
            _ => names.join("; "),
        };
        let _ = writeln!(text, "not offered: {which}: {reason}");
    }
    text
}

/// Candidates that the terminal names one by one.
const FEW: usize = 3;

/// The candidates that help most, the best first: by the parameter that is farthest from what is wanted. The chosen one is among them.
fn best<'a>(
    result: &PlanResult,
    mut told: Vec<(usize, &'a PlanCandidate)>,
) -> Vec<(usize, &'a PlanCandidate)> {
    if told.len() <= SHOWN {
        return told;
    }
    let short = |c: &PlanCandidate| {
        let figures = c.standard_deviation_if_next.iter().flatten();
        let ratios = figures.zip(&result.wanted);
        let ratio = ratios.map(|(s, w)| s.unwrap_or(f64::INFINITY) / w.unwrap_or(f64::INFINITY));
        ratio.fold(0.0, f64::max)
    };
    let chosen = result.chosen.first().map(|s| s.candidate as usize);
    told.sort_by(|(i, a), (j, b)| {
        let first = |k: &usize| Some(*k) != chosen;
        first(i).cmp(&first(j)).then(short(a).total_cmp(&short(b)))
    });
    told.truncate(SHOWN);
    told
}

fn order(result: &PlanResult) -> String {
    if result.chosen.is_empty() {
        return String::new();
    }
    let all = result.chosen.iter().enumerate();
    let last = result.chosen.len();
    let kept = all.filter(|(k, _)| last <= SHOWN || *k + 1 < SHOWN || *k + 1 == last);
    let rows = kept.map(|(k, step)| {
        let words = vec![(k + 1).to_string(), narrow(&step.name)];
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
