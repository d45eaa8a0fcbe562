//! The joint path: one adjustment of all profilers' mountings, in rounds of association.

use nalgebra::DMatrix;

use super::conditions::{AttitudeConditions, PointConditions, Tie, recorded};
use super::config::RailJointConfig;
use super::judge::{Case, InsShares};
use super::model::{Blocks, Turned, chain, parameters};
use super::scene::RailScene;
use crate::adjust::{
    AdjustError, ChainModel, Estimate, Kernel, Limits, Observability, Options, ParameterSet,
    Problem, Quality, QualityOptions, Snooped, Solution, Source, Status,
};
use crate::calibrate::driver::{self, Model, Next, Pass, Schedule, Solved};
use crate::calibrate::verdict::Doubted;
use crate::math;
use crate::observe::Mounting;
use crate::watch::Unwatched;

/// Gates of the first rounds, metres: the start knows neither heading nor pitch.
const FIRST_GATES_M: [f64; 2] = [0.003, 0.001];
/// A round whose first step is smaller than this (sigmas) has changed nothing, whatever ties it changed.
const STILL_SIGMAS: f64 = 0.1;
/// Bend of Huber's kernel in the rounds of association: a kernel that forgets far points could hold on to a wrong start.
const PASSING_SIGMAS: f64 = 2.0;
/// Conditions with the largest normalised residuals that are listed.
const WORST: usize = 200;
/// Rounds of data snooping at the most.
const MOST_SNOOPS: usize = 1;

/// One round of association and adjustment.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// Width of the gate, metres.
    pub gate_m: f64,
    /// Ties.
    pub ties: usize,
    /// Ties that were not there before, or on another element.
    pub changed: usize,
    /// Cost and largest step (sigmas) of each iteration.
    pub iterations: Vec<(f64, f64)>,
}

/// What the joint path found.
#[derive(Debug)]
pub struct RailJoint {
    /// Mounting of each profiler.
    pub mountings: Vec<Mounting>,
    /// Covariance of pitch, roll, yaw (rad), lx, lz (m) of each profiler in turn.
    pub covariance: DMatrix<f64>,
    /// The last solution.
    pub solution: Solution,
    /// Its blocks.
    pub blocks: Blocks,
    /// Points that entered it.
    pub ties: Vec<Tie>,
    /// Share of the INS' mean attitudes that agree, of the worst-off axis.
    pub ins_share: f64,
    /// Points within the gate that data snooping took out.
    pub snooped: usize,
    /// Every round.
    pub rounds: Vec<Round>,
    /// Whether the association stood still.
    pub stable: bool,
    /// Tests of the last solution.
    pub quality: Quality,
    /// What speaks against the solution, and the bounds of what it could not say.
    pub doubted: Doubted,
    /// What the data determine.
    pub observability: Observability,
    /// Condition behind each entry of `quality.worst`: a row of the points, or an INS position.
    pub worst: Vec<Suspect>,
}

/// What a condition belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suspect {
    /// A row of the campaign's points.
    Point(u32),
    /// The INS' mean at a position.
    Attitude(u32),
}

/// The joint path as the driver runs it.
struct Path<'a> {
    scene: &'a RailScene<'a>,
    config: &'a RailJointConfig,
    blocks: Blocks,
    chain: ChainModel,
    recorded: Vec<u32>,
    start: Estimate,
    rounds: Vec<Round>,
    /// Ties of the round to come that the round before did not have.
    changed: usize,
}

/// Runs the joint path from a start for every profiler's mounting.
///
/// # Errors
/// [`AdjustError`]: nothing to adjust, or values that are not finite. A bad end is no error: see the solution's status.
pub fn joint(
    scene: &RailScene,
    config: &RailJointConfig,
    start: &[Mounting],
) -> Result<RailJoint, AdjustError> {
    let (set, blocks) = parameters(scene, start)?;
    let mut path = Path {
        chain: chain(scene)?,
        recorded: recorded(scene),
        start: Estimate::new(set),
        rounds: vec![],
        changed: 0,
        scene,
        config,
        blocks,
    };
    let solved = driver::run(&mut path, &Unwatched)?;
    path.outcome(solved)
}

/// Ties that are new or on another element.
fn changed(before: &[Tie], now: &[Tie]) -> usize {
    let key = |t: &Tie| (t.position, t.row);
    let kept = |t: &&Tie| {
        before
            .binary_search_by_key(&key(t), key)
            .is_ok_and(|k| before[k] == **t)
    };
    let kept = now.iter().filter(kept).count();
    (now.len() - kept).max(before.len() - kept)
}

impl Path<'_> {
    fn gate_m(&self, round: usize) -> f64 {
        let sigmas = self.scene.campaign.profilers.iter();
        let largest = sigmas
            .map(|p| p.lateral_sigma_m.max(p.vertical_sigma_m))
            .fold(0.0, f64::max);
        let own = self.config.gate_sigma
            * math::hypot(largest, self.scene.campaign.stand.profile_sigma_m);
        FIRST_GATES_M.get(round).map_or(own, |first| first.max(own))
    }

    /// Ties every point to the nearest element, if its foot lies within it and the distance within the gate.
    fn associate(&self, estimate: &Estimate, gate_m: f64) -> Vec<Tie> {
        let (scene, x) = (self.scene, &estimate.parameters);
        let stands: Vec<Turned> = (0..scene.positions.len())
            .map(|k| Turned::at(scene, &self.blocks, x, estimate.chain.as_ref(), k))
            .collect();
        let mountings: Vec<Mounting> = (0..scene.campaign.profilers.len())
            .map(|p| self.blocks.mounting(x, p))
            .collect();
        let offsets = self.blocks.profile.map(|id| x.euclidean(id));
        let tie = |placed: &super::scene::Placed| {
            let row = placed.row as usize;
            let mounting = &mountings[scene.campaign.points.profiler[row] as usize];
            let u = mounting.rotation * scene.campaign.points.point(row) + mounting.lever_arm_m;
            let q = stands[placed.position as usize].section(&u);
            let near = scene.rail.nearest(&q)?;
            let off = scene.rail.elements[near.element].extended(&q).distance_m;
            let off = off - offsets.map_or(0.0, |o| o[near.element]);
            (near.inside && off.abs() <= gate_m).then_some(Tie {
                row: placed.row,
                position: placed.position,
                element: near.element as u16,
            })
        };
        scene.points.iter().filter_map(tie).collect()
    }

    /// Named in the words of the rail; points that data snooping switched off are taken out.
    fn outcome(self, solved: Solved<Vec<Tie>>) -> Result<RailJoint, AdjustError> {
        let Solved {
            solution,
            mut ties,
            stable,
            judged,
        } = solved;
        let judged = judged.ok_or(AdjustError::TooFew {
            conditions: ties.len(),
            unknowns: self.blocks.sought(),
        })?;
        let suspect = |w: &crate::adjust::ConditionQuality| match w.set {
            0 => Suspect::Point(ties[w.condition].row),
            _ => Suspect::Attitude(self.recorded[w.condition / 3]),
        };
        let worst = judged.quality.worst.iter().map(suspect).collect();
        let ins_share = InsShares::of(self.recorded.len(), judged.ignored.get(1)).least();
        if let Some(mask) = judged.ignored.first() {
            let mut off = mask.iter();
            ties.retain(|_| !off.next().unwrap_or(false));
        }
        let (x, sought) = (&solution.estimate.parameters, self.blocks.sought());
        let profilers = 0..self.blocks.mountings.len();
        let covariance = solution.cofactor.view((0, 0), (sought, sought));
        Ok(RailJoint {
            mountings: profilers.map(|p| self.blocks.mounting(x, p)).collect(),
            covariance: covariance.into_owned(),
            observability: judged.observability,
            doubted: judged.doubted,
            snooped: judged.removed,
            quality: judged.quality,
            solution,
            blocks: self.blocks,
            ties,
            ins_share,
            rounds: self.rounds,
            stable,
            worst,
        })
    }
}

impl Model for Path<'_> {
    type Ties = Vec<Tie>;

    fn begin(&mut self) -> Result<(Estimate, Vec<Tie>), AdjustError> {
        let ties = self.associate(&self.start, self.gate_m(0));
        self.changed = ties.len();
        Ok((self.start.clone(), ties))
    }

    fn schedule(&self) -> Schedule {
        Schedule {
            passing: Options {
                kernel: Kernel::Huber { k: PASSING_SIGMAS },
                robust_covariance: false,
                step_tolerance_sigmas: 0.02,
                ..self.config.options()
            },
            last: self.config.options(),
            quality: QualityOptions {
                worst: WORST,
                ..QualityOptions::default()
            },
            most_snoops: MOST_SNOOPS,
            limits: Limits {
                radian: self.config.max_sigma_deg.to_radians(),
                metre: self.config.max_sigma_m,
                ..Limits::default()
            },
        }
    }

    fn with_problem<T>(
        &self,
        ties: &Vec<Tie>,
        _: &ParameterSet,
        then: impl FnOnce(&Problem) -> T,
    ) -> T {
        let (scene, blocks) = (self.scene, &self.blocks);
        let points = PointConditions {
            scene,
            blocks,
            ties,
        };
        let attitude = AttitudeConditions {
            scene,
            blocks,
            group: scene.campaign.profilers.len() as u16,
            positions: &self.recorded,
        };
        let mut sources = vec![Source::new(&points)];
        if !self.recorded.is_empty() {
            sources.push(Source::new(&attitude));
        }
        let mut problem = Problem::with_chain(sources, &self.chain);
        problem.large = self.config.large.clone();
        then(&problem)
    }

    fn judge(
        &self,
        ties: &Vec<Tie>,
        problem: &Problem,
        found: &Snooped,
    ) -> Result<Doubted, AdjustError> {
        let case = Case {
            scene: self.scene,
            blocks: &self.blocks,
            solution: &found.solution,
            quality: &found.quality,
            ties,
            ins: InsShares::of(self.recorded.len(), found.ignored.get(1)),
            config: &self.config.verdict,
        };
        case.heard(problem)
    }

    /// The ties are at rest when none changed, or when the adjustment hardly moved whatever ties changed.
    fn next(&mut self, pass: &Pass<'_, Vec<Tie>>) -> Next<Vec<Tie>> {
        let (next, solution) = (pass.round + 1, pass.solution);
        let iterations = solution.iterations.iter();
        let iterations: Vec<_> = iterations.map(|r| (r.cost, r.step_sigmas)).collect();
        let narrow = |round: usize| round >= FIRST_GATES_M.len();
        let first_step = iterations.first().map(|i| i.1);
        let stable = narrow(pass.round) && first_step.is_some_and(|step| step < STILL_SIGMAS);
        self.rounds.push(Round {
            gate_m: self.gate_m(pass.round),
            ties: pass.ties.len(),
            changed: self.changed,
            iterations,
        });
        let singular = matches!(solution.status, Status::RankDeficient { .. });
        if stable || singular || next >= self.config.max_rounds as usize {
            return Next::Rest { ties: None, stable };
        }
        let now = self.associate(&solution.estimate, self.gate_m(next));
        if 2 * now.len() < pass.ties.len() {
            // the adjustment ran away along a direction that the data do not determine
            return Next::Rest { ties: None, stable };
        }
        self.changed = changed(pass.ties, &now);
        if narrow(next) && self.changed == 0 {
            let (ties, stable) = (Some(now), true);
            return Next::Rest { ties, stable };
        }
        Next::Again(now)
    }
}
