//! The outcome of both paths as a result.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix3};
use serde_json::json;

use super::joint::{Joint, JointError, reported as reported_places};
use super::model::Values;
use super::parameters::{DEEP_SOUND_SPEED, HEAVE_LAG, HEAVE_SCALE, LATENCY, RANGE_SCALE, own};
use super::reference::{Reference, ReferenceError};
use super::reml::CLAIMED;
use super::run::{SeabedInput, SeabedOutcome};
use super::scene::{Head, Scene};
use super::simulate::SeabedTruth;
use super::verdict::{Judgement, Reason};
use super::views::views;
use crate::adjust::Unit;
use crate::calibrate::conventions;
use crate::calibrate::metric;
use crate::calibrate::quality::readable;
use crate::calibrate::solution::{
    Mounted, iterations, matrices, own_names, own_unknown, parameter, prior_note,
};
use crate::geometry::rotation;
use crate::observe::Mounting;
use crate::results::{
    AgainstTruth, Calibration, Comparison, Difference, Finding, Page, Parameter, Provenance,
    SCHEMA, SensorCounts, Severity, Solution, Solutions, Status, TextTable, TruthRow, Verdict,
};

/// Columns of a head's six; the first one's lever arm upwards is held and has none.
fn six(head: usize) -> [Option<usize>; 6] {
    let ([pitch, roll, yaw], [right, forward, up]) = own(head);
    [Some(pitch), Some(roll), Some(yaw), right, forward, up]
}

/// The other parameters in the order of a result.
const OTHERS: [(&str, Unit, usize); 5] = [
    ("latency", Unit::Second, LATENCY),
    ("range scale", Unit::One, RANGE_SCALE),
    ("heave scale", Unit::One, HEAVE_SCALE),
    ("heave lag", Unit::Second, HEAVE_LAG),
    ("deep sound speed", Unit::One, DEEP_SOUND_SPEED),
];

/// Every column in the order of a result: the mountings of the heads, what they share, and the caller's own unknowns.
fn columns(joint: &Joint) -> Vec<Option<usize>> {
    let heads = joint.values.mountings.len();
    let others = OTHERS.iter().map(|o| Some(o.2));
    let all = (0..heads).flat_map(six).chain(others);
    all.chain(own_places(joint).map(Some)).collect()
}

/// Places of the caller's own unknowns.
fn own_places(joint: &Joint) -> impl Iterator<Item = usize> {
    let places = joint.parameters.iter().enumerate();
    places.filter_map(|(k, p)| p.own().map(|_| k))
}

/// What a head's mounting is called, and what its parameters' names begin with.
fn named(scene: &Scene, head: usize) -> (String, String) {
    if scene.heads.len() == 1 {
        return ("multibeam".to_owned(), String::new());
    }
    let name = scene.heads[head].name();
    let prefix = format!("{name} ");
    (name, prefix)
}

/// The result of a calibration.
pub(super) fn result(
    outcome: &SeabedOutcome,
    input: &SeabedInput<'_>,
    read: usize,
    provenance: Provenance,
) -> Calibration {
    let reference = outcome.reference.as_ref();
    let solutions = Solutions {
        reference: reference.map(|found| by_reference(found, input.scene)),
        joint: outcome
            .joint
            .as_ref()
            .map(|found| jointly(found, input.scene)),
        joint_simple: None,
    };
    let verdict = verdict(outcome, solutions.reference.as_ref());
    let deciding = solutions.deciding().is_some_and(|s| s.usable);
    let usable = verdict.state.is_usable() && deciding;
    let conventions = conventions::deciding(&solutions, usable);
    Calibration {
        schema: SCHEMA,
        procedure: "seabed".to_owned(),
        provenance,
        usable,
        reason: verdict.reason(),
        verdict,
        counts: counts(outcome, input.scene, read),
        comparison: comparison(outcome),
        solutions,
        residual_rms_m: BTreeMap::new(),
        notes: notes(outcome, input.scene),
        details: details(outcome),
        conventions,
    }
}

fn finding(reason: &Reason, usable: bool) -> Finding {
    Finding::new(
        reason.code,
        if usable {
            Severity::Finding
        } else {
            Severity::Refuses
        },
        reason.words.clone(),
        format!("takes away {}", reason.parameters.join(", ")),
        reason.advice.clone(),
    )
}

/// What lines that do not meet want.
const SAIL: &str = "sail a line back on the same track and one beside it";

fn no_solution(error: &dyn std::error::Error, advice: &str) -> Verdict {
    Verdict::not_determined(vec![Finding::new(
        "no_solution",
        Severity::Refuses,
        error.to_string(),
        "a solution",
        advice,
    )])
}

/// The verdict; a mistake that explains a misfit comes first.
fn verdict(outcome: &SeabedOutcome, reference: Option<&Solution>) -> Verdict {
    let verdict = of_paths(outcome, reference);
    let Some(mistake) = &outcome.mistake else {
        return verdict;
    };
    let findings = std::iter::once(mistake.clone()).chain(verdict.findings);
    Verdict {
        bounds: verdict.bounds,
        ..Verdict::of(findings.collect())
    }
}

fn of_paths(outcome: &SeabedOutcome, reference: Option<&Solution>) -> Verdict {
    match (&outcome.joint, &outcome.reference) {
        (Some(Ok((_, judged))), _) => {
            let reasons = judged.reasons.iter().map(|r| finding(r, judged.usable()));
            // a cause before the misfit that it makes, and after what the layout does not determine
            let (misfits, others): (Vec<_>, Vec<_>) =
                (reasons.zip(&judged.reasons)).partition(|(_, reason)| reason.is_of_the_model());
            let doubted = judged.doubted.findings.iter().cloned();
            let findings = (others.into_iter().map(|(finding, _)| finding))
                .chain(doubted)
                .chain(misfits.into_iter().map(|(finding, _)| finding))
                .chain(judged.notes.iter().cloned())
                .collect();
            let mut verdict = if judged.usable() || judged.is_of_the_model() {
                Verdict::of(findings)
            } else {
                Verdict::not_determined(findings)
            };
            verdict.bounds.clone_from(&judged.doubted.bounds);
            verdict
        }
        (Some(Err(error @ JointError::Extra { .. })), _) => no_solution(
            error,
            "leave it out, or state what is known of it as its prior sigma",
        ),
        (Some(Err(error)), _) => no_solution(error, SAIL),
        (None, Some(Err(error))) => no_solution(error, SAIL),
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

/// What a parameter that stands within its prior is worth.
const WITHIN_PRIOR: &str = "held within its prior: takes up errors of its kind, no result";

fn note(column: Option<usize>, joint: &Joint, judged: &Judgement) -> &'static str {
    match column {
        None => "held: inseparable from the heights of the lines",
        Some(k) if !joint.sought[k] => "held",
        Some(k) if judged.determined[k] => "",
        Some(k) if joint.parameters[k].own().is_some() => own_note(k, joint, judged),
        Some(k) if joint.parameters[k].kind.is_reported() => "not determined",
        Some(_) => WITHIN_PRIOR,
    }
}

/// An unknown of the caller's own is determined unless something speaks against the whole solution.
fn own_note(k: usize, joint: &Joint, judged: &Judgement) -> &'static str {
    let name = joint.parameters[k].name();
    let refused = judged.reasons.iter().any(|r| r.parameters.contains(&name));
    match refused {
        true => "not determined",
        false => prior_note(joint.priors[k], joint.sigma(k)),
    }
}

/// An unknown of the caller's own, in its own unit.
fn own_parameter(k: usize, joint: &Joint) -> Parameter {
    let own = &joint.parameters[k];
    own_unknown(
        (&own.name(), own.unit()),
        joint.priors[k],
        joint.off[k],
        joint.sigma(k),
    )
}

/// The parameter as it may be reported.
fn reported(parameter: Parameter, note: &str) -> Parameter {
    let refused = note == "not determined";
    let shown = |x: Option<f64>| x.filter(|_| !refused);
    Parameter {
        value: shown(parameter.value),
        correction: shown(parameter.correction),
        sigma: shown(parameter.sigma),
        determined: note.is_empty(),
        note: note.to_owned(),
        ..parameter
    }
}

fn jointly(found: &Result<(Joint, Judgement), JointError>, scene: &Scene) -> Solution {
    let (joint, judged) = match found {
        Ok(found) => found,
        Err(error) => return Solution::without_result(Status::Refused, error.to_string()),
    };
    let covariance = covariance(joint);
    let names: Vec<_> = (0..scene.heads.len()).map(|h| named(scene, h)).collect();
    let own: Vec<_> = (0..scene.heads.len())
        .map(|head| covariance.view((6 * head, 6 * head), (6, 6)).into_owned())
        .collect();
    let mounted = |head: usize| {
        let (found, nominal) = (&joint.values.mountings[head], &scene.heads[head].nominal);
        Mounted {
            name: &names[head].0,
            rotation: (&found.rotation, &nominal.rotation),
            lever_arm_m: Some((found.lever_arm_m, nominal.lever_arm_m)),
            covariance: Some(&own[head]),
            arrays: scene.heads[head].arrays.as_ref(),
        }
    };
    let heads: Vec<Mounted<'_>> = (0..scene.heads.len()).map(mounted).collect();
    let off = joint.values.from_nominal(scene);
    let others = OTHERS
        .iter()
        .map(|(name, unit, k)| parameter(name, *unit, off[*k], Some(joint.sigma(*k))));
    let of_heads = heads.iter().zip(&names);
    let all = of_heads.flat_map(|(m, (_, prefix))| m.parameters(prefix));
    let parameters = all
        .chain(others)
        .chain(own_places(joint).map(|k| own_parameter(k, joint)))
        .zip(columns(joint))
        .map(|(p, column)| reported(p, note(column, joint, judged)))
        .collect();
    let usable = judged.usable();
    let (covariance_rows, correlation_rows) = matrices(&covariance);
    Solution {
        usable,
        parameters,
        covariance: covariance_rows.filter(|_| usable),
        correlation: correlation_rows.filter(|_| usable),
        mountings: match usable {
            true => heads.iter().map(Mounted::result).collect(),
            false => vec![],
        },
        convergence: iterations(
            0,
            0,
            joint
                .passes
                .iter()
                .map(|p| (p.omega_over_freedom, p.step_sigmas)),
        )
        .collect(),
        details: named_own(joint),
        ..Solution::without_result(status(joint, usable), judged.words())
    }
}

/// The names of the caller's own unknowns; nothing where there are none.
fn named_own(joint: &Joint) -> serde_json::Value {
    let names: Vec<String> = own_places(joint)
        .map(|k| joint.parameters[k].name())
        .collect();
    own_names(&names)
}

fn status(joint: &Joint, usable: bool) -> Status {
    match (joint.converged, usable) {
        (false, _) => Status::OutOfIterations,
        (true, true) => Status::Converged,
        (true, false) => Status::Refused,
    }
}

fn covariance(joint: &Joint) -> DMatrix<f64> {
    let all = columns(joint);
    DMatrix::from_fn(all.len(), all.len(), |i, j| match (all[i], all[j]) {
        (Some(a), Some(b)) => joint.covariance[a][b],
        _ => 0.0,
    })
}

fn by_reference(found: &Result<Reference, ReferenceError>, scene: &Scene) -> Solution {
    let reference = match found {
        Ok(found) => found,
        Err(error) => return Solution::without_result(Status::Refused, error.to_string()),
    };
    let values = reference.values();
    // the paths of the books know one head: the first of several
    let (found, nominal) = (&values.mountings[0], &scene.heads[0].nominal);
    let (name, prefix) = named(scene, 0);
    let mounted = Mounted {
        name: &name,
        rotation: (&found.rotation, &nominal.rotation),
        lever_arm_m: Some((found.lever_arm_m, nominal.lever_arm_m)),
        covariance: None,
        arrays: scene.heads[0].arrays.as_ref(),
    };
    let latency = parameter("latency", Unit::Second, values.latency_s, None);
    let scale = parameter("range scale", Unit::One, values.range_scale, None);
    let angles = mounted.parameters(&prefix).into_iter().take(3);
    let sought = match reference {
        Reference::Patch(_) => 4,
        Reference::Features(_) => 5,
    };
    let all = angles.chain([latency, scale]).zip(reference.found());
    let parameters: Vec<Parameter> = all.take(sought).map(found_or_not).collect();
    let without: Vec<&str> = (0..3)
        .filter(|k| !reference.found()[*k])
        .map(|k| parameters[k].name.as_str())
        .collect();
    let usable = without.is_empty();
    let (end, message) = if usable {
        (Status::Converged, String::new())
    } else {
        let message = format!("no pair of lines for {}", without.join(", "));
        (Status::Refused, message)
    };
    Solution {
        usable,
        mountings: usable.then(|| mounted.result()).into_iter().collect(),
        parameters,
        ..Solution::without_result(end, message)
    }
}

fn found_or_not((parameter, found): (Parameter, bool)) -> Parameter {
    if found {
        return parameter;
    }
    Parameter {
        note: "no pair of lines for it".to_owned(),
        ..reported(parameter, "not determined")
    }
}

/// The reference path minus the joint path: what both found, in the metric of the joint covariance.
fn comparison(outcome: &SeabedOutcome) -> Option<Comparison> {
    let (joint, judged) = outcome.joint.as_ref()?.as_ref().ok()?;
    let reference = outcome.reference.as_ref()?.as_ref().ok()?;
    let both: Vec<usize> = (0..4)
        .filter(|k| reference.found()[*k] && judged.determined[*k])
        .collect();
    let (ours, theirs) = (&joint.values, reference.values());
    let rotations = (&theirs.mountings[0].rotation, &ours.mountings[0].rotation);
    let turn = rotation::log(&(rotations.0 * rotations.1.transpose()));
    let all = [turn.x, turn.y, turn.z, theirs.latency_s - ours.latency_s];
    let d = DVector::from_iterator(both.len(), both.iter().map(|k| all[*k]));
    let covariance = DMatrix::from_fn(both.len(), both.len(), |i, j| {
        joint.covariance[both[i]][both[j]]
    });
    let (chi_square, degrees, p_value) = metric::chi_square(&d, &covariance)?;
    let difference = |k: &usize| {
        let unit = if *k < 3 { Unit::Radian } else { Unit::Second };
        let (difference, word) = readable(all[*k], unit);
        Difference {
            name: joint.parameters[*k].name(),
            unit: word.to_owned(),
            difference,
            in_joint_sigmas: all[*k] / joint.sigma(*k),
        }
    };
    Some(Comparison {
        differences: both.iter().map(difference).collect(),
        chi_square,
        degrees_of_freedom: degrees as u32,
        p_value,
    })
}

fn counts(outcome: &SeabedOutcome, scene: &Scene, read: usize) -> BTreeMap<String, SensorCounts> {
    let on_lines = scene.soundings.len();
    let mut rejected = BTreeMap::from([("off every line".to_owned(), (read - on_lines) as u64)]);
    let mut used = 0;
    if let Some(Ok((joint, _))) = &outcome.joint {
        used = joint
            .tiles
            .iter()
            .flat_map(|t| &t.members)
            .filter(|k| joint.alive[**k as usize])
            .count();
        let residual = joint.rejected;
        rejected.insert("off their line's surface".to_owned(), joint.screened as u64);
        rejected.insert("by their residual".to_owned(), residual as u64);
        let rest = on_lines - joint.screened - residual - used;
        rejected.insert("not selected for a tile".to_owned(), rest as u64);
    } else {
        rejected.insert("not adjusted".to_owned(), on_lines as u64);
    }
    let counts = SensorCounts {
        read: read as u64,
        used: used as u64,
        rejected,
    };
    BTreeMap::from([("multibeam".to_owned(), counts)])
}

fn notes(outcome: &SeabedOutcome, scene: &Scene) -> Vec<String> {
    let judged = match &outcome.joint {
        Some(Ok((joint, judged))) => {
            let held = (joint.field.noise_factor == CLAIMED).then(|| {
                "the noise of the soundings cannot be separated from the relief and was held at the claimed value"
                    .to_owned()
            });
            judged.noted().chain(held).collect()
        }
        _ => vec![],
    };
    let scale = "scale, heave, lever arm and profile are held within their priors; the latency's sigma holds as long as heave and attitude are of one clock within the heave lag's prior";
    let mut all = vec![scale.to_owned()];
    all.extend(judged);
    all.extend(outcome.reference.as_ref().and_then(|_| first_alone(scene)));
    all.extend((outcome.reference.as_ref()).and_then(|_| without_own(scene)));
    all
}

/// What the reference paths do where there are unknowns of the caller's own, in words.
fn without_own(scene: &Scene) -> Option<String> {
    let names: Vec<&str> = scene.extras.iter().map(|e| e.name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "the reference path knows no unknowns of your own: {} are the joint path's alone",
            names.join(", ")
        )
    })
}

/// What the reference paths do where there are several heads, in words.
fn first_alone(scene: &Scene) -> Option<String> {
    let [first, others @ ..] = scene.heads.as_slice() else {
        return None;
    };
    let others: Vec<String> = others.iter().map(Head::name).collect();
    (!others.is_empty()).then(|| {
        format!(
            "the reference path knows one head: it calibrates {} from its own soundings alone, and nothing of {}",
            first.name(),
            others.join(", ")
        )
    })
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
            "lines": heights(outcome, joint),
            "sigmas": sigmas(joint),
            "passes": joint.passes,
            "reasons": judged.reasons,
        }),
        _ => serde_json::Value::Null,
    };
    let (mut patch, mut features) = (serde_json::Value::Null, serde_json::Value::Null);
    match &outcome.reference {
        Some(Ok(Reference::Patch(found))) => patch = json!(found.steps),
        Some(Ok(Reference::Features(found))) => {
            features = json!({ "cell_m": found.cell_m, "latency_s": found.latency_s, "pairs": found.pairs });
        }
        _ => {}
    }
    json!({ "layout": outcome.layout, "joint": joint, "patch_test": patch, "features": features })
}

/// The name of each line, and by how much its heights are to be lifted, metres: tide and datum, as far as they differ between lines.
fn lifts<'a>(outcome: &'a SeabedOutcome, joint: &'a Joint) -> impl Iterator<Item = (&'a str, f64)> {
    let tracks = outcome.layout.tracks.iter().enumerate();
    tracks.map(|(k, track)| (track.name.as_str(), joint.line_height_m(k)))
}

fn heights(outcome: &SeabedOutcome, joint: &Joint) -> serde_json::Value {
    let one = |(name, height_m)| json!({ "name": name, "height_m": height_m });
    lifts(outcome, joint).map(one).collect()
}

/// Each parameter's sigma by the model, by the tiles' scatter, from relief and from motion alone; rad, m, s, 1.
fn sigmas(joint: &Joint) -> serde_json::Value {
    let part = |all: &Option<Vec<f64>>, k: usize| {
        let sigma = all.as_ref().map(|s| s[k]);
        sigma.filter(|s| s.is_finite())
    };
    let one = |k: usize| {
        json!({
            "name": joint.parameters[k].name(),
            "unit": joint.parameters[k].unit(),
            "model": joint.sigma(k),
            "scatter": joint.sandwich_sigma[k],
            "relief": part(&joint.relief_sigma, k),
            "motion": part(&joint.motion_sigma, k),
        })
    };
    let count = joint.sought.len();
    (0..count).filter(|k| joint.sought[*k]).map(one).collect()
}

/// The report's own section.
pub(super) fn page(
    outcome: &SeabedOutcome,
    scene: &Scene,
    name: &str,
    truth: Option<&SeabedTruth>,
) -> Page {
    Page {
        title: name.to_owned(),
        kind: "calibration of a multibeam's mounting over natural seabed",
        data: drawn(outcome, scene),
        scripts: &[
            include_str!("page/surfaces.js"),
            include_str!("page/coverage.js"),
            include_str!("page/features.js"),
            include_str!("page/page.js"),
        ],
        tables: vec![pairs(outcome), sources(outcome)],
        against_truth: truth.map(|truth| against(outcome, scene, truth)),
    }
}

/// What the report draws: the details, and the lines against each other.
fn drawn(outcome: &SeabedOutcome, scene: &Scene) -> serde_json::Value {
    let mut data = details(outcome);
    data["views"] = json!(views(outcome, scene));
    data
}

fn strings<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).to_vec()
}

/// Which lines met.
fn pairs(outcome: &SeabedOutcome) -> TextTable {
    let layout = &outcome.layout;
    let row = |pair: &super::layout::Pair| {
        let [a, b] = pair.lines.map(|k| layout.tracks[k].name.as_str());
        vec![
            format!("{a} and {b}, {:?}", pair.kind).to_lowercase(),
            format!("{:.1}", pair.apart_m),
            format!("{:.2}", pair.speed_ratio),
            pair.tiles.to_string(),
        ]
    };
    TextTable {
        header: strings(["lines", "apart, m", "speeds", "common tiles"]),
        rows: layout.pairs.iter().map(row).collect(),
        lines: vec![],
    }
}

/// Where the information comes from.
fn sources(outcome: &SeabedOutcome) -> TextTable {
    let Some(Ok((joint, judged))) = &outcome.joint else {
        return TextTable::default();
    };
    let row = |k: usize| {
        let parameter = &joint.parameters[k];
        let unit = unit_of(parameter);
        let figure = |x: Option<f64>| {
            x.map_or_else(|| "-".to_owned(), |x| format!("{:.5}", readable(x, unit).0))
        };
        vec![
            format!("{}, {}", parameter.name(), readable(0.0, unit).1),
            figure(Some(joint.sigma(k))),
            figure(Some(joint.sandwich_sigma[k])),
            figure(joint.relief_sigma.as_ref().map(|s| s[k])),
            figure(joint.motion_sigma.as_ref().map(|s| s[k])),
        ]
    };
    let field = &joint.field;
    let words = format!(
        "relief {:.3} m about the tiles' planes, correlated over {:.1} m; noise {:.2} times the claimed one; {} tiles",
        field.sigma_m,
        field.length_m,
        field.noise_factor,
        joint.tiles.len()
    );
    TextTable {
        header: strings([
            "sigma of",
            "model",
            "tiles' scatter",
            "relief alone",
            "motion alone",
        ]),
        rows: (joint.reported().filter(|k| joint.sought[*k]))
            .map(row)
            .collect(),
        lines: judged
            .noted()
            .chain([words, lifted(outcome, joint)])
            .collect(),
    }
}

/// The heights of the lines in words.
fn lifted(outcome: &SeabedOutcome, joint: &Joint) -> String {
    let all = lifts(outcome, joint).map(|(name, m)| format!("{name} {:+.1} cm", 100.0 * m));
    format!("lines lifted by: {}", all.collect::<Vec<_>>().join(", "))
}

/// Unit of a parameter that may be reported.
fn unit_of(parameter: &super::parameters::Parameter) -> Unit {
    match parameter.kind.is_angle() {
        true => Unit::Radian,
        false => Unit::Second,
    }
}

/// Errors against the truth: pitch, roll, yaw of each head, latency. The reference path has the first head only.
fn against(outcome: &SeabedOutcome, scene: &Scene, truth: &SeabedTruth) -> AgainstTruth {
    let parameters = scene.parameters();
    let rotations = truth.rotations();
    let turn = |head: usize, from: &Mounting, to: &Matrix3<f64>| {
        let turn = rotation::log(&(to * from.rotation.transpose()));
        own(head).0.into_iter().zip(<[f64; 3]>::from(turn))
    };
    let nominal = || scene.heads.iter().map(|head| &head.nominal);
    let errors = |values: &Values| {
        let mut all = vec![0.0; parameters.len()];
        let heads = values.mountings.iter().zip(&rotations).enumerate();
        for (head, (found, due)) in heads {
            let due = Mounting {
                rotation: *due,
                ..*found
            };
            all_of(&mut all, turn(head, &due, &found.rotation));
        }
        all[LATENCY] = values.latency_s - truth.latency_s;
        all
    };
    let mut due = vec![0.0; parameters.len()];
    for (head, (nominal, rotation)) in nominal().zip(&rotations).enumerate() {
        all_of(&mut due, turn(head, nominal, rotation));
    }
    due[LATENCY] = truth.latency_s;
    let joint = match &outcome.joint {
        Some(Ok((joint, _))) => Some((errors(&joint.values), joint)),
        _ => None,
    };
    let reference = match &outcome.reference {
        Some(Ok(reference)) => Some((errors(reference.values()), reference.found())),
        _ => None,
    };
    let row = |k: usize| {
        let unit = unit_of(&parameters[k]);
        let shown = |x: f64| readable(x, unit).0;
        let found = |(e, found): &(Vec<f64>, [bool; 5])| {
            let has = found.get(k).is_some_and(|found| *found) && k <= LATENCY;
            has.then(|| shown(e[k]))
        };
        TruthRow {
            name: parameters[k].name(),
            unit: readable(0.0, unit).1.to_owned(),
            correction: Some(shown(due[k])),
            reference: reference.as_ref().and_then(found),
            joint: joint.as_ref().map(|(e, _)| shown(e[k])),
            joint_in_sigmas: joint.as_ref().map(|(e, j)| e[k] / j.sigma(k)),
            joint_simple: None,
        }
    };
    AgainstTruth {
        rows: reported_places(&parameters).map(row).collect(),
    }
}

fn all_of(all: &mut [f64], of: impl Iterator<Item = (usize, f64)>) {
    for (place, value) in of {
        all[place] = value;
    }
}
