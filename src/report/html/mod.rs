//! `report.html`: one file that opens offline, pictures first.
//!
//! The page is the template `report.html` of this folder with its style, its scripts and the data put in place; the scripts draw what the
//! data say. No address outside the page is ever referred to.

use super::card::{Card, card};
use super::headline::{SIGNIFICANCE, difference, headline};
use crate::results::{AgainstTruth, BudgetResult, Calibration, Page, PlanResult};
use serde::Serialize;

const STYLE: &str = include_str!("report.css");

/// The page: head, then sections that the scripts make.
const TEMPLATE: &str = include_str!("bare.html");

/// What every calibration's page has before a procedure's own scripts.
const SHELL: [&str; 8] = [
    include_str!("elements.js"),
    include_str!("plots.js"),
    include_str!("solutions.js"),
    include_str!("charts.js"),
    include_str!("drift.js"),
    include_str!("tables.js"),
    include_str!("verdict.js"),
    include_str!("card.js"),
];

/// What runs last: builds the page from top to bottom.
const MAIN: &str = include_str!("main.js");

const BUDGET: [&str; 7] = [
    include_str!("elements.js"),
    include_str!("plots.js"),
    include_str!("sought.js"),
    include_str!("shares.js"),
    include_str!("curves.js"),
    include_str!("honesty.js"),
    include_str!("budget.js"),
];
const PLAN: [&str; 4] = [
    include_str!("elements.js"),
    include_str!("plots.js"),
    include_str!("sought.js"),
    include_str!("plan.js"),
];
/// What the scripts of a bare page read.
#[derive(Serialize)]
struct Data<'a, R> {
    headline: &'a str,
    result: &'a R,
}

/// `report.html` of an error budget.
///
/// # Errors
/// As [`render`].
pub fn budget(result: &BudgetResult) -> serde_json::Result<String> {
    let kind = format!("error budget of a {} calibration", result.procedure);
    let headline = super::budget_headline(result);
    bare(&kind, &result.scenario, &headline, result, &BUDGET)
}

/// `plan.html`.
///
/// # Errors
/// As [`render`].
pub fn plan(result: &PlanResult) -> serde_json::Result<String> {
    let headline = super::plan::verdict(result);
    bare("survey plan", &result.scenario, &headline, result, &PLAN)
}

/// What the scripts of a calibration's page read.
#[derive(Serialize)]
struct Shown<'a> {
    title: &'a str,
    headline: String,
    significance: f64,
    card: Option<Card>,
    difference: Option<String>,
    result: &'a Calibration,
    page: &'a serde_json::Value,
    against_truth: Option<&'a AgainstTruth>,
}

/// `report.html` of a calibration.
///
/// # Errors
/// None for results made by this program; `serde_json` does not promise it.
pub fn render(result: &Calibration, page: &Page) -> serde_json::Result<String> {
    let shown = Shown {
        title: &page.title,
        headline: headline(result),
        significance: SIGNIFICANCE,
        card: card(result),
        difference: result.comparison.as_ref().map(difference),
        result,
        page: &page.data,
        against_truth: page.against_truth.as_ref(),
    };
    // a block of its own, so that names of a procedure's scripts and of the shell's do not meet
    let own = format!("{{\n{}\n}}", page.scripts.join("\n"));
    let scripts: Vec<&str> = SHELL.into_iter().chain([own.as_str(), MAIN]).collect();
    let data = serde_json::to_string(&shown)?;
    Ok(filled(page.kind, &page.title, &data, &scripts))
}

fn bare(
    kind: &str,
    title: &str,
    headline: &str,
    result: &impl Serialize,
    scripts: &[&str],
) -> serde_json::Result<String> {
    let data = serde_json::to_string(&Data { headline, result })?;
    Ok(filled(kind, title, &data, scripts))
}

fn filled(kind: &str, title: &str, data: &str, scripts: &[&str]) -> String {
    let parts = [
        ("title", text(title)),
        ("kind", text(kind)),
        ("style", STYLE.into()),
        ("data", script(data)),
        ("scripts", scripts.join("\n")),
    ];
    fill(TEMPLATE, &parts)
}

/// Puts each part in the place of its `<!--name-->`, in one pass, so that a part's own text is never searched.
fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut page = String::with_capacity(
        template.len() + parts.iter().map(|(_, part)| part.len()).sum::<usize>(),
    );
    let mut rest = template;
    while let Some((place, name, part)) = next_mark(rest, parts) {
        page.push_str(&rest[..place]);
        page.push_str(part);
        rest = &rest[place + mark(name).len()..];
    }
    page.push_str(rest);
    page
}

fn next_mark<'a>(rest: &str, parts: &'a [(&str, String)]) -> Option<(usize, &'a str, &'a str)> {
    parts
        .iter()
        .filter_map(|(name, part)| Some((rest.find(&mark(name))?, *name, part.as_str())))
        .min_by_key(|found| found.0)
}

fn mark(name: &str) -> String {
    format!("<!--{name}-->")
}

/// Text safe between tags.
fn text(raw: &str) -> String {
    raw.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// JSON safe inside a script element: no `<` is left that could end or open anything, and the text means the same.
fn script(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_looks_like_a_mark_is_left_alone() {
        let parts = [("title", "<!--data-->".into()), ("data", "d".to_string())];
        assert_eq!(
            fill("a<!--title-->b<!--data-->c", &parts),
            "a<!--data-->bdc"
        );
    }

    #[test]
    fn data_cannot_leave_its_script_element() {
        let json = serde_json::to_string("</script><!--\u{2028}").unwrap();
        let safe = script(&json);
        assert!(!safe.contains('<') && !safe.contains('\u{2028}'));
        assert_eq!(
            serde_json::from_str::<String>(&safe).unwrap(),
            "</script><!--\u{2028}"
        );
    }
}
