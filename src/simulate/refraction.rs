//! Bent rays: the ray equation integrated step by step, so that nothing is shared with the estimator's closed form.

use nalgebra::Vector3;

use super::scene::{BLANKING_M, Hit, Ray, Surface};
use crate::observe::SoundSpeedProfile;

/// Length of a step, metres; the midpoint rule's error is below a micrometre at 10 m for gradients of 1/s.
const STEP_M: f64 = 0.1;

/// One-way travel time to the surface that a ray hit, and the cosine at which it struck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Path {
    /// One-way travel time, seconds.
    pub(super) time_s: f64,
    /// Cosine between ray and normal.
    pub(super) cosine: f64,
    /// What was hit.
    pub(super) surface: Surface,
}

/// Follows a ray until it hits something; `None` when it leaves the water or comes to `limit_m` first.
///
/// Ray equation: `d(direction)/ds = -(grad c - (grad c . direction) direction) / c`.
pub(super) fn trace(
    water: &SoundSpeedProfile,
    level_m: f64,
    start: &Ray,
    limit_m: f64,
    cast: impl Fn(&Ray) -> Option<Hit>,
) -> Option<Path> {
    let mut ray = *start;
    let mut time_s = 0.0;
    let turn = |at: &Vector3<f64>, direction: &Vector3<f64>| {
        let (speed, per_metre) = speed_and_gradient(water, level_m - at.z);
        let gradient = Vector3::new(0.0, 0.0, -per_metre);
        (
            speed,
            (direction * gradient.dot(direction) - gradient) / speed,
        )
    };
    // speed, bend and the direction of the chord of the next `step_m`
    let middle = |ray: &Ray, step_m: f64| {
        let (_, bend) = turn(&ray.origin_m, &ray.direction);
        let half = (ray.direction + bend * (0.5 * step_m)).normalize();
        let (speed, bend) = turn(&(ray.origin_m + half * (0.5 * step_m)), &half);
        let chord = Ray {
            origin_m: ray.origin_m,
            direction: half,
        };
        (speed, bend, chord)
    };
    for _ in 0..(limit_m / STEP_M) as usize {
        let (speed, bend, chord) = middle(&ray, STEP_M);
        // beyond the step too: what the next one begins in front of, it would not see
        if let Some(hit) = cast(&chord).filter(|hit| hit.range_m <= STEP_M + BLANKING_M) {
            let (speed, _, shorter) = middle(&ray, hit.range_m);
            let hit = cast(&shorter).unwrap_or(hit);
            return Some(Path {
                time_s: time_s + hit.range_m / speed,
                cosine: hit.cosine,
                surface: hit.surface,
            });
        }
        ray.origin_m += chord.direction * STEP_M;
        ray.direction = (ray.direction + bend * STEP_M).normalize();
        time_s += STEP_M / speed;
        if ray.origin_m.z >= level_m {
            return None;
        }
    }
    None
}

/// How far a bent ray can be from the straight one at this range while it stays above a depth, metres.
pub(super) fn largest_bend_m(water: &SoundSpeedProfile, range_m: f64, deepest_m: f64) -> f64 {
    let within = water.depth_m.iter().filter(|d| **d < deepest_m);
    let ends = within.copied().chain([0.0, deepest_m]);
    let (mut steepest, mut slowest) = (0.0_f64, f64::INFINITY);
    for depth_m in ends {
        let (speed, per_metre) = speed_and_gradient(water, depth_m);
        steepest = steepest.max(per_metre.abs());
        slowest = slowest.min(speed);
    }
    range_m * range_m * steepest / (2.0 * slowest)
}

/// Speed (metres per second) and its change per metre of depth; constant above the first and below the last sample.
pub(crate) fn speed_and_gradient(water: &SoundSpeedProfile, depth_m: f64) -> (f64, f64) {
    let below = water.depth_m.partition_point(|&d| d <= depth_m);
    let last = water.depth_m.len() - 1;
    if below == 0 {
        return (water.speed_m_s[0], 0.0);
    }
    if below > last {
        return (water.speed_m_s[last], 0.0);
    }
    let (d0, d1) = (water.depth_m[below - 1], water.depth_m[below]);
    let (c0, c1) = (water.speed_m_s[below - 1], water.speed_m_s[below]);
    let gradient = (c1 - c0) / (d1 - d0);
    (c0 + gradient * (depth_m - d0), gradient)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn water(depth_m: &[f64], speed_m_s: &[f64]) -> SoundSpeedProfile {
        SoundSpeedProfile {
            depth_m: depth_m.to_vec(),
            speed_m_s: speed_m_s.to_vec(),
        }
    }

    /// By hand: `range^2 gradient / (2 slowest)`; what lies deeper than a ray comes does not count.
    #[test]
    fn the_bend_is_that_of_the_water_within_reach() {
        let falling = water(&[0.0, 12_000.0], &[1500.0, -900.0]);
        let bend_m = largest_bend_m(&falling, 50.0, 50.0);
        assert!(
            (bend_m - 2500.0 * 0.2 / (2.0 * 1490.0)).abs() < 1e-9,
            "{bend_m}"
        );
        let layered = water(&[0.0, 10.0, 20.0, 30.0], &[1500.0, 1501.0, 1503.0, 1400.0]);
        for (deepest_m, gradient, slowest) in [
            (5.0, 0.1, 1500.0),
            (15.0, 0.2, 1500.0),
            (25.0, 10.3, 1451.5),
            (90.0, 10.3, 1400.0),
        ] {
            let found = largest_bend_m(&layered, 10.0, deepest_m);
            let expected = 100.0 * gradient / (2.0 * slowest);
            assert!(
                (found - expected).abs() < 1e-9,
                "{deepest_m}: {found} {expected}"
            );
        }
    }
}
