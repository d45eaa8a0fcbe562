//! The outcome as plain data: `result.json`, and the report's own section.

mod details;
mod judgement;
mod samples;
mod solutions;

pub use details::{
    HausdorffStep, RailDetails, RailJointDetails, RailReferenceDetails, RailReferenceSteps,
};
pub use samples::{Outline, ProfileSample, RailSamples, ResidualSample, page, true_values};

use std::collections::BTreeMap;

use super::joint::RailJoint;
use super::observed::Profiler;
use super::reference::RailReference;
use super::run::RailOutcome;
use super::scene::RailScene;
use super::trial::{corrections_from, names};
use crate::calibrate::solution::compared;
use crate::formats::week;
use crate::results::{Calibration, Comparison, Provenance, SCHEMA, SensorCounts, Solutions};
use crate::survey::decimals;
use samples::{paths, rms};
use solutions::{joint, reference, unit};

/// Everything for `result.json`.
///
/// # Errors
/// None for details made here; `serde_json` does not promise it.
pub fn result(outcome: &RailOutcome, provenance: Provenance) -> serde_json::Result<Calibration> {
    let scene = &outcome.scene;
    let reason = outcome.refusal.as_ref().map(ToString::to_string);
    let by_reference = outcome.reference.as_ref().map(|r| reference(r, scene));
    let by_joint = outcome.joint.as_ref().map(|j| joint(j, outcome));
    Ok(Calibration {
        schema: SCHEMA,
        procedure: "rail".to_owned(),
        provenance,
        usable: reason.is_none(),
        verdict: outcome.verdict(),
        reason,
        counts: counts(outcome),
        solutions: Solutions {
            reference: by_reference.transpose()?,
            joint: by_joint.transpose()?,
            joint_simple: None,
        },
        comparison: comparison(outcome),
        residual_rms_m: paths(outcome)
            .into_iter()
            .map(|path| (path.name.to_owned(), rms(outcome, &path)))
            .collect(),
        notes: notes(scene),
        details: serde_json::to_value(details(scene))?,
        conventions: vec![],
    })
}

fn details(scene: &RailScene) -> RailDetails {
    let (heading, pitch) = scene.turned_rad();
    RailDetails {
        rail: scene.rail.name.clone(),
        positions: scene.positions.len() as u64,
        turned_deg: [heading.to_degrees(), pitch.to_degrees()],
    }
}

fn notes(scene: &RailScene) -> Vec<String> {
    let mut notes = vec![
        "lever arms along the rail are seen only through the table's turns, relative to its centre of rotation: the rail is the same all along"
            .to_owned(),
        "errors of the stated orientation and place of the rail and of the table's centre of rotation pass into the angles and offsets in full; between profilers they cancel"
            .to_owned(),
    ];
    notes.extend(week::passed("profiles", &scene.campaign.points.time_s));
    let noise = &scene.campaign.attitude_noise;
    let sigmas = [noise.roll_pitch_rad, noise.heading_rad];
    let columns = scene.campaign.attitude.columns();
    notes.extend(decimals::of_attitude(columns, sigmas));
    if scene.turning > 0 {
        notes.push(format!(
            "{} points were taken while the table turned and were left out",
            scene.turning
        ));
    }
    let silent = scene
        .positions
        .iter()
        .filter(|p| p.attitude.is_none())
        .count();
    if silent > 0 {
        notes.push(format!(
            "{silent} of {} positions have no INS record",
            scene.positions.len()
        ));
    }
    notes
}

pub(super) fn usable_joint<'o>(outcome: &'o RailOutcome) -> Option<&'o RailJoint> {
    outcome
        .joint
        .as_ref()?
        .as_ref()
        .ok()
        .filter(|_| outcome.refusal.is_none())
}

pub(super) fn usable_reference<'o>(outcome: &'o RailOutcome) -> Option<&'o Vec<RailReference>> {
    outcome.reference.as_ref()?.as_ref().ok()
}

/// Points by profiler.
fn counts(outcome: &RailOutcome) -> BTreeMap<String, SensorCounts> {
    let scene = &outcome.scene;
    let points = &scene.campaign.points;
    let per = |rows: &mut dyn Iterator<Item = u32>| {
        let mut n = vec![0u64; scene.campaign.profilers.len()];
        rows.for_each(|row| n[points.profiler[row as usize] as usize] += 1);
        n
    };
    let read = per(&mut (0..points.len() as u32));
    let resting = per(&mut scene.points.iter().map(|p| p.row));
    let joint = outcome.joint.as_ref().and_then(|j| j.as_ref().ok());
    let used = per(&mut joint.iter().flat_map(|j| j.ties.iter().map(|t| t.row)));
    let one = |(p, profiler): (usize, &Profiler)| {
        let mut rejected = BTreeMap::new();
        let mut reject = |why: &str, n: u64| {
            if n > 0 {
                rejected.insert(why.to_owned(), n);
            }
        };
        reject("while the table turned", read[p] - resting[p]);
        reject(
            if joint.is_some() {
                "off the rail"
            } else {
                "not adjusted"
            },
            resting[p] - used[p],
        );
        let counts = SensorCounts {
            read: read[p],
            used: used[p],
            rejected,
        };
        (profiler.name.clone(), counts)
    };
    scene
        .campaign
        .profilers
        .iter()
        .enumerate()
        .map(one)
        .collect()
}

/// The reference path minus the joint one.
fn comparison(outcome: &RailOutcome) -> Option<Comparison> {
    let (by_reference, by_joint) = (usable_reference(outcome)?, usable_joint(outcome)?);
    let found = by_reference.iter().map(|r| &r.mounting);
    let d = corrections_from(found, by_joint.mountings.iter());
    let names = names(&outcome.scene.campaign.profilers).into_iter();
    let named = names.enumerate().map(|(k, name)| (name, unit(k)));
    compared(named, &d, &by_joint.covariance)
}
