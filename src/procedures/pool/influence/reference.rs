//! The reference path's influences: its real code differenced by the numbers that it takes from the points.

use nalgebra::{Matrix6x3, Matrix6x4, Vector3, Vector4, Vector6};

use super::super::config::{SequentialConfig, Variant};
use super::super::frame;
use super::super::run::{PoolInput, PoolOutcome, Scanned, Sounded, scanner_planes};
use super::super::scene::Scene;
use super::super::sequential::{
    self, FaceSoundings, HorizontalSoundings, RoleSoundings, ScannerPlanes, SequentialError,
};
use super::super::ties::Tie;
use super::moved::Frame;
use super::{Pull, Pulls, difference};
use crate::geometry::{PlaneFit, rotation};
use crate::georef::georeference;
use crate::observe::{Mounting, PoseSample};
use crate::target::Role;

/// The reference path, linearised.
#[derive(Clone, Debug)]
pub struct SequentialInfluence {
    /// Pulls of the observations.
    pub pulls: Pulls,
    /// The mounting that it finds in these data: free of noise, it still is off by the method's own bias.
    pub mounting: Mounting,
}

/// Linearises the reference path (projected variant: the literal one may cycle and has no derivative) on an outcome's scene.
///
/// # Errors
/// [`SequentialError`] as the path itself.
pub fn sequential(
    input: &PoolInput,
    outcome: &PoolOutcome,
) -> Result<SequentialInfluence, SequentialError> {
    let (scene, scanned) = (&outcome.scene, Scanned::by(&outcome.scene, input));
    let ties = sounding_ties(input, outcome, &scanned);
    let held = hold(scene, &ties);
    let mut path = Differences {
        scene,
        held: &held,
        scanner: scanner_planes(outcome)?,
        wall_m: wall_mean_m(outcome),
        rest: scene.campaign.sonar,
        config: SequentialConfig {
            variant: Variant::Projected,
            ..input.sequential.clone()
        },
    };
    let start = path.run(&Knobs::at_rest(&path.scanner))?;
    path.rest = start;
    let mut rest = Knobs::at_rest(&path.scanner);
    let found = path.pooled(&start, &rest);
    let fits = [
        found.p1.plane("P1", &path.scanner.p1.plane.normal)?,
        found.p2.plane("P2", &path.scanner.p2.plane.normal)?,
        found.p3.plane("P3", &path.scanner.p3.plane.normal)?,
    ];
    rest.fits = fits;
    let slopes = path.slopes(&rest, &start)?;
    let soundings = path.of_soundings(&slopes, &fits, &start, &found);
    let returns = of_returns(scene, &scanned, &slopes);
    let counts = [found.p1, found.p2, found.p3, found.level()].map(|s| s.count().max(1) as f64);
    let turn = |face: usize| match role_index(scene, face) {
        Some(role) => slopes.turn[role] / counts[role],
        None => Matrix6x3::zeros(),
    };
    Ok(SequentialInfluence {
        pulls: Pulls {
            soundings,
            returns,
            turns: (0..scene.target.faces.len()).map(turn).collect(),
        },
        mounting: start,
    })
}

/// The soundings of the reference path, tied as it ties them.
fn sounding_ties(input: &PoolInput, outcome: &PoolOutcome, scanned: &Scanned) -> Vec<Tie> {
    let Some(rough) = outcome.rough else {
        return vec![];
    };
    let sounded = Sounded::by(&outcome.scene, input, &rough.mounting, &scanned.fitted);
    sounded.ties.iter().collect()
}

/// Mean of the wall's returns, whose X the path compares.
fn wall_mean_m(outcome: &PoolOutcome) -> Vector3<f64> {
    let scene = &outcome.scene;
    let ties = outcome.returns.iter();
    let of_wall = ties.filter(|t| scene.target.faces[t.face as usize].role == Role::P2);
    let points = of_wall.filter_map(|t| Some(scene.laser_point(t.row as usize)?.0));
    let (count, sum) = points.fold((0, Vector3::zeros()), |(n, sum), p| (n + 1, sum + p));
    sum / f64::from(count.max(1))
}

/// A tied sounding as the path uses it again in every pass.
struct Held {
    pose: PoseSample,
    u_m: Vector3<f64>,
    tie: Tie,
}

fn hold(scene: &Scene, ties: &[Tie]) -> Vec<Held> {
    let nominal = &scene.campaign.sonar;
    let one = |tie: &Tie| {
        let pose = scene.sounding_pose(tie.row as usize, 0.0)?;
        let u_m = scene.beam(tie.row as usize, &pose, nominal)?.vector_m();
        Some(Held {
            pose,
            u_m,
            tie: *tie,
        })
    };
    ties.iter().filter_map(one).collect()
}

/// P1, P2, P3, horizontal as 0 to 3; `None` for faces that the path does not use.
fn role_index(scene: &Scene, face: usize) -> Option<usize> {
    match scene.target.faces[face].role {
        Role::P1 => Some(0),
        Role::P2 => Some(1),
        Role::P3 => Some(2),
        Role::Horizontal => Some(3),
        _ => None,
    }
}

/// Every number that the differences turn: where its points were moved to.
#[derive(Clone)]
struct Knobs {
    /// Planes about whose centroids and axes the soundings are moved.
    fits: [PlaneFit; 3],
    /// Shift (metres) and slopes along both axes of the soundings' displacement along the normal.
    soundings: [[f64; 3]; 3],
    /// Shift of the soundings on horizontal faces, metres.
    level_m: f64,
    /// Turn of the soundings' attitudes (target frame, radians) on P1 to P3 and the horizontal faces.
    turn: [Vector3<f64>; 4],
    /// Shift and slopes of the scanner's planes.
    scanner: [[f64; 3]; 3],
    /// Shift of the mean X of the wall's returns, metres.
    wall_m: f64,
    /// Shift of the mean height of the returns on horizontal faces, metres.
    height_m: f64,
    /// The frame of everything.
    frame: Vector4<f64>,
}

impl Knobs {
    fn at_rest(scanner: &ScannerPlanes) -> Self {
        Self {
            fits: [scanner.p1, scanner.p2, scanner.p3],
            soundings: [[0.0; 3]; 3],
            level_m: 0.0,
            turn: [Vector3::zeros(); 4],
            scanner: [[0.0; 3]; 3],
            wall_m: 0.0,
            height_m: 0.0,
            frame: Vector4::zeros(),
        }
    }

    /// What a sounding is moved by along its plane's normal, from where it lies at rest.
    fn moved(&self, role: usize, rest_m: &Vector3<f64>) -> Vector3<f64> {
        let Some(fit) = self.fits.get(role) else {
            return Vector3::z() * self.level_m;
        };
        let [shift, first, second] = self.soundings[role];
        let arm = rest_m - fit.centroid_m;
        let along = fit.along.map(|axis| axis.dot(&arm));
        fit.plane.normal * (shift + first * along[0] + second * along[1])
    }

    /// The scanner's planes tilted and shifted, in the frame moved; `wall_m` is the mean of the wall's returns.
    fn scanner(&self, at_rest: &ScannerPlanes, wall_m: &Vector3<f64>) -> ScannerPlanes {
        let mut moved = at_rest.clone();
        let planes = [&mut moved.p1, &mut moved.p2, &mut moved.p3];
        for (fit, [shift, first, second]) in planes.into_iter().zip(self.scanner) {
            let tilt = fit.along[0] * first + fit.along[1] * second;
            fit.centroid_m += fit.plane.normal * shift;
            fit.plane.normal = (fit.plane.normal - tilt).normalize();
            fit.plane.offset_m = fit.plane.normal.dot(&fit.centroid_m);
        }
        moved.wall_mean_x_m += self.wall_m;
        moved
            .horizontal
            .iter_mut()
            .for_each(|h| h.mean_height_m += self.height_m);
        Frame::of(&self.frame).planes(&moved, wall_m)
    }
}

/// Derivatives of the six parameters by every knob.
struct Slopes {
    soundings: [[Vector6<f64>; 3]; 3],
    level: Vector6<f64>,
    turn: [Matrix6x3<f64>; 4],
    scanner: [[Vector6<f64>; 3]; 3],
    wall: Vector6<f64>,
    height: Vector6<f64>,
    frame: Matrix6x4<f64>,
}

/// Steps of the differences, radians and metres: small against curvature, large against the tolerance of the path's end.
const STEP: f64 = 5e-4;

/// The reference path's real code, to be run many times.
struct Differences<'a> {
    scene: &'a Scene<'a>,
    held: &'a [Held],
    scanner: ScannerPlanes,
    /// Mean of the wall's returns.
    wall_m: Vector3<f64>,
    /// The mounting under which points are at rest.
    rest: Mounting,
    config: SequentialConfig,
}

impl Differences<'_> {
    fn run(&self, knobs: &Knobs) -> Result<Mounting, SequentialError> {
        let scanner = knobs.scanner(&self.scanner, &self.wall_m);
        let nominal = self.scene.campaign.sonar;
        let mut observe = |mounting: &Mounting, _: u32| self.pooled(mounting, knobs);
        Ok(sequential::run(&nominal, &scanner, &self.config, &mut observe)?.mounting)
    }

    fn pooled(&self, mounting: &Mounting, knobs: &Knobs) -> RoleSoundings {
        let target = self.scene.target;
        let turns = knobs.turn.map(|turn| rotation::exp(&turn));
        let frame = Frame::of(&knobs.frame);
        let mut faces = vec![FaceSoundings::default(); target.faces.len()];
        for h in self.held {
            if let Some(role) = role_index(self.scene, h.tie.face as usize) {
                // an error stays with its sounding, wherever the path's mounting puts the point; a turn takes that way along
                let at = |mounting| georeference(&h.pose, mounting, &h.u_m);
                let rest = at(&self.rest);
                let point = rest + turns[role] * (at(mounting) - rest) + knobs.moved(role, &rest);
                let attitude = frame.back * turns[role] * h.pose.rotation;
                faces[h.tie.face as usize].add(&frame.point(&point), &attitude);
            }
        }
        let mut roles = RoleSoundings::default();
        for (face, soundings) in faces.into_iter().enumerate() {
            match role_index(self.scene, face) {
                Some(0) => roles.p1.merge(&soundings),
                Some(1) => roles.p2.merge(&soundings),
                Some(2) => roles.p3.merge(&soundings),
                Some(_) if soundings.count() > 0 => roles.horizontal.push(HorizontalSoundings {
                    design_height_m: target.design_offset_m(face),
                    soundings,
                }),
                _ => {}
            }
        }
        roles
    }

    /// Central difference over one knob.
    fn slope(
        &self,
        rest: &Knobs,
        centre: &Mounting,
        turn: impl Fn(&mut Knobs, f64),
    ) -> Result<Vector6<f64>, SequentialError> {
        let at = |step: f64| {
            let mut knobs = rest.clone();
            turn(&mut knobs, step);
            Ok(difference(&self.run(&knobs)?, centre))
        };
        Ok((at(STEP)? - at(-STEP)?) / (2.0 * STEP))
    }

    fn slopes(&self, rest: &Knobs, centre: &Mounting) -> Result<Slopes, SequentialError> {
        let mut found = Slopes {
            soundings: [[Vector6::zeros(); 3]; 3],
            level: self.slope(rest, centre, |k, step| k.level_m = step)?,
            turn: [Matrix6x3::zeros(); 4],
            scanner: [[Vector6::zeros(); 3]; 3],
            wall: self.slope(rest, centre, |k, step| k.wall_m = step)?,
            height: self.slope(rest, centre, |k, step| k.height_m = step)?,
            frame: Matrix6x4::zeros(),
        };
        for i in 0..4 {
            let slope = self.slope(rest, centre, |k, step| k.frame[i] = step)?;
            found.frame.set_column(i, &slope);
        }
        for i in 0..3 {
            for role in 0..3 {
                found.soundings[role][i] =
                    self.slope(rest, centre, |k, step| k.soundings[role][i] = step)?;
                found.scanner[role][i] =
                    self.slope(rest, centre, |k, step| k.scanner[role][i] = step)?;
            }
            for role in 0..4 {
                let slope = self.slope(rest, centre, |k, step| k.turn[role][i] = step)?;
                found.turn[role].set_column(i, &slope);
            }
        }
        Ok(found)
    }

    fn of_soundings(
        &self,
        slopes: &Slopes,
        fits: &[PlaneFit; 3],
        mounting: &Mounting,
        found: &RoleSoundings,
    ) -> Vec<Pull> {
        let level = found.level().count().max(1) as f64;
        let one = |h: &Held| {
            let role = role_index(self.scene, h.tie.face as usize)?;
            let point = georeference(&h.pose, mounting, &h.u_m);
            let six = match fits.get(role) {
                Some(fit) => on_plane(fit, &slopes.soundings[role], &point),
                None => slopes.level / level,
            };
            Some(Pull {
                row: h.tie.row,
                face: h.tie.face,
                six,
            })
        };
        self.held.iter().filter_map(one).collect()
    }
}

/// Pull of one point of a least-squares plane.
fn on_plane(fit: &PlaneFit, slopes: &[Vector6<f64>; 3], point: &Vector3<f64>) -> Vector6<f64> {
    let arm = point - fit.centroid_m;
    slopes[0] / fit.count as f64
        + slopes[1] * (fit.along[0].dot(&arm) / fit.in_plane_m2[0])
        + slopes[2] * (fit.along[1].dot(&arm) / fit.in_plane_m2[1])
}

/// Pulls gathered by row: one for each face that a row is held to, mostly one.
struct Gathered {
    rows: Vec<Option<Pull>>,
    others: Vec<Pull>,
}

impl Gathered {
    fn add(&mut self, row: u32, face: u16, six: Vector6<f64>) {
        let pull = self.rows[row as usize].get_or_insert(Pull {
            row,
            face,
            six: Vector6::zeros(),
        });
        if pull.face == face {
            pull.six += six;
        } else {
            self.others.push(Pull { row, face, six });
        }
    }

    fn in_order(self) -> Vec<Pull> {
        let mut all: Vec<Pull> = self.rows.into_iter().flatten().collect();
        all.extend(self.others);
        all.sort_by_key(|pull| pull.row);
        all
    }
}

/// Returns act through the planes (of the wide association), through the means (of the association on those planes), and, where
/// they register the target, through the frame.
fn of_returns(scene: &Scene, scanned: &Scanned, slopes: &Slopes) -> Vec<Pull> {
    let mut all = Gathered {
        rows: vec![None; scene.campaign.laser.len()],
        others: vec![],
    };
    let mut add = |tie: &Tie, six: Vector6<f64>| all.add(tie.row, tie.face, six);
    for tie in &scanned.wide {
        if let Some(six) = through_plane(scene, scanned, slopes, &tie) {
            add(&tie, six);
        }
    }
    let count = |role: Role| {
        let of_role = |face: usize| scene.target.faces[face].role == role;
        scanned.returns.count(of_role).max(1) as f64
    };
    let (wall, level) = (count(Role::P2), count(Role::Horizontal));
    for tie in &scanned.returns {
        let face = &scene.target.faces[tie.face as usize];
        let normal = scene.target.groups[face.group].normal;
        match face.role {
            Role::P2 => add(&tie, slopes.wall * (normal.x / wall)),
            Role::Horizontal => add(&tie, slopes.height * (normal.z / level)),
            _ => {}
        }
    }
    for response in frame::of_returns(scene) {
        let face = &scene.target.faces[response.face as usize];
        let side = scene.target.groups[face.group].normal.dot(&response.normal);
        let six = slopes.frame * response.parameters * side.signum();
        all.add(response.point as u32, response.face, six);
    }
    all.in_order()
}

fn through_plane(
    scene: &Scene,
    scanned: &Scanned,
    slopes: &Slopes,
    tie: &Tie,
) -> Option<Vector6<f64>> {
    let target = scene.target;
    let face = &target.faces[tie.face as usize];
    let slopes = slopes.scanner.get(role_index(scene, tie.face as usize)?)?;
    // a role's first face names the group whose plane counts
    let first = target.faces.iter().find(|f| f.role == face.role)?;
    if first.group != face.group {
        return None;
    }
    let fit = &scanned.planes[face.group]?.fit;
    let (point, _) = scene.laser_point(tie.row as usize)?;
    let design = target.groups[face.group].normal * target.design_offset_m(tie.face as usize);
    Some(on_plane(fit, slopes, &(point - design)))
}
