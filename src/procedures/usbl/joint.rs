//! The joint path: mounting, transducer, beacons, range scale and attitude noise in one adjustment.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::conditions::{Blocks, FixConditions, PER_FIX};
use super::config::JointConfig;
use super::judge::Case;
use super::observed::{ControlPoint, Role};
use super::scene::Scene;
use super::start;
use crate::adjust::{
    AdjustError, Block, BlockId, ChainModel, Component, Estimate, Kernel, Limits, Observability,
    Options, ParameterSet, Problem, Process, ProcessKind, Quality, QualityOptions, Snooped,
    Solution, Source, Status, Unit,
};
use crate::calibrate::driver::{self, Model, Next, Pass, Schedule, Solved};
use crate::calibrate::verdict::Doubted;
use crate::watch::Unwatched;

/// Names of the mounting's parameters, first in every covariance.
pub const MOUNTING: [&str; 3] = ["pitch", "roll", "yaw"];
/// Names of the transducer's position, next.
pub const TRANSDUCER: [&str; 3] = ["transducer east", "transducer north", "transducer up"];
/// Name of the range scale, last of the parameters sought.
pub const SCALE: &str = "range scale";
/// Rounds of data snooping at the most.
const MOST_SNOOPS: usize = 5;
/// Conditions with the largest normalised residuals that are listed, and removed at most in one round.
const WORST: usize = 200;

/// What the joint path ended with.
#[derive(Debug)]
pub struct JointOutcome {
    /// Adjusted `R_u^b`.
    pub rotation: Matrix3<f64>,
    /// Adjusted centre of the transducer in the level frame, metres.
    pub transducer_m: Vector3<f64>,
    /// Adjusted range scale.
    pub scale: f64,
    /// Covariance of pitch, roll, yaw (rad), transducer east, north, up (m), range scale.
    pub covariance: DMatrix<f64>,
    /// The last adjustment.
    pub solution: Solution,
    /// Handles into its parameters.
    pub blocks: Blocks,
    /// Fixes used, whole or in part, rows ascending.
    pub used: Vec<u32>,
    /// Common fixes rejected as gross errors before the last adjustment, rows ascending.
    pub gross: Vec<u32>,
    /// Single conditions that data snooping removed.
    pub snooped: usize,
    /// What speaks against the solution, and the bounds of what it could not say.
    pub doubted: Doubted,
    /// Tests, groups, worst conditions; `None` when the solve did not end with an estimate.
    pub judgement: Option<Judgement>,
}

/// What the engine says of the last adjustment.
#[derive(Debug)]
pub struct Judgement {
    /// Global test, groups, worst conditions.
    pub quality: Quality,
    /// What the data determine, priors included.
    pub observability: Observability,
    /// Standard deviations of the parameters sought without the surveyed position of the transducer; infinite where the fixes alone
    /// do not determine them.
    pub without_survey: Vec<f64>,
}

/// Number of parameters sought: mounting, transducer, scale.
pub const SOUGHT: usize = 7;

/// Names and units of the parameters sought.
#[must_use]
pub fn sought() -> [(&'static str, Unit); SOUGHT] {
    [
        (MOUNTING[0], Unit::Radian),
        (MOUNTING[1], Unit::Radian),
        (MOUNTING[2], Unit::Radian),
        (TRANSDUCER[0], Unit::Metre),
        (TRANSDUCER[1], Unit::Metre),
        (TRANSDUCER[2], Unit::Metre),
        (SCALE, Unit::One),
    ]
}

/// Runs the joint path; `None` when there is no fix of a common beacon to start from.
///
/// # Errors
/// [`AdjustError`] from the engine; how the solve ended is in the outcome.
pub fn run(scene: &Scene, config: &JointConfig) -> Result<Option<JointOutcome>, AdjustError> {
    let Some(rotation) = start::rotation(scene) else {
        return Ok(None);
    };
    let (start, blocks) = parameters(scene, config, &rotation)?;
    let mut path = Path {
        epochs: Epochs::number(scene, config)?,
        scene,
        config,
        blocks,
        start,
    };
    let solved = driver::run(&mut path, &Unwatched)?;
    Ok(Some(path.outcome(solved)))
}

/// The joint path as the driver runs it.
struct Path<'a> {
    scene: &'a Scene<'a>,
    config: &'a JointConfig,
    blocks: Blocks,
    epochs: Epochs,
    start: ParameterSet,
}

/// Common fixes by what the first adjustment says of them, rows ascending.
struct Sorted {
    used: Vec<u32>,
    gross: Vec<u32>,
}

impl Model for Path<'_> {
    type Ties = Sorted;

    fn begin(&mut self) -> Result<(Estimate, Sorted), AdjustError> {
        let used = self.scene.common.clone();
        let gross = vec![];
        Ok((Estimate::new(self.start.clone()), Sorted { used, gross }))
    }

    fn schedule(&self) -> Schedule {
        Schedule {
            passing: robust(),
            last: self.config.options(),
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
        fixes: &Sorted,
        _: &ParameterSet,
        then: impl FnOnce(&Problem) -> T,
    ) -> T {
        let conditions = FixConditions {
            scene: self.scene,
            blocks: &self.blocks,
            fixes: &fixes.used,
            epochs: self.epochs.of_record(),
        };
        let sources = vec![Source::new(&conditions)];
        match &self.epochs.chain {
            Some(chain) => then(&Problem::with_chain(sources, chain)),
            None => then(&Problem::dense(sources)),
        }
    }

    /// One adjustment under a forgiving kernel tells gross errors from the others; a fix names its beacon, so nothing is tied again.
    fn next(&mut self, pass: &Pass<'_, Sorted>) -> Next<Sorted> {
        let solution = pass.solution;
        if !matches!(solution.status, Status::Converged | Status::Stalled) {
            return Next::End(None);
        }
        let (gross, used) = split(
            self.scene,
            &self.blocks,
            solution,
            &self.epochs,
            self.config,
        );
        let sorted = Some(Sorted { used, gross });
        if sorted.as_ref().is_some_and(|s| s.used.is_empty()) {
            return Next::End(sorted);
        }
        Next::Rest {
            ties: sorted,
            stable: true,
        }
    }

    /// Attitude noise starts from nothing again: the forgiving kernel has spread it by gross errors.
    fn last_start(&self, solution: &Solution) -> Estimate {
        Estimate::new(solution.estimate.parameters.clone())
    }

    fn judge(
        &self,
        fixes: &Sorted,
        problem: &Problem,
        found: &Snooped,
    ) -> Result<Doubted, AdjustError> {
        let case = Case {
            scene: self.scene,
            blocks: &self.blocks,
            solution: &found.solution,
            quality: &found.quality,
            used: &fixes.used,
            config: &self.config.verdict,
        };
        case.heard(problem)
    }
}

impl Path<'_> {
    fn outcome(self, solved: Solved<Sorted>) -> JointOutcome {
        let Solved {
            solution,
            ties,
            judged,
            ..
        } = solved;
        let x = &solution.estimate.parameters;
        let covariance = solution.cofactor.view((0, 0), (SOUGHT, SOUGHT));
        let (mut doubted, mut snooped) = (Doubted::default(), 0);
        let judgement = judged.map(|judged| {
            (doubted, snooped) = (judged.doubted, judged.removed);
            Judgement {
                observability: judged.observability,
                without_survey: without_survey(&solution, &self.blocks),
                quality: judged.quality,
            }
        });
        JointOutcome {
            rotation: x.rotation(self.blocks.mounting),
            transducer_m: self.blocks.transducer_m(x),
            scale: self.blocks.scale_of(x),
            covariance: covariance.into_owned(),
            snooped,
            doubted,
            judgement,
            solution,
            blocks: self.blocks,
            used: ties.used,
            gross: ties.gross,
        }
    }
}

/// The kernel of the start: it forgives gross errors without forgetting where the good ones lie.
fn robust() -> Options {
    Options {
        kernel: Kernel::Cauchy { k: 2.385 },
        step_tolerance_sigmas: 0.01,
        robust_covariance: false,
        max_iterations: 200,
        ..Options::default()
    }
}

/// Common fixes with a residual beyond the gate, and the others.
fn split(
    scene: &Scene,
    blocks: &Blocks,
    solution: &Solution,
    epochs: &Epochs,
    config: &JointConfig,
) -> (Vec<u32>, Vec<u32>) {
    let conditions = FixConditions {
        scene,
        blocks,
        fixes: &scene.common,
        epochs: epochs.of_record(),
    };
    let (x, chain) = (
        &solution.estimate.parameters,
        solution.estimate.chain.as_ref(),
    );
    let is_gross = |k: &usize| {
        (0..PER_FIX).any(|component| {
            use crate::adjust::Conditions;
            let mut row = crate::adjust::Row::default();
            conditions.linearise(k * PER_FIX + component, x, chain, &mut row);
            !(row.misclosure.abs() <= config.gate_sigma * row.variance.sqrt())
        })
    };
    let (gross, good): (Vec<usize>, Vec<usize>) = (0..scene.common.len()).partition(is_gross);
    let rows = |list: Vec<usize>| list.into_iter().map(|k| scene.common[k]).collect();
    (rows(gross), rows(good))
}

/// The attitude records that fixes hang on, as epochs of a chain.
struct Epochs {
    of_record: Vec<u32>,
    chain: Option<ChainModel>,
}

impl Epochs {
    fn number(scene: &Scene, config: &JointConfig) -> Result<Self, AdjustError> {
        let times_s = scene.campaign.attitude.times_s();
        let mut needed = vec![false; times_s.len()];
        for fix in &scene.common {
            let record = scene.poses[*fix as usize].record as usize;
            needed[record..record + 2].fill(true);
        }
        let mut of_record = vec![u32::MAX; times_s.len()];
        let mut epochs_s = vec![];
        for (record, _) in needed.iter().enumerate().filter(|(_, n)| **n) {
            of_record[record] = epochs_s.len() as u32;
            epochs_s.push(times_s[record]);
        }
        let processes = processes(scene);
        let wanted = config.attitude_noise && !processes.is_empty() && epochs_s.len() > 1;
        let chain = wanted
            .then(|| ChainModel::new(epochs_s, processes))
            .transpose()?;
        Ok(Self { of_record, chain })
    }

    fn of_record(&self) -> Option<&[u32]> {
        self.chain.is_some().then_some(&self.of_record)
    }
}

/// Noise about east, north and up, white or wandering; roll and pitch have the same noise and the sensor stands nearly level, so that their
/// axes may be taken as east and north.
fn processes(scene: &Scene) -> Vec<Process> {
    let noise = &scene.campaign.attitude_noise;
    let sigmas = [
        noise.roll_pitch_rad,
        noise.roll_pitch_rad,
        noise.heading_rad,
    ];
    let tau_s = noise.correlation_time_s;
    let kind = if tau_s > 0.0 {
        ProcessKind::GaussMarkov { tau_s }
    } else {
        ProcessKind::White
    };
    let process = |(axis, sigma): (usize, f64)| Process {
        component: 3 + axis,
        sigma,
        kind,
    };
    let all = sigmas.into_iter().enumerate();
    all.filter(|(_, sigma)| *sigma > 0.0).map(process).collect()
}

/// The unknowns: mounting, transducer, scale first; datum and beacons after them.
fn parameters(
    scene: &Scene,
    config: &JointConfig,
    rotation: &Matrix3<f64>,
) -> Result<(ParameterSet, Blocks), AdjustError> {
    let campaign = scene.campaign;
    let mut set = ParameterSet::new();
    let mounting = set.push(Block::rotation("mounting", MOUNTING, rotation).sought())?;
    let transducer = surveyed(
        &mut set,
        &campaign.transducer,
        "transducer",
        config.transducer,
    )?;
    let scale_sigma = campaign.sound_speed_relative;
    let scale = known(
        &mut set,
        ("range scale", &[SCALE], Unit::One),
        &[0.0],
        DMatrix::from_element(1, 1, scale_sigma * scale_sigma),
        config.range_scale,
    )?;
    for id in [transducer, scale] {
        set.block_mut(id).sought = true;
    }
    let (tilt, azimuth) = (campaign.datum.tilt_rad, campaign.datum.azimuth_rad);
    let datum = known(
        &mut set,
        (
            "datum",
            &["datum about east", "datum about north", "datum about up"],
            Unit::Radian,
        ),
        &[0.0; 3],
        DMatrix::from_diagonal(
            &Vector3::new(tilt * tilt, tilt * tilt, azimuth * azimuth)
                .as_slice()
                .to_vec()
                .into(),
        ),
        true,
    )?;
    let mut beacons = vec![];
    for beacon in &campaign.beacons {
        let common = beacon.role == Role::Common;
        let place = |set: &mut _| surveyed(set, &beacon.point, &beacon.point.name, config.beacons);
        beacons.push(common.then(|| place(&mut set)).transpose()?);
    }
    let blocks = Blocks {
        mounting,
        transducer,
        scale,
        datum,
        beacons,
    };
    Ok((set, blocks))
}

fn surveyed(
    set: &mut ParameterSet,
    point: &ControlPoint,
    name: &str,
    free: bool,
) -> Result<BlockId, AdjustError> {
    let names = ["east", "north", "up"].map(|axis| format!("{name} {axis}"));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let covariance = DMatrix::from_column_slice(3, 3, point.covariance_m2.as_slice());
    known(
        set,
        (name, &names, Unit::Metre),
        point.position_m.as_slice(),
        covariance,
        free,
    )
}

/// A block with a prior at its value; held where it has no variance or shall not move.
fn known(
    set: &mut ParameterSet,
    (name, components, unit): (&str, &[&str], Unit),
    value: &[f64],
    covariance: DMatrix<f64>,
    free: bool,
) -> Result<BlockId, AdjustError> {
    let components = components
        .iter()
        .map(|c| Component::new(*c, unit))
        .collect();
    let block = Block::euclidean(name, components, value);
    let most = covariance.diagonal().max();
    if !(free && most > 0.0) {
        return set.push(block.held());
    }
    // a component that is known exactly beside others that are not: a millionth of their sigma keeps the prior proper
    let mut proper = covariance;
    for i in 0..proper.nrows() {
        proper[(i, i)] = proper[(i, i)].max(1e-12 * most);
    }
    set.push(block.with_prior(value.to_vec(), proper))
}

/// Standard deviations of the parameters sought when the transducer's surveyed position is taken out of the information.
fn without_survey(solution: &Solution, blocks: &Blocks) -> Vec<f64> {
    let x = &solution.estimate.parameters;
    let mut information = solution.information();
    let first = x.offset(blocks.transducer);
    if let Some(prior) = &x.block(blocks.transducer).prior
        && let Some(weight) = prior.covariance.clone().try_inverse()
    {
        let mut part = information.view_mut((first, first), (3, 3));
        part -= weight;
    }
    let free = x.free_columns();
    let inner = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        information[(free[i], free[j])]
    });
    let scale: Vec<f64> = (0..free.len())
        .map(|i| inner[(i, i)].max(0.0).sqrt())
        .collect();
    let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        inner[(i, j)] / (scale[i] * scale[j])
    });
    let eigen = scaled.symmetric_eigen();
    let variance = |column: usize| {
        let Some(i) = free.iter().position(|c| *c == column) else {
            return 0.0;
        };
        let of = |k: usize| {
            let share = eigen.eigenvectors[(i, k)].powi(2);
            match eigen.eigenvalues[k] {
                value if value > 1e-11 => share / value,
                _ if share > 1e-6 => f64::INFINITY,
                _ => 0.0,
            }
        };
        (0..free.len()).map(of).sum::<f64>() / (scale[i] * scale[i])
    };
    (0..SOUGHT).map(|column| variance(column).sqrt()).collect()
}
