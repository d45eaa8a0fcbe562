//! A USBL calibration for the terminal, as `result.json` and as a page.

use std::fmt::Write;
use std::path::Path;

use comfy_table::CellAlignment;

use super::files::both;
use super::text::ruled_table;
use super::{ReportError, Written, html, json};
use crate::results::{
    MountingAngles, Parameter, UsblJoint, UsblPrintedAngles, UsblResiduals, UsblResult, UsblSamples,
};
use crate::units::with_sigma;

/// Writes `result.json` and `report.html` into `folder`, each whole or not at all.
///
/// # Errors
/// [`ReportError`]; both texts are made before the first is written.
pub fn write_usbl(
    folder: &Path,
    result: &UsblResult,
    samples: &UsblSamples,
) -> Result<Written, ReportError> {
    both(folder, &to_bytes(result)?, &html::usbl(result, samples)?)
}

/// The bytes of `result.json`; the same result gives the same bytes.
///
/// # Errors
/// None for a result made by this program; `serde_json` does not promise it.
pub fn to_bytes(result: &UsblResult) -> serde_json::Result<Vec<u8>> {
    json::lines(result)
}

/// The result in one or two sentences.
#[must_use]
pub fn headline(result: &UsblResult) -> String {
    if let Some(reason) = &result.reason {
        return format!("No usable result: {reason}.");
    }
    let joint = result.solutions.joint.as_ref().filter(|joint| joint.usable);
    let Some(joint) = joint else {
        return reference_headline(result);
    };
    let angle = |name: &str| {
        let found = joint.parameters.iter().find(|p| p.name == name)?;
        Some(format!("{name} {} deg", shown(found)))
    };
    let angles: Vec<_> = ["pitch", "roll", "yaw"]
        .into_iter()
        .filter_map(angle)
        .collect();
    format!(
        "Correction of the mounting by the joint path: {} (one sigma).{}",
        angles.join(", "),
        check_sentence(result)
    )
}

fn reference_headline(result: &UsblResult) -> String {
    let found = result
        .solutions
        .reference
        .as_ref()
        .and_then(|r| r.correction_deg);
    found.map_or_else(
        || "No path was asked for.".to_owned(),
        |c| {
            format!(
                "Correction of the mounting by the reference path: pitch {:.4}, roll {:.4}, yaw {:.4} deg.",
                c.pitch, c.roll, c.yaw
            )
        },
    )
}

/// What the check beacons say; empty without any.
fn check_sentence(result: &UsblResult) -> String {
    let checks = result
        .verification
        .iter()
        .filter_map(|v| Some((v, v.joint?)));
    let sentence = |(v, r): (_, UsblResiduals)| {
        let v: &crate::results::UsblVerification = v;
        let length = r.mean_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        let p = r.p_value?;
        let verdict = if p < 0.01 { "contradicts it" } else { "agrees" };
        Some(format!(
            " Check beacon {} {verdict}: mean residual {:.1} mm, p = {p:.2}.",
            v.beacon,
            1e3 * length
        ))
    };
    checks.filter_map(sentence).collect()
}

/// A value with its standard deviation, or alone.
fn shown(parameter: &Parameter) -> String {
    match (parameter.value, parameter.standard_deviation) {
        (Some(value), Some(sigma)) => with_sigma(value, sigma),
        (Some(value), None) => format!("{value} ({})", parameter.note),
        _ => "-".to_owned(),
    }
}

/// The summary for the terminal. Ends with a newline.
#[must_use]
pub fn summary(result: &UsblResult) -> String {
    let parts = [
        headline(result),
        corrections(result),
        parameters(result),
        mounting(result),
        printed(result),
        verification(result),
        tests(result),
        counts(result),
    ];
    let filled: Vec<_> = parts
        .iter()
        .map(|p| p.trim_end())
        .filter(|p| !p.is_empty())
        .collect();
    filled.join("\n\n") + "\n"
}

fn corrections(result: &UsblResult) -> String {
    let reference = result.solutions.reference.as_ref().filter(|r| r.usable);
    let joint = result.solutions.joint.as_ref().filter(|j| j.usable);
    if reference.is_none() && joint.is_none() {
        return String::new();
    }
    let mut table = ruled_table();
    table.set_header([
        "correction, deg",
        "reference",
        "joint ± 1 sigma",
        "reference - joint, in sigmas of joint",
    ]);
    let names = [
        "pitch (bow up)",
        "roll (starboard down)",
        "yaw (counter-clockwise)",
    ];
    for (i, name) in names.into_iter().enumerate() {
        let correction = reference.and_then(|r| r.correction_deg);
        let old = correction.map_or_else(String::new, |c| {
            format!("{:.4}", [c.pitch, c.roll, c.yaw][i])
        });
        let new = joint.map_or_else(String::new, |j| shown(&j.parameters[i]));
        let compared = result.comparison.as_ref();
        let sigmas = compared.map_or_else(String::new, |c| {
            format!("{:+.1}", c.differences[i].in_reference_sigmas)
        });
        table.add_row([name.to_owned(), old, new, sigmas]);
    }
    aligned(&mut table);
    let mut text = table.trim_fmt();
    if let Some(c) = &result.comparison {
        let _ = write!(
            text,
            "\nchi-square of the difference {:.1} on {} degrees of freedom, p = {:.2e}",
            c.chi_square, c.degrees_of_freedom, c.p_value
        );
    }
    text
}

fn aligned(table: &mut comfy_table::Table) {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}

fn parameters(result: &UsblResult) -> String {
    let joint = result.solutions.joint.as_ref().filter(|j| j.usable);
    let rest = joint.map_or(&[][..], |j| &j.parameters[3.min(j.parameters.len())..]);
    let line = |p: &Parameter| {
        let unit = if p.unit == "1" { "" } else { &p.unit };
        format!("{}: {} {unit}\n", p.name, shown(p))
    };
    rest.iter().map(line).collect()
}

fn mounting(result: &UsblResult) -> String {
    let solutions = &result.solutions;
    let joint = solutions
        .joint
        .as_ref()
        .and_then(|j| Some(("joint", j.mounting_deg?)));
    let reference = solutions
        .reference
        .as_ref()
        .and_then(|r| Some(("reference", r.mounting_deg?)));
    let Some((path, m)) = joint.or(reference).filter(|_| result.usable) else {
        return String::new();
    };
    let MountingAngles {
        roll,
        pitch,
        heading,
    } = m;
    format!(
        "mounting of the transducer on the attitude sensor ({path}): roll {roll:.4}, pitch {pitch:.4}, heading {heading:.4} deg"
    )
}

/// The patent's angles beside those of this program.
fn printed(result: &UsblResult) -> String {
    let Some(reference) = result.solutions.reference.as_ref().filter(|r| r.usable) else {
        return String::new();
    };
    let (Some(d), Some(m)) = (reference.difference_printed_deg, reference.mounting_deg) else {
        return String::new();
    };
    let UsblPrintedAngles { h, p, r } = d;
    format!(
        "reference path as the patent prints it, adjusted minus measured: H {h:.4}, P {p:.4} (bow down), R {r:.4} (starboard up) deg\n\
         the same difference as a rotation: heading {:.4}, pitch {:.4} (bow up), roll {:.4} (starboard down) deg",
        m.heading, m.pitch, m.roll
    )
}

fn verification(result: &UsblResult) -> String {
    if result
        .verification
        .iter()
        .all(|v| v.joint.is_none() && v.reference.is_none())
    {
        return String::new();
    }
    let mut table = ruled_table();
    table.set_header([
        "predicted - surveyed, mm",
        "fixes",
        "reference: mean e, n, u",
        "rms",
        "joint: mean e, n, u",
        "rms",
        "p",
    ]);
    for v in &result.verification {
        let mean = |r: Option<UsblResiduals>| {
            r.map_or_else(String::new, |r| {
                let [e, n, u] = r.mean_m.map(|x| 1e3 * x);
                format!("{e:+.1} {n:+.1} {u:+.1}")
            })
        };
        let rms = |r: Option<UsblResiduals>| {
            r.map_or_else(String::new, |r| format!("{:.1}", 1e3 * r.rms_m))
        };
        let some = v.joint.or(v.reference);
        let fixes = some.map_or_else(String::new, |r| format!("{} (+{})", r.fixes, r.outliers));
        let p = v.joint.and_then(|r| r.p_value);
        table.add_row([
            format!("{} ({})", v.beacon, v.role),
            fixes,
            mean(v.reference),
            rms(v.reference),
            mean(v.joint),
            rms(v.joint),
            p.map_or_else(String::new, |p| format!("{p:.2}")),
        ]);
    }
    aligned(&mut table);
    table.trim_fmt()
}

fn tests(result: &UsblResult) -> String {
    let quality = result
        .solutions
        .joint
        .as_ref()
        .and_then(|j: &UsblJoint| j.quality.as_ref());
    let Some(quality) = quality else {
        return String::new();
    };
    let t = &quality.global_test;
    let verdict = match (t.void_because.as_str(), t.passed) {
        ("", true) => "passed".to_owned(),
        ("", false) => "failed".to_owned(),
        (why, _) => format!("void: {why}"),
    };
    let mut text = format!(
        "global test: {verdict}; variance factor {:.4}, {:.0} % interval {:.4} to {:.4}, {} degrees of freedom\n",
        t.statistic,
        100.0 * (1.0 - t.significance),
        t.lower,
        t.upper,
        quality.degrees_of_freedom
    );
    for weak in &quality.observability.weak {
        let _ = writeln!(text, "weakly determined: {}", weak.text);
    }
    text
}

fn counts(result: &UsblResult) -> String {
    let reasons: Vec<String> = result
        .fixes
        .rejected
        .iter()
        .map(|(why, n)| format!("{n} {why}"))
        .collect();
    let rejected = if reasons.is_empty() {
        String::new()
    } else {
        format!("; not used: {}", reasons.join(", "))
    };
    format!(
        "fixes: {} used of {}{rejected}",
        result.fixes.used, result.fixes.read
    )
}
