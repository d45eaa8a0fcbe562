//! Seeded random sample consensus for a plane among points with outliers (Fischler and Bolles 1981), with samples from
//! a neighbourhood (NAPSAC, Myatt et al. 2002), a truncated quadratic score (MSAC, Torr and Zisserman 2000) and refits
//! of every new best plane (LO-RANSAC, Chum et al. 2003).
//!
//! One thread, one generator: the same points, search and seed give the same plane.

use nalgebra::Vector3;
use rand::{RngExt, seq::index};
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use super::plane::{Plane, PlaneError, PlaneFit, PlaneMoments};
use crate::math;
use crate::stats;

/// Fewest trials before the adaptive stop may act.
const LEAST_TRIALS: usize = 60;
/// Refits of a new best plane on the scoring sample, and of the last one on all points.
const REFITS: usize = 4;
/// Smallest sine of the angle at a minimal sample's corner.
const LEAST_SINE: f64 = 0.1;

/// Only planes whose normal lies near an expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedNormal {
    /// Expected unit normal; the found normal points to its side.
    pub normal: Vector3<f64>,
    /// Largest angle from it, radians.
    pub within_rad: f64,
}

/// Only planes that pass near a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedOffset {
    /// Where the offset is looked at, metres.
    pub at_m: Vector3<f64>,
    /// Smallest distance of the plane from `at_m` along its (oriented) normal, metres.
    pub low_m: f64,
    /// Largest distance of the plane from `at_m` along its (oriented) normal, metres.
    pub high_m: f64,
}

/// What to look for, and how hard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSearch {
    /// Largest distance of an inlier, metres (about 3 sigma of the points).
    pub tolerance_m: f64,
    /// Fewest inliers of an acceptable plane.
    pub least_inliers: usize,
    /// Size of the neighbourhood from which every second minimal sample is drawn, metres; `None`: always anywhere.
    pub neighbourhood_m: Option<f64>,
    /// Constraint on the normal.
    pub normal: Option<ExpectedNormal>,
    /// Constraint on the offset.
    pub offset: Option<ExpectedOffset>,
    /// Probability of having drawn at least one clean sample when the search stops.
    pub confidence: f64,
    /// Most trials.
    pub max_trials: usize,
    /// Points against which a trial is scored; the result is refitted on all.
    pub scoring_sample: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for PlaneSearch {
    fn default() -> Self {
        Self {
            tolerance_m: 0.03,
            least_inliers: 30,
            neighbourhood_m: Some(0.5),
            normal: None,
            offset: None,
            confidence: 0.9999,
            max_trials: 5000,
            scoring_sample: 2000,
            seed: 1,
        }
    }
}

/// A plane found among points.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundPlane {
    /// Least-squares fit to the inliers.
    pub fit: PlaneFit,
    /// Indices of the inliers, ascending.
    pub inliers: Vec<u32>,
    /// Trials done.
    pub trials: usize,
}

/// Why no plane was found.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RansacError {
    /// Not enough points to start with.
    #[error("{found} points, expected at least {expected} for a plane")]
    TooFew {
        /// Number of points.
        found: usize,
        /// Number needed.
        expected: usize,
    },
    /// No plane that meets the constraints gathers enough points.
    #[error(
        "the best plane after {trials} trials holds {found} of {points} points, expected at least {expected}"
    )]
    NoConsensus {
        /// Inliers of the best admissible plane.
        found: usize,
        /// Number needed.
        expected: usize,
        /// Number of points searched.
        points: usize,
        /// Trials done.
        trials: usize,
    },
    /// The inliers do not span a plane.
    #[error("the points of the best plane: {0}")]
    Degenerate(#[from] PlaneError),
}

/// The plane with the best score among `points_m` (metres).
///
/// # Errors
/// [`RansacError`] when too few points agree on an admissible plane.
pub fn find_plane(
    points_m: &[Vector3<f64>],
    search: &PlaneSearch,
) -> Result<FoundPlane, RansacError> {
    let expected = search.least_inliers.max(3);
    if points_m.len() < expected {
        return Err(RansacError::TooFew {
            found: points_m.len(),
            expected,
        });
    }
    let mut generator = stats::stream(search.seed, 0);
    let scored = scoring_points(points_m, search.scoring_sample, &mut generator);
    let sampler = Sampler::new(points_m, search.neighbourhood_m);
    let (best, trials) = best_plane(&sampler, &scored, search, &mut generator);
    let none = |found| RansacError::NoConsensus {
        found,
        expected,
        points: points_m.len(),
        trials,
    };
    let fit = refitted(points_m, best.ok_or(none(0))?, search)?;
    let inliers = inliers(points_m, &fit.plane, search.tolerance_m);
    if inliers.len() < expected || !admissible(&fit.plane, search) {
        return Err(none(inliers.len()));
    }
    Ok(FoundPlane {
        fit,
        inliers,
        trials,
    })
}

/// Up to `most` planes, the best first, each searched among the points the earlier ones left.
#[must_use]
pub fn find_planes(
    points_m: &[Vector3<f64>],
    search: &PlaneSearch,
    most: usize,
) -> Vec<FoundPlane> {
    let mut left: Vec<u32> = (0..points_m.len() as u32).collect();
    let mut found = vec![];
    while found.len() < most {
        let points: Vec<_> = left.iter().map(|k| points_m[*k as usize]).collect();
        let Ok(mut plane) = find_plane(&points, search) else {
            break;
        };
        for k in &mut plane.inliers {
            *k = left[*k as usize];
        }
        left.retain(|k| plane.inliers.binary_search(k).is_err());
        found.push(plane);
    }
    found
}

/// Draws minimal samples until a clean one is as good as certain; the best plane by score, and the trials.
fn best_plane(
    sampler: &Sampler<'_>,
    scored: &[Vector3<f64>],
    search: &PlaneSearch,
    generator: &mut ChaCha8Rng,
) -> (Option<Plane>, usize) {
    let (mut best, mut best_score, mut needed) = (None, 0.0, search.max_trials);
    let mut trial = 0;
    while trial < needed {
        let sample = sampler.draw(trial % 2 == 0, generator);
        trial += 1;
        let Some(plane) = sample.and_then(|s| through_three(&s, search)) else {
            continue;
        };
        if score(scored, &plane, search.tolerance_m) > best_score {
            let plane = locally_optimised(scored, plane, search);
            best_score = score(scored, &plane, search.tolerance_m);
            best = Some(plane);
            needed = trials_needed(scored, &plane, search);
        }
    }
    (best, trial)
}

/// `log(1 - confidence) / log(1 - w^3)` with the share w of inliers, within its bounds.
fn trials_needed(scored: &[Vector3<f64>], plane: &Plane, search: &PlaneSearch) -> usize {
    let within = scored
        .iter()
        .filter(|p| plane.distance_m(p).abs() <= search.tolerance_m)
        .count();
    let share = within as f64 / scored.len() as f64;
    let trials = math::ln(1.0 - search.confidence) / math::ln_1p(-share.powi(3));
    (trials.ceil() as usize).clamp(LEAST_TRIALS.min(search.max_trials), search.max_trials)
}

/// Sum of 1 - (distance/tolerance)^2 over the points within the tolerance.
fn score(points_m: &[Vector3<f64>], plane: &Plane, tolerance_m: f64) -> f64 {
    let per_square = 1.0 / (tolerance_m * tolerance_m);
    points_m
        .iter()
        .map(|p| (1.0 - plane.distance_m(p).powi(2) * per_square).max(0.0))
        .sum()
}

/// Refits on the scoring points, from a doubled tolerance down, as long as the score grows.
fn locally_optimised(scored: &[Vector3<f64>], start: Plane, search: &PlaneSearch) -> Plane {
    let (mut best, mut best_score) = (start, score(scored, &start, search.tolerance_m));
    let mut current = start;
    for step in 0..REFITS {
        let tolerance = search.tolerance_m * (2.0 - step as f64 / (REFITS - 1) as f64);
        let Ok(fit) = fit_within(scored, &current, tolerance) else {
            break;
        };
        current = oriented(fit.plane, &start, search);
        let score = score(scored, &current, search.tolerance_m);
        if score > best_score && admissible(&current, search) {
            (best, best_score) = (current, score);
        }
    }
    best
}

/// Refits on all points until the inliers no longer change the plane.
fn refitted(
    points_m: &[Vector3<f64>],
    start: Plane,
    search: &PlaneSearch,
) -> Result<PlaneFit, PlaneError> {
    let mut fit = fit_within(points_m, &start, search.tolerance_m)?;
    for _ in 0..REFITS {
        fit = fit_within(points_m, &fit.plane, search.tolerance_m)?;
    }
    let plane = oriented(fit.plane, &start, search);
    Ok(fit.towards(&plane.normal))
}

fn fit_within(
    points_m: &[Vector3<f64>],
    plane: &Plane,
    tolerance_m: f64,
) -> Result<PlaneFit, PlaneError> {
    let mut moments = PlaneMoments::default();
    for point in points_m
        .iter()
        .filter(|p| plane.distance_m(p).abs() <= tolerance_m)
    {
        moments.add(point);
    }
    moments.fit()
}

fn inliers(points_m: &[Vector3<f64>], plane: &Plane, tolerance_m: f64) -> Vec<u32> {
    let near = |p: &Vector3<f64>| plane.distance_m(p).abs() <= tolerance_m;
    (0u32..)
        .zip(points_m)
        .filter(|(_, p)| near(p))
        .map(|(k, _)| k)
        .collect()
}

fn oriented(plane: Plane, like: &Plane, search: &PlaneSearch) -> Plane {
    plane.towards(&search.normal.map_or(like.normal, |n| n.normal))
}

fn admissible(plane: &Plane, search: &PlaneSearch) -> bool {
    let normal = search.normal.is_none_or(|n| {
        math::atan2(
            plane.normal.cross(&n.normal).norm(),
            plane.normal.dot(&n.normal),
        ) <= n.within_rad
    });
    let offset = search
        .offset
        .is_none_or(|o| (o.low_m..=o.high_m).contains(&-plane.distance_m(&o.at_m)));
    normal && offset
}

/// The plane through a minimal sample, if it is well shaped and admissible.
fn through_three(sample: &[Vector3<f64>; 3], search: &PlaneSearch) -> Option<Plane> {
    let (a, b) = (sample[1] - sample[0], sample[2] - sample[0]);
    let area = a.cross(&b);
    if !(area.norm() > LEAST_SINE * a.norm() * b.norm()) {
        return None;
    }
    let plane = Plane::through(area.normalize(), &sample[0]);
    let plane = oriented(plane, &plane, search);
    admissible(&plane, search).then_some(plane)
}

fn scoring_points(
    points_m: &[Vector3<f64>],
    most: usize,
    generator: &mut ChaCha8Rng,
) -> Vec<Vector3<f64>> {
    if points_m.len() <= most {
        return points_m.to_vec();
    }
    let mut chosen = index::sample(generator, points_m.len(), most.max(3)).into_vec();
    chosen.sort_unstable();
    chosen.into_iter().map(|k| points_m[k]).collect()
}

type Cell = [i64; 3];

/// Draws minimal samples: anywhere, or from the cells of a grid around a first point.
struct Sampler<'a> {
    points_m: &'a [Vector3<f64>],
    cell_m: Option<f64>,
    /// Cell and index of every point, sorted.
    cells: Vec<(Cell, u32)>,
}

impl<'a> Sampler<'a> {
    fn new(points_m: &'a [Vector3<f64>], cell_m: Option<f64>) -> Self {
        let mut cells: Vec<(Cell, u32)> = cell_m.map_or_else(Vec::new, |size| {
            (0u32..)
                .zip(points_m)
                .map(|(k, p)| (cell_of(p, size), k))
                .collect()
        });
        cells.sort_unstable();
        Self {
            points_m,
            cell_m,
            cells,
        }
    }

    fn draw(&self, near: bool, generator: &mut ChaCha8Rng) -> Option<[Vector3<f64>; 3]> {
        let first = self.anywhere(generator);
        match self.cell_m {
            Some(size) if near => {
                let second = self.near(&first, size, generator)?;
                Some([first, second, self.near(&first, size, generator)?])
            }
            _ => Some([first, self.anywhere(generator), self.anywhere(generator)]),
        }
    }

    fn anywhere(&self, generator: &mut ChaCha8Rng) -> Vector3<f64> {
        self.points_m[generator.random_range(0..self.points_m.len())]
    }

    /// A point of the cell that a random step of up to one cell size hits; a few steps are tried.
    fn near(
        &self,
        around: &Vector3<f64>,
        size: f64,
        generator: &mut ChaCha8Rng,
    ) -> Option<Vector3<f64>> {
        for _ in 0..8 {
            let step = Vector3::from_fn(|_, _| generator.random_range(-size..=size));
            let cell = cell_of(&(around + step), size);
            let start = self.cells.partition_point(|(c, _)| *c < cell);
            let end = self.cells.partition_point(|(c, _)| *c <= cell);
            if end > start {
                let (_, k) = self.cells[generator.random_range(start..end)];
                return Some(self.points_m[k as usize]);
            }
        }
        None
    }
}

fn cell_of(point_m: &Vector3<f64>, size_m: f64) -> Cell {
    [0, 1, 2].map(|axis| (point_m[axis] / size_m).floor() as i64)
}
