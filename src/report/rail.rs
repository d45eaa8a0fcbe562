//! A rail calibration for the terminal, as JSON and as a page.

use std::fmt::Write;
use std::path::Path;

use comfy_table::CellAlignment;

use super::files::{Written, both};
use super::text::ruled_table;
use super::{ReportError, html, json};
use crate::results::{Parameter, RailResult, RailSamples};
use crate::units::with_sigma;

/// Writes `result.json` and `report.html` into `folder`, each whole or not at all; the folder is made when missing.
///
/// # Errors
/// [`ReportError`]; both texts are made before the first is written.
pub fn write_rail(
    folder: &Path,
    result: &RailResult,
    samples: &RailSamples,
) -> Result<Written, ReportError> {
    both(folder, &to_bytes(result)?, &html::rail(result, samples)?)
}

/// The bytes of `result.json`; the same result gives the same bytes.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &RailResult) -> serde_json::Result<Vec<u8>> {
    json::lines(result)
}

/// The result in one sentence.
#[must_use]
pub fn headline(result: &RailResult) -> String {
    if !result.usable {
        let reason = result.reason.as_deref().unwrap_or("the run gave no reason");
        return format!("No usable result: {}.", reason.trim_end_matches('.'));
    }
    let rms = |path: &str| result.residual_rms_m.get(path).map(|m| m * 1e3);
    let worst = result.comparison.as_ref().and_then(|c| {
        let size = |d: &&crate::results::ParameterDifference| d.in_reference_sigmas.abs();
        c.differences
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))
    });
    match (rms("nominal"), rms("joint"), rms("reference"), worst) {
        (Some(before), Some(joint), Some(reference), Some(worst)) => format!(
            "The joint adjustment brings the profiles' RMS distance from the standard profile from {before:.3} mm (nominal) to {joint:.3} mm and states its \
             uncertainty; the patent's path leaves {reference:.3} mm and differs most in {} by {:.4} {} ({:.0} sigmas of the joint solution).",
            worst.name,
            worst.difference,
            worst.unit,
            worst.in_reference_sigmas.abs()
        ),
        (Some(before), Some(joint), _, _) => format!(
            "The joint adjustment brings the profiles' RMS distance from the standard profile from {before:.3} mm (nominal) to {joint:.3} mm and states its uncertainty."
        ),
        (Some(before), None, Some(reference), _) => format!(
            "The patent's path brings the profiles' RMS distance from the standard profile from {before:.3} mm (nominal) to {reference:.3} mm; it states no uncertainty."
        ),
        _ => "The mountings are determined.".to_owned(),
    }
}

/// A summary: verdict, both paths side by side, the mountings to enter, tests, weak directions, counts. Ends with a newline.
#[must_use]
pub fn summary(result: &RailResult) -> String {
    let mut text = format!("{}\n\n", headline(result));
    let table = corrections(result);
    if !table.is_empty() {
        let _ = writeln!(text, "{table}\n");
    }
    for line in ends(result)
        .iter()
        .chain(&mountings(result))
        .chain(&tests(result))
        .chain(&counts(result))
    {
        let _ = writeln!(text, "{line}");
    }
    for note in &result.notes {
        let _ = writeln!(text, "Note: {note}.");
    }
    text
}

/// Millimetres for metres.
fn shown(p: &Parameter) -> Option<(f64, Option<f64>, &str)> {
    let (scale, unit) = if p.unit == "m" {
        (1e3, "mm")
    } else {
        (1.0, p.unit.as_str())
    };
    Some((
        p.value? * scale,
        p.standard_deviation.map(|s| s * scale),
        unit,
    ))
}

fn cell(p: Option<&Parameter>) -> String {
    match p.and_then(shown) {
        Some((value, Some(sigma), _)) => with_sigma(value, sigma),
        Some((value, None, _)) => format!("{value:.4}"),
        None => String::new(),
    }
}

fn corrections(result: &RailResult) -> String {
    let (reference, joint) = (&result.solutions.reference, &result.solutions.joint);
    let old: &[Parameter] = reference.as_ref().map_or(&[], |r| &r.parameters);
    let new: &[Parameter] = joint.as_ref().map_or(&[], |j| &j.parameters);
    let names = if new.is_empty() { old } else { new };
    if names.is_empty() {
        return String::new();
    }
    let mut table = ruled_table();
    table.set_header([
        "correction",
        "patent's path",
        "joint ± 1 sigma",
        "difference, in sigmas of joint",
    ]);
    for (k, p) in names.iter().enumerate() {
        let unit = shown(p).map_or("", |s| s.2);
        let sigmas = result
            .comparison
            .as_ref()
            .and_then(|c| c.differences.get(k));
        let sigmas = sigmas.map_or(String::new(), |d| format!("{:.1}", d.in_reference_sigmas));
        table.add_row([
            format!("{}, {unit}", p.name),
            cell(old.get(k)),
            cell(new.get(k)),
            sigmas,
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

fn ends(result: &RailResult) -> Vec<String> {
    let line = |path: &str, status: crate::results::Status, usable: bool, message: &str| {
        let usable = if usable { "" } else { ", not usable" };
        let colon = if message.is_empty() { "" } else { ": " };
        format!(
            "{path}: {}{usable}{colon}{message}",
            super::format::status(status)
        )
    };
    let reference = result.solutions.reference.as_ref();
    let joint = result.solutions.joint.as_ref();
    [
        reference.map(|r| line("patent's path", r.status, r.usable, &r.message)),
        joint.map(|j| line("joint", j.status, j.usable, &j.message)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn mountings(result: &RailResult) -> Vec<String> {
    let joint = result
        .solutions
        .joint
        .as_ref()
        .map(|j| ("joint", &j.mountings));
    let reference = result
        .solutions
        .reference
        .as_ref()
        .map(|r| ("patent's path", &r.mountings));
    let Some((path, all)) = joint.or(reference).filter(|_| result.usable) else {
        return vec![];
    };
    let one = |m: &crate::results::RailMounting| {
        let (a, [x, y, z]) = (&m.mounting_deg, m.lever_arm_m);
        format!(
            "mounting of {} ({path}): roll {:.4}, pitch {:.4}, heading {:.4} deg; lever arm {x:.5}, {y:.5}, {z:.5} m (right, forward, up)",
            m.profiler, a.roll, a.pitch, a.heading
        )
    };
    all.iter().map(one).collect()
}

fn tests(result: &RailResult) -> Vec<String> {
    let Some(quality) = result
        .solutions
        .joint
        .as_ref()
        .and_then(|j| j.quality.as_ref())
    else {
        return vec![];
    };
    let t = &quality.global_test;
    let verdict = match (t.void_because.as_str(), t.passed) {
        ("", true) => "passed".to_owned(),
        ("", false) => "failed".to_owned(),
        (why, _) => format!("void: {why}"),
    };
    let mut lines = vec![format!(
        "global test: {verdict}; variance factor {:.4}, {:.0} % interval {:.4} to {:.4}, {} degrees of freedom",
        t.statistic,
        100.0 * (1.0 - t.significance),
        t.lower,
        t.upper,
        quality.degrees_of_freedom
    )];
    lines.extend(
        quality
            .observability
            .weak
            .iter()
            .take(4)
            .map(|w| format!("weakly determined: {}", w.text)),
    );
    lines
}

fn counts(result: &RailResult) -> Vec<String> {
    let one = |c: &crate::results::ProfilerCounts| {
        let rejected: Vec<String> = c
            .rejected
            .iter()
            .map(|(why, n)| format!("{n} {why}"))
            .collect();
        let rejected = if rejected.is_empty() {
            String::new()
        } else {
            format!("; left out: {}", rejected.join(", "))
        };
        format!(
            "points of {}: {} used of {}{rejected}",
            c.profiler, c.used, c.read
        )
    };
    result.counts.iter().map(one).collect()
}
