//! The scanner's planes: extracted from the laser returns by RANSAC and a robust fit, checked between passes.

use nalgebra::{DMatrix, DVector, Vector3};

use super::scene::Scene;
use super::ties::TieSet;
use crate::geometry::plane::{Plane, PlaneFit, PlaneMoments};
use crate::geometry::ransac::{ExpectedNormal, PlaneSearch, find_plane};
use crate::matching::Patches;
use crate::math;
use crate::stats::ChiSquare;
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
    math::hypot(
        math::hypot(math::hypot(laser.range_m, angle_m), trajectory.position_m),
        trajectory.position_drift_m,
    )
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

/// Probability that good data are refused because the passes seem to disagree, per survey. A
/// scanner turned by 1 deg moves an inclined face 4 m further away by 5 cm, 4.6 sigmas of a 1 cm drift: smaller probabilities miss it.
const FALSE_REFUSAL: f64 = 1e-4;
/// Independent error of a pass's plane beside its noise, metres: faces off their common plane, of which each pass sees others.
const FLOOR_M: f64 = 0.003 * std::f64::consts::FRAC_1_SQRT_2;
/// Distance at which an angle of scanner or heading displaces the target, metres.
const REACH_M: f64 = 10.0;

/// The plane that one pass of the scanner gives by itself.
struct PassPlane {
    group: usize,
    /// Mean time of its returns, seconds.
    time_s: f64,
    /// Distance from the middle of all passes' returns on the group, along the group's normal, metres.
    away_m: f64,
    /// Standard deviation of that distance from the returns' noise, metres.
    spread_m: f64,
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

/// Compares the upright planes that each pass of the scanner gives by itself; the horizontal faces are seen too obliquely. Returns
/// the worst pair where the trajectory's drift and the scanner's stated uncertainty do not explain the differences: a scanner that
/// is not calibrated after all.
///
/// One chi-square test of all differences together, at a probability of one false refusal in 10 000 surveys: drift moves
/// all planes of a pass alike, so that planes of several directions prove more than each by itself.
#[must_use]
pub fn disagreement(scene: &Scene, ties: &TieSet) -> Option<Disagreement> {
    let upright = |role| matches!(role, Role::P1 | Role::P2 | Role::P3);
    let groups = scene.target.groups.iter().enumerate();
    let seen: Vec<PassPlane> = groups
        .filter(|(_, g)| upright(g.role))
        .flat_map(|(group, _)| pass_planes(scene, ties, group))
        .collect();
    let covariance = covariance(scene, &seen);
    let differences = differences(&seen);
    let statistic = statistic(&seen, &covariance, &differences)?;
    (statistic > limit(differences.len())?).then(|| worst_pair(scene, &seen, &covariance))?
}

/// Quantile of chi-square that good data exceed with probability [`FALSE_REFUSAL`].
fn limit(differences: usize) -> Option<f64> {
    let chi = ChiSquare::new(differences as f64)?;
    Some(chi.quantile(1.0 - FALSE_REFUSAL))
}

/// Each plane with the first pass's of its group.
fn differences(seen: &[PassPlane]) -> Vec<(usize, usize)> {
    let first = |k: usize| seen.iter().position(|s| s.group == seen[k].group);
    let pairs = (0..seen.len()).filter_map(|k| Some((first(k)?, k)));
    pairs.filter(|(first, k)| first < k).collect()
}

/// Covariance of the planes' distances: drift is one vector for all planes, correlated in time; the rest is independent.
fn covariance(scene: &Scene, seen: &[PassPlane]) -> DMatrix<f64> {
    let noise = &scene.campaign.trajectory.noise;
    let scanner_m = scene.campaign.scanner_sigma.map_or(0.0, |s| {
        math::hypot(s.rotation_rad.amax() * REACH_M, s.lever_arm_m.amax())
    });
    let own_m2 = scanner_m.powi(2) + (REACH_M * noise.heading_drift_rad).powi(2) + FLOOR_M.powi(2);
    let normal = |k: usize| scene.target.groups[seen[k].group].normal;
    DMatrix::from_fn(seen.len(), seen.len(), |i, j| {
        if i == j {
            return noise.position_drift_m.powi(2) + own_m2 + seen[i].spread_m.powi(2);
        }
        let gap = (seen[i].time_s - seen[j].time_s).abs() / noise.drift_correlation_time_s;
        noise.position_drift_m.powi(2) * math::exp(-gap) * normal(i).dot(&normal(j))
    })
}

/// Sum of squares of the differences, weighted with their covariance: chi-square distributed for good data.
fn statistic(
    seen: &[PassPlane],
    covariance: &DMatrix<f64>,
    differences: &[(usize, usize)],
) -> Option<f64> {
    let n = differences.len();
    let apart = DVector::from_fn(n, |k, _| {
        let (a, b) = differences[k];
        seen[b].away_m - seen[a].away_m
    });
    let of_differences = DMatrix::from_fn(n, n, |k, l| {
        let ((a, b), (c, d)) = (differences[k], differences[l]);
        covariance[(b, d)] - covariance[(b, c)] - covariance[(a, d)] + covariance[(a, c)]
    });
    let factor = of_differences.cholesky()?;
    Some(apart.dot(&factor.solve(&apart)))
}

/// The two passes of one group that differ most, in their own sigma.
fn worst_pair(
    scene: &Scene,
    seen: &[PassPlane],
    covariance: &DMatrix<f64>,
) -> Option<Disagreement> {
    let pairs = (0..seen.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let same = pairs.filter(|&(a, b)| seen[a].group == seen[b].group);
    let described = same.map(|(a, b)| Disagreement {
        group: scene.target.groups[seen[a].group].name.clone(),
        apart_m: (seen[a].away_m - seen[b].away_m).abs(),
        sigma_m: (covariance[(a, a)] + covariance[(b, b)] - 2.0 * covariance[(a, b)]).sqrt(),
        passes: seen.iter().filter(|s| s.group == seen[a].group).count(),
    });
    described.max_by(|a, b| (a.apart_m / a.sigma_m).total_cmp(&(b.apart_m / b.sigma_m)))
}

/// The planes of a group that the passes give, in order of time.
fn pass_planes(scene: &Scene, ties: &TieSet, group: usize) -> Vec<PassPlane> {
    let points = group_points(scene, ties, group);
    let fits: Vec<(f64, PlaneFit)> = split_passes(&points)
        .into_iter()
        .filter_map(|pass| robust_pass(scene, group, pass))
        .collect();
    let middle_m = fits.iter().map(|(_, f)| f.centroid_m).sum::<Vector3<f64>>() / fits.len() as f64;
    let pass = |(time_s, fit): &(f64, PlaneFit)| PassPlane {
        group,
        time_s: *time_s,
        away_m: fit.plane.distance_m(&middle_m),
        spread_m: fit.sigma_at_m(&middle_m, fit.point_sigma_m()),
    };
    fits.iter().map(pass).collect()
}

fn split_passes(points: &[(f64, Vector3<f64>)]) -> Vec<&[(f64, Vector3<f64>)]> {
    let passes = points.chunk_by(|a, b| b.0 - a.0 <= PASS_GAP_S);
    passes.filter(|pass| pass.len() >= 200).collect()
}

/// Mean time and plane of one pass's returns; `None` where they do not settle on one.
fn robust_pass(
    scene: &Scene,
    group: usize,
    points: &[(f64, Vector3<f64>)],
) -> Option<(f64, PlaneFit)> {
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
    settled.then(|| (time_s, found.fit.towards(&normal)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_survey_in_ten_thousand_is_refused_by_chance() {
        // one difference: the normal quantile Q(3.89059) = 5e-5 (Abramowitz and Stegun, table 26.5), squared
        assert!((limit(1).expect("a limit").sqrt() - 3.890_59).abs() < 1e-4);
        assert_eq!(limit(0), None);
    }

    /// Two passes whose planes P1 and P3 moved by one drift: the statistic is that of the drift, not of each plane.
    #[test]
    fn planes_that_move_together_count_once() {
        let pass = |group, away_m| PassPlane {
            group,
            time_s: 0.0,
            away_m,
            spread_m: 0.0,
        };
        let seen = [pass(0, 0.0), pass(0, 0.05), pass(1, 0.0), pass(1, 0.05)];
        let pairs = differences(&seen);
        assert_eq!(pairs, [(0, 1), (2, 3)]);
        let apart = |common: f64| {
            let c = DMatrix::from_fn(4, 4, |i, j| match (i == j, i % 2 == j % 2) {
                (true, _) => 1e-4,
                (false, true) => common * 1e-4,
                (false, false) => 0.0,
            });
            statistic(&seen, &c, &pairs).expect("a statistic")
        };
        // alone: each 0.05^2 / 2e-4 = 12.5; moved as one, (1 + 0.99) as uncertain together
        assert!((apart(0.0) - 25.0).abs() < 1e-9);
        assert!((apart(0.99) - 25.0 / 1.99).abs() < 1e-9);
        assert!((apart(-0.99) - 25.0 / 0.01).abs() < 1e-6);
    }
}
