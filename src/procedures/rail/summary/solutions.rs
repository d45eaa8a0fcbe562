//! The outcome of each path as it stands in a result.

use nalgebra::DMatrix;

use super::super::joint::{RailJoint, Round};
use super::super::model::SOUGHT;
use super::super::reference::{RailReference, ReferenceError, SweepStep};
use super::super::run::{RailInput, RailOutcome};
use super::super::scene::RailScene;
use super::super::trial::{corrections, names};
use super::super::verdict::RailRefusal;
use super::judgement::judged;
use crate::adjust::{self, Unit};
use crate::calibrate::quality::readable;
use crate::observe::Mounting;
use crate::results::{
    Angles, HausdorffStep, JointIteration, MountingAngles, Parameter, RailJointSolution,
    RailMounting, RailReferenceSolution, RailReferenceSteps, Status,
};

fn mounting(found: &Mounting, profiler: &crate::observe::Profiler) -> RailMounting {
    let r = found.rotation;
    let (roll, pitch, heading) = found.angles();
    let turn = found
        .correction_from(&profiler.nominal)
        .map(f64::to_degrees);
    RailMounting {
        profiler: profiler.name.clone(),
        rotation_matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)])),
        mounting_deg: MountingAngles {
            roll: roll.to_degrees(),
            pitch: pitch.to_degrees(),
            heading: heading.to_degrees(),
        },
        correction_deg: Angles {
            pitch: turn.x,
            roll: turn.y,
            yaw: turn.z,
        },
        lever_arm_m: found.lever_arm_m.into(),
        lever_arm_correction_m: (found.lever_arm_m - profiler.nominal.lever_arm_m).into(),
    }
}

fn mountings<'m>(
    found: impl Iterator<Item = &'m Mounting>,
    scene: &RailScene,
) -> Vec<RailMounting> {
    found
        .zip(&scene.campaign.profilers)
        .map(|(m, p)| mounting(m, p))
        .collect()
}

pub(super) fn unit(column: usize) -> Unit {
    if column % SOUGHT < 3 {
        Unit::Radian
    } else {
        Unit::Metre
    }
}

/// Corrections as named parameters, angles in degrees.
fn parameters(values: &[f64], sigmas: Option<&DMatrix<f64>>, scene: &RailScene) -> Vec<Parameter> {
    let named = names(&scene.campaign.profilers)
        .into_iter()
        .zip(values)
        .enumerate();
    named
        .map(|(k, (name, value))| {
            let (shown, unit_name) = readable(*value, unit(k));
            Parameter {
                name,
                unit: unit_name.to_owned(),
                nominal: Some(0.0),
                value: Some(shown),
                standard_deviation: sigmas.map(|c| readable(c[(k, k)].sqrt(), unit(k)).0),
                note: String::new(),
            }
        })
        .collect()
}

pub(super) fn reference(
    found: &Result<Vec<RailReference>, ReferenceError>,
    scene: &RailScene,
) -> RailReferenceSolution {
    let all = match found {
        Ok(all) => all,
        Err(error) => {
            return RailReferenceSolution {
                status: Status::Refused,
                usable: false,
                message: error.to_string(),
                mountings: vec![],
                parameters: vec![],
                steps: vec![],
            };
        }
    };
    let values = corrections(all.iter().map(|r| &r.mounting), &scene.campaign.profilers);
    RailReferenceSolution {
        status: Status::Converged,
        usable: true,
        message: String::new(),
        mountings: mountings(all.iter().map(|r| &r.mounting), scene),
        parameters: parameters(&values, None, scene),
        steps: all
            .iter()
            .zip(&scene.campaign.profilers)
            .map(|(r, p)| steps(r, &p.name))
            .collect(),
    }
}

fn steps(found: &RailReference, name: &str) -> RailReferenceSteps {
    let sweep = |steps: &[SweepStep]| {
        let shown = |s: &SweepStep| HausdorffStep {
            turn_deg: s.turn_rad.to_degrees(),
            distance_m: s.distance_m,
        };
        steps.iter().map(shown).collect()
    };
    RailReferenceSteps {
        profiler: name.to_owned(),
        coarse_roll_deg: found.roll_rad.0.to_degrees(),
        fine_roll_deg: found.roll_rad.1.to_degrees(),
        heading_sweep: sweep(&found.heading),
        pitch_sweep: sweep(&found.pitch),
        fine_rms_m: found.rms_m.0,
        compensated_rms_m: found.rms_m.1,
    }
}

fn status(joint: &RailJoint, refused: bool) -> Status {
    match &joint.solution.status {
        adjust::Status::RankDeficient { .. } => Status::RankDeficient,
        adjust::Status::Stalled => Status::Stalled,
        adjust::Status::OutOfIterations => Status::OutOfIterations,
        adjust::Status::Converged if refused => Status::Refused,
        adjust::Status::Converged => Status::Converged,
    }
}

pub(super) fn joint(
    found: &Result<RailJoint, adjust::AdjustError>,
    outcome: &RailOutcome,
    input: &RailInput,
) -> RailJointSolution {
    let message = outcome
        .refusal
        .as_ref()
        .map(RailRefusal::to_string)
        .unwrap_or_default();
    let refused = outcome.refusal.is_some();
    let mut solution = RailJointSolution {
        status: Status::Refused,
        usable: !refused,
        message,
        mountings: vec![],
        parameters: vec![],
        covariance: vec![],
        nuisance: vec![],
        iterations: vec![],
        quality: None,
    };
    let Ok(found) = found else { return solution };
    solution.status = status(found, refused);
    solution.iterations = iterations(found);
    if refused {
        return solution;
    }
    let scene = &outcome.scene;
    let values = corrections(found.mountings.iter(), &scene.campaign.profilers);
    solution.mountings = mountings(found.mountings.iter(), scene);
    solution.parameters = parameters(&values, Some(&found.covariance), scene);
    solution.covariance = found
        .covariance
        .row_iter()
        .map(|r| r.iter().copied().collect())
        .collect();
    solution.nuisance = nuisance(found);
    solution.quality = judged(found, scene, input);
    solution
}

fn iterations(found: &RailJoint) -> Vec<JointIteration> {
    let round = |(outer, round): (usize, &Round)| {
        let reassigned = round.changed as u64;
        let all = round.iterations.iter().enumerate();
        let step = move |(inner, &(cost, sigmas)): (usize, &(f64, f64))| JointIteration {
            outer: outer as u32 + 1,
            inner: inner as u32 + 1,
            cost: finite(cost),
            largest_step_in_sigma: finite(sigmas),
            reassigned: if inner == 0 { reassigned } else { 0 },
        };
        all.map(step).collect::<Vec<_>>()
    };
    found.rounds.iter().enumerate().flat_map(round).collect()
}

/// JSON knows no infinity.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::MAX }
}

/// What was estimated along: the change from its prior, since rotations have no single value.
fn nuisance(found: &RailJoint) -> Vec<Parameter> {
    let x = &found.solution.estimate.parameters;
    let (mut all, mut column) = (vec![], 0);
    for block in x.blocks() {
        let size = block.components.len();
        if let Some(prior) = &block.prior {
            let change = block.chart.difference(&block.value, &prior.value);
            for (i, component) in block.components.iter().enumerate() {
                let sigma = found.solution.cofactor[(column + i, column + i)].sqrt();
                let (value, unit) = readable(change[i], component.unit);
                all.push(Parameter {
                    name: component.name.clone(),
                    unit: unit.to_owned(),
                    nominal: Some(0.0),
                    value: Some(value),
                    standard_deviation: Some(readable(sigma, component.unit).0),
                    note: "change from what was known before".to_owned(),
                });
            }
        }
        column += size;
    }
    all
}
