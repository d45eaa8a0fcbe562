//! Gross errors before everything else: each line's soundings against a robust surface of their surroundings.
//!
//! The window is wider than a school of fish or a burst of bad pings, so that the bad soundings cannot be its majority.

use std::collections::BTreeMap;

use nalgebra::{SMatrix, SVector, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use super::tiles::Cell;
use crate::stats::{mad_sigma, stream};

/// Settings of the screen; lengths for a depth of 15 m, longer in proportion where it is deeper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// Side of a cell, metres; the window is three by three.
    pub cell_m: f64,
    /// Squared distances from the plane are cut off here, metres.
    pub truncate_m: f64,
    /// A sounding is dropped beyond this, metres, or beyond `sigmas`.
    pub least_m: f64,
    /// A sounding is dropped beyond so many sigmas of its surroundings.
    pub sigmas: f64,
    /// Cells whose window has fewer soundings are dropped.
    pub fewest: usize,
}

impl Screen {
    /// For a typical depth, metres.
    #[must_use]
    pub fn for_depth(depth_m: f64) -> Self {
        let scale = super::tiles::depth_scale(depth_m);
        Self {
            cell_m: 10.0 * scale,
            truncate_m: 0.35 * scale,
            least_m: 0.30 * scale,
            sigmas: 5.0,
            fewest: 30,
        }
    }

    /// Marks the soundings of one strip to be kept; `points_m` are theirs, `None` where there is none.
    #[must_use]
    pub fn keep(&self, points_m: &[Option<Vector3<f64>>], seed: u64) -> Vec<bool> {
        let mut cells: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
        for (k, point) in points_m.iter().enumerate() {
            if let Some(point) = point {
                cells
                    .entry(Cell::of(point, self.cell_m))
                    .or_default()
                    .push(k);
            }
        }
        let kept: Vec<Vec<usize>> = cells
            .par_iter()
            .map(|(cell, own)| self.keep_cell(points_m, &cells, *cell, own, seed))
            .collect();
        let mut keep = vec![false; points_m.len()];
        for k in kept.into_iter().flatten() {
            keep[k] = true;
        }
        keep
    }

    fn keep_cell(
        &self,
        points_m: &[Option<Vector3<f64>>],
        cells: &BTreeMap<Cell, Vec<usize>>,
        cell: Cell,
        own: &[usize],
        seed: u64,
    ) -> Vec<usize> {
        let around: Vec<usize> = cell
            .neighbours()
            .filter_map(|c| cells.get(&c))
            .flatten()
            .copied()
            .collect();
        if around.len() < self.fewest {
            return vec![];
        }
        let stride = around.len().div_ceil(MOST_IN_WINDOW);
        let centre = cell.centre_m(self.cell_m);
        let relative = |k: usize| points_m[k].map(|p| p - centre);
        let window: Vec<Vector3<f64>> = around
            .iter()
            .step_by(stride)
            .filter_map(|k| relative(*k))
            .collect();
        let plane = ransac_plane(&window, self.truncate_m, TRIALS, cell.stream(seed));
        let surface = Surface::fit(&window, &plane, self.cell_m, 2.0 * self.truncate_m);
        let limit_m = self.least_m.max(self.sigmas * surface.sigma_m);
        own.iter()
            .copied()
            .filter(|k| relative(*k).is_some_and(|p| surface.off_m(&p).abs() <= limit_m))
            .collect()
    }
}

/// Most soundings of a window that its surface is fitted to.
const MOST_IN_WINDOW: usize = 400;
const TRIALS: usize = 200;

/// Height over a plane `z = a + b x + c y`.
pub(super) fn over_plane(plane: &Vector3<f64>, p: &Vector3<f64>) -> f64 {
    p.z - (plane.x + plane.y * p.x + plane.z * p.y)
}

/// The plane through three of the points with the least sum of truncated squares (MSAC: Torr and Zisserman, 2000).
pub(super) fn ransac_plane(
    points_m: &[Vector3<f64>],
    truncate_m: f64,
    trials: usize,
    stream_of: (u64, u64),
) -> Vector3<f64> {
    let mut draws = stream(stream_of.0, stream_of.1);
    let limit = truncate_m * truncate_m;
    let mut best = (f64::INFINITY, Vector3::zeros());
    for _ in 0..trials {
        let pick: [usize; 3] = [0, 1, 2].map(|_| draws.random_range(0..points_m.len()));
        let Some(plane) = plane_through(pick.map(|k| points_m[k])) else {
            continue;
        };
        let mut cost = 0.0;
        for p in points_m {
            cost += over_plane(&plane, p).powi(2).min(limit);
            if cost >= best.0 {
                break;
            }
        }
        if cost < best.0 {
            best = (cost, plane);
        }
    }
    best.1
}

fn plane_through([a, b, c]: [Vector3<f64>; 3]) -> Option<Vector3<f64>> {
    let normal = (b - a).cross(&(c - a));
    if normal.z.abs() < 0.2 * normal.norm() || normal.z == 0.0 {
        return None;
    }
    let (east, north) = (-normal.x / normal.z, -normal.y / normal.z);
    Some(Vector3::new(a.z - east * a.x - north * a.y, east, north))
}

/// A quadratic surface about the cell's centre, and how far good soundings lie from it.
struct Surface {
    coefficients: SVector<f64, 6>,
    scale_m: f64,
    sigma_m: f64,
}

impl Surface {
    /// Tukey's weights from the plane on, scale by the median absolute deviation of what lies near.
    fn fit(points_m: &[Vector3<f64>], plane: &Vector3<f64>, scale_m: f64, near_m: f64) -> Self {
        let mut surface = Self {
            coefficients: SVector::from_column_slice(&[
                plane.x,
                plane.y * scale_m,
                plane.z * scale_m,
                0.0,
                0.0,
                0.0,
            ]),
            scale_m,
            sigma_m: 0.0,
        };
        surface.sigma_m = surface.scale_of(points_m, near_m);
        for _ in 0..5 {
            let Some(next) = surface.reweighted(points_m) else {
                break;
            };
            surface.coefficients = next;
            surface.sigma_m = surface.scale_of(points_m, near_m);
        }
        surface
    }

    fn basis(&self, p: &Vector3<f64>) -> SVector<f64, 6> {
        let (u, v) = (p.x / self.scale_m, p.y / self.scale_m);
        SVector::from_column_slice(&[1.0, u, v, u * u, u * v, v * v])
    }

    fn off_m(&self, p: &Vector3<f64>) -> f64 {
        p.z - self.coefficients.dot(&self.basis(p))
    }

    fn scale_of(&self, points_m: &[Vector3<f64>], near_m: f64) -> f64 {
        let mut near: Vec<f64> = points_m
            .iter()
            .map(|p| self.off_m(p))
            .filter(|off| off.abs() < near_m)
            .collect();
        mad_sigma(&mut near).unwrap_or(0.0).max(1e-3)
    }

    fn reweighted(&self, points_m: &[Vector3<f64>]) -> Option<SVector<f64, 6>> {
        let width = 4.685 * self.sigma_m;
        let (mut normal, mut right) = (SMatrix::<f64, 6, 6>::zeros(), SVector::<f64, 6>::zeros());
        for p in points_m {
            let x = self.off_m(p) / width;
            if x.abs() >= 1.0 {
                continue;
            }
            let (weight, row) = ((1.0 - x * x).powi(2), self.basis(p));
            normal += row * row.transpose() * weight;
            right += row * (weight * p.z);
        }
        // a hair of ridge keeps the curvature of a narrow window at zero
        for k in 3..6 {
            normal[(k, k)] += 1e-6 * normal[(0, 0)].max(1e-12);
        }
        normal.cholesky().map(|factor| factor.solve(&right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bed(gross: impl Fn(usize) -> f64) -> Vec<Option<Vector3<f64>>> {
        let at = |k: usize| {
            let (x, y) = ((k % 60) as f64 * 0.5, (k / 60) as f64 * 0.5);
            let z = -14.0 + 0.1 * x - 0.002 * y * y + 0.01 * ((k * 7919) % 13) as f64 / 13.0;
            Some(Vector3::new(x, y, z + gross(k)))
        };
        (0..3600).map(at).collect()
    }

    #[test]
    fn a_school_of_fish_goes_and_the_bed_stays() {
        let fish = |k: usize| k % 60 > 10 && k % 60 < 18 && (600..1500).contains(&k);
        let points = bed(|k| if fish(k) { 1.2 } else { 0.0 });
        let keep = Screen::for_depth(14.0).keep(&points, 1);
        let kept_fish = (0..points.len()).filter(|k| fish(*k) && keep[*k]).count();
        let lost_bed = (0..points.len()).filter(|k| !fish(*k) && !keep[*k]).count();
        assert_eq!((kept_fish, lost_bed), (0, 0));
    }

    #[test]
    fn a_place_with_few_soundings_is_dropped() {
        let points: Vec<_> = bed(|_| 0.0).into_iter().step_by(200).collect();
        let keep = Screen::for_depth(14.0).keep(&points, 1);
        assert!(keep.iter().all(|kept| !kept));
    }
}
