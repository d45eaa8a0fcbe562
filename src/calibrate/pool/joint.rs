//! The joint path: angles, lever arm, planes and trajectory errors in one Gauss-Helmert adjustment (mathematics section 5).

mod predict;

pub use predict::{Information, information, predict};

use nalgebra::{DMatrix, Matrix6, Vector3};

use super::conditions::{
    FacePlane, MountingBlocks, ReturnConditions, SoundingConditions, TrajectoryErrors,
};
use super::config::{Drift, JointConfig, KernelName, Planes};
use super::coverage::Coverage;
use super::planes::{self, GroupPlanes};
use super::scene::Scene;
use super::ties::{
    Among, Association, Corrected, TieSet, TrajectoryVariance, tie_returns, tie_soundings,
};
use crate::adjust::{
    AdjustError, Block, BlockId, ChainModel, Component, Estimate, Kernel, Limits, Observability,
    Options, ParameterSet, Problem, Process, ProcessKind, Quality, QualityOptions, Solution,
    Source, Status, Unit, VarianceComponent, observability, snoop, solve, variance_components,
};
use crate::geometry::plane::Plane;
use crate::geometry::rotation;
use crate::matching::Patches;
use crate::observe::Mounting;

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
/// The first round only brings the estimate near: of more ties than this it takes evenly chosen ones.
const FIRST_ROUND_TIES: usize = 25_000;
/// The last adjustment has converged when nothing moves by more than this in its own sigma.
const LAST_STEP_SIGMAS: f64 = 0.01;
/// Rounds of data snooping at the most.
const MOST_SNOOPS: usize = 1;
/// Rounds of variance components at the most.
const MOST_COMPONENT_ROUNDS: usize = 20;
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
    /// Plane of every face, where its group was seen by the scanner.
    pub faces: Vec<Option<FacePlane>>,
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
    /// Handles into its parameters.
    pub blocks: Blocks,
    /// Soundings used.
    pub soundings: TieSet,
    /// Returns used.
    pub returns: TieSet,
    /// Every outer iteration.
    pub rounds: Vec<Round>,
    /// Whether the assignment became stable.
    pub stable: bool,
    /// Quality and observability; `None` when the solve did not end with an estimate.
    pub judgement: Option<Judgement>,
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

/// Records that observations hang on, numbered as epochs of the chain.
#[derive(Clone, Debug)]
pub struct Epochs {
    /// Epoch of each record; `u32::MAX` where no observation needs it.
    pub(super) of_record: Vec<u32>,
    pub(super) chain: Option<ChainModel>,
}

impl Epochs {
    /// Numbers the records around the tied returns and the candidate soundings; `reach_s` widens for a latency.
    ///
    /// # Errors
    /// [`AdjustError`] when the noise of the trajectory makes no chain.
    pub fn number(
        scene: &Scene,
        returns: &TieSet,
        soundings: &[u32],
        reach_s: f64,
    ) -> Result<Self, AdjustError> {
        let trajectory = &scene.trajectory;
        let mut needed = vec![false; trajectory.len()];
        let times_s = trajectory.times_s();
        let mut mark = |time_s: f64| {
            if let Ok(record) = trajectory.record_before(time_s) {
                needed[record..record + 2].fill(true);
            }
            if reach_s > 0.0 {
                let first = times_s.partition_point(|t| *t <= time_s - reach_s);
                let last = times_s.partition_point(|t| *t <= time_s + reach_s);
                let end = (last + 1).min(times_s.len());
                needed[first.saturating_sub(1)..end].fill(true);
            }
        };
        if scene.laser_uses_trajectory() {
            returns
                .ties
                .iter()
                .for_each(|t| mark(scene.campaign.laser.time_s[t.row as usize]));
        }
        soundings
            .iter()
            .for_each(|&k| mark(scene.campaign.soundings.time_s[k as usize]));
        let mut of_record = vec![u32::MAX; needed.len()];
        let mut times_s = vec![];
        for (record, _) in needed.iter().enumerate().filter(|(_, n)| **n) {
            of_record[record] = times_s.len() as u32;
            times_s.push(trajectory.times_s()[record]);
        }
        let processes = processes(scene);
        let chain = if processes.is_empty() || times_s.len() < 2 {
            None
        } else {
            Some(ChainModel::new(times_s, processes)?)
        };
        Ok(Self { of_record, chain })
    }
}

/// The stochastic processes of a trajectory's errors: white per record, and drift (mathematics section 5).
fn processes(scene: &Scene) -> Vec<Process> {
    let noise = &scene.campaign.trajectory.noise;
    let white = |component, sigma| Process {
        component,
        sigma,
        kind: ProcessKind::White,
    };
    let tau_s = noise.drift_correlation_time_s;
    let slow = |component, sigma| Process {
        component,
        sigma,
        kind: ProcessKind::GaussMarkov { tau_s },
    };
    let mut all: Vec<Process> = (0..3).map(|i| white(i, noise.position_m)).collect();
    all.extend([
        white(3, noise.roll_pitch_rad),
        white(4, noise.roll_pitch_rad),
        white(5, noise.heading_rad),
    ]);
    all.extend((0..3).map(|i| slow(i, noise.position_drift_m)));
    all.push(slow(5, noise.heading_drift_rad));
    all.retain(|p| p.sigma > 0.0);
    all
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
    pub candidates: &'a [u32],
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
    progress: &(dyn Fn(&str) + Sync),
) -> Result<JointOutcome, AdjustError> {
    let reach_s = if config.latency { 0.5 } else { 0.0 };
    let epochs = Epochs::number(scene, start.returns, start.candidates, reach_s)?;
    let (parameters, blocks) = parameters(scene, start, config)?;
    let frame = Frame {
        scene,
        start,
        config,
        epochs: &epochs,
        blocks: &blocks,
    };
    let mut estimate = Estimate::new(parameters);
    let mut ties = frame.associate(surfaces, &estimate);
    let mut rounds: Vec<Round> = vec![];
    loop {
        progress(&format!(
            "joint path: round {}, {} soundings tied",
            rounds.len() + 1,
            ties.soundings.ties.len()
        ));
        let before = blocks.mounting.at(&estimate.parameters);
        let thinned = (rounds.is_empty() && ties.are_many()).then(|| ties.thinned());
        let used = thinned.as_ref().unwrap_or(&ties);
        let solution = frame.with_problem(used, &estimate.parameters.clone(), |problem| {
            solve(problem, estimate, &passing(config))
        })?;
        if !solution.status.was_successful() && solution.status != Status::Stalled {
            return Ok(frame.outcome(solution, ties, rounds, false, None));
        }
        let covariance = six_covariance(&solution, &blocks);
        let step = step_in_sigmas(
            &blocks.mounting.at(&solution.estimate.parameters),
            &before,
            &covariance,
        );
        surfaces.moved(scene, &blocks, &solution.estimate.parameters);
        let again = frame.associate(surfaces, &solution.estimate);
        let reassigned = again.soundings.changed_from(&ties.soundings);
        let all = reassigned + again.returns.changed_from(&ties.returns);
        rounds.push(Round {
            inner: solution.iterations.len(),
            cost: solution.cost,
            largest_step_in_sigma: step,
            reassigned,
        });
        let stable = all <= (ties.soundings.ties.len() + ties.returns.ties.len()) / STABLE_SHARE
            || (step < STABLE_SIGMAS && rounds.len() > 1);
        let stable = stable && !(rounds.len() == 1 && ties.are_many());
        if stable || rounds.len() >= MOST_ROUNDS {
            progress("joint path: data snooping and quality");
            return frame.judged(solution, again, rounds, stable);
        }
        ties = again;
        estimate = solution.estimate;
    }
}

/// What stays the same over the rounds of one joint path.
struct Frame<'a> {
    scene: &'a Scene<'a>,
    start: &'a JointStart<'a>,
    config: &'a JointConfig,
    epochs: &'a Epochs,
    blocks: &'a Blocks,
}

impl Frame<'_> {
    fn outcome(
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
            judgement,
        }
    }

    /// Data snooping from the stable solution, then the judgement.
    fn judged(
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
        let snooped = self.with_problem(&ties, &start.parameters.clone(), |problem| {
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
        Ok(self.outcome(snooped.solution, ties, rounds, stable, Some(judgement)))
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
        let found = self.with_problem(ties, &estimate.parameters, |problem| {
            variance_components(problem, estimate.clone(), &plain, MOST_COMPONENT_ROUNDS)
        })?;
        Ok(Some(Components {
            groups: found.components,
            converged: found.converged,
        }))
    }

    /// Builds the problem of these ties and hands it to `then`.
    fn with_problem<T>(
        &self,
        ties: &Ties,
        parameters: &ParameterSet,
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
        let soundings = SoundingConditions {
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

/// Options of the adjustments before the last: their cofactors only measure steps.
fn passing(config: &JointConfig) -> Options {
    Options {
        step_tolerance_sigmas: 0.05,
        robust_covariance: false,
        ..options(config)
    }
}

/// The engine's options for a configuration.
pub(crate) fn options(config: &JointConfig) -> Options {
    let k = config.kernel_width_sigma;
    let kernel = match config.kernel {
        KernelName::LeastSquares => Kernel::LeastSquares,
        KernelName::Huber => Kernel::Huber { k },
        KernelName::Cauchy => Kernel::Cauchy { k },
        KernelName::Tukey => Kernel::Tukey { k },
        KernelName::GemanMcclure => Kernel::GemanMcClure { k },
    };
    Options {
        kernel,
        step_tolerance_sigmas: LAST_STEP_SIGMAS,
        ..Options::default()
    }
}

/// Every block of the adjustment, at its start.
fn parameters(
    scene: &Scene,
    start: &JointStart,
    config: &JointConfig,
) -> Result<(ParameterSet, Blocks), AdjustError> {
    let mut x = ParameterSet::new();
    let mounting = push_mounting(&mut x, scene, &start.mounting, config)?;
    let free = config.planes == Planes::Adjusted;
    let scanner = match scene.campaign.scanner_sigma {
        Some(sigma) if free && scene.laser_uses_trajectory() => {
            Some(push_scanner(&mut x, scene, &sigma)?)
        }
        _ => None,
    };
    let scalar = |x: &mut ParameterSet, name: &str, unit| {
        x.push(Block::euclidean(
            name,
            vec![Component::new(name, unit)],
            &[0.0],
        ))
    };
    let latency = config
        .latency
        .then(|| scalar(&mut x, "latency", Unit::Second))
        .transpose()?;
    let range_scale = config
        .range_scale
        .then(|| scalar(&mut x, "range_scale", Unit::One))
        .transpose()?;
    let faces = push_planes(&mut x, scene, start.planes, free)?;
    Ok((
        x,
        Blocks {
            mounting,
            scanner,
            latency,
            range_scale,
            faces,
        },
    ))
}

fn push_mounting(
    x: &mut ParameterSet,
    scene: &Scene,
    rough: &Mounting,
    config: &JointConfig,
) -> Result<MountingBlocks, AdjustError> {
    let nominal = &scene.campaign.sonar;
    let held: Vec<bool> = SIX
        .iter()
        .map(|name| config.hold.iter().any(|h| h == name))
        .collect();
    let mut delta = rough.correction_from(nominal);
    let mut arm = rough.lever_arm_m;
    for i in 0..3 {
        if held[i] {
            delta[i] = 0.0;
        }
        if held[i + 3] {
            arm[i] = nominal.lever_arm_m[i];
        }
    }
    let mut turn = Block::rotation(
        "mounting angles",
        ["pitch", "roll", "yaw"],
        &(rotation::exp(&delta) * nominal.rotation),
    );
    turn.held.copy_from_slice(&held[..3]);
    let metres = ["lx", "ly", "lz"]
        .map(|name| Component::new(name, Unit::Metre))
        .to_vec();
    let mut lever = Block::euclidean("lever arm", metres, arm.as_slice());
    lever.held.copy_from_slice(&held[3..]);
    let p = &config.prior;
    let rad = |deg: Option<f64>| deg.map(f64::to_radians);
    if let Some(covariance) = prior_covariance(
        [
            rad(p.pitch_sigma_deg),
            rad(p.roll_sigma_deg),
            rad(p.yaw_sigma_deg),
        ],
        10.0,
    ) {
        turn = turn.with_prior(nominal.rotation.as_slice().to_vec(), covariance);
    }
    if let Some(covariance) = prior_covariance([p.lx_sigma_m, p.ly_sigma_m, p.lz_sigma_m], 1e3) {
        lever = lever.with_prior(nominal.lever_arm_m.as_slice().to_vec(), covariance);
    }
    Ok(MountingBlocks {
        rotation: x.push(turn)?,
        lever_arm: x.push(lever)?,
    })
}

/// Diagonal covariance of the given sigmas, `vague` for those not given; `None` when none is.
fn prior_covariance(sigmas: [Option<f64>; 3], vague: f64) -> Option<DMatrix<f64>> {
    if sigmas.iter().all(Option::is_none) {
        return None;
    }
    let diagonal = sigmas.map(|s| s.unwrap_or(vague).powi(2));
    Some(DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(
        &diagonal,
    )))
}

fn push_scanner(
    x: &mut ParameterSet,
    scene: &Scene,
    sigma: &crate::observe::MountingSigma,
) -> Result<MountingBlocks, AdjustError> {
    let scanner = &scene.campaign.scanner;
    let square = |v: &Vector3<f64>| {
        DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(
            3,
            v.iter().map(|s| s.max(1e-9).powi(2)),
        ))
    };
    let turn = Block::rotation(
        "scanner angles",
        ["scanner pitch", "scanner roll", "scanner yaw"],
        &scanner.rotation,
    )
    .with_prior(
        scanner.rotation.as_slice().to_vec(),
        square(&sigma.rotation_rad),
    );
    let metres = ["scanner lx", "scanner ly", "scanner lz"]
        .map(|n| Component::new(n, Unit::Metre))
        .to_vec();
    let lever = Block::euclidean("scanner lever arm", metres, scanner.lever_arm_m.as_slice())
        .with_prior(
            scanner.lever_arm_m.as_slice().to_vec(),
            square(&sigma.lever_arm_m),
        );
    Ok(MountingBlocks {
        rotation: x.push(turn)?,
        lever_arm: x.push(lever)?,
    })
}

/// A unit normal and a distance per group that the scanner saw, and an observed offset per face with a tolerance.
fn push_planes(
    x: &mut ParameterSet,
    scene: &Scene,
    planes: &GroupPlanes,
    free: bool,
) -> Result<Vec<Option<FacePlane>>, AdjustError> {
    let target = scene.target;
    let mut groups: Vec<Option<(BlockId, BlockId)>> = vec![None; target.groups.len()];
    for (group, plane) in planes.iter().enumerate() {
        let Some(plane) = plane else { continue };
        let name = &target.groups[group].name;
        let mut normal = Block::unit_normal(name.clone(), &plane.fit.plane.normal);
        let metre = vec![Component::new(format!("{name} distance"), Unit::Metre)];
        let mut distance = Block::euclidean(
            format!("{name} distance"),
            metre,
            &[plane.fit.plane.offset_m],
        );
        if !free {
            (normal, distance) = (normal.held(), distance.held());
        }
        groups[group] = Some((x.push(normal)?, x.push(distance)?));
    }
    let mut offsets: Vec<Option<BlockId>> = vec![None; target.offsets.len()];
    let mut faces = vec![];
    for face in &target.faces {
        let Some((normal, distance)) = groups[face.group] else {
            faces.push(None);
            continue;
        };
        let design = &target.offsets[face.offset];
        if design.sigma_m > 0.0 && offsets[face.offset].is_none() {
            let metre = vec![Component::new(
                format!("offset of {}", design.name),
                Unit::Metre,
            )];
            let variance = DMatrix::from_element(1, 1, design.sigma_m.powi(2));
            let block = Block::euclidean(
                format!("offset of {}", design.name),
                metre,
                &[design.value_m],
            )
            .with_prior(vec![design.value_m], variance);
            offsets[face.offset] = Some(x.push(block)?);
        }
        faces.push(Some(FacePlane {
            normal,
            distance,
            offset: offsets[face.offset],
            design_m: design.value_m,
        }));
    }
    Ok(faces)
}

/// Ties of both sensors.
#[derive(Clone, Debug)]
struct Ties {
    soundings: TieSet,
    returns: TieSet,
}

impl Ties {
    fn are_many(&self) -> bool {
        self.soundings.ties.len().max(self.returns.ties.len()) > FIRST_ROUND_TIES
    }

    /// Evenly chosen ties of both sensors.
    fn thinned(&self) -> Self {
        Self {
            soundings: self.soundings.thinned(FIRST_ROUND_TIES),
            returns: self.returns.thinned(FIRST_ROUND_TIES),
        }
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

impl Frame<'_> {
    /// Ties both sensors under the current estimate. Before the first adjustment the returns keep their ties and the gate allows
    /// for the trajectory's errors; afterwards poses are corrected by the estimated errors and the gate is as narrow as the
    /// instruments' own noise.
    fn associate(&self, surfaces: &Surfaces, estimate: &Estimate) -> Ties {
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

    fn associate_soundings(
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
    fn known(&self, mut set: TieSet) -> TieSet {
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
fn six_covariance(solution: &Solution, blocks: &Blocks) -> Matrix6<f64> {
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
