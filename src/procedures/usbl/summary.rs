//! A USBL calibration's outcome as plain results: `result.json` and the samples of the report's pictures.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::conditions::{ANGLES, PER_FIX, RANGES};
use super::config::KernelName;
use super::joint::{JointOutcome, MOUNTING, SOUGHT, sought};
use super::reference::{PrintedAngles, ReferenceOutcome};
use super::verdict::{Layout, rests_on_survey};
use super::verify::BeaconResiduals;
use super::{UsblInput, UsblOutcome};
use crate::adjust;
use crate::calibrate::choices::Method;
use crate::calibrate::metric;
use crate::calibrate::quality::{Judged, block_priors, group, named_prior, quality, readable};
use crate::geometry::rotation;
use crate::observe::usbl::Role;
use crate::results::{
    Angles, MountingAngles, Parameter, ParameterComparison, ParameterDifference, Provenance,
    Quality, SCHEMA, SensorCounts, Status, UsblBeacon, UsblFixSample, UsblIteration, UsblJoint,
    UsblPrintedAngles, UsblReference, UsblResiduals, UsblResult, UsblSamples, UsblSolutions,
    UsblTruth, UsblVerification,
};

/// Fixes of a beacon that the pictures show at the most.
const SHOWN: usize = 400;
/// A turn of the attitude sensor above this makes the means of the reference path doubtful, radians.
const UNREST_RAD: f64 = 0.01;

/// The outcome as `result.json` gives it; `read` and `dropped` count the fixes of the file, `notes` come from reading it.
#[must_use]
pub fn result(
    outcome: &UsblOutcome,
    input: &UsblInput,
    (read, dropped): (usize, usize),
    notes: &[String],
    provenance: Provenance,
) -> UsblResult {
    let campaign = input.campaign;
    let usable = outcome.refusal.is_none();
    let solutions = UsblSolutions {
        reference: (input.method != Method::Joint).then(|| reference(outcome, input)),
        joint: (input.method != Method::Sequential).then(|| joint(outcome, input)),
    };
    UsblResult {
        schema: SCHEMA,
        procedure: "usbl".to_owned(),
        provenance,
        usable,
        reason: outcome.refusal.as_ref().map(ToString::to_string),
        verdict: outcome.verdict(),
        fixes: counts(outcome, read, dropped),
        beacons: beacons(input),
        transducer_standard_deviation_m: sigmas(&campaign.transducer.covariance_m2),
        nominal_mounting_deg: mounting(&campaign.nominal),
        comparison: if usable { compare(outcome) } else { None },
        solutions,
        verification: verification(outcome),
        notes: notes
            .iter()
            .cloned()
            .chain(own_notes(outcome, input))
            .collect(),
    }
}

fn sigmas(covariance: &Matrix3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|i| covariance[(i, i)].sqrt())
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]))
}

fn mounting(r: &Matrix3<f64>) -> MountingAngles {
    let (roll, pitch, heading) = rotation::to_attitude(r);
    MountingAngles {
        roll: roll.to_degrees(),
        pitch: pitch.to_degrees(),
        heading: heading.to_degrees(),
    }
}

fn correction(r: &Matrix3<f64>, nominal: &Matrix3<f64>) -> Angles {
    let turn = rotation::log(&(r * nominal.transpose())).map(f64::to_degrees);
    Angles {
        pitch: turn.x,
        roll: turn.y,
        yaw: turn.z,
    }
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

fn reference(outcome: &UsblOutcome, input: &UsblInput) -> UsblReference {
    if let Some(refusal) = outcome.refusal.as_ref().filter(|r| r.is_of_layout()) {
        return no_reference(refusal.to_string());
    }
    match &outcome.reference {
        Some(Ok(found)) => reference_found(found, input),
        Some(Err(error)) => no_reference(error.to_string()),
        None => no_reference("did not run".to_owned()),
    }
}

fn no_reference(message: String) -> UsblReference {
    UsblReference {
        status: Status::Refused,
        usable: false,
        message,
        rotation_matrix: None,
        mounting_deg: None,
        correction_deg: None,
        formal_covariance: None,
        adjusted_printed_deg: None,
        measured_printed_deg: None,
        difference_printed_deg: None,
        iterations: vec![],
    }
}

fn reference_found(found: &ReferenceOutcome, input: &UsblInput) -> UsblReference {
    let [roll, pitch, heading] = found.measured.map(f64::to_degrees);
    let iteration = |i: &super::reference::ReferenceIteration| {
        let [h, r, p] = i.step.map(f64::to_degrees);
        UsblIteration {
            step_deg: UsblPrintedAngles { h, p, r },
            rms_m: i.rms_m,
        }
    };
    UsblReference {
        status: if found.converged {
            Status::Converged
        } else {
            Status::OutOfIterations
        },
        usable: found.converged,
        message: String::new(),
        rotation_matrix: Some(rows(&found.rotation)),
        mounting_deg: Some(mounting(&found.rotation)),
        correction_deg: Some(correction(&found.rotation, &input.campaign.nominal)),
        formal_covariance: found.covariance.as_ref().map(rows),
        adjusted_printed_deg: Some(printed(&found.adjusted)),
        measured_printed_deg: Some(UsblPrintedAngles {
            h: heading,
            p: -pitch,
            r: -roll,
        }),
        difference_printed_deg: Some(printed(&found.difference)),
        iterations: found.iterations.iter().map(iteration).collect(),
    }
}

fn joint(outcome: &UsblOutcome, input: &UsblInput) -> UsblJoint {
    let refused = outcome.refusal.as_ref();
    let message = refused.map(ToString::to_string).unwrap_or_default();
    let Some(found) = &outcome.joint else {
        return no_joint(Status::Refused, message);
    };
    let quality = quality_of(found, outcome, input);
    let iterations = found.solution.iterations.len() as u64;
    if refused.is_some() {
        let status = match found.solution.status {
            adjust::Status::RankDeficient { .. } => Status::RankDeficient,
            _ => Status::Refused,
        };
        return UsblJoint {
            iterations,
            quality,
            ..no_joint(status, message)
        };
    }
    let list = |m: &DMatrix<f64>| -> Vec<Vec<f64>> {
        m.row_iter()
            .map(|row| row.iter().copied().collect())
            .collect()
    };
    UsblJoint {
        status: match found.solution.status {
            adjust::Status::Stalled => Status::Stalled,
            _ => Status::Converged,
        },
        usable: true,
        message,
        rotation_matrix: Some(rows(&found.rotation)),
        mounting_deg: Some(mounting(&found.rotation)),
        printed_deg: Some(printed(&PrintedAngles::of(&found.rotation))),
        correction_deg: Some(correction(&found.rotation, &input.campaign.nominal)),
        transducer_m: Some(found.transducer_m.into()),
        range_scale: Some(found.scale),
        parameters: parameters(found, input),
        covariance: Some(list(&found.covariance)),
        correlation: Some(list(&metric::correlation(&found.covariance))),
        iterations,
        quality,
    }
}

fn no_joint(status: Status, message: String) -> UsblJoint {
    UsblJoint {
        status,
        usable: false,
        message,
        rotation_matrix: None,
        mounting_deg: None,
        printed_deg: None,
        correction_deg: None,
        transducer_m: None,
        range_scale: None,
        parameters: vec![],
        covariance: None,
        correlation: None,
        iterations: 0,
        quality: None,
    }
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

fn parameters(found: &JointOutcome, input: &UsblInput) -> Vec<Parameter> {
    let values = values(found, &input.campaign.nominal);
    let named = sought().into_iter().enumerate();
    named
        .map(|(i, (name, unit))| {
            let sigma = found.covariance[(i, i)].sqrt();
            let (value, word) = readable(values[i], unit);
            Parameter {
                name: name.to_owned(),
                unit: word.to_owned(),
                nominal: Some(0.0),
                value: Some(value),
                standard_deviation: (sigma > 0.0).then(|| readable(sigma, unit).0),
                note: if sigma > 0.0 { "" } else { "held" }.to_owned(),
            }
        })
        .collect()
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
        robust: input.joint.kernel != KernelName::LeastSquares,
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
fn compare(outcome: &UsblOutcome) -> Option<ParameterComparison> {
    let joint = outcome.joint.as_ref()?;
    let reference = outcome.reference.as_ref()?.as_ref().ok()?;
    let turn = rotation::log(&(reference.rotation * joint.rotation.transpose()));
    let covariance = joint.covariance.view((0, 0), (3, 3)).into_owned();
    let d = DVector::from_column_slice(turn.as_slice());
    let (chi_square, free, p_value) = metric::chi_square(&d, &covariance)?;
    let difference = |(i, name): (usize, &&str)| ParameterDifference {
        name: (*name).to_owned(),
        unit: "deg".to_owned(),
        difference: turn[i].to_degrees(),
        in_reference_sigmas: turn[i] / covariance[(i, i)].sqrt(),
    };
    Some(ParameterComparison {
        reference: "joint".to_owned(),
        differences: MOUNTING.iter().enumerate().map(difference).collect(),
        chi_square,
        degrees_of_freedom: free as u32,
        p_value,
    })
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
        "a constant error of the attitude sensor cannot be told from the mounting; it is part of the calibration".to_owned(),
    );
    notes
}

/// Residuals for the pictures.
#[must_use]
pub fn samples(outcome: &UsblOutcome, title: &str, truth: Option<UsblTruth>) -> UsblSamples {
    let fixes = &outcome.scene.campaign.fixes;
    let begin_s = fixes.time_s.first().copied().unwrap_or(0.0);
    let mut all = vec![];
    for beacon in 0..outcome.scene.campaign.beacons.len() as u32 {
        let find = |list: &[BeaconResiduals], fix: u32| {
            let own = list.iter().find(|r| r.beacon == beacon)?;
            own.residuals.iter().find(|r| r.fix == fix).copied()
        };
        let rows: Vec<u32> = (0..fixes.len() as u32)
            .filter(|fix| fixes.beacon[*fix as usize] == beacon)
            .collect();
        for &fix in rows.iter().step_by(rows.len().div_ceil(SHOWN).max(1)) {
            let reference = find(&outcome.reference_residuals, fix);
            let joint = find(&outcome.joint_residuals, fix);
            all.push(UsblFixSample {
                beacon,
                time_s: fixes.time_s[fix as usize] - begin_s,
                reference_m: reference.map(|r| r.enu_m.into()),
                joint_m: joint.map(|r| r.enu_m.into()),
                outlier: joint.or(reference).is_some_and(|r| r.outlier),
            });
        }
    }
    UsblSamples {
        title: title.to_owned(),
        fixes: all,
        truth,
    }
}
