//! The whole pool calibration in memory: prepare, extract, reference path, joint path.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::alternatives;
use super::config::{Drift, JointConfig, Planes, SequentialConfig};
use super::joint::{self, JointOutcome, JointStart, Surfaces};
use super::planes::{self, GroupPlanes};
use super::rows::Rows;
use super::scene::{RoughMounting, Scene};
use super::sequential::{
    self, FaceSoundings, HorizontalReturns, HorizontalSoundings, RoleSoundings, ScannerPlanes,
    SequentialError,
};
use super::ties::{self, Among, Association, Tie, TieSet};
use super::verdict::Refusal;
use crate::adjust::AdjustError;
pub use crate::calibrate::choices::Method;
use crate::calibrate::verdict::Doubted;
use crate::files::spill::SpillError;
use crate::geometry::ellipsoid::TargetPose;
use crate::geometry::plane::{Plane, PlaneFit};
use crate::georef::{RayError, georeference};
use crate::matching::{Patches, Water};
use crate::observe::{Campaign, Extra, ExtraFault, Mounting, PoseSample, Struck, extra};
use crate::target::{Role, Target};
use crate::watch::{Stopped, Unwatched, Watch};

/// Everything a pool calibration needs.
#[derive(Clone, Debug)]
pub struct PoolInput<'a> {
    /// What was observed.
    pub campaign: &'a Campaign,
    /// The target at design dimensions.
    pub target: &'a Target,
    /// What the surveyor knows of the target's pose beforehand.
    pub prior: &'a TargetPose,
    /// Which paths run.
    pub method: Method,
    /// The reference path.
    pub sequential: &'a SequentialConfig,
    /// The joint path.
    pub joint: &'a JointConfig,
    /// Seed of RANSAC.
    pub seed: u64,
    /// Unknowns of the caller's own, one number a sounding each; the joint path solves for them.
    pub extras: &'a [Extra],
}

/// What a pool calibration ended with. A path that did not run is `None`.
#[derive(Debug)]
pub struct PoolOutcome<'a> {
    /// The scene, in the refined target frame.
    pub scene: Scene<'a>,
    /// The scanner's planes by group of the target.
    pub planes: GroupPlanes,
    /// Ties of the laser returns.
    pub returns: TieSet,
    /// The rough registration of the soundings.
    pub rough: Option<RoughMounting>,
    /// The reference path.
    pub sequential: Option<Result<sequential::Outcome, SequentialError>>,
    /// The reference path again in other configurations, in the order they were asked for ([`calibrate_with`]).
    pub further: Vec<Result<sequential::Outcome, SequentialError>>,
    /// The rigorous joint path.
    pub joint: Option<JointOutcome>,
    /// The simple joint model, where it was asked for.
    pub simple: Option<JointOutcome>,
    /// Why there is no usable result.
    pub refusal: Option<Refusal>,
}

/// Why a calibration could not be run at all.
#[derive(Debug, thiserror::Error)]
pub enum PoolError {
    /// The sound speed cannot be used.
    #[error("sound speed: {0}")]
    SoundSpeed(#[from] RayError),
    /// An unknown of the caller's own cannot be used.
    #[error(transparent)]
    Extra(#[from] ExtraFault),
    /// Soundings that were kept in a file cannot be read from it again.
    #[error("soundings: {0}")]
    File(#[from] SpillError),
    /// What other processes answered cannot be put together.
    #[error("joint path: {0}")]
    Outside(AdjustError),
    /// Stopped by whoever watches.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Gate of the first, wide association of returns, in sigmas: the target's planes are known from its design only.
const WIDE: f64 = 4.0;
/// Soundings within this of the target under the rough mounting stay candidates, metres.
pub(super) const CANDIDATE_M: f64 = 0.5;

/// What the laser returns say of the target: association, planes, association on those planes.
pub(super) struct Scanned {
    /// The faces above the water, on the planes found.
    pub laser: Patches,
    /// Ties by the design alone, in a wide gate.
    pub wide: TieSet,
    /// The planes found, by group.
    pub planes: GroupPlanes,
    /// The same without their statistics.
    pub fitted: Vec<Option<Plane>>,
    /// Ties on the planes found.
    pub returns: TieSet,
}

impl Scanned {
    pub(super) fn by(scene: &Scene, input: &PoolInput) -> Self {
        let origins = scene.origins(&input.campaign.scanner);
        let mut laser = Patches::new(
            input.target,
            Water::Above,
            input.campaign.water_level_m,
            &origins,
        );
        let tie = |laser: &Patches, among, gate| {
            ties::tie_returns(scene, laser, among, &Association::before(gate))
        };
        let wide = tie(&laser, Among::All, WIDE * input.joint.gate_sigma);
        let planes = planes::extract(scene, &wide, input.seed);
        let fitted: Vec<Option<Plane>> = planes.iter().map(|p| p.map(|p| p.fit.plane)).collect();
        planes::apply(&mut laser, scene, &fitted);
        let returns = tie(&laser, Among::AllLike(&wide), input.joint.gate_sigma);
        Self {
            laser,
            wide,
            planes,
            fitted,
            returns,
        }
    }
}

/// Calibrates. `progress` is told what is being done.
///
/// # Errors
/// [`PoolError`] when the input cannot be worked with at all; a calibration that ends without a usable result is an outcome.
pub fn calibrate<'a>(
    input: &PoolInput<'a>,
    progress: &dyn Watch,
) -> Result<PoolOutcome<'a>, PoolError> {
    calibrate_with(input, &[], progress)
}

/// Calibrates, and runs the reference path in further configurations on the same planes and the same tied soundings
/// ([`PoolOutcome::further`]; nothing where the reference path does not run).
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_with<'a>(
    input: &PoolInput<'a>,
    further: &[SequentialConfig],
    progress: &dyn Watch,
) -> Result<PoolOutcome<'a>, PoolError> {
    progress.begin("refining the target's pose from the laser points")?;
    check_extras(input)?;
    let mut scene = Scene::prepare(input.campaign, input.target, input.prior)?;
    scene.extras = input.extras;
    let outcome = calibrate_scene(input, scene, further, progress)?;
    let outcome = explained(input, outcome, progress)?;
    match input.campaign.soundings.fault() {
        Some(fault) => Err(fault.clone().into()),
        None => Ok(outcome),
    }
}

/// Refuses unknowns of the caller's own that cannot be used, or whose name another parameter has.
fn check_extras(input: &PoolInput) -> Result<(), PoolError> {
    let mut taken = joint::SIX.to_vec();
    taken.extend(["latency", "range_scale"]);
    extra::check(input.extras, input.campaign.soundings.len(), &taken)?;
    Ok(())
}

/// As [`calibrate_with`], of a simulated survey of which is known what each observation struck: nothing is tied to another face. What a
/// path's error changes by is what wrong ties cost.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_with_true_ties<'a>(
    input: &PoolInput<'a>,
    struck: &'a Struck,
    further: &[SequentialConfig],
) -> Result<PoolOutcome<'a>, PoolError> {
    let mut scene = Scene::prepare(input.campaign, input.target, input.prior)?;
    scene.struck = Some(struck);
    calibrate_scene(input, scene, further, &Unwatched)
}

/// What the soundings say of the target under the rough mounting.
pub(super) struct Sounded {
    /// The faces below the water, on the planes that the scanner found.
    pub(super) sonar: Patches,
    /// Soundings that may lie on the target.
    pub(super) candidates: Rows,
    /// Their ties.
    pub(super) ties: TieSet,
}

impl Sounded {
    pub(super) fn by(
        scene: &Scene,
        input: &PoolInput,
        mounting: &Mounting,
        fitted: &[Option<Plane>],
    ) -> Self {
        let (origins, level_m) = (scene.origins(mounting), input.campaign.water_level_m);
        let mut sonar = Patches::new(input.target, Water::Below, level_m, &origins);
        planes::apply(&mut sonar, scene, fitted);
        let candidates = scene.soundings_near(&sonar, mounting, CANDIDATE_M);
        let gate = input.joint.gate_sigma;
        let ties = ties::tie_soundings_first(scene, &sonar, &candidates, mounting, gate);
        Self {
            sonar,
            candidates,
            ties,
        }
    }
}

fn calibrate_scene<'a>(
    input: &PoolInput<'a>,
    scene: Scene<'a>,
    further: &[SequentialConfig],
    progress: &dyn Watch,
) -> Result<PoolOutcome<'a>, PoolError> {
    let (mut outcome, seen) = seen(input, scene, progress)?;
    let Some((laser, sounded, rough)) = seen else {
        return Ok(outcome);
    };
    if input.method != Method::Joint {
        progress.begin("reference path: angles, then offsets")?;
        let tied = Tied::new(&outcome.scene, &sounded.ties);
        let first = run_sequential(&outcome, &tied, input.sequential);
        let again = further.iter().map(|c| run_sequential(&outcome, &tied, c));
        (outcome.further, outcome.sequential) = (again.collect(), Some(first));
    }
    if input.method != Method::Reference {
        let start = JointStart {
            mounting: rough.mounting,
            planes: &outcome.planes,
            returns: &outcome.returns,
            candidates: &sounded.candidates,
            soundings: &sounded.ties,
        };
        let sonar = sounded.sonar;
        let (scene, mut surfaces) = (&outcome.scene, Surfaces { laser, sonar });
        progress.begin("joint path: angles, lever arm, planes and drift together")?;
        let rigorous = joint::run(scene, &start, &mut surfaces, input.joint, progress);
        let simple = || simple_joint(input, scene, &start, &mut surfaces, progress);
        (outcome.joint, outcome.simple, outcome.refusal) = jointly(rigorous, simple)?;
    }
    let refusal = outcome.refusal.take();
    outcome.refusal = refusal.or_else(|| Refusal::of_solution(&outcome, input));
    Ok(outcome)
}

/// The faces above the water, what the soundings say, and the rough registration.
type Seen = (Patches, Sounded, RoughMounting);

/// What both sensors say of the target; nothing, with the refusal in the outcome, where no path can begin.
fn seen<'a>(
    input: &PoolInput<'a>,
    scene: Scene<'a>,
    progress: &dyn Watch,
) -> Result<(PoolOutcome<'a>, Option<Seen>), PoolError> {
    progress.begin("extracting the scanner's planes")?;
    let scanned = Scanned::by(&scene, input);
    let mut outcome = PoolOutcome {
        scene,
        planes: scanned.planes,
        returns: scanned.returns,
        rough: None,
        sequential: None,
        further: vec![],
        joint: None,
        simple: None,
        refusal: None,
    };
    outcome.refusal = Refusal::of_scanner(&outcome.scene, &outcome.planes, &scanned.wide);
    if outcome.refusal.is_some() {
        return Ok((outcome, None));
    }
    progress.begin("finding the target in the soundings")?;
    let rough = outcome.scene.rough_mounting();
    outcome.rough = Some(rough);
    outcome.refusal = Refusal::of_soundings(&rough).or_else(|| {
        let heights_m = outcome.scene.sounding_heights_m(&rough.mounting);
        Refusal::of_water(&outcome.scene, "soundings", &heights_m, 1.0)
    });
    if outcome.refusal.is_some() {
        return Ok((outcome, None));
    }
    let sounded = Sounded::by(&outcome.scene, input, &rough.mounting, &scanned.fitted);
    Ok((outcome, Some((scanned.laser, sounded, rough))))
}

/// Where a survey ended without a usable result, the discrete mistake that would explain it takes the place of the reason.
fn explained<'a>(
    input: &PoolInput<'a>,
    mut outcome: PoolOutcome<'a>,
    progress: &dyn Watch,
) -> Result<PoolOutcome<'a>, Stopped> {
    if outcome.refusal.is_some() && outcome.scene.struck.is_none() {
        progress.begin("trying signs, units and axes")?;
        let mistake = alternatives::named(input, progress);
        progress.go_on()?;
        let mistake = mistake.map(|finding| Refusal::DoesNotFit(Box::new(finding)));
        outcome.refusal = mistake.or(outcome.refusal);
    }
    Ok(outcome)
}

/// The rigorous joint path, the simple one, and why there is no rigorous one.
type Jointly = (Option<JointOutcome>, Option<JointOutcome>, Option<Refusal>);

/// How the rigorous joint path ended; after a result comes the simple one, where it was asked for.
fn jointly(
    rigorous: Result<JointOutcome, AdjustError>,
    simple: impl FnOnce() -> Result<Option<JointOutcome>, Stopped>,
) -> Result<Jointly, PoolError> {
    match rigorous {
        Ok(found) => Ok((Some(found), simple()?, None)),
        Err(AdjustError::Stopped(stopped)) => Err(stopped.into()),
        Err(
            torn @ (AdjustError::MissingBlock { .. }
            | AdjustError::SurplusBlock { .. }
            | AdjustError::Torn(_)),
        ) => Err(PoolError::Outside(torn)),
        Err(error) => Ok((None, None, Some(Refusal::failed(&error)))),
    }
}

/// The simple joint model, where it was asked for.
fn simple_joint(
    input: &PoolInput,
    scene: &Scene,
    start: &JointStart,
    surfaces: &mut Surfaces,
    progress: &dyn Watch,
) -> Result<Option<JointOutcome>, Stopped> {
    if !input.joint.simple {
        return Ok(None);
    }
    progress.begin("simple joint model: planes fixed, drift off")?;
    let simple = JointConfig {
        planes: Planes::Fixed,
        drift: Drift::Off,
        ..input.joint.clone()
    };
    let mut simple = joint::run(scene, start, surfaces, &simple, progress);
    if let Ok(simple) = &mut simple {
        simple.doubted = Doubted::default();
    }
    progress.go_on()?;
    Ok(simple.ok())
}

/// A tied sounding as the reference path uses it again in every pass.
#[derive(Clone, Copy)]
struct Held {
    pose: PoseSample,
    u_m: Vector3<f64>,
    face: u16,
}

/// Up to so many tied soundings are held ready (136 bytes each); of more each is made ready anew in every pass, since memory must not
/// grow with what can be computed.
const MOST_HELD: usize = 200_000;
/// Soundings per parallel task, whose sums are merged in order.
const CHUNK: usize = 16_384;

/// Soundings that were tied once (patent step 2), to be georeferenced in every pass.
struct Tied<'a> {
    scene: &'a Scene<'a>,
    ties: &'a TieSet,
    /// Those that have a beam, where they are few.
    held: Option<Vec<Held>>,
    /// The ties that each task begins at, so that all tasks but the last have as many soundings with a beam.
    begins: Vec<usize>,
}

impl<'a> Tied<'a> {
    fn new(scene: &'a Scene<'a>, ties: &'a TieSet) -> Self {
        let few = ties.len() <= MOST_HELD;
        let mut tied = Self {
            scene,
            ties,
            held: None,
            begins: vec![],
        };
        if few {
            let starts = (0..ties.len()).into_par_iter().step_by(CHUNK);
            let chunk = |start| ties.from(start).take(CHUNK);
            let held = starts.flat_map_iter(|start| chunk(start).filter_map(|t| hold(scene, t)));
            tied.held = Some(held.collect());
        } else {
            tied.begins = tied.begins();
        }
        tied
    }

    fn begins(&self) -> Vec<usize> {
        let starts: Vec<usize> = (0..self.ties.len()).step_by(CHUNK).collect();
        let whole = |start: &usize| {
            let mut ties = self.ties.from(*start).take(CHUNK);
            ties.all(|tie| hold(self.scene, tie).is_some())
        };
        if starts.par_iter().all(whole) {
            return starts;
        }
        let held = self.ties.iter().enumerate();
        let held = held.filter(|(_, tie)| hold(self.scene, *tie).is_some());
        held.step_by(CHUNK).map(|(k, _)| k).collect()
    }

    /// Sums over the faces by task, under a mounting.
    fn sums(&self, mounting: &Mounting) -> Vec<Vec<FaceSoundings>> {
        let faces = self.scene.target.faces.len();
        if let Some(held) = &self.held {
            let of = |chunk: &[Held]| sums(faces, chunk.iter().copied(), mounting);
            return held.par_chunks(CHUNK).map(of).collect();
        }
        let of = |begin: &usize| {
            let held = self
                .ties
                .from(*begin)
                .filter_map(|tie| hold(self.scene, tie));
            sums(faces, held.take(CHUNK), mounting)
        };
        self.begins.par_iter().map(of).collect()
    }
}

fn hold(scene: &Scene, tie: Tie) -> Option<Held> {
    let pose = scene.sounding_pose(tie.row as usize, 0.0)?;
    let beam = scene.beam(tie.row as usize, &pose, &scene.campaign.sonar)?;
    Some(Held {
        pose,
        u_m: beam.vector_m(),
        face: tie.face,
    })
}

fn sums(faces: usize, held: impl Iterator<Item = Held>, mounting: &Mounting) -> Vec<FaceSoundings> {
    let mut sums = vec![FaceSoundings::default(); faces];
    for h in held {
        sums[h.face as usize].add(&georeference(&h.pose, mounting, &h.u_m), &h.pose.rotation);
    }
    sums
}

/// Runs the reference path on tied soundings, re-georeferenced in every pass.
fn run_sequential(
    outcome: &PoolOutcome,
    tied: &Tied,
    config: &SequentialConfig,
) -> Result<sequential::Outcome, SequentialError> {
    let scanner = scanner_planes(outcome)?;
    let nominal = outcome.scene.campaign.sonar;
    sequential::run(&nominal, &scanner, config, &mut |mounting: &Mounting, _| {
        pooled(tied, mounting)
    })
}

/// Soundings of all passes by role, under a mounting; parts are merged in a fixed order.
fn pooled(tied: &Tied, mounting: &Mounting) -> RoleSoundings {
    let (target, parts) = (tied.scene.target, tied.sums(mounting));
    let mut roles = RoleSoundings::default();
    for (face, f) in target.faces.iter().enumerate() {
        let mut all = FaceSoundings::default();
        parts.iter().for_each(|part| all.merge(&part[face]));
        match f.role {
            Role::P1 => roles.p1.merge(&all),
            Role::P2 => roles.p2.merge(&all),
            Role::P3 => roles.p3.merge(&all),
            Role::Horizontal if all.count() > 0 => {
                let design_height_m = target.design_offset_m(face);
                roles.horizontal.push(HorizontalSoundings {
                    design_height_m,
                    soundings: all,
                });
            }
            _ => {}
        }
    }
    roles
}

/// A group's plane moved along its normal to the faces' design position.
fn at_face(mut fit: PlaneFit, offset_m: f64) -> PlaneFit {
    fit.plane.offset_m += offset_m;
    fit.centroid_m += fit.plane.normal * offset_m;
    fit
}

/// The scanner's side of the reference path.
pub(super) fn scanner_planes(outcome: &PoolOutcome) -> Result<ScannerPlanes, SequentialError> {
    let target = outcome.scene.target;
    let fit = |role: Role, plane: &'static str| {
        let face = target.faces.iter().position(|f| f.role == role);
        let found = face.and_then(|f| {
            Some(at_face(
                outcome.planes[target.faces[f].group]?.fit,
                target.design_offset_m(f),
            ))
        });
        found.ok_or(SequentialError::NoScannerPlane { plane })
    };
    let mut sums = vec![(0usize, Vector3::zeros()); target.faces.len()];
    for tie in &outcome.returns {
        if let Some((point, _)) = outcome.scene.laser_point(tie.row as usize) {
            sums[tie.face as usize].0 += 1;
            sums[tie.face as usize].1 += point;
        }
    }
    let of_role = |role: Role| {
        target
            .faces
            .iter()
            .zip(&sums)
            .enumerate()
            .filter(move |(_, (f, _))| f.role == role)
            .map(|(k, (_, s))| (k, *s))
    };
    let wall = of_role(Role::P2).fold((0, 0.0), |all, (_, s)| (all.0 + s.0, all.1 + s.1.x));
    let horizontal = of_role(Role::Horizontal)
        .filter(|(_, s)| s.0 > 0)
        .map(|(face, s)| HorizontalReturns {
            face,
            design_height_m: target.design_offset_m(face),
            mean_height_m: s.1.z / s.0 as f64,
            count: s.0,
        })
        .collect();
    Ok(ScannerPlanes {
        p1: fit(Role::P1, "P1")?,
        p2: fit(Role::P2, "P2")?,
        p3: fit(Role::P3, "P3")?,
        wall_mean_x_m: wall.1 / wall.0.max(1) as f64,
        horizontal,
    })
}
