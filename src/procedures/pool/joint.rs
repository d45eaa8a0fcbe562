//! The joint path: angles, lever arm, planes and trajectory errors in one Gauss-Helmert adjustment (`docs/joint-path.md`).

mod epochs;
mod outside;
mod predict;
mod round;
mod unknowns;

pub use epochs::Epochs;
pub use outside::{BlockWorker, OutsideError};
pub use predict::{Information, information, predict};
pub(crate) use round::options;

use nalgebra::Matrix6;

use super::conditions::{FacePlane, MountingBlocks};
use super::config::{JointConfig, Planes};
use super::coverage::Coverage;
use super::doubts::Passes;
use super::judge::Case;
use super::planes::{self, GroupPlanes};
use super::rows::Rows;
use super::scene::Scene;
use super::ties::TieSet;
use crate::adjust::{
    AdjustError, BlockId, ChainModel, Elsewhere, Estimate, Limits, Observability, ParameterSet,
    Problem, Quality, QualityOptions, Snooped, Solution, Status, VarianceComponent, shares,
};
use crate::calibrate::cloud::SensorModel;
use crate::calibrate::driver::{self, Model, Next, Pass, Schedule};
use crate::calibrate::verdict::Doubted;
use crate::geometry::plane::Plane;
use crate::matching::Patches;
use crate::observe::Mounting;
use crate::watch::Watch;
use outside::HandedOut;
use round::{Frame, Ties};
use unknowns::parameters;

/// Names of the six parameters in the order of every covariance.
pub const SIX: [&str; 6] = ["pitch", "roll", "yaw", "lx", "ly", "lz"];
/// Observation groups.
pub const SOUNDINGS: u16 = 0;
/// Observation group of the laser returns.
pub const RETURNS: u16 = 1;
/// Outer iterations (association, then adjustment) at the most.
const MOST_ROUNDS: usize = 12;
/// The assignment is stable when no parameter moves by more than this in its own sigma between two rounds.
const STABLE_SIGMAS: f64 = 0.01;
/// Or when fewer than one tie in this many changed: the last adjustment runs with the changed ones.
const STABLE_SHARE: usize = 500;
/// Rounds of data snooping at the most.
const MOST_SNOOPS: usize = 1;
/// Conditions with the largest normalised residuals that are listed.
const WORST: usize = 1000;

/// One outer iteration, for the report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Iterations of the adjustment.
    pub inner: usize,
    /// Cost at its end.
    pub cost: f64,
    /// Largest change of one of the six parameters since the round before, in its own sigma.
    pub largest_step_in_sigma: f64,
    /// Soundings whose tie changed.
    pub reassigned: usize,
}

/// Handles of the blocks.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// The mounting sought.
    pub mounting: MountingBlocks,
    /// The scanner's mounting, where it has a prior.
    pub scanner: Option<MountingBlocks>,
    /// Latency, seconds.
    pub latency: Option<BlockId>,
    /// Range scale.
    pub range_scale: Option<BlockId>,
    /// Unknowns of the caller's own, in the order of the scene's.
    pub extras: Vec<BlockId>,
    /// Plane of every face, where its group was seen by the scanner.
    pub faces: Vec<Option<FacePlane>>,
}

impl Blocks {
    /// Mounting, latency and range scale at these parameters.
    #[must_use]
    pub fn sensor(&self, x: &ParameterSet) -> SensorModel {
        let value = |id: Option<BlockId>| id.map_or(0.0, |id| x.euclidean(id)[0]);
        SensorModel {
            mounting: self.mounting.at(x),
            latency_s: value(self.latency),
            range_scale: value(self.range_scale),
        }
    }

    /// Values of the caller's own unknowns at these parameters.
    #[must_use]
    pub fn own(&self, x: &ParameterSet) -> Vec<f64> {
        self.extras.iter().map(|id| x.euclidean(*id)[0]).collect()
    }
}

/// What the joint path ended with.
#[derive(Debug)]
pub struct JointOutcome {
    /// The adjusted mounting.
    pub mounting: Mounting,
    /// Covariance of pitch, roll, yaw (rad), lx, ly, lz (m).
    pub covariance: Matrix6<f64>,
    /// The last adjustment.
    pub solution: Solution,
    /// The processes whose states are the trajectory's errors, with their epochs; `None` where these are not estimated.
    pub chain: Option<ChainModel>,
    /// Handles into its parameters.
    pub blocks: Blocks,
    /// Values of the caller's own unknowns, in the order of the scene's.
    pub extras: Vec<f64>,
    /// Soundings used.
    pub soundings: TieSet,
    /// Returns used.
    pub returns: TieSet,
    /// Every outer iteration.
    pub rounds: Vec<Round>,
    /// Whether the assignment became stable.
    pub stable: bool,
    /// What speaks against the solution, and the bounds of what it could not say.
    pub doubted: Doubted,
    /// Quality and observability; `None` when the solve did not end with an estimate.
    pub judgement: Option<Judgement>,
}

impl JointOutcome {
    /// Columns of the parameters sought: the mounting's six, latency and range scale where they are unknowns, and the caller's own.
    #[must_use]
    pub fn columns(&self) -> Vec<usize> {
        let x = &self.solution.estimate.parameters;
        let mounting = &self.blocks.mounting;
        let (turn, arm) = (x.offset(mounting.rotation), x.offset(mounting.lever_arm));
        let extra = [self.blocks.latency, self.blocks.range_scale];
        let extra = extra.into_iter().flatten();
        let extra = extra.chain(self.blocks.extras.iter().copied());
        let extra = extra.map(|id| x.offset(id));
        (turn..turn + 3).chain(arm..arm + 3).chain(extra).collect()
    }
}

/// What the engine says of the last adjustment.
#[derive(Debug)]
pub struct Judgement {
    /// Global test, groups, worst conditions.
    pub quality: Quality,
    /// What the data determine.
    pub observability: Observability,
    /// Soundings and returns removed by data snooping.
    pub snooped: usize,
    /// What the faces' directions determine, the boat's motion aside.
    pub coverage: Coverage,
    /// Iterated variance components, where they were asked for.
    pub components: Option<Components>,
    /// Raw rows of the worst conditions, in the order of [`Quality::worst`]: group and row.
    pub worst_rows: Vec<(u16, u32)>,
}

/// Iterated variance components by observation group (Förstner 1979).
#[derive(Clone, Debug)]
pub struct Components {
    /// One per group, in order.
    pub groups: Vec<VarianceComponent>,
    /// Whether they stood still within 1 %.
    pub converged: bool,
}

impl JointOutcome {
    /// Weighted sum of squares by redundancy; `None` when nothing was judged.
    #[must_use]
    pub fn variance_factor(&self) -> Option<f64> {
        self.judgement
            .as_ref()
            .map(|j| j.quality.global.variance_factor)
    }

    /// The directions that the data leave undetermined, in words.
    #[must_use]
    pub fn undetermined_directions(&self) -> Vec<String> {
        let Status::RankDeficient { directions } = &self.solution.status else {
            return vec![];
        };
        let x = &self.solution.estimate.parameters;
        let names: Vec<&str> = x.components().map(|c| c.name.as_str()).collect();
        directions.iter().map(|d| combination(d, &names)).collect()
    }
}

/// The parameters that make up a direction, largest first: "0.9 yaw - 0.4 ly".
fn combination(direction: &[f64], names: &[&str]) -> String {
    let mut parts: Vec<(f64, &str)> = direction
        .iter()
        .copied()
        .zip(names.iter().copied())
        .filter(|(v, _)| v.abs() > 0.2)
        .collect();
    parts.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    parts
        .iter()
        .map(|(v, name)| format!("{v:+.2} {name}"))
        .collect::<Vec<_>>()
        .join(" ")
}

/// What the joint path starts from.
#[derive(Clone, Copy, Debug)]
pub struct JointStart<'a> {
    /// Rough mounting.
    pub mounting: Mounting,
    /// The scanner's planes.
    pub planes: &'a GroupPlanes,
    /// Ties of the laser returns.
    pub returns: &'a TieSet,
    /// Soundings that may lie on the target.
    pub candidates: &'a Rows,
    /// Ties of the soundings under the rough mounting, before anything is known of the trajectory's errors.
    pub soundings: &'a TieSet,
}

/// How far a latency may move an observation along the trajectory, seconds.
fn reach_s(config: &JointConfig) -> f64 {
    if config.latency { 0.5 } else { 0.0 }
}

/// Runs the joint path: associate, adjust, until the assignment is stable; then data snooping.
///
/// # Errors
/// [`AdjustError`] from the engine; how the solve ended is in the outcome.
pub fn run(
    scene: &Scene,
    start: &JointStart,
    surfaces: &mut Surfaces,
    config: &JointConfig,
    progress: &dyn Watch,
) -> Result<JointOutcome, AdjustError> {
    let candidates = start.candidates.iter();
    let epochs = Epochs::number(scene, start.returns, candidates, reach_s(config))?;
    let (parameters, blocks) = parameters(scene, start, config)?;
    let frame = Frame {
        scene,
        start,
        config,
        epochs: &epochs,
        blocks: &blocks,
        workers: progress.workers(),
    };
    let mut path = Path {
        frame,
        surfaces,
        start: parameters,
        rounds: vec![],
        progress,
    };
    let solved = driver::run(&mut path, progress)?;
    path.ended(solved)
}

/// The joint path as the driver runs it.
struct Path<'a> {
    frame: Frame<'a>,
    surfaces: &'a mut Surfaces,
    start: ParameterSet,
    rounds: Vec<Round>,
    progress: &'a dyn Watch,
}

impl Path<'_> {
    fn tell(&self, ties: &Ties) {
        self.progress.step(&format!(
            "joint path: round {}, {} soundings tied",
            self.rounds.len() + 1,
            ties.soundings.len()
        ));
    }
}

impl Model for Path<'_> {
    type Ties = Ties;

    fn begin(&mut self) -> Result<(Estimate, Ties), AdjustError> {
        let ties = self.frame.first_ties();
        self.tell(&ties);
        Ok((Estimate::new(self.start.clone()), ties))
    }

    fn schedule(&self) -> Schedule {
        Schedule {
            passing: round::passing(self.frame.config),
            last: options(self.frame.config),
            quality: QualityOptions {
                worst: WORST,
                ..QualityOptions::default()
            },
            most_snoops: MOST_SNOOPS,
            limits: Limits::default(),
        }
    }

    fn with_problem<T>(
        &self,
        ties: &Ties,
        from: &ParameterSet,
        then: impl FnOnce(&Problem) -> T,
    ) -> T {
        let frame = &self.frame;
        let passes = Passes::of(frame.scene, &ties.soundings);
        let conditions = frame.conditions(ties, from, &passes);
        let here = frame.problem(&conditions);
        let outside = frame.workers.zip(here.chain).map(|(workers, _)| {
            let kept = (frame.identity(), from.values());
            HandedOut::new(workers, (ties, &passes), kept, shares(&here))
        });
        then(&Problem {
            elsewhere: outside.as_ref().map(|out| out as &dyn Elsewhere),
            ..here
        })
    }

    fn judge(
        &self,
        ties: &Ties,
        problem: &Problem,
        found: &Snooped,
    ) -> Result<Doubted, AdjustError> {
        let frame = &self.frame;
        if frame.config.planes == Planes::Fixed {
            return Ok(Doubted::default());
        }
        let passes = Passes::of(frame.scene, &ties.soundings);
        let at = &found.solution.estimate.parameters;
        let (soundings, returns) = frame.conditions(ties, at, &passes);
        let case = Case {
            scene: frame.scene,
            blocks: frame.blocks,
            solution: &found.solution,
            quality: &found.quality,
            conditions: (&soundings, &returns),
            passes: &passes,
            config: &frame.config.verdict,
        };
        case.heard(problem)
    }

    fn thinned(&self, round: usize, ties: &Ties) -> Option<Ties> {
        (round == 0 && ties.are_many()).then(|| ties.thinned())
    }

    /// The ties are at rest when few of them changed or the parameters hardly moved, and none was left out.
    fn next(&mut self, pass: &Pass<'_, Ties>) -> Next<Ties> {
        let (solution, ties) = (pass.solution, pass.ties);
        if !solution.status.was_successful() && solution.status != Status::Stalled {
            return Next::End(None);
        }
        let again = self.tie_again(&solution.estimate);
        let reassigned = again.soundings.changed_from(&ties.soundings);
        let all = reassigned + again.returns.changed_from(&ties.returns);
        let step = self.frame.step_in_sigmas(solution, pass.before);
        self.rounds.push(Round {
            inner: solution.iterations.len(),
            cost: solution.cost,
            largest_step_in_sigma: step,
            reassigned,
        });
        let few = (ties.soundings.len() + ties.returns.len()) / STABLE_SHARE;
        let settled = all <= few || (step < STABLE_SIGMAS && self.rounds.len() > 1);
        let stable = settled && !pass.thinned;
        if stable || self.rounds.len() >= MOST_ROUNDS {
            self.progress.step("joint path: data snooping and quality");
            let ties = Some(again);
            return Next::Rest { ties, stable };
        }
        self.tell(&again);
        Next::Again(again)
    }
}

impl Path<'_> {
    /// Moves the faces onto the adjusted planes and ties everything to them.
    fn tie_again(&mut self, estimate: &Estimate) -> Ties {
        let (scene, blocks) = (self.frame.scene, self.frame.blocks);
        self.surfaces.moved(scene, blocks, &estimate.parameters);
        self.frame.associate(self.surfaces, estimate)
    }
}

/// The faces as each sensor sees them, on their planes as currently known.
#[derive(Debug)]
pub struct Surfaces {
    /// Above the water.
    pub laser: Patches,
    /// Below it.
    pub sonar: Patches,
}

impl Surfaces {
    /// Moves the faces onto the adjusted planes.
    fn moved(&mut self, scene: &Scene, blocks: &Blocks, x: &ParameterSet) {
        let planes: Vec<Option<Plane>> = (0..scene.target.groups.len())
            .map(|group| {
                let face = scene.target.faces.iter().position(|f| f.group == group)?;
                let plane = blocks.faces[face].as_ref()?;
                Some(Plane {
                    normal: x.normal(plane.normal),
                    offset_m: x.euclidean(plane.distance)[0],
                })
            })
            .collect();
        planes::apply(&mut self.laser, scene, &planes);
        planes::apply(&mut self.sonar, scene, &planes);
    }
}
