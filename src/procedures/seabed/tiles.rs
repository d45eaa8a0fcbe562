//! The seabed cut into tiles, and which soundings of each tile take part.

use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::screen::{over_plane, ransac_plane};
use crate::stats::{mad_sigma, stream};

/// A square of a regular grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Column, from the west.
    pub east: i32,
    /// Row, from the south.
    pub north: i32,
}

impl Cell {
    /// The cell that holds a point.
    #[must_use]
    pub fn of(point_m: &Vector3<f64>, side_m: f64) -> Self {
        Self {
            east: (point_m.x / side_m).floor() as i32,
            north: (point_m.y / side_m).floor() as i32,
        }
    }

    /// Its centre, metres, at height 0.
    #[must_use]
    pub fn centre_m(self, side_m: f64) -> Vector3<f64> {
        let middle = |k: i32| (f64::from(k) + 0.5) * side_m;
        Vector3::new(middle(self.east), middle(self.north), 0.0)
    }

    /// It and its eight neighbours.
    pub fn neighbours(self) -> impl Iterator<Item = Self> {
        (-1..=1).flat_map(move |north| {
            (-1..=1).map(move |east| Self {
                east: self.east + east,
                north: self.north + north,
            })
        })
    }

    /// Seed and stream of the cell's random numbers.
    #[must_use]
    pub fn stream(self, seed: u64) -> (u64, u64) {
        let place = (u64::from(self.east as u32) << 32) | u64::from(self.north as u32);
        (seed, place)
    }
}

/// How lengths grow with the depth: 1 down to 15 m.
#[must_use]
pub fn depth_scale(depth_m: f64) -> f64 {
    (depth_m / 15.0).max(1.0)
}

/// How tiles are cut and drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Side of a tile, metres.
    pub side_m: f64,
    /// Most soundings in a tile.
    pub most: usize,
    /// Fewest soundings of a strip in a tile.
    pub fewest: usize,
    /// Fewest strips in a tile: one head's seabed on one line.
    pub strips: usize,
    /// Most tiles.
    pub tiles: usize,
    /// Soundings further than this from their strip's plane in the tile are never dropped by it, metres.
    pub least_m: f64,
    /// Seed of the draws.
    pub seed: u64,
}

/// The soundings of one tile that take part, in the order of their strips.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// Where it lies.
    pub cell: Cell,
    /// Centre, metres, at height 0.
    pub centre_m: Vector3<f64>,
    /// Numbers of the soundings.
    pub members: Vec<u32>,
    /// How many strips they are of.
    pub strips: usize,
}

/// A sounding that may take part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its number.
    pub sounding: u32,
    /// Its strip: which head's on which line.
    pub strip: u32,
    /// Where it struck, metres.
    pub point_m: Vector3<f64>,
}

impl Cut {
    /// Cuts the candidates into tiles and draws from each.
    #[must_use]
    pub fn tiles(&self, candidates: &[Candidate]) -> Vec<Tile> {
        let mut sorted: Vec<(Cell, u32, &Candidate)> = candidates
            .iter()
            .map(|c| (Cell::of(&c.point_m, self.side_m), c.strip, c))
            .collect();
        sorted.par_sort_by_key(|(cell, strip, c)| (*cell, *strip, c.sounding));
        let groups: Vec<_> = sorted.chunk_by(|a, b| a.0 == b.0).collect();
        let mut groups: Vec<_> = groups.into_iter().filter(|g| self.is_wide(g)).collect();
        if groups.len() > self.tiles {
            groups.shuffle(&mut stream(self.seed, u64::MAX));
            groups.truncate(2 * self.tiles);
            groups.sort_by_key(|g| g[0].0);
        }
        let mut tiles: Vec<Tile> = groups.par_iter().filter_map(|g| self.draw(g)).collect();
        if tiles.len() > self.tiles {
            tiles.shuffle(&mut stream(self.seed, u64::MAX - 1));
            tiles.truncate(self.tiles);
            tiles.sort_by_key(|t| t.cell);
        }
        tiles
    }

    /// Whether enough strips have enough soundings in a tile.
    fn is_wide(&self, group: &[(Cell, u32, &Candidate)]) -> bool {
        let full = |strip: &&[(Cell, u32, &Candidate)]| strip.len() >= self.fewest;
        group.chunk_by(|a, b| a.1 == b.1).filter(full).count() >= self.strips
    }

    fn draw(&self, group: &[(Cell, u32, &Candidate)]) -> Option<Tile> {
        let cell = group[0].0;
        let centre_m = cell.centre_m(self.side_m);
        let strips: Vec<Vec<u32>> = group
            .chunk_by(|a, b| a.1 == b.1)
            .map(|strip| self.near_plane(strip, &centre_m))
            .filter(|strip| strip.len() >= self.fewest)
            .collect();
        if strips.len() < self.strips {
            return None;
        }
        let share = self.most / strips.len();
        let (seed, place) = cell.stream(self.seed);
        let mut draws = stream(seed ^ 0x7469_6c65, place);
        let mut members = vec![];
        for mut strip in strips.iter().cloned() {
            strip.shuffle(&mut draws);
            strip.truncate(share.max(self.fewest));
            strip.sort_unstable();
            members.extend(strip);
        }
        Some(Tile {
            cell,
            centre_m,
            members,
            strips: strips.len(),
        })
    }

    /// The soundings of a strip in a tile that lie near the strip's plane there.
    fn near_plane(&self, strip: &[(Cell, u32, &Candidate)], centre_m: &Vector3<f64>) -> Vec<u32> {
        if strip.len() < self.fewest {
            return vec![];
        }
        let stride = strip.len().div_ceil(100);
        let relative = |c: &Candidate| c.point_m - centre_m;
        let sample: Vec<_> = strip
            .iter()
            .step_by(stride)
            .map(|e| relative(e.2))
            .collect();
        let (seed, place) = strip[0].0.stream(self.seed ^ u64::from(strip[0].1));
        let plane = ransac_plane(&sample, self.least_m, 60, (seed, place));
        let mut offs: Vec<f64> = sample.iter().map(|p| over_plane(&plane, p)).collect();
        let centre = crate::stats::median(&mut offs).unwrap_or(0.0);
        let limit_m = self
            .least_m
            .max(6.0 * mad_sigma(&mut offs).unwrap_or(f64::INFINITY));
        strip
            .iter()
            .filter(|e| (over_plane(&plane, &relative(e.2)) - centre).abs() <= limit_m)
            .map(|e| e.2.sounding)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates() -> Vec<Candidate> {
        let one = |k: u32| Candidate {
            sounding: k,
            strip: k % 2,
            point_m: Vector3::new(f64::from(k % 93) * 0.3, f64::from(k / 93) * 0.7, -14.0),
        };
        (0..2790).map(one).collect()
    }

    fn cut() -> Cut {
        Cut {
            side_m: 7.0,
            most: 64,
            fewest: 6,
            strips: 2,
            tiles: 5,
            least_m: 0.12,
            seed: 3,
        }
    }

    #[test]
    fn tiles_share_their_places_evenly_among_strips() {
        let tiles = cut().tiles(&candidates());
        assert_eq!(tiles.len(), 5);
        for tile in &tiles {
            let first = tile.members.iter().filter(|k| *k % 2 == 0).count();
            assert_eq!((first, tile.members.len()), (32, 64));
        }
    }

    #[test]
    fn the_draw_is_the_same_on_one_thread() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let alone = pool.expect("a pool").install(|| cut().tiles(&candidates()));
        assert_eq!(alone, cut().tiles(&candidates()));
    }

    #[test]
    fn a_sounding_off_its_strip_never_takes_part() {
        let mut all = candidates();
        for c in all.iter_mut().filter(|c| c.sounding % 31 == 0) {
            c.point_m.z += 0.5;
        }
        let tiles = Cut {
            tiles: 1000,
            ..cut()
        }
        .tiles(&all);
        let drawn = tiles.iter().flat_map(|t| &t.members);
        assert!(drawn.copied().all(|k| k % 31 != 0));
    }
}
