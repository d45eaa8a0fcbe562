//! Coarse fit of a profile to the standard profile: iterative closest points (patent, claims 2 and 3).
//!
//! The patent's `T_coarse` minimises `J(T) = sum |p_i - (R q_i + t)|^2` over pairs of nearest points. A profile and the cross-section are
//! planes, so T is a turn about the rail's axis and a shift. Pairs further apart than three robust sigmas are left out of a step.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Vector2;

use super::profile::RailProfile;
use crate::math;
use crate::stats::mad_sigma;

/// Pairs nearer than this are never left out, metres.
const ALWAYS_M: f64 = 2e-4;
/// A step that turns (radians) and shifts (metres) by less ends the fit.
const STILL: f64 = 1e-8;

/// A turn about the rail's axis, positive as roll is (right side down), and a shift: `(x, z) = Rot (s, t) + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// Turn, radians.
    pub roll_rad: f64,
    /// Shift, metres.
    pub shift_m: Vector2<f64>,
}

/// Turns a plane vector as roll does: `x' = x cos + z sin`, `z' = -x sin + z cos`.
#[must_use]
pub fn rolled(roll_rad: f64, p: &Vector2<f64>) -> Vector2<f64> {
    let (s, c) = math::sin_cos(roll_rad);
    Vector2::new(p.x * c + p.y * s, -p.x * s + p.y * c)
}

impl Rigid {
    /// A point of the profile in the cross-section, metres.
    #[must_use]
    pub fn apply(&self, p: &Vector2<f64>) -> Vector2<f64> {
        rolled(self.roll_rad, p) + self.shift_m
    }

    /// This transform, then a turn about a place and a shift that carries the place to another.
    #[must_use]
    pub fn then(&self, roll_rad: f64, from_m: &Vector2<f64>, to_m: &Vector2<f64>) -> Self {
        Self {
            roll_rad: self.roll_rad + roll_rad,
            shift_m: to_m + rolled(roll_rad, &(self.shift_m - from_m)),
        }
    }
}

/// The standard profile as points in a k-d tree.
pub struct Cloud {
    points: Vec<[f64; 2]>,
    tree: ImmutableKdTree<f64, 2>,
}

impl Cloud {
    /// Points of the profile at a spacing, metres; `None` when there are none.
    #[must_use]
    pub fn new(rail: &RailProfile, spacing_m: f64) -> Option<Self> {
        let points: Vec<[f64; 2]> = rail
            .elements
            .iter()
            .flat_map(|e| e.samples(spacing_m))
            .map(|p| [p.x, p.y])
            .collect();
        let tree = ImmutableKdTree::new_from_slice(&points).ok()?;
        (!points.is_empty()).then_some(Self { points, tree })
    }

    fn nearest(&self, p: &Vector2<f64>) -> Vector2<f64> {
        let found = self
            .tree
            .query(&[p.x, p.y])
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        Vector2::from(self.points[found.item as usize])
    }
}

/// Fits a profile to the cloud from a start; at most `max_steps` steps.
#[must_use]
pub fn fit(cloud: &Cloud, profile: &[Vector2<f64>], start: Rigid, max_steps: u32) -> Rigid {
    let mut transform = start;
    for _ in 0..max_steps {
        let moved: Vec<_> = profile.iter().map(|p| transform.apply(p)).collect();
        let pairs: Vec<_> = moved.iter().map(|p| (*p, cloud.nearest(p))).collect();
        let Some((roll, from, to)) = step(&pairs) else {
            return transform;
        };
        let next = transform.then(roll, &from, &to);
        let shift = (to - from).norm();
        transform = next;
        if roll.abs() < STILL && shift < STILL {
            break;
        }
    }
    transform
}

/// Least squares of the pairs: turn about the mean of the measured points, which goes to the mean of their partners.
fn step(pairs: &[(Vector2<f64>, Vector2<f64>)]) -> Option<(f64, Vector2<f64>, Vector2<f64>)> {
    let mut gaps: Vec<f64> = pairs.iter().map(|(p, q)| (q - p).norm()).collect();
    let limit =
        (3.0 * mad_sigma(&mut gaps.clone())? + crate::stats::median(&mut gaps)?).max(ALWAYS_M);
    let near: Vec<_> = pairs
        .iter()
        .filter(|(p, q)| (q - p).norm() <= limit)
        .collect();
    if near.len() < 3 {
        return None;
    }
    let n = near.len() as f64;
    let from = near.iter().map(|pair| pair.0).sum::<Vector2<f64>>() / n;
    let to = near.iter().map(|pair| pair.1).sum::<Vector2<f64>>() / n;
    let (mut dot, mut cross) = (0.0, 0.0);
    for (p, q) in near {
        let (a, b) = (p - from, q - to);
        dot += a.dot(&b);
        cross += a.y * b.x - a.x * b.y;
    }
    Some((math::atan2(cross, dot), from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A noise-free half of the head and web, turned by 2 degrees and shifted by 2 mm, comes back to the clouds' spacing.
    #[test]
    fn a_moved_profile_comes_back() {
        let rail = RailProfile::built_in("chn60").expect("a rail");
        let cloud = Cloud::new(&rail, 1e-4).expect("points");
        let truth = Rigid {
            roll_rad: 0.035,
            shift_m: Vector2::new(0.002, -0.0015),
        };
        let seen = rail.elements[16..28].iter().flat_map(|e| e.samples(3.3e-4));
        let back = |p: Vector2<f64>| rolled(-truth.roll_rad, &(p - truth.shift_m));
        let profile: Vec<_> = seen.map(back).collect();
        let found = fit(
            &cloud,
            &profile,
            Rigid {
                roll_rad: 0.0,
                shift_m: Vector2::zeros(),
            },
            500,
        );
        assert!((found.roll_rad - truth.roll_rad).abs() < 1e-3, "{found:?}");
        assert!((found.shift_m - truth.shift_m).norm() < 1e-4, "{found:?}");
    }

    #[test]
    fn a_turn_about_a_place_carries_it() {
        let first = Rigid {
            roll_rad: 0.3,
            shift_m: Vector2::new(1.0, 2.0),
        };
        let (from, to) = (Vector2::new(0.4, -0.2), Vector2::new(0.5, 0.5));
        let both = first.then(0.2, &from, &to);
        let p = Vector2::new(0.7, 0.1);
        let slow = to + rolled(0.2, &(first.apply(&p) - from));
        assert!((both.apply(&p) - slow).norm() < 1e-15);
    }
}
