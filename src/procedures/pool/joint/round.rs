//! One round of the joint path: association under the current estimate, the adjustment's problem, and the judgement at the end.

use nalgebra::Matrix6;

use super::super::conditions::{ReturnConditions, SoundingConditions, TrajectoryErrors};
use super::super::config::{Drift, JointConfig, Planes};
use super::super::coverage::Coverage;
use super::super::doubts::Passes;
use super::super::judge::Cells;
use super::super::scene::Scene;
use super::super::ties::{
    Among, Association, Corrected, PlacedBy, Reason, TieSet, TrajectoryVariance, tie_returns,
    tie_soundings,
};
use super::{
    Blocks, Components, Epochs, JointOutcome, JointStart, Judgement, Path, RETURNS, Round,
    SOUNDINGS, Surfaces,
};
use crate::adjust::{
    AdjustError, Bits, Estimate, Kernel, Options, ParameterSet, Problem, Solution, Source,
    variance_components,
};
use crate::calibrate::driver::{Model, Solved};
use crate::calibrate::verdict::Doubted;
use crate::matching::Patches;
use crate::observe::Mounting;
use crate::watch::Workers;

/// The first round only brings the estimate near: of more ties than this it takes evenly chosen ones.
const FIRST_ROUND_TIES: usize = 8_000;
/// The last adjustment has converged when nothing moves by more than this in its own sigma.
const LAST_STEP_SIGMAS: f64 = 0.01;

/// Rounds of variance components at the most.
const MOST_COMPONENT_ROUNDS: usize = 20;

/// What stays the same over the rounds of one joint path.
pub(super) struct Frame<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) start: &'a JointStart<'a>,
    pub(super) config: &'a JointConfig,
    pub(super) epochs: &'a Epochs,
    pub(super) blocks: &'a Blocks,
    /// Other processes that work on the blocks of the trajectory, where there are any.
    pub(super) workers: Option<&'a dyn Workers>,
}

impl Frame<'_> {
    pub(super) fn outcome(
        &self,
        solution: Solution,
        ties: Ties,
        rounds: Vec<Round>,
        stable: bool,
        judgement: Option<Judgement>,
    ) -> JointOutcome {
        JointOutcome {
            extras: self.blocks.own(&solution.estimate.parameters),
            mounting: self.blocks.mounting.at(&solution.estimate.parameters),
            covariance: six_covariance(&solution, self.blocks),
            solution,
            chain: self.epochs.chain.clone().filter(|_| self.has_states()),
            blocks: self.blocks.clone(),
            soundings: ties.soundings,
            returns: ties.returns,
            rounds,
            stable,
            doubted: Doubted::default(),
            judgement,
        }
    }

    /// Largest step of the mounting that an adjustment made, in the sigma of each parameter.
    pub(super) fn step_in_sigmas(&self, solution: &Solution, before: &ParameterSet) -> f64 {
        let mounting = &self.blocks.mounting;
        let covariance = six_covariance(solution, self.blocks);
        let now = mounting.at(&solution.estimate.parameters);
        step_in_sigmas(&now, &mounting.at(before), &covariance)
    }

    /// Whether the trajectory's errors are states of a chain.
    fn has_states(&self) -> bool {
        self.config.drift == Drift::On && self.epochs.chain.is_some()
    }

    fn trajectory_errors(&self) -> TrajectoryErrors<'_> {
        if self.has_states() {
            return TrajectoryErrors::States(&self.epochs.of_record);
        }
        let noise = &self.scene.campaign.trajectory.noise;
        TrajectoryErrors::Variance(TrajectoryVariance::new(noise, false))
    }

    /// The conditions of these ties, linearised from these parameters.
    pub(super) fn conditions<'a>(
        &'a self,
        ties: &'a Ties,
        parameters: &ParameterSet,
        passes: &'a Passes,
    ) -> (SoundingConditions<'a>, ReturnConditions<'a>) {
        let cells = Cells {
            passes: passes.count(),
            faces: self.scene.target.faces.len(),
        };
        let (cells, blocks) = (Some((cells, passes)), self.blocks);
        let latency_s = blocks.latency.map_or(0.0, |id| parameters.euclidean(id)[0]);
        let soundings = SoundingConditions {
            cells,
            scene: self.scene,
            ties: &ties.soundings,
            planes: &blocks.faces,
            mounting: blocks.mounting,
            latency: blocks.latency,
            range_scale: blocks.range_scale,
            extras: &blocks.extras,
            latency_at_start_s: latency_s,
            trajectory: self.trajectory_errors(),
            group: SOUNDINGS,
        };
        let returns = ReturnConditions {
            cells,
            scene: self.scene,
            ties: &ties.returns,
            planes: &blocks.faces,
            scanner: blocks.scanner,
            trajectory: self.trajectory_errors(),
            group: RETURNS,
        };
        (soundings, returns)
    }

    /// Their problem, worked on by this process.
    pub(super) fn problem<'p>(
        &'p self,
        (soundings, returns): &'p (SoundingConditions<'p>, ReturnConditions<'p>),
    ) -> Problem<'p> {
        let mut sources = vec![Source::new(soundings)];
        if self.config.planes == Planes::Adjusted {
            sources.push(Source::new(returns));
        }
        let mut problem = match &self.epochs.chain {
            Some(chain) if self.has_states() => Problem::with_chain(sources, chain),
            _ => Problem::dense(sources),
        };
        problem.large = self.config.large.clone();
        problem
    }
}

impl Frame<'_> {
    /// The ties before the first adjustment: the gate allowed for all of the trajectory's errors.
    pub(super) fn first_ties(&self) -> Ties {
        Ties {
            soundings: self.known(self.start.soundings.clone()),
            returns: self.known(self.start.returns.clone()),
        }
    }

    /// Ties both sensors under an adjusted estimate: poses are corrected by the estimated errors and the gate is as narrow as the
    /// instruments' own noise.
    pub(super) fn associate(&self, surfaces: &Surfaces, estimate: &Estimate) -> Ties {
        let corrected = estimate.chain.as_ref().map(|chain| Corrected {
            epochs: &self.epochs.of_record,
            chain,
        });
        let association = Association {
            gate_sigmas: self.config.gate_sigma,
            corrected,
        };
        let soundings = self.associate_soundings(&surfaces.sonar, estimate, &association);
        let returns = match corrected {
            Some(_)
                if self.config.planes == Planes::Adjusted && self.scene.laser_uses_trajectory() =>
            {
                tie_returns(
                    self.scene,
                    &surfaces.laser,
                    Among::Tied(self.start.returns),
                    &association,
                )
            }
            _ => self.start.returns.clone(),
        };
        Ties {
            soundings,
            returns: self.known(returns),
        }
    }

    pub(super) fn associate_soundings(
        &self,
        patches: &Patches,
        estimate: &Estimate,
        association: &Association,
    ) -> TieSet {
        let x = &estimate.parameters;
        let model = PlacedBy {
            sensor: self.blocks.sensor(x),
            extras: &self.blocks.own(x),
        };
        let candidates = self.start.candidates;
        self.known(tie_soundings(
            self.scene,
            patches,
            candidates,
            &model,
            association,
        ))
    }

    /// Only ties on faces whose plane the scanner saw.
    pub(super) fn known(&self, mut set: TieSet) -> TieSet {
        set.retain(Reason::Unseen, |t| {
            self.blocks.faces[t.face as usize].is_some()
        });
        set
    }
}

impl Path<'_> {
    /// The driver's end in the words of the pool: observations that data snooping switched off are taken out.
    pub(super) fn ended(self, solved: Solved<Ties>) -> Result<JointOutcome, AdjustError> {
        let Solved {
            solution,
            mut ties,
            stable,
            judged,
        } = solved;
        let Some(judged) = judged else {
            return Ok(self.frame.outcome(solution, ties, self.rounds, false, None));
        };
        let row = |set: usize, k: usize| {
            let (group, ties) = match set {
                0 => (SOUNDINGS, &ties.soundings),
                _ => (RETURNS, &ties.returns),
            };
            (group, ties.get(k).map_or(0, |tie| tie.row))
        };
        let worst = judged.quality.worst.iter();
        let mounting = self.frame.blocks.mounting.at(&solution.estimate.parameters);
        let mut judgement = Judgement {
            components: None,
            worst_rows: worst.map(|w| row(w.set, w.condition)).collect(),
            observability: judged.observability,
            snooped: judged.removed,
            coverage: Coverage::of(self.frame.scene, &ties.soundings, &mounting),
            quality: judged.quality,
        };
        drop_snooped(&mut ties.soundings, judged.ignored.first());
        drop_snooped(&mut ties.returns, judged.ignored.get(1));
        judgement.components = self.components(&ties, &solution.estimate)?;
        let outcome = self
            .frame
            .outcome(solution, ties, self.rounds, stable, Some(judgement));
        Ok(JointOutcome {
            doubted: judged.doubted,
            ..outcome
        })
    }

    /// Iterated variance components of the ties that data snooping left, by plain least squares: a kernel shortens the tails and
    /// with them the components.
    fn components(
        &self,
        ties: &Ties,
        estimate: &Estimate,
    ) -> Result<Option<Components>, AdjustError> {
        if !self.frame.config.variance_components {
            return Ok(None);
        }
        let plain = Options {
            kernel: Kernel::LeastSquares,
            ..passing(self.frame.config)
        };
        let found = self.with_problem(ties, &estimate.parameters, |problem| {
            variance_components(problem, estimate.clone(), &plain, MOST_COMPONENT_ROUNDS)
        })?;
        Ok(Some(Components {
            groups: found.components,
            converged: found.converged,
        }))
    }
}

/// Options of the adjustments before the last: their cofactors only measure steps.
pub(super) fn passing(config: &JointConfig) -> Options {
    Options {
        step_tolerance_sigmas: 0.05,
        robust_covariance: false,
        ..options(config)
    }
}

/// The engine's options for a configuration.
pub(crate) fn options(config: &JointConfig) -> Options {
    Options {
        kernel: config.kernel.kernel(config.kernel_width_sigma),
        step_tolerance_sigmas: LAST_STEP_SIGMAS,
        ..Options::default()
    }
}

/// Ties of both sensors.
#[derive(Clone, Debug)]
pub(super) struct Ties {
    pub(super) soundings: TieSet,
    pub(super) returns: TieSet,
}

impl Ties {
    pub(super) fn are_many(&self) -> bool {
        self.soundings.len().max(self.returns.len()) > FIRST_ROUND_TIES
    }

    /// Evenly chosen ties of both sensors.
    pub(super) fn thinned(&self) -> Self {
        Self {
            soundings: self.soundings.thinned(FIRST_ROUND_TIES),
            returns: self.returns.thinned(FIRST_ROUND_TIES),
        }
    }
}

/// Removes ties that data snooping switched off.
fn drop_snooped(set: &mut TieSet, ignored: Option<&Bits>) {
    let Some(ignored) = ignored else { return };
    let mut keep = ignored.iter().map(|off| !off);
    set.retain(Reason::GrossError, |_| keep.next().unwrap_or(true));
}

/// Covariance of the six parameters; zero rows for those held.
pub(super) fn six_covariance(solution: &Solution, blocks: &Blocks) -> Matrix6<f64> {
    let x = &solution.estimate.parameters;
    let column = |i: usize| {
        if i < 3 {
            x.offset(blocks.mounting.rotation) + i
        } else {
            x.offset(blocks.mounting.lever_arm) + i - 3
        }
    };
    Matrix6::from_fn(|i, j| solution.cofactor[(column(i), column(j))])
}

/// Largest difference of two mountings in the sigma of each parameter.
fn step_in_sigmas(now: &Mounting, before: &Mounting, covariance: &Matrix6<f64>) -> f64 {
    let turn = now.correction_from(before);
    let arm = now.lever_arm_m - before.lever_arm_m;
    (0..6)
        .map(|i| {
            (if i < 3 { turn[i] } else { arm[i - 3] }).abs() / covariance[(i, i)].sqrt().max(1e-12)
        })
        .fold(0.0, f64::max)
}
