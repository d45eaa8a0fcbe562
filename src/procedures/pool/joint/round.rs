//! One round of the joint path: association under the current estimate, the adjustment's problem, and the judgement at the end.

use nalgebra::Matrix6;

use super::super::conditions::{ReturnConditions, SoundingConditions, TrajectoryErrors};
use super::super::config::{Drift, JointConfig, Planes};
use super::super::coverage::Coverage;
use super::super::doubts::Passes;
use super::super::judge::{Case, Cells};
use super::super::scene::Scene;
use super::super::ties::{
    Among, Association, Corrected, TieSet, TrajectoryVariance, tie_returns, tie_soundings,
};
use super::{
    Blocks, Components, Epochs, JointOutcome, JointStart, Judgement, RETURNS, Round, SOUNDINGS,
    Surfaces,
};
use crate::adjust::{
    AdjustError, BlockId, Estimate, Kernel, Limits, Options, ParameterSet, Problem, Quality,
    QualityOptions, Solution, Source, observability, snoop, variance_components,
};
use crate::calibrate::verdict::Doubted;
use crate::matching::Patches;

/// The first round only brings the estimate near: of more ties than this it takes evenly chosen ones.
const FIRST_ROUND_TIES: usize = 8_000;
/// The last adjustment has converged when nothing moves by more than this in its own sigma.
const LAST_STEP_SIGMAS: f64 = 0.01;

/// Rounds of data snooping at the most.
const MOST_SNOOPS: usize = 1;

/// Rounds of variance components at the most.
const MOST_COMPONENT_ROUNDS: usize = 20;

/// Conditions with the largest normalised residuals that are listed.
const WORST: usize = 1000;

/// What stays the same over the rounds of one joint path.
pub(super) struct Frame<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) start: &'a JointStart<'a>,
    pub(super) config: &'a JointConfig,
    pub(super) epochs: &'a Epochs,
    pub(super) blocks: &'a Blocks,
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
            mounting: self.blocks.mounting.at(&solution.estimate.parameters),
            covariance: six_covariance(&solution, self.blocks),
            solution,
            blocks: self.blocks.clone(),
            soundings: ties.soundings,
            returns: ties.returns,
            rounds,
            stable,
            doubted: Doubted::default(),
            judgement,
        }
    }

    /// Data snooping from the stable solution, then the judgement.
    pub(super) fn judged(
        &self,
        solution: Solution,
        mut ties: Ties,
        rounds: Vec<Round>,
        stable: bool,
    ) -> Result<JointOutcome, AdjustError> {
        let quality_options = QualityOptions {
            worst: WORST,
            ..QualityOptions::default()
        };
        let start = solution.estimate;
        let passes = Passes::of(self.scene, &ties.soundings.ties);
        let snooped =
            self.with_problem(&ties, &start.parameters.clone(), Some(&passes), |problem| {
                snoop(
                    problem,
                    start,
                    &options(self.config),
                    &quality_options,
                    MOST_SNOOPS,
                )
            })?;
        let row = |set: usize, k: usize| match set {
            0 => (SOUNDINGS, ties.soundings.ties[k].row),
            _ => (RETURNS, ties.returns.ties[k].row),
        };
        let mut judgement = Judgement {
            components: None,
            worst_rows: snooped
                .quality
                .worst
                .iter()
                .map(|w| row(w.set, w.condition))
                .collect(),
            observability: observability(&snooped.solution, &Limits::default()),
            snooped: snooped.removed.len(),
            coverage: Coverage::of(
                self.scene,
                &ties.soundings.ties,
                &self
                    .blocks
                    .mounting
                    .at(&snooped.solution.estimate.parameters),
            ),
            quality: snooped.quality,
        };
        drop_snooped(&mut ties.soundings, snooped.ignored.first());
        drop_snooped(&mut ties.returns, snooped.ignored.get(1));
        judgement.components = self.components(&ties, &snooped.solution.estimate)?;
        let doubted = self.doubted(&ties, &snooped.solution, &judgement.quality, &passes)?;
        let outcome = self.outcome(snooped.solution, ties, rounds, stable, Some(judgement));
        Ok(JointOutcome { doubted, ..outcome })
    }

    /// What speaks against a solution on the ties that data snooping left.
    fn doubted(
        &self,
        ties: &Ties,
        solution: &Solution,
        quality: &Quality,
        passes: &Passes,
    ) -> Result<Doubted, AdjustError> {
        if self.config.planes == Planes::Fixed || !solution.status.was_successful() {
            return Ok(Doubted::default());
        }
        let case = Case {
            scene: self.scene,
            blocks: self.blocks,
            solution,
            quality,
            ties: (&ties.soundings.ties, &ties.returns.ties),
            passes,
            config: &self.config.verdict,
        };
        let parameters = &solution.estimate.parameters;
        self.with_problem(ties, parameters, None, |problem| case.heard(problem))
    }

    /// Iterated variance components of the ties that data snooping left, by plain least squares: a kernel shortens the tails and
    /// with them the components.
    fn components(
        &self,
        ties: &Ties,
        estimate: &Estimate,
    ) -> Result<Option<Components>, AdjustError> {
        if !self.config.variance_components {
            return Ok(None);
        }
        let plain = Options {
            kernel: Kernel::LeastSquares,
            ..passing(self.config)
        };
        let found = self.with_problem(ties, &estimate.parameters, None, |problem| {
            variance_components(problem, estimate.clone(), &plain, MOST_COMPONENT_ROUNDS)
        })?;
        Ok(Some(Components {
            groups: found.components,
            converged: found.converged,
        }))
    }

    /// Builds the problem of these ties and hands it to `then`.
    pub(super) fn with_problem<T>(
        &self,
        ties: &Ties,
        parameters: &ParameterSet,
        passes: Option<&Passes>,
        then: impl FnOnce(&Problem) -> T,
    ) -> T {
        let as_states = self.config.drift == Drift::On && self.epochs.chain.is_some();
        let trajectory = if as_states {
            TrajectoryErrors::States(&self.epochs.of_record)
        } else {
            TrajectoryErrors::Variance(TrajectoryVariance::new(
                &self.scene.campaign.trajectory.noise,
                false,
            ))
        };
        let cells = passes.map(|passes| {
            let faces = self.scene.target.faces.len();
            let passes_count = passes.count();
            (
                Cells {
                    passes: passes_count,
                    faces,
                },
                passes,
            )
        });
        let soundings = SoundingConditions {
            cells,
            scene: self.scene,
            ties: &ties.soundings.ties,
            planes: &self.blocks.faces,
            mounting: self.blocks.mounting,
            latency: self.blocks.latency,
            range_scale: self.blocks.range_scale,
            latency_at_start_s: self
                .blocks
                .latency
                .map_or(0.0, |id| parameters.euclidean(id)[0]),
            trajectory,
            group: SOUNDINGS,
        };
        let returns = ReturnConditions {
            cells,
            scene: self.scene,
            ties: &ties.returns.ties,
            planes: &self.blocks.faces,
            scanner: self.blocks.scanner,
            trajectory,
            group: RETURNS,
        };
        let mut sources = vec![Source::new(&soundings)];
        if self.config.planes == Planes::Adjusted {
            sources.push(Source::new(&returns));
        }
        let problem = match &self.epochs.chain {
            Some(chain) if as_states => Problem::with_chain(sources, chain),
            _ => Problem::dense(sources),
        };
        then(&problem)
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
        let value = |id: Option<BlockId>| id.map_or(0.0, |id| x.euclidean(id)[0]);
        let mounting = self.blocks.mounting.at(x);
        let (latency_s, scale) = (value(self.blocks.latency), value(self.blocks.range_scale));
        self.known(tie_soundings(
            self.scene,
            patches,
            self.start.candidates,
            &mounting,
            latency_s,
            scale,
            association,
        ))
    }

    /// Only ties on faces whose plane the scanner saw.
    pub(super) fn known(&self, mut set: TieSet) -> TieSet {
        let before = set.ties.len();
        set.ties
            .retain(|t| self.blocks.faces[t.face as usize].is_some());
        let lost = (before - set.ties.len()) as u64;
        if lost > 0 {
            set.rejected
                .insert("on a plane that the scanner did not see", lost);
        }
        set
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
        self.soundings.ties.len().max(self.returns.ties.len()) > FIRST_ROUND_TIES
    }

    /// Evenly chosen ties of both sensors.
    pub(super) fn thinned(&self) -> Self {
        Self {
            soundings: self.soundings.thinned(FIRST_ROUND_TIES),
            returns: self.returns.thinned(FIRST_ROUND_TIES),
        }
    }
}

/// Removes ties that data snooping switched off, and counts them.
fn drop_snooped(set: &mut TieSet, ignored: Option<&Vec<bool>>) {
    let Some(ignored) = ignored else { return };
    let before = set.ties.len();
    let mut keep = ignored.iter().map(|off| !off);
    set.ties.retain(|_| keep.next().unwrap_or(true));
    let removed = (before - set.ties.len()) as u64;
    if removed > 0 {
        set.rejected.insert("gross error", removed);
    }
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
