//! A seabed calibration for the terminal and as a page.

use std::fmt::Write;
use std::path::Path;

use super::files::{ReportError, Written, both};
use super::json;
use crate::results::{SeabedParameter, SeabedResult, SeabedSolution};
use crate::ruled::Ruled;

/// Writes `result.json` and `report.html` into `folder`, each whole or not at all.
///
/// # Errors
/// [`ReportError`]; both texts are made before the first is written.
pub fn write_seabed(folder: &Path, result: &SeabedResult) -> Result<Written, ReportError> {
    both(folder, &json::lines(result)?, &page(result))
}

/// The result in one sentence.
#[must_use]
pub fn headline(result: &SeabedResult) -> String {
    if !result.usable {
        let reason = result.reason.as_deref().unwrap_or("the run gave no reason");
        return format!("No usable result: {}.", reason.trim_end_matches('.'));
    }
    match (&result.solutions.joint, &result.solutions.reference) {
        (Some(_), Some(_)) => "The joint adjustment determines pitch, roll and yaw and states its uncertainty; the patch test stands beside it without one.".to_owned(),
        (Some(_), None) => "The joint adjustment determines pitch, roll and yaw and states its uncertainty.".to_owned(),
        _ => "The patch test determines pitch, roll and yaw; it states no uncertainty.".to_owned(),
    }
}

/// A summary for the terminal. Ends with a newline.
#[must_use]
pub fn summary(result: &SeabedResult) -> String {
    let mut text = format!("{}\n\n", headline(result));
    let mut table = Ruled::new([
        "correction",
        "unit",
        "patch test",
        "joint",
        "sigma",
        "relief alone",
        "motion alone",
        "",
    ])
    .texts(2);
    for row in rows(result) {
        table.row(row);
    }
    let _ = writeln!(text, "{table}\n");
    for line in ends(result).iter().chain(&result.notes) {
        let _ = writeln!(text, "{line}");
    }
    for (name, count) in &result.counts {
        let _ = writeln!(text, "soundings {}: {count}", name.replace('_', " "));
    }
    text
}

fn ends(result: &SeabedResult) -> Vec<String> {
    let paths = [
        ("patch test", &result.solutions.reference),
        ("joint", &result.solutions.joint),
    ];
    let one = |(name, solution): (&str, &Option<SeabedSolution>)| {
        let solution = solution.as_ref()?;
        let colon = if solution.message.is_empty() {
            ""
        } else {
            ": "
        };
        let status = solution.status.replace('_', " ");
        Some(format!("{name}: {status}{colon}{}", solution.message))
    };
    paths.into_iter().filter_map(one).collect()
}

/// One row of each parameter, both paths side by side.
fn rows(result: &SeabedResult) -> Vec<[String; 8]> {
    let none = vec![];
    let of = |s: &Option<SeabedSolution>| s.as_ref().map_or(none.clone(), |s| s.parameters.clone());
    let (patch, joint) = (of(&result.solutions.reference), of(&result.solutions.joint));
    let longer = if joint.is_empty() { &patch } else { &joint };
    let figure = |x: Option<f64>, unit: &str| {
        x.map_or_else(|| "-".to_owned(), |x| format!("{x:.*}", decimals(unit)))
    };
    let row = |p: &SeabedParameter| {
        let same = |all: &[SeabedParameter]| all.iter().find(|q| q.name == p.name).cloned();
        let (patch, joint) = (
            same(&patch).unwrap_or_default(),
            same(&joint).unwrap_or_default(),
        );
        [
            p.name.replace('_', " "),
            p.unit.clone(),
            figure(patch.correction, &p.unit),
            figure(joint.correction, &p.unit),
            figure(joint.sigma, &p.unit),
            figure(joint.relief_sigma, &p.unit),
            figure(joint.motion_sigma, &p.unit),
            if joint.note.is_empty() {
                patch.note
            } else {
                joint.note
            },
        ]
    };
    longer.iter().map(row).collect()
}

fn decimals(unit: &str) -> usize {
    match unit {
        "deg" | "m" => 4,
        _ => 5,
    }
}

/// Text that may stand in a page.
fn safe(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// The page: what the terminal says as tables, and what only the details hold; complete in itself, no script.
fn page(result: &SeabedResult) -> String {
    let name = result.provenance.configuration["name"]
        .as_str()
        .unwrap_or("seabed");
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{0}</title>\n<style>body{{font:15px/1.5 sans-serif;max-width:62em;margin:2em auto;padding:0 1em}}table{{border-collapse:collapse;margin:1em 0}}td,th{{border-bottom:1px solid #ccc;padding:.2em .8em;text-align:right}}td:first-child,th:first-child{{text-align:left}}</style>\n<h1>{0}</h1>\n<p>{1}</p>\n",
        safe(name),
        safe(&headline(result))
    );
    let heads = [
        "correction",
        "unit",
        "patch test",
        "joint",
        "sigma",
        "relief alone",
        "motion alone",
        "",
    ];
    table(&mut html, &heads.map(str::to_owned), &rows(result));
    for line in ends(result).iter().chain(&result.notes) {
        let _ = writeln!(html, "<p>{}</p>", safe(line));
    }
    for (title, part) in [
        ("Lines", &result.details["layout"]["tracks"]),
        ("Pairs of lines", &result.details["layout"]["pairs"]),
        (
            "Passes of the joint adjustment",
            &result.details["joint"]["passes"],
        ),
        ("Steps of the patch test", &result.details["patch_test"]),
    ] {
        listed(&mut html, title, part);
    }
    html.push_str("</html>\n");
    html
}

/// A list of equal objects as a table.
fn listed(html: &mut String, title: &str, list: &serde_json::Value) {
    let objects: Vec<_> = list.as_array().into_iter().flatten().collect();
    let Some(first) = objects.first().and_then(|o| o.as_object()) else {
        return;
    };
    let heads: Vec<String> = first.keys().map(|k| k.replace('_', " ")).collect();
    let cell = |value: &serde_json::Value| match value.as_f64() {
        Some(x) if !value.is_u64() => format!("{x:.4}"),
        _ => value.to_string().replace('"', ""),
    };
    let row = |o: &&serde_json::Value| -> Vec<String> {
        o.as_object()
            .into_iter()
            .flatten()
            .map(|(_, v)| cell(v))
            .collect()
    };
    let rows: Vec<Vec<String>> = objects.iter().map(row).collect();
    let _ = writeln!(html, "<h2>{title}</h2>");
    table(html, &heads, &rows);
}

fn table<R: AsRef<[String]>>(html: &mut String, heads: &[String], rows: &[R]) {
    let line = |tag: &str, cells: &[String]| {
        let inner: String = cells
            .iter()
            .map(|c| format!("<{tag}>{}</{tag}>", safe(c)))
            .collect();
        format!("<tr>{inner}</tr>\n")
    };
    html.push_str("<table>\n");
    html.push_str(&line("th", heads));
    for row in rows {
        html.push_str(&line("td", row.as_ref()));
    }
    html.push_str("</table>\n");
}
