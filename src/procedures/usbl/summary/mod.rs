//! A USBL calibration's outcome as plain results: `result.json` and the report's own section.

mod details;
mod page;
mod words;

pub use details::{
    UsblBeacon, UsblDetails, UsblIteration, UsblJointDetails, UsblPrintedAngles,
    UsblReferenceDetails, UsblResiduals, UsblVerification,
};
pub use page::{UsblFixSample, UsblSamples, page, true_values};

use nalgebra::{DMatrix, Matrix3};

use super::conditions::{ANGLES, PER_FIX, RANGES};
use super::joint::{JointOutcome, MOUNTING, SOUGHT, sought};
use super::observed::Role;
use super::reference::{PrintedAngles, ReferenceOutcome};
use super::verdict::{Layout, rests_on_survey};
use super::verify::BeaconResiduals;
use super::{UsblInput, UsblOutcome};
use crate::adjust;
use crate::calibrate::choices::Method;
use crate::calibrate::quality::{Judged, block_priors, group, named_prior, quality};
use crate::calibrate::solution::{
    Mounted, compared, iterations, matrices, mounting_angles, parameter, rows,
};
use crate::geometry::rotation;
use crate::results::{
    Calibration, Comparison, Parameter, Provenance, Quality, SCHEMA, SensorCounts, Solution,
    Solutions, Status,
};
/// Name of the sensor whose mounting is sought.
pub const SENSOR: &str = "transducer";
/// A turn of the attitude sensor above this makes the means of the reference path doubtful, radians.
const UNREST_RAD: f64 = 0.01;

/// The outcome as `result.json` gives it; `read` and `dropped` count the fixes of the file, `notes` come from reading it.
///
/// # Errors
/// None for details made here; `serde_json` does not promise it.
pub fn result(
    outcome: &UsblOutcome,
    input: &UsblInput,
    (read, dropped): (usize, usize),
    notes: &[String],
    provenance: Provenance,
) -> serde_json::Result<Calibration> {
    let usable = outcome.refusal.is_none();
    let own = own_notes(outcome, input);
    let reason = outcome.refusal.as_ref().map(ToString::to_string);
    Ok(Calibration {
        schema: SCHEMA,
        procedure: "usbl".to_owned(),
        provenance,
        usable,
        verdict: outcome.verdict(),
        reason,
        counts: [("fixes".to_owned(), counts(outcome, read, dropped))].into(),
        solutions: solutions(outcome, input)?,
        comparison: usable.then(|| compare(outcome)).flatten(),
        residual_rms_m: std::collections::BTreeMap::new(),
        notes: notes.iter().cloned().chain(own).collect(),
        details: serde_json::to_value(details(outcome, input))?,
        conventions: vec![],
    })
}

/// One entry per path that was asked for.
fn solutions(outcome: &UsblOutcome, input: &UsblInput) -> serde_json::Result<Solutions> {
    let reference = (input.method != Method::Joint).then(|| reference(outcome, input));
    let joint = (input.method != Method::Reference).then(|| joint(outcome, input));
    Ok(Solutions {
        reference: reference.transpose()?,
        joint: joint.transpose()?,
        joint_simple: None,
    })
}

fn details(outcome: &UsblOutcome, input: &UsblInput) -> UsblDetails {
    UsblDetails {
        beacons: beacons(input),
        transducer_standard_deviation_m: sigmas(&input.campaign.transducer.covariance_m2),
        nominal_mounting_deg: mounting_angles(&input.campaign.nominal),
        verification: verification(outcome),
    }
}

fn sigmas(covariance: &Matrix3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|i| covariance[(i, i)].sqrt())
}

fn printed(angles: &PrintedAngles) -> UsblPrintedAngles {
    UsblPrintedAngles {
        h: angles.h.to_degrees(),
        p: angles.p.to_degrees(),
        r: angles.r.to_degrees(),
    }
}

fn role(role: Role) -> String {
    match role {
        Role::Common => "common",
        Role::Check => "check",
    }
    .to_owned()
}

fn beacons(input: &UsblInput) -> Vec<UsblBeacon> {
    let campaign = input.campaign;
    let numbered = campaign.beacons.iter().enumerate();
    numbered
        .map(|(k, beacon)| UsblBeacon {
            name: beacon.point.name.clone(),
            role: role(beacon.role),
            position_m: beacon.point.position_m.into(),
            standard_deviation_m: sigmas(&beacon.point.covariance_m2),
            fixes: campaign.fixes.of_beacon(k as u32) as u64,
        })
        .collect()
}

fn counts(outcome: &UsblOutcome, read: usize, dropped: usize) -> SensorCounts {
    let all = outcome.scene.campaign.fixes.len();
    let common = outcome.scene.common.len();
    let gross = outcome.joint.as_ref().map_or(0, |j| j.gross.len());
    let reasons = [
        ("gross error", gross),
        ("check beacon", all - common),
        ("no attitude", dropped),
    ];
    let rejected = reasons.into_iter().filter(|(_, n)| *n > 0);
    SensorCounts {
        read: read as u64,
        used: (common - gross) as u64,
        rejected: rejected
            .map(|(why, n)| (why.to_owned(), n as u64))
            .collect(),
    }
}

fn reference(outcome: &UsblOutcome, input: &UsblInput) -> serde_json::Result<Solution> {
    let refused = |message: String| Ok(Solution::without_result(Status::Refused, message));
    if let Some(refusal) = outcome.refusal.as_ref().filter(|r| r.is_of_layout()) {
        return refused(refusal.to_string());
    }
    match &outcome.reference {
        Some(Ok(found)) => reference_found(found, input),
        Some(Err(error)) => refused(error.to_string()),
        None => refused("did not run".to_owned()),
    }
}

fn reference_found(found: &ReferenceOutcome, input: &UsblInput) -> serde_json::Result<Solution> {
    let status = if found.converged {
        Status::Converged
    } else {
        Status::OutOfIterations
    };
    let mounted = mounted(&found.rotation, input, None);
    Ok(Solution {
        usable: found.converged,
        parameters: mounted.parameters(""),
        mountings: vec![mounted.result()],
        details: serde_json::to_value(reference_details(found))?,
        ..Solution::without_result(status, String::new())
    })
}

/// The transducer on the attitude sensor, found and nominal.
fn mounted<'a>(
    found: &'a Matrix3<f64>,
    input: &'a UsblInput,
    covariance: Option<&'a DMatrix<f64>>,
) -> Mounted<'a> {
    Mounted {
        name: SENSOR,
        rotation: (found, &input.campaign.nominal),
        lever_arm_m: None,
        covariance,
        arrays: None,
    }
}

fn reference_details(found: &ReferenceOutcome) -> UsblReferenceDetails {
    let [roll, pitch, heading] = found.measured.map(f64::to_degrees);
    let iteration = |i: &super::reference::ReferenceIteration| {
        let [h, r, p] = i.step.map(f64::to_degrees);
        UsblIteration {
            step_deg: UsblPrintedAngles { h, p, r },
            rms_m: i.rms_m,
        }
    };
    UsblReferenceDetails {
        formal_covariance: found.covariance.as_ref().map(rows),
        adjusted_printed_deg: printed(&found.adjusted),
        measured_printed_deg: UsblPrintedAngles {
            h: heading,
            p: -pitch,
            r: -roll,
        },
        difference_printed_deg: printed(&found.difference),
        iterations: found.iterations.iter().map(iteration).collect(),
    }
}

fn joint(outcome: &UsblOutcome, input: &UsblInput) -> serde_json::Result<Solution> {
    let refused = outcome.refusal.as_ref();
    let message = refused.map(ToString::to_string).unwrap_or_default();
    let Some(found) = &outcome.joint else {
        return Ok(Solution::without_result(Status::Refused, message));
    };
    let status = match (&found.solution.status, refused) {
        (adjust::Status::RankDeficient { .. }, Some(_)) => Status::RankDeficient,
        (_, Some(_)) => Status::Refused,
        (adjust::Status::Stalled, None) => Status::Stalled,
        _ => Status::Converged,
    };
    let steps = found.solution.iterations.iter();
    let solution = Solution {
        convergence: iterations(0, 0, steps.map(|i| (i.cost, i.step_sigmas))).collect(),
        quality: quality_of(found, outcome, input),
        ..Solution::without_result(status, message)
    };
    if refused.is_some() {
        return Ok(solution);
    }
    let (covariance, correlation) = matrices(&found.covariance);
    let mounted = mounted(&found.rotation, input, Some(&found.covariance));
    let printed_deg = printed(&PrintedAngles::of(&found.rotation));
    Ok(Solution {
        usable: true,
        parameters: parameters(found, &mounted),
        mountings: vec![mounted.result()],
        covariance,
        correlation,
        details: serde_json::to_value(UsblJointDetails { printed_deg })?,
        ..solution
    })
}

/// The values sought in the order of [`sought`], SI and radians: corrections to the nominal mounting, transducer, scale.
#[must_use]
pub fn values(found: &JointOutcome, nominal: &Matrix3<f64>) -> [f64; SOUGHT] {
    let turn = rotation::log(&(found.rotation * nominal.transpose()));
    let place = &found.transducer_m;
    [
        turn.x,
        turn.y,
        turn.z,
        place.x,
        place.y,
        place.z,
        found.scale,
    ]
}

/// The mounting's angles, then the transducer's place and the range scale, both counted from what was surveyed or measured.
fn parameters(found: &JointOutcome, mounted: &Mounted) -> Vec<Parameter> {
    let mut all = mounted.parameters("");
    let place = found.transducer_m.iter().copied().chain([found.scale]);
    let named = sought().into_iter().enumerate().skip(MOUNTING.len());
    all.extend(named.zip(place).map(|((i, (name, unit)), value)| {
        parameter(name, unit, value, Some(found.covariance[(i, i)].sqrt()))
    }));
    all
}

fn quality_of(found: &JointOutcome, outcome: &UsblOutcome, input: &UsblInput) -> Option<Quality> {
    let judgement = found.judgement.as_ref()?;
    let groups = judgement.quality.groups.iter();
    let name = |g: &adjust::GroupQuality| match g.group {
        RANGES => group(g, "range", "ranges alone"),
        ANGLES => group(g, "angles", "both angles together"),
        _ => group(g, "other", ""),
    };
    let campaign = outcome.scene.campaign;
    let worst = &judgement.quality.worst;
    let observation = |place: usize| {
        let condition = worst[place].condition;
        let fix = found.used[condition / PER_FIX] as usize;
        let beacon = &campaign.beacons[campaign.fixes.beacon[fix] as usize];
        let what = ["range", "first angle", "second angle"][condition % PER_FIX];
        format!(
            "{what} of beacon {} at {:.3} s",
            beacon.point.name, campaign.fixes.time_s[fix]
        )
    };
    let mut priors = block_priors(&found.solution.estimate.parameters);
    let noise = &campaign.attitude_noise;
    if input.joint.attitude_noise {
        let named = [
            ("attitude noise, roll and pitch", noise.roll_pitch_rad),
            ("attitude noise, heading", noise.heading_rad),
        ];
        let some = named.into_iter().filter(|(_, sigma)| *sigma > 0.0);
        priors.extend(some.map(|(name, s)| named_prior(name, s, adjust::Unit::Radian)));
    }
    let names: Vec<String> = sought()
        .iter()
        .map(|(name, _)| (*name).to_owned())
        .collect();
    quality(Judged {
        quality: &judgement.quality,
        observability: &judgement.observability,
        parameters: &found.solution.estimate.parameters,
        sought: &names,
        priors,
        groups: groups.map(name).collect(),
        observation: &observation,
        advice: &advice,
    })
}

fn advice(a: &str, b: &str) -> &'static str {
    let has = |word: &str| a.contains(word) || b.contains(word);
    if has("datum") {
        "; nothing in the data separates a constant turn of the control from the mounting"
    } else if has("range scale") && has("up") {
        "; a better sound speed, or beacons at different depths, separate them"
    } else if has("transducer") {
        "; a better survey of the transducer, or beacons spread around it at different depths, separate them"
    } else {
        ""
    }
}

/// Reference minus joint, pitch, roll and yaw in the metric of the joint path's covariance.
fn compare(outcome: &UsblOutcome) -> Option<Comparison> {
    let joint = outcome.joint.as_ref()?;
    let reference = outcome.reference.as_ref()?.as_ref().ok()?;
    let turn = rotation::log(&(reference.rotation * joint.rotation.transpose()));
    let covariance = joint.covariance.view((0, 0), (3, 3)).into_owned();
    let named = MOUNTING.map(|name| (name.to_owned(), adjust::Unit::Radian));
    compared(named, turn.as_slice(), &covariance)
}

fn verification(outcome: &UsblOutcome) -> Vec<UsblVerification> {
    let of = |list: &[BeaconResiduals], beacon: u32, tested: bool| {
        let found = list.iter().find(|r| r.beacon == beacon)?;
        Some(residuals(found, tested))
    };
    let beacons = outcome.scene.campaign.beacons.iter().enumerate();
    beacons
        .map(|(k, beacon)| UsblVerification {
            beacon: beacon.point.name.clone(),
            role: role(beacon.role),
            reference: of(&outcome.reference_residuals, k as u32, false),
            joint: of(
                &outcome.joint_residuals,
                k as u32,
                beacon.role == Role::Check,
            ),
        })
        .collect()
}

fn residuals(found: &BeaconResiduals, tested: bool) -> UsblResiduals {
    let test = found.test().filter(|_| tested);
    UsblResiduals {
        fixes: found.good as u64,
        outliers: (found.residuals.len() - found.good) as u64,
        mean_m: found.mean_m.into(),
        rms_m: found.rms_m,
        mean_standard_deviation_m: sigmas(&found.covariance_m2),
        test_statistic: test.map(|t| t.0),
        p_value: test.map(|t| t.1),
    }
}

fn own_notes(outcome: &UsblOutcome, input: &UsblInput) -> Vec<String> {
    let mut notes = vec![];
    let layout = Layout::of(&outcome.scene).in_words();
    if !layout.is_empty() {
        notes.push(layout);
    }
    if let Some(joint) = &outcome.joint {
        notes.extend(rests_on_survey(joint, &input.joint));
    }
    if let Some(Ok(reference)) = &outcome.reference
        && reference.unrest_rad > UNREST_RAD
    {
        notes.push(format!(
            "the attitude sensor turned by up to {:.2} deg about its mean: the reference path averages the fixes as if it stood still",
            reference.unrest_rad.to_degrees()
        ));
    }
    notes.push(
        "a constant error of the attitude sensor cannot be separated from the mounting; it becomes part of the calibration".to_owned(),
    );
    notes
}
