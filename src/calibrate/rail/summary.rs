//! The outcome as plain data: `result.json`, and the samples for the report.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Vector2};

use super::joint::{RailJoint, Suspect};
use super::model::{SOUGHT, Turned};
use super::reference::{RailReference, SweepStep};
use super::run::{RailInput, RailOutcome};
use super::scene::RailScene;
use super::trial::{correction, corrections, names};
use super::verdict::RailRefusal;
use crate::adjust::{self, Unit};
use crate::calibrate::metric;
use crate::calibrate::pool::config::KernelName;
use crate::calibrate::quality::{Judged, block_priors, group, named_prior, quality, readable};
use crate::observe::Mounting;
use crate::results::{
    Angles, HausdorffStep, JointIteration, MountingAngles, Outline, Parameter, ParameterComparison,
    ParameterDifference, Prior, ProfileSample, ProfilerCounts, Provenance, Quality, RAIL_SCHEMA,
    RailJointSolution, RailMounting, RailReferenceSolution, RailReferenceSteps, RailResult,
    RailSamples, RailSolutions, ResidualSample, Status,
};

/// Points of a profile shown per profiler and path.
const SHOWN: usize = 1500;
/// Residuals shown.
const RESIDUALS: usize = 6000;
/// Spacing of the drawn outline, metres.
const DRAWN_M: f64 = 5e-4;
/// Points further from the standard profile than this are not counted as the rail's under a path, metres.
const NEAR_M: f64 = 0.005;

/// Everything for `result.json`.
#[must_use]
pub fn result(outcome: &RailOutcome, input: &RailInput, provenance: Provenance) -> RailResult {
    let scene = &outcome.scene;
    let (heading, pitch) = scene.turned_rad();
    RailResult {
        schema: RAIL_SCHEMA,
        procedure: "rail".to_owned(),
        provenance,
        usable: outcome.refusal.is_none(),
        reason: outcome.refusal.as_ref().map(ToString::to_string),
        rail: scene.rail.name.clone(),
        positions: scene.positions.len() as u64,
        turned_deg: [heading.to_degrees(), pitch.to_degrees()],
        counts: counts(outcome),
        solutions: RailSolutions {
            reference: outcome.reference.as_ref().map(|r| reference(r, scene)),
            joint: outcome.joint.as_ref().map(|j| joint(j, outcome, input)),
        },
        comparison: comparison(outcome),
        residual_rms_m: paths(outcome)
            .into_iter()
            .map(|(name, m)| (name.to_owned(), rms(outcome, &m)))
            .collect(),
        notes: notes(scene),
    }
}

fn notes(scene: &RailScene) -> Vec<String> {
    let mut notes = vec![
        "lever arms along the rail are seen only through the table's turns, relative to its centre of rotation: the rail is the same all along"
            .to_owned(),
        "angles and offsets are as good as the stated orientation and place of the rail and of the table's centre of rotation; between profilers they are better"
            .to_owned(),
    ];
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

fn usable_joint<'o>(outcome: &'o RailOutcome) -> Option<&'o RailJoint> {
    outcome
        .joint
        .as_ref()?
        .as_ref()
        .ok()
        .filter(|_| outcome.refusal.is_none())
}

fn usable_reference<'o>(outcome: &'o RailOutcome) -> Option<&'o Vec<RailReference>> {
    outcome.reference.as_ref()?.as_ref().ok()
}

fn counts(outcome: &RailOutcome) -> Vec<ProfilerCounts> {
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
    let one = |(p, profiler): (usize, &crate::observe::Profiler)| {
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
        ProfilerCounts {
            profiler: profiler.name.clone(),
            read: read[p],
            used: used[p],
            rejected,
        }
    };
    scene
        .campaign
        .profilers
        .iter()
        .enumerate()
        .map(one)
        .collect()
}

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

fn unit(column: usize) -> Unit {
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

fn reference(
    found: &Result<Vec<RailReference>, super::reference::ReferenceError>,
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

fn joint(
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
    let round = |(outer, round): (usize, &super::joint::Round)| {
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

fn judged(found: &RailJoint, scene: &RailScene, input: &RailInput) -> Option<Quality> {
    let profilers = &scene.campaign.profilers;
    let name = |g: &adjust::GroupQuality| match profilers.get(usize::from(g.group)) {
        Some(p) => (
            format!("points of {}", p.name),
            "for both coordinates together: they share each condition",
        ),
        None => (
            "INS attitude".to_owned(),
            "for roll, pitch and heading together",
        ),
    };
    let shown = found
        .quality
        .groups
        .iter()
        .map(|g| group(g, &name(g).0, name(g).1));
    quality(Judged {
        quality: &found.quality,
        observability: &found.observability,
        parameters: &found.solution.estimate.parameters,
        robust: input.joint.kernel != KernelName::LeastSquares,
        sought: &names(profilers),
        priors: priors(found, scene),
        groups: shown.collect(),
        observation: &|place| match found.worst[place] {
            Suspect::Point(row) => {
                let profiler =
                    &profilers[scene.campaign.points.profiler[row as usize] as usize].name;
                format!("point {row} of {profiler}")
            }
            Suspect::Attitude(position) => format!("INS at position {}", position + 1),
        },
        advice: &|_, _| "",
    })
}

fn priors(found: &RailJoint, scene: &RailScene) -> Vec<Prior> {
    let mut all = block_priors(&found.solution.estimate.parameters);
    let sigma = scene.campaign.stand.table_sigma_rad;
    all.push(named_prior(
        "table angle, per position and axis",
        sigma,
        Unit::Radian,
    ));
    all
}

/// The reference path minus the joint one.
fn comparison(outcome: &RailOutcome) -> Option<ParameterComparison> {
    let (by_reference, by_joint) = (usable_reference(outcome)?, usable_joint(outcome)?);
    let mut d = vec![];
    for (from, to) in by_joint.mountings.iter().zip(by_reference) {
        d.extend(correction(&to.mounting, from));
    }
    let (chi_square, degrees, p_value) =
        metric::chi_square(&DVector::from_vec(d.clone()), &by_joint.covariance)?;
    let all = names(&outcome.scene.campaign.profilers)
        .into_iter()
        .zip(d)
        .enumerate();
    let differences = all.map(|(k, (name, value))| {
        let (difference, unit) = readable(value, unit(k));
        let in_reference_sigmas = value / by_joint.covariance[(k, k)].sqrt();
        ParameterDifference {
            name,
            unit: unit.to_owned(),
            difference,
            in_reference_sigmas,
        }
    });
    Some(ParameterComparison {
        reference: "joint".to_owned(),
        differences: differences.collect(),
        chi_square,
        degrees_of_freedom: degrees as u32,
        p_value,
    })
}

/// Mountings of each path that has some.
fn paths(outcome: &RailOutcome) -> Vec<(&'static str, Vec<Mounting>)> {
    let nominal = outcome
        .scene
        .campaign
        .profilers
        .iter()
        .map(|p| p.nominal)
        .collect();
    let mut all = vec![("nominal", nominal)];
    if let Some(found) = usable_reference(outcome) {
        all.push(("reference", found.iter().map(|r| r.mounting).collect()));
    }
    if let Some(found) = usable_joint(outcome) {
        all.push(("joint", found.mountings.clone()));
    }
    all
}

/// The stand at a position as known before, with the INS' attitude.
fn stand(scene: &RailScene, position: usize) -> Turned {
    let s = &scene.campaign.stand;
    let [roll, pitch, heading] = s.rail_attitude_rad;
    let body = scene.attitude(position);
    Turned {
        body,
        table: body,
        seat: nalgebra::Matrix3::identity(),
        heading_axis: -nalgebra::Vector3::z(),
        pitch_axis: nalgebra::Vector3::x(),
        rail: crate::geometry::rotation::from_attitude(roll, pitch, heading),
        pivot_body_m: s.pivot_body_m,
        pivot_rail_m: s.pivot_rail_m,
    }
}

/// A point in the cross-section with its signed distance from the nearest element, metres.
fn placed(
    scene: &RailScene,
    stand: &Turned,
    mountings: &[Mounting],
    row: usize,
) -> Option<(Vector2<f64>, f64)> {
    let mounting = &mountings[scene.campaign.points.profiler[row] as usize];
    let q = stand
        .section(&(mounting.rotation * scene.campaign.points.point(row) + mounting.lever_arm_m));
    let near = scene.rail.nearest(&q)?;
    let signed = scene.rail.elements[near.element].extended(&q).distance_m;
    Some((q, near.distance_m.copysign(signed)))
}

/// RMS distance of the used points (of all points without a joint solution) under these mountings, as known before otherwise.
fn rms(outcome: &RailOutcome, mountings: &[Mounting]) -> f64 {
    let scene = &outcome.scene;
    let stands: Vec<Turned> = (0..scene.positions.len())
        .map(|k| stand(scene, k))
        .collect();
    let rows: Vec<(u32, u32)> = match usable_joint(outcome) {
        Some(found) => found.ties.iter().map(|t| (t.row, t.position)).collect(),
        None => scene.points.iter().map(|p| (p.row, p.position)).collect(),
    };
    let distance = |&(row, position): &(u32, u32)| {
        placed(scene, &stands[position as usize], mountings, row as usize)
    };
    let squares: Vec<f64> = rows
        .iter()
        .filter_map(distance)
        .map(|(_, d)| d.abs().min(NEAR_M).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Samples for the pictures; `truth` are true corrections in the parameters' order, radians and metres.
#[must_use]
pub fn samples(outcome: &RailOutcome, title: &str, truth: Option<Vec<f64>>) -> RailSamples {
    let shown = |values: Vec<f64>| {
        values
            .iter()
            .enumerate()
            .map(|(k, v)| readable(*v, unit(k)).0)
            .collect()
    };
    RailSamples {
        title: title.to_owned(),
        outline_mm: outline(&outcome.scene),
        profiles: profiles(outcome),
        residuals: residuals(outcome),
        truth: truth.map(shown),
    }
}

fn outline(scene: &RailScene) -> Vec<Outline> {
    let region = |k: usize| {
        if scene.rail.line_region.contains(&k) {
            "line"
        } else if scene.rail.arc_region.contains(&k) {
            "arc"
        } else {
            ""
        }
    };
    let all = scene.rail.elements.iter().enumerate();
    all.map(|(k, e)| Outline {
        name: scene.rail.names[k].clone(),
        region: region(k).to_owned(),
        points: e
            .samples(DRAWN_M)
            .iter()
            .map(|p| [micrometres(p.x), micrometres(p.y)])
            .collect(),
    })
    .collect()
}

/// Millimetres to the micrometre: the pictures need no more.
fn micrometres(m: f64) -> f64 {
    (m * 1e6).round() * 1e-3
}

fn profiles(outcome: &RailOutcome) -> Vec<ProfileSample> {
    let scene = &outcome.scene;
    let level = scene.level_position();
    let at = stand(scene, level);
    let rows: Vec<usize> = scene
        .points
        .iter()
        .filter(|p| p.position as usize == level)
        .map(|p| p.row as usize)
        .collect();
    let mut all = vec![];
    for (path, mountings) in paths(outcome) {
        for profiler in 0..mountings.len() as u32 {
            let own: Vec<usize> = rows
                .iter()
                .copied()
                .filter(|&r| scene.campaign.points.profiler[r] == profiler)
                .collect();
            let step = own.len().div_ceil(SHOWN).max(1);
            let place = |&row: &usize| placed(scene, &at, &mountings, row);
            let points = own
                .iter()
                .step_by(step)
                .filter_map(place)
                .map(|(q, d)| [q.x, q.y, d].map(micrometres));
            all.push(ProfileSample {
                profiler,
                path: path.to_owned(),
                points: points.collect(),
            });
        }
    }
    all
}

fn residuals(outcome: &RailOutcome) -> Vec<ResidualSample> {
    let Some(found) = usable_joint(outcome) else {
        return vec![];
    };
    let (scene, x) = (&outcome.scene, &found.solution.estimate.parameters);
    let states = found.solution.estimate.chain.as_ref();
    let step = found.ties.len().div_ceil(RESIDUALS).max(1);
    let offsets = found.blocks.profile.map(|id| x.euclidean(id));
    let one = |t: &super::conditions::Tie| {
        let at = Turned::at(scene, &found.blocks, x, states, t.position as usize);
        let profiler = scene.campaign.points.profiler[t.row as usize];
        let m = &found.mountings[profiler as usize];
        let q =
            at.section(&(m.rotation * scene.campaign.points.point(t.row as usize) + m.lever_arm_m));
        let off = scene.rail.elements[usize::from(t.element)]
            .extended(&q)
            .distance_m;
        ResidualSample {
            profiler,
            element: u32::from(t.element),
            position: t.position,
            joint_mm: micrometres(off - offsets.map_or(0.0, |o| o[usize::from(t.element)])),
        }
    };
    found.ties.iter().step_by(step).map(one).collect()
}
