//! The outcome of each path as it stands in a result.

use nalgebra::DMatrix;

use super::super::joint::RailJoint;
use super::super::model::SOUGHT;
use super::super::observed::Profiler;
use super::super::reference::{RailReference, ReferenceError, SweepStep};
use super::super::run::RailOutcome;
use super::super::scene::RailScene;
use super::super::verdict::RailRefusal;
use super::details::{HausdorffStep, RailJointDetails, RailReferenceDetails, RailReferenceSteps};
use super::judgement::judged;
use crate::adjust::{self, Unit};
use crate::calibrate::solution::{Mounted, iterations, matrices, parameter, status};
use crate::observe::Mounting;
use crate::results::{Iteration, Parameter, Solution, Status};

pub(super) fn unit(column: usize) -> Unit {
    if column % SOUGHT < 3 {
        Unit::Radian
    } else {
        Unit::Metre
    }
}

fn mounted<'a>(
    found: &'a Mounting,
    profiler: &'a Profiler,
    covariance: Option<&'a DMatrix<f64>>,
) -> Mounted<'a> {
    Mounted {
        name: &profiler.name,
        rotation: (&found.rotation, &profiler.nominal.rotation),
        lever_arm_m: Some((found.lever_arm_m, profiler.nominal.lever_arm_m)),
        covariance,
        arrays: None,
    }
}

/// Columns of one mounting's pitch, roll, yaw, lx, ly, lz: the engine has the lever arms along the rail behind all others.
fn columns(profiler: usize, profilers: usize) -> [usize; 6] {
    let (first, along) = (SOUGHT * profiler, SOUGHT * profilers + profiler);
    [first, first + 1, first + 2, first + 3, along, first + 4]
}

/// The rows and columns named.
fn part(of: &DMatrix<f64>, columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
        of[(columns[i], columns[j])]
    })
}

pub(super) fn reference(
    found: &Result<Vec<RailReference>, ReferenceError>,
    scene: &RailScene,
) -> serde_json::Result<Solution> {
    let all = match found {
        Ok(all) => all,
        Err(error) => {
            return Ok(Solution::without_result(Status::Refused, error.to_string()));
        }
    };
    let profilers = &scene.campaign.profilers;
    let pairs = || all.iter().zip(profilers);
    let details = RailReferenceDetails {
        steps: pairs().map(|(r, p)| steps(r, &p.name)).collect(),
    };
    let named = |(r, p): (&RailReference, &Profiler)| {
        let mut six = mounted(&r.mounting, p, None).parameters(&format!("{} ", p.name));
        six[4] = not_sought(&six[4]);
        six
    };
    Ok(Solution {
        usable: true,
        parameters: pairs().flat_map(named).collect(),
        mountings: pairs()
            .map(|(r, p)| mounted(&r.mounting, p, None).result())
            .collect(),
        details: serde_json::to_value(details)?,
        ..Solution::without_result(Status::Converged, String::new())
    })
}

/// The lever arm along the rail, which the patent's path leaves as it was.
fn not_sought(parameter: &Parameter) -> Parameter {
    Parameter {
        value: None,
        correction: None,
        determined: false,
        note: "not estimated by this path".to_owned(),
        ..parameter.clone()
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

pub(super) fn joint(
    found: &Result<RailJoint, adjust::AdjustError>,
    outcome: &RailOutcome,
) -> serde_json::Result<Solution> {
    let refusal = outcome.refusal.as_ref().map(RailRefusal::to_string);
    let (refused, message) = (refusal.is_some(), refusal.unwrap_or_default());
    let Ok(found) = found else {
        return Ok(Solution::without_result(Status::Refused, message));
    };
    let solution = Solution {
        convergence: convergence(found),
        ..Solution::without_result(status(&found.solution.status, refused), message)
    };
    if refused {
        return Ok(solution);
    }
    let scene = &outcome.scene;
    let profilers = &scene.campaign.profilers;
    let of_one = |p: usize| part(&found.solution.cofactor, &columns(p, profilers.len()));
    let own: Vec<DMatrix<f64>> = (0..profilers.len()).map(of_one).collect();
    let all: Vec<Mounted> = (found.mountings.iter().zip(profilers).zip(&own))
        .map(|((m, p), covariance)| mounted(m, p, Some(covariance)))
        .collect();
    let sought: Vec<usize> = (0..profilers.len())
        .flat_map(|p| columns(p, profilers.len()))
        .collect();
    let (covariance, correlation) = matrices(&part(&found.solution.cofactor, &sought));
    let nuisance = nuisance(found, sought.len());
    Ok(Solution {
        usable: true,
        parameters: all
            .iter()
            .flat_map(|m| m.parameters(&format!("{} ", m.name)))
            .collect(),
        mountings: all.iter().map(Mounted::result).collect(),
        covariance,
        correlation,
        quality: judged(found, scene),
        details: serde_json::to_value(RailJointDetails { nuisance })?,
        ..solution
    })
}

fn convergence(found: &RailJoint) -> Vec<Iteration> {
    let rounds = found.rounds.iter().enumerate();
    rounds
        .flat_map(|(k, round)| {
            iterations(k, round.changed as u64, round.iterations.iter().copied())
        })
        .collect()
}

/// What was estimated along: the change from its prior, since rotations have no single value.
/// The first `sought` columns are parameters already.
fn nuisance(found: &RailJoint, sought: usize) -> Vec<Parameter> {
    let x = &found.solution.estimate.parameters;
    let (mut all, mut column) = (vec![], 0);
    for block in x.blocks() {
        let size = block.components.len();
        if let Some(prior) = block.prior.as_ref().filter(|_| column >= sought) {
            let change = block.chart.difference(&block.value, &prior.value);
            for (i, component) in block.components.iter().enumerate() {
                let sigma = found.solution.cofactor[(column + i, column + i)].sqrt();
                all.push(Parameter {
                    note: "change from what was known before".to_owned(),
                    ..parameter(&component.name, component.unit, change[i], Some(sigma))
                });
            }
        }
        column += size;
    }
    all
}
