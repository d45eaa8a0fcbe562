//! Decimated points for the report's pictures, and the RMS of each path.

use nalgebra::{Matrix3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::super::conditions::Tie;
use super::super::joint::RailJoint;
use super::super::model::Turned;
use super::super::run::RailOutcome;
use super::super::scene::RailScene;
use super::super::simulate::RailTruth;
use super::super::simulate::truth::ProfilerTruth;
use super::{usable_joint, usable_reference};
use crate::calibrate::truth::{TrueMounting, TrueValues};
use crate::geometry::curve::Element;
use crate::geometry::rotation;
use crate::math;
use crate::observe::Mounting;
use crate::results::{Calibration, Page};

/// What the report's pictures are drawn from. Stays in memory; `result.json` does not hold it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RailSamples {
    /// The standard profile as polylines, one per element, millimetres.
    pub outline_mm: Vec<Outline>,
    /// Some of the points at the position nearest to level, under each mounting.
    pub profiles: Vec<ProfileSample>,
    /// Residuals of some of the points over all positions.
    pub residuals: Vec<ResidualSample>,
}

/// One element of the standard profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// Its name.
    pub name: String,
    /// `line`, `arc` for the reference path's regions, else empty.
    pub region: String,
    /// (x, z), millimetres.
    pub points: Vec<[f64; 2]>,
}

/// Points of one profiler in the cross-section.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProfileSample {
    /// Index of the profiler.
    pub profiler: u32,
    /// `nominal`, `reference` or `joint`.
    pub path: String,
    /// (x, z, distance from the profile), millimetres.
    pub points: Vec<[f64; 3]>,
}

/// A residual with its place on the profile and its position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualSample {
    /// Index of the profiler.
    pub profiler: u32,
    /// Element of the rail.
    pub element: u32,
    /// Position of the table.
    pub position: u32,
    /// Place on the profile: length of the standard profile from its begin, millimetres.
    pub along_mm: f64,
    /// Distance from the profile under the joint solution, millimetres.
    pub joint_mm: f64,
    /// Standard deviation of the same by the profiler's stated noise, millimetres.
    pub stated_mm: f64,
}

/// Points of a profile shown per profiler and path.
const SHOWN: usize = 1500;
/// Residuals shown.
const RESIDUALS: usize = 6000;
/// Spacing of the drawn outline, metres.
const DRAWN_M: f64 = 5e-4;
/// Points further from the standard profile than this are not counted as the rail's under a path, metres.
const NEAR_M: f64 = 0.005;

/// A path's mountings, and the stand at every position as the path has it.
pub(super) struct Path {
    /// `nominal`, `reference` or `joint`.
    pub(super) name: &'static str,
    mountings: Vec<Mounting>,
    stands: Vec<Turned>,
}

/// Each path that has mountings. The joint one comes with the stand that it estimated, the others with the stand as known before.
pub(super) fn paths(outcome: &RailOutcome) -> Vec<Path> {
    let scene = &outcome.scene;
    let known: Vec<Turned> = (0..scene.positions.len())
        .map(|k| stand(scene, k))
        .collect();
    let path = |name, mountings| Path {
        name,
        mountings,
        stands: known.clone(),
    };
    let profilers = scene.campaign.profilers.iter();
    let mut all = vec![path("nominal", profilers.map(|p| p.nominal).collect())];
    if let Some(found) = usable_reference(outcome) {
        all.push(path(
            "reference",
            found.iter().map(|r| r.mounting).collect(),
        ));
    }
    if let Some(found) = usable_joint(outcome) {
        all.push(Path {
            stands: estimated(scene, found),
            ..path("joint", found.mountings.clone())
        });
    }
    all
}

/// The stand that the joint path estimated.
fn estimated(scene: &RailScene, found: &RailJoint) -> Vec<Turned> {
    let estimate = &found.solution.estimate;
    let at = |k| {
        Turned::at(
            scene,
            &found.blocks,
            &estimate.parameters,
            estimate.chain.as_ref(),
            k,
        )
    };
    (0..scene.positions.len()).map(at).collect()
}

/// The stand at a position as known before, with the INS' attitude.
fn stand(scene: &RailScene, position: usize) -> Turned {
    let s = &scene.campaign.stand;
    let [roll, pitch, heading] = s.rail_attitude_rad;
    let body = scene.attitude(position);
    Turned {
        body,
        table: body,
        seat: Matrix3::identity(),
        heading_axis: -Vector3::z(),
        pitch_axis: Vector3::x(),
        rail: rotation::from_attitude(roll, pitch, heading),
        pivot_body_m: s.pivot_body_m,
        pivot_rail_m: s.pivot_rail_m,
        gap_m: 0.0,
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

/// RMS distance of the used points (of all points without a joint solution) from the standard profile under a path.
pub(super) fn rms(outcome: &RailOutcome, path: &Path) -> f64 {
    let scene = &outcome.scene;
    let rows: Vec<(u32, u32)> = match usable_joint(outcome) {
        Some(found) => found.ties.iter().map(|t| (t.row, t.position)).collect(),
        None => scene.points.iter().map(|p| (p.row, p.position)).collect(),
    };
    let distance = |&(row, position): &(u32, u32)| {
        let stand = &path.stands[position as usize];
        placed(scene, stand, &path.mountings, row as usize)
    };
    let squares: Vec<f64> = rows
        .iter()
        .filter_map(distance)
        .map(|(_, d)| d.abs().min(NEAR_M).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// What the report of an outcome shows beside its result; `title` names the survey, `truth` is known of a simulated one.
///
/// # Errors
/// None for samples made here; `serde_json` does not promise it.
pub fn page(
    outcome: &RailOutcome,
    result: &Calibration,
    title: &str,
    truth: Option<&RailTruth>,
) -> serde_json::Result<Page> {
    let samples = RailSamples {
        outline_mm: outline(&outcome.scene),
        profiles: profiles(outcome),
        residuals: residuals(outcome),
    };
    Ok(Page {
        title: title.to_owned(),
        kind: "calibration of track profilers at a standard rail",
        data: serde_json::to_value(samples)?,
        scripts: &[
            include_str!("../page/page.js"),
            include_str!("../page/residuals.js"),
        ],
        tables: vec![],
        against_truth: truth.map(|t| true_values(t).against(&result.solutions)),
    })
}

/// The truth by the names of the parameters.
#[must_use]
pub fn true_values(truth: &RailTruth) -> TrueValues {
    let one = |profiler: &ProfilerTruth| {
        let mounting = profiler.mounting();
        TrueMounting {
            prefix: format!("{} ", profiler.name),
            rotation: mounting.rotation,
            lever_arm_m: Some(mounting.lever_arm_m),
        }
    };
    TrueValues {
        mountings: truth.profilers.iter().map(one).collect(),
        others: vec![],
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
    let rows: Vec<usize> = scene
        .points
        .iter()
        .filter(|p| p.position as usize == level)
        .map(|p| p.row as usize)
        .collect();
    let mut all = vec![];
    for path in paths(outcome) {
        for profiler in 0..path.mountings.len() as u32 {
            let own: Vec<usize> = rows
                .iter()
                .copied()
                .filter(|&r| scene.campaign.points.profiler[r] == profiler)
                .collect();
            let step = own.len().div_ceil(SHOWN).max(1);
            let place = |&row: &usize| placed(scene, &path.stands[level], &path.mountings, row);
            let points = own
                .iter()
                .step_by(step)
                .filter_map(place)
                .map(|(q, d)| [q.x, q.y, d].map(micrometres));
            all.push(ProfileSample {
                profiler,
                path: path.name.to_owned(),
                points: points.collect(),
            });
        }
    }
    all
}

/// Lengths along the standard profile.
struct Ruler {
    /// Where each element begins, metres, and points along it at even distances.
    elements: Vec<(f64, f64, Vec<Vector2<f64>>)>,
}

impl Ruler {
    fn of(scene: &RailScene) -> Self {
        let mut begin_m = 0.0;
        let one = |e: &Element| {
            let (from_m, length_m) = (begin_m, e.length_m());
            begin_m += length_m;
            (from_m, length_m, e.samples(DRAWN_M))
        };
        Self {
            elements: scene.rail.elements.iter().map(one).collect(),
        }
    }

    /// Length to the sample of the element that is nearest to a point, metres.
    fn place_m(&self, element: usize, q: &Vector2<f64>) -> f64 {
        let (from_m, length_m, samples) = &self.elements[element];
        let mut best = (f64::INFINITY, 0);
        for (k, sample) in samples.iter().enumerate() {
            let distance_m = (sample - q).norm_squared();
            if distance_m < best.0 {
                best = (distance_m, k);
            }
        }
        from_m + length_m * best.1 as f64 / (samples.len().max(2) - 1) as f64
    }
}

fn residuals(outcome: &RailOutcome) -> Vec<ResidualSample> {
    let Some(found) = usable_joint(outcome) else {
        return vec![];
    };
    let (scene, x) = (&outcome.scene, &found.solution.estimate.parameters);
    let states = found.solution.estimate.chain.as_ref();
    let step = found.ties.len().div_ceil(RESIDUALS).max(1);
    let offsets = found.blocks.profile.map(|id| x.euclidean(id));
    let ruler = Ruler::of(scene);
    let one = |t: &Tie| {
        let at = Turned::at(scene, &found.blocks, x, states, t.position as usize);
        let profiler = scene.campaign.points.profiler[t.row as usize];
        let m = &found.mountings[profiler as usize];
        let q =
            at.section(&(m.rotation * scene.campaign.points.point(t.row as usize) + m.lever_arm_m));
        let offset = scene.rail.elements[usize::from(t.element)].extended(&q);
        let off = offset.distance_m;
        let normal = at.rail * Vector3::new(offset.normal.x, 0.0, offset.normal.y);
        let own = (at.body * m.rotation).tr_mul(&normal);
        let device = &scene.campaign.profilers[profiler as usize];
        ResidualSample {
            profiler,
            element: u32::from(t.element),
            position: t.position,
            along_mm: micrometres(ruler.place_m(usize::from(t.element), &q)),
            stated_mm: micrometres(math::hypot(
                own.x * device.lateral_sigma_m,
                own.z * device.vertical_sigma_m,
            )),
            joint_mm: micrometres(off - offsets.map_or(0.0, |o| o[usize::from(t.element)])),
        }
    };
    found.ties.iter().step_by(step).map(one).collect()
}
