//! The outcome of both paths as a result.

use std::collections::BTreeMap;

use nalgebra::Matrix3;
use serde_json::json;

use super::joint::{Joint, JointError};
use super::model::COUNT;
use super::reference::Patch;
use super::run::{SeabedInput, SeabedOutcome};
use super::scene::Scene;
use super::verdict::{Judgement, Reason};
use crate::observe::Mounting;
use crate::results::{
    Finding, Provenance, SeabedMounting, SeabedParameter, SeabedResult, SeabedSolution,
    SeabedSolutions, Severity, Verdict,
};

/// Names, units and columns in the order of a result; the lever arm upwards is held and has no column.
const SHOWN: [(&str, &str, Option<usize>); COUNT + 1] = [
    ("pitch", "deg", Some(0)),
    ("roll", "deg", Some(1)),
    ("yaw", "deg", Some(2)),
    ("lx", "m", Some(7)),
    ("ly", "m", Some(8)),
    ("lz", "m", None),
    ("latency", "s", Some(3)),
    ("range_scale", "1", Some(4)),
    ("heave_scale", "1", Some(5)),
    ("heave_lag", "s", Some(6)),
    ("deep_sound_speed", "1", Some(9)),
];

/// The result of a calibration.
pub(super) fn result(
    outcome: &SeabedOutcome,
    input: &SeabedInput<'_>,
    read: usize,
    provenance: Provenance,
) -> SeabedResult {
    let reference = outcome.reference.as_ref();
    let solutions = SeabedSolutions {
        reference: reference.map(|found| by_patch_test(found, input.scene)),
        joint: outcome
            .joint
            .as_ref()
            .map(|found| jointly(found, input.scene)),
    };
    let verdict = verdict(outcome, solutions.reference.as_ref());
    let deciding = solutions.joint.as_ref().or(solutions.reference.as_ref());
    SeabedResult {
        schema: 2,
        procedure: "seabed".to_owned(),
        provenance,
        usable: verdict.state.is_usable() && deciding.is_some_and(|s| s.usable),
        reason: verdict.reason(),
        verdict,
        counts: counts(outcome, input.scene, read),
        solutions,
        notes: notes(outcome),
        details: details(outcome),
    }
}

fn finding(reason: &Reason) -> Finding {
    Finding::new(
        reason.code,
        Severity::Refuses,
        reason.words.clone(),
        format!("takes away {}", reason.parameters.join(", ")),
        reason.advice.clone(),
    )
}

fn no_solution(error: &JointError) -> Verdict {
    let advice = "sail a line back on the same track and one beside it";
    Verdict::not_determined(vec![Finding::new(
        "no_solution",
        Severity::Refuses,
        error.to_string(),
        "a solution",
        advice,
    )])
}

fn verdict(outcome: &SeabedOutcome, reference: Option<&SeabedSolution>) -> Verdict {
    match (&outcome.joint, &outcome.reference) {
        (Some(Ok((_, judged))), _) => {
            let findings: Vec<Finding> = judged.reasons.iter().map(finding).collect();
            if judged.usable() {
                Verdict::of(findings)
            } else {
                Verdict::not_determined(findings)
            }
        }
        (Some(Err(error)), _) | (None, Some(Err(error))) => no_solution(error),
        (None, _) => match reference {
            Some(found) if !found.usable => Verdict::not_determined(vec![Finding::new(
                "layout",
                Severity::Refuses,
                found.message.clone(),
                "a pair of lines for each angle",
                "sail the missing line",
            )]),
            _ => Verdict::of(vec![]),
        },
    }
}

/// A figure in the unit of its parameter.
fn shown(figure: f64, unit: &str) -> f64 {
    if unit == "deg" {
        figure.to_degrees()
    } else {
        figure
    }
}

fn note(name: &str, determined: bool, sought: bool) -> &'static str {
    match name {
        "lz" => "held: inseparable from the heights of the lines",
        _ if !sought => "held",
        "pitch" | "roll" | "yaw" | "latency" if determined => "",
        "pitch" | "roll" | "yaw" | "latency" => "refused",
        _ => "held within its prior: takes up errors of its kind, no result",
    }
}

fn jointly(found: &Result<(Joint, Judgement), JointError>, scene: &Scene) -> SeabedSolution {
    let (joint, judged) = match found {
        Ok(found) => found,
        Err(error) => return refused(error.to_string()),
    };
    let off = joint.values.from_nominal(scene);
    let one = |(name, unit, column): &(&str, &str, Option<usize>)| {
        let sought = column.is_some_and(|k| joint.sought[k]);
        let determined = column.is_some_and(|k| judged.determined[k]);
        let hidden = note(name, determined, sought) == "refused";
        let figure = |x: f64| (sought && !hidden && x.is_finite()).then(|| shown(x, unit));
        let of = |all: Option<[f64; COUNT]>| figure(all?[(*column)?]);
        SeabedParameter {
            name: (*name).to_owned(),
            unit: (*unit).to_owned(),
            correction: column.and_then(|k| figure(off[k])),
            sigma: column.and_then(|k| figure(joint.sigma(k))),
            relief_sigma: of(joint.relief_sigma),
            motion_sigma: of(joint.motion_sigma),
            determined,
            note: note(name, determined, sought).to_owned(),
        }
    };
    let usable = judged.usable();
    let status = match (joint.converged, usable) {
        (false, _) => "out_of_iterations",
        (true, true) => "converged",
        (true, false) => "refused",
    };
    SeabedSolution {
        status: status.to_owned(),
        usable,
        message: judged.words(),
        parameters: SHOWN.iter().map(one).collect(),
        covariance: usable.then(|| covariance(joint)),
        mountings: mountings(usable, &joint.values.mounting, &scene.nominal),
    }
}

fn refused(message: String) -> SeabedSolution {
    SeabedSolution {
        status: "refused".to_owned(),
        message,
        ..SeabedSolution::default()
    }
}

fn covariance(joint: &Joint) -> Vec<Vec<f64>> {
    let entry = |a: Option<usize>, b: Option<usize>| match (a, b) {
        (Some(a), Some(b)) => joint.covariance[a][b],
        _ => 0.0,
    };
    let row = |a: Option<usize>| SHOWN.iter().map(|b| entry(a, b.2)).collect();
    SHOWN.iter().map(|a| row(a.2)).collect()
}

fn by_rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

fn mountings(usable: bool, found: &Mounting, nominal: &Mounting) -> Vec<SeabedMounting> {
    if !usable {
        return vec![];
    }
    let (roll, pitch, heading) = found.angles();
    let named = [("roll", roll), ("pitch", pitch), ("heading", heading)];
    vec![SeabedMounting {
        name: "multibeam".to_owned(),
        rotation_matrix: by_rows(&found.rotation),
        nominal_rotation_matrix: by_rows(&nominal.rotation),
        mounting_deg: named
            .map(|(name, angle)| (name.to_owned(), angle.to_degrees()))
            .into(),
        lever_arm_m: found.lever_arm_m.into(),
        nominal_lever_arm_m: nominal.lever_arm_m.into(),
    }]
}

fn by_patch_test(found: &Result<Patch, JointError>, scene: &Scene) -> SeabedSolution {
    let patch = match found {
        Ok(found) => found,
        Err(error) => return refused(error.to_string()),
    };
    let off = patch.values.from_nominal(scene);
    let names = ["pitch", "roll", "yaw", "latency"];
    let one = |k: usize| {
        let unit = if k < 3 { "deg" } else { "s" };
        let no_pair = "no pair of lines for it";
        SeabedParameter {
            name: names[k].to_owned(),
            unit: unit.to_owned(),
            correction: patch.found[k].then(|| shown(off[k], unit)),
            determined: patch.found[k],
            note: if patch.found[k] { "" } else { no_pair }.to_owned(),
            ..SeabedParameter::default()
        }
    };
    let usable = patch.found[..3].iter().all(|f| *f);
    let without: Vec<&str> = (0..3)
        .filter(|k| !patch.found[*k])
        .map(|k| names[k])
        .collect();
    SeabedSolution {
        status: if usable { "converged" } else { "refused" }.to_owned(),
        usable,
        message: if usable {
            String::new()
        } else {
            format!("no pair of lines for {}", without.join(", "))
        },
        parameters: (0..4).map(one).collect(),
        covariance: None,
        mountings: mountings(usable, &patch.values.mounting, &scene.nominal),
    }
}

fn counts(outcome: &SeabedOutcome, scene: &Scene, read: usize) -> BTreeMap<String, u64> {
    let on_lines = scene.soundings.len();
    let mut counts = BTreeMap::from([
        ("read".to_owned(), read as u64),
        ("on_lines".to_owned(), on_lines as u64),
    ]);
    if let Some(Ok((joint, _))) = &outcome.joint {
        let used: usize = joint.tiles.iter().map(|t| t.members.len()).sum();
        counts.insert("screened_out".to_owned(), joint.screened as u64);
        counts.insert("rejected_by_residual".to_owned(), joint.rejected as u64);
        counts.insert("used".to_owned(), used as u64);
    }
    counts
}

fn notes(outcome: &SeabedOutcome) -> Vec<String> {
    let judged = match &outcome.joint {
        Some(Ok((_, judged))) => judged.notes.clone(),
        _ => vec![],
    };
    let scale = "scale, heave, lever arm and profile are held within their priors; the latency's sigma holds as long as heave and attitude are of one clock within the heave lag's prior";
    let mut all = vec![scale.to_owned()];
    all.extend(judged);
    all
}

fn details(outcome: &SeabedOutcome) -> serde_json::Value {
    let joint = match &outcome.joint {
        Some(Ok((joint, judged))) => json!({
            "field": {
                "relief_m": joint.field.sigma_m,
                "length_m": joint.field.length_m,
                "noise_factor": joint.field.noise_factor,
            },
            "omega_over_freedom": joint.omega_over_freedom,
            "degrees_of_freedom": joint.freedom,
            "tiles": joint.tiles.len(),
            "sandwich_over_model": SHOWN.iter().filter_map(|(name, _, column)| {
                let k = (*column)?;
                joint.sought[k].then(|| ((*name).to_owned(), joint.sandwich_sigma[k] / joint.sigma(k)))
            }).collect::<BTreeMap<String, f64>>(),
            "passes": joint.passes,
            "reasons": judged.reasons,
        }),
        _ => serde_json::Value::Null,
    };
    let patch = match &outcome.reference {
        Some(Ok(patch)) => json!(patch.steps),
        _ => serde_json::Value::Null,
    };
    json!({ "layout": outcome.layout, "joint": joint, "patch_test": patch })
}
