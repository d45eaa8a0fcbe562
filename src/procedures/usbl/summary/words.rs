//! What the terminal says of a USBL calibration beside what it says of every one: the patent's angles and the verification.

use super::super::UsblOutcome;
use super::details::{UsblPrintedAngles, UsblResiduals, UsblVerification};
use crate::results::{Calibration, TextTable};

/// Both, where there is something to say.
pub fn tables(outcome: &UsblOutcome, result: &Calibration) -> Vec<TextTable> {
    let all = super::verification(outcome);
    let verified = all
        .iter()
        .any(|v| v.joint.is_some() || v.reference.is_some());
    let verification = verified.then(|| verification(&all));
    printed(outcome, result)
        .into_iter()
        .chain(verification)
        .collect()
}

/// The patent's angles beside those of this program.
fn printed(outcome: &UsblOutcome, result: &Calibration) -> Option<TextTable> {
    let solution = result.solutions.reference.as_ref().filter(|r| r.usable)?;
    let found = outcome.reference.as_ref()?.as_ref().ok()?;
    let UsblPrintedAngles { h, p, r } = super::printed(&found.difference);
    let m = &solution.mountings.first()?.mounting_deg;
    let row = |name: &str, all: [f64; 3]| {
        let cells = all.iter().map(|v| format!("{v:.4}"));
        [name.to_owned()].into_iter().chain(cells).collect()
    };
    Some(TextTable {
        header: ["reference solution, deg", "heading", "pitch", "roll"].map(str::to_owned).into(),
        rows: vec![
            row("as the patent prints it", [h, p, r]),
            row("as a mounting", [m.heading, m.pitch, m.roll]),
        ],
        lines: vec![
            "The patent subtracts angles (pitch bow down, roll starboard up); the mounting is the difference as a rotation (bow up, starboard down)."
                .to_owned(),
        ],
    })
}

fn verification(all: &[UsblVerification]) -> TextTable {
    let header = [
        "predicted - surveyed",
        "fixes",
        "reference, mm",
        "rms",
        "joint, mm",
        "rms",
        "p",
    ];
    TextTable {
        header: header.map(str::to_owned).into(),
        rows: all.iter().map(verified).collect(),
        lines: all.iter().filter_map(checked).collect(),
    }
}

fn verified(v: &UsblVerification) -> Vec<String> {
    let mean = |r: Option<UsblResiduals>| {
        r.map_or_else(String::new, |r| {
            let [e, n, u] = r.mean_m.map(|x| 1e3 * x);
            format!("{e:+.0} {n:+.0} {u:+.0}")
        })
    };
    let rms =
        |r: Option<UsblResiduals>| r.map_or_else(String::new, |r| format!("{:.0}", 1e3 * r.rms_m));
    let some = v.joint.or(v.reference);
    let p = v.joint.and_then(|r| r.p_value);
    vec![
        format!("{} ({})", v.beacon, v.role),
        some.map_or_else(String::new, |r| format!("{} (+{})", r.fixes, r.outliers)),
        mean(v.reference),
        rms(v.reference),
        mean(v.joint),
        rms(v.joint),
        p.map_or_else(String::new, |p| format!("{p:.2}")),
    ]
}

/// What a check beacon says.
fn checked(v: &UsblVerification) -> Option<String> {
    let joint = v.joint?;
    let length = joint.mean_m.iter().map(|x| x * x).sum::<f64>().sqrt();
    let p = joint.p_value?;
    let verdict = if p < 0.01 { "contradicts it" } else { "agrees" };
    Some(format!(
        "Check beacon {} {verdict}: mean residual {:.1} mm, p = {p:.2}.",
        v.beacon,
        1e3 * length
    ))
}
