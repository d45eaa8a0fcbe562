//! `report.html`: one file that opens offline, pictures first.
//!
//! The page is the template `report.html` of this folder with its style, its scripts and the data put in place; the scripts draw what the
//! data say. No address outside the page is ever referred to.

mod payload;

use crate::results::{
    BudgetResult, PlanResult, PoolResult, RailResult, RailSamples, ReportSamples, UsblResult,
    UsblSamples,
};
use serde::Serialize;

const TEMPLATE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");
const SCRIPTS: [&str; 7] = [
    include_str!("elements.js"),
    include_str!("draw.js"),
    include_str!("view3d.js"),
    include_str!("maps.js"),
    include_str!("charts.js"),
    include_str!("tables.js"),
    include_str!("main.js"),
];

/// Of pages whose sections the scripts make themselves.
const BARE: &str = include_str!("bare.html");
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
const RAIL: [&str; 3] = [
    include_str!("elements.js"),
    include_str!("plots.js"),
    include_str!("rail.js"),
];

const USBL: [&str; 3] = [
    include_str!("elements.js"),
    include_str!("plots.js"),
    include_str!("usbl.js"),
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

/// A rail calibration's result with what its pictures are drawn from.
#[derive(Serialize)]
struct RailPage<'a> {
    #[serde(flatten)]
    result: &'a RailResult,
    samples: &'a RailSamples,
}

/// `report.html` of a rail calibration.
///
/// # Errors
/// As [`render`].
pub fn rail(result: &RailResult, samples: &RailSamples) -> serde_json::Result<String> {
    let headline = super::rail::headline(result);
    let page = RailPage { result, samples };
    bare("rail calibration", &samples.title, &headline, &page, &RAIL)
}

/// A result and what its pictures are drawn from.
#[derive(Serialize)]
struct WithSamples<'a, R, S> {
    result: &'a R,
    samples: &'a S,
}

/// `report.html` of a USBL calibration.
///
/// # Errors
/// As [`render`].
pub fn usbl(result: &UsblResult, samples: &UsblSamples) -> serde_json::Result<String> {
    let headline = super::usbl::headline(result);
    let kind = "calibration of an ultra-short baseline";
    let data = WithSamples { result, samples };
    bare(kind, &samples.title, &headline, &data, &USBL)
}

fn bare(
    kind: &str,
    title: &str,
    headline: &str,
    result: &impl Serialize,
    scripts: &[&str],
) -> serde_json::Result<String> {
    let data = serde_json::to_string(&Data { headline, result })?;
    let parts = [
        ("title", text(title)),
        ("kind", text(kind)),
        ("style", STYLE.into()),
        ("data", script(&data)),
        ("scripts", scripts.join("\n")),
    ];
    Ok(fill(BARE, &parts))
}

/// The page as text.
///
/// # Errors
/// None for results made by this program; `serde_json` does not promise it.
pub fn render(result: &PoolResult, samples: &ReportSamples) -> serde_json::Result<String> {
    let data = serde_json::to_string(&payload::Payload::new(result, samples))?;
    let parts = [
        ("title", text(&samples.title)),
        ("style", STYLE.into()),
        ("data", script(&data)),
        ("scripts", SCRIPTS.join("\n")),
    ];
    Ok(fill(TEMPLATE, &parts))
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
