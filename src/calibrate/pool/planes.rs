//! The scanner's planes: extracted from the laser returns by RANSAC and a robust fit, checked between passes.

use nalgebra::Vector3;

use super::scene::Scene;
use super::ties::TieSet;
use crate::geometry::plane::{Plane, PlaneFit, PlaneMoments};
use crate::geometry::ransac::{ExpectedNormal, PlaneSearch, find_plane};
use crate::matching::Patches;
use crate::target::Role;

/// Points that the search for a plane looks at.
const SEARCH_POINTS: usize = 20_000;
/// A plane of fewer returns is none.
const LEAST_RETURNS: usize = 30;
/// Observations further apart in time than this belong to different passes, seconds.
pub(super) const PASS_GAP_S: f64 = 5.0;

/// The plane of one group, at the group's design position (face offsets taken off).
#[derive(Clone, Copy, Debug)]
pub struct GroupPlane {
    /// The fit; its normal is the group's, its offset the distance of the group's plane from its design position, metres.
    pub fit: PlaneFit,
}

/// Planes by group index; `None` where the scanner saw too little.
pub type GroupPlanes = Vec<Option<GroupPlane>>;

/// Return `tie` taken back along its group's normal by its face's design offset: on the group's plane.
fn on_group_plane(scene: &Scene, row: u32, face: usize) -> Option<Vector3<f64>> {
    let (point, _) = scene.laser_point(row as usize)?;
    let group = &scene.target.groups[scene.target.faces[face].group];
    Some(point - group.normal * scene.target.design_offset_m(face))
}

/// Extracts every group's plane from the tied returns.
#[must_use]
pub fn extract(scene: &Scene, ties: &TieSet, seed: u64) -> GroupPlanes {
    (0..scene.target.groups.len())
        .map(|group| extract_group(scene, ties, group, seed))
        .collect()
}

fn group_points(scene: &Scene, ties: &TieSet, group: usize) -> Vec<(f64, Vector3<f64>)> {
    let of_group = ties
        .ties
        .iter()
        .filter(|t| scene.target.faces[t.face as usize].group == group);
    let time = |row: u32| {
        scene
            .campaign
            .laser
            .time_s
            .get(row as usize)
            .copied()
            .unwrap_or(0.0)
    };
    of_group
        .filter_map(|t| Some((time(t.row), on_group_plane(scene, t.row, t.face as usize)?)))
        .collect()
}

fn extract_group(scene: &Scene, ties: &TieSet, group: usize, seed: u64) -> Option<GroupPlane> {
    let points = group_points(scene, ties, group);
    if points.len() < LEAST_RETURNS {
        return None;
    }
    let stride = points.len().div_ceil(SEARCH_POINTS);
    let sample: Vec<Vector3<f64>> = points.iter().step_by(stride).map(|p| p.1).collect();
    let normal = scene.target.groups[group].normal;
    let tolerance_m = 4.0 * point_sigma_m(scene);
    let search = PlaneSearch {
        tolerance_m,
        least_inliers: LEAST_RETURNS.min(sample.len()),
        normal: Some(ExpectedNormal {
            normal,
            within_rad: 0.09,
        }),
        seed,
        ..PlaneSearch::default()
    };
    let found = find_plane(&sample, &search).ok()?;
    let plane = found.fit.plane;
    let mut moments = PlaneMoments::default();
    for (_, p) in points
        .iter()
        .filter(|(_, p)| plane.distance_m(p).abs() <= tolerance_m)
    {
        moments.add(p);
    }
    let fit = moments.fit().ok()?.towards(&normal);
    Some(GroupPlane { fit })
}

/// Spread of a laser point along a normal: its own noise, the trajectory's, metres.
fn point_sigma_m(scene: &Scene) -> f64 {
    let (laser, trajectory) = (
        &scene.campaign.laser.noise,
        &scene.campaign.trajectory.noise,
    );
    if !scene.laser_uses_trajectory() {
        return laser.point_m;
    }
    let angle_m = laser.angle_rad * 10.0;
    laser
        .range_m
        .hypot(angle_m)
        .hypot(trajectory.position_m)
        .hypot(trajectory.position_drift_m)
        .max(0.002)
}

/// Puts the groups' planes under the faces of a set of patches.
pub fn apply(patches: &mut Patches, scene: &Scene, planes: &[Option<Plane>]) {
    for (face, f) in scene.target.faces.iter().enumerate() {
        if let Some(plane) = planes[f.group] {
            patches.set_plane(
                face,
                plane.normal,
                plane.offset_m + scene.target.design_offset_m(face),
            );
        }
    }
}

/// Two passes disagree beyond this many sigmas: two surveys in a thousand by chance, with three passes (docs/validation.md).
const DISAGREES: f64 = 4.0;

/// The plane that one pass of the scanner gives by itself.
struct PassPlane {
    fit: PlaneFit,
    time_s: f64,
}

/// A disagreement between the planes of two passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// Group concerned.
    pub group: String,
    /// Largest distance between the two passes' planes over the face, metres.
    pub apart_m: f64,
    /// Its expected standard deviation, metres.
    pub sigma_m: f64,
    /// Number of passes.
    pub passes: usize,
}

/// Compares the upright planes that each pass of the scanner gives by itself; the horizontal faces are seen too obliquely. Returns the worst that exceeds four sigmas of what the
/// trajectory's drift and the scanner's stated uncertainty explain: a scanner that is not calibrated after all.
#[must_use]
pub fn disagreement(scene: &Scene, ties: &TieSet) -> Option<Disagreement> {
    let mut worst: Option<Disagreement> = None;
    let upright = |role| matches!(role, Role::P1 | Role::P2 | Role::P3);
    let groups = scene.target.groups.iter().enumerate();
    for (group, _) in groups.filter(|(_, g)| upright(g.role)) {
        let points = group_points(scene, ties, group);
        let passes = split_passes(&points);
        let fits: Vec<PassPlane> = passes
            .iter()
            .filter_map(|pass| robust_pass(scene, group, pass))
            .collect();
        for (k, a) in fits.iter().enumerate() {
            for b in &fits[..k] {
                let found = compare(scene, group, a, b, fits.len());
                let excess = |d: &Disagreement| d.apart_m / d.sigma_m;
                if excess(&found) > DISAGREES
                    && worst.as_ref().is_none_or(|w| excess(&found) > excess(w))
                {
                    worst = Some(found);
                }
            }
        }
    }
    worst
}

fn split_passes(points: &[(f64, Vector3<f64>)]) -> Vec<&[(f64, Vector3<f64>)]> {
    let passes = points.chunk_by(|a, b| b.0 - a.0 <= PASS_GAP_S);
    passes.filter(|pass| pass.len() >= 200).collect()
}

fn robust_pass(scene: &Scene, group: usize, points: &[(f64, Vector3<f64>)]) -> Option<PassPlane> {
    let normal = scene.target.groups[group].normal;
    let sample: Vec<Vector3<f64>> = points
        .iter()
        .step_by(points.len().div_ceil(5000))
        .map(|p| p.1)
        .collect();
    let search = PlaneSearch {
        tolerance_m: 4.0 * point_sigma_m(scene),
        least_inliers: 100,
        normal: Some(ExpectedNormal {
            normal,
            within_rad: 0.09,
        }),
        seed: 1,
        ..PlaneSearch::default()
    };
    let found = find_plane(&sample, &search).ok()?;
    let sigma_m = found
        .fit
        .sigma_at_m(&found.fit.centroid_m, point_sigma_m(scene));
    let settled = 2 * found.inliers.len() > sample.len() && sigma_m < 0.003;
    let time_s = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
    settled.then(|| PassPlane {
        fit: found.fit.towards(&normal),
        time_s,
    })
}

/// The drift of two passes differs by `2 sigma^2 (1 - exp(-dt / tau))` in variance.
fn compare(
    scene: &Scene,
    group: usize,
    a: &PassPlane,
    b: &PassPlane,
    passes: usize,
) -> Disagreement {
    let middle = (a.fit.centroid_m + b.fit.centroid_m) * 0.5;
    let noise = &scene.campaign.trajectory.noise;
    let gap = (a.time_s - b.time_s).abs() / noise.drift_correlation_time_s;
    let drift = -2.0 * noise.position_drift_m.powi(2) * (-gap).exp_m1();
    let scanner = scene.campaign.scanner_sigma.map_or(0.0, |s| {
        (s.rotation_rad.amax() * 10.0).hypot(s.lever_arm_m.amax())
    });
    let heading = std::f64::consts::SQRT_2 * 10.0 * noise.heading_drift_rad;
    let spread = |pass: &PassPlane| pass.fit.sigma_at_m(&middle, pass.fit.point_sigma_m());
    let sigma_m =
        (drift + 2.0 * scanner.powi(2) + heading.powi(2) + spread(a).powi(2) + spread(b).powi(2))
            .sqrt();
    let apart_m = (a.fit.plane.distance_m(&middle) - b.fit.plane.distance_m(&middle)).abs();
    Disagreement {
        group: scene.target.groups[group].name.clone(),
        apart_m,
        sigma_m: sigma_m.max(0.003),
        passes,
    }
}
