//! How the lines lie: tracks, speeds, and what each pair of lines is good for.

use crate::math;
use std::collections::BTreeMap;

use nalgebra::{Vector2, Vector3};
use serde::Serialize;

use super::scene::Scene;
use super::tiles::Tile;

/// One line's track.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Track {
    /// Name of the line.
    pub name: String,
    /// Course over ground, degrees from north.
    pub course_deg: f64,
    /// Mean speed, metres per second.
    pub speed_m_s: f64,
    /// Length, metres.
    pub length_m: f64,
    #[serde(skip)]
    middle_m: Vector2<f64>,
    #[serde(skip)]
    direction: Vector2<f64>,
}

/// What a pair of lines is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PairKind {
    /// One track, same direction.
    Same,
    /// One track, opposite directions.
    Reciprocal,
    /// Parallel tracks side by side.
    Offset,
    /// Tracks that cross.
    Crossing,
}

/// Two lines that sounded the same seabed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Numbers of the lines.
    pub lines: [usize; 2],
    /// What it is.
    pub kind: PairKind,
    /// Distance between the tracks, metres; 0 for crossing ones.
    pub apart_m: f64,
    /// Faster speed over slower.
    pub speed_ratio: f64,
    /// Whether they were sailed in opposite directions.
    pub opposite: bool,
    /// Tiles that both sounded.
    pub tiles: usize,
}

/// Tracks and pairs of a survey.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Layout {
    /// One of each line.
    pub tracks: Vec<Track>,
    /// Pairs with at least [`FEWEST_TILES`] common tiles.
    pub pairs: Vec<Pair>,
}

/// Common tiles that make two lines a pair.
pub const FEWEST_TILES: usize = 20;

impl Layout {
    /// Of a survey whose lines met on these tiles.
    #[must_use]
    pub fn new(scene: &Scene, tiles: &[Tile]) -> Self {
        let tracks: Vec<Track> = (0..scene.lines.len()).map(|k| track(scene, k)).collect();
        let depth_m = scene.typical_depth_m();
        let pairs = shared(scene, tiles)
            .into_iter()
            .filter(|(_, count)| *count >= FEWEST_TILES)
            .map(|(lines, count)| pair(&tracks, lines, count, depth_m))
            .collect();
        Self { tracks, pairs }
    }

    /// Whether a pair of this kind is there.
    #[must_use]
    pub fn has(&self, kind: PairKind) -> bool {
        self.pairs.iter().any(|pair| pair.kind == kind)
    }

    /// What the layout cannot give, pitch, roll and yaw: why, or nothing.
    #[must_use]
    pub fn missing(&self) -> [Option<&'static str>; 3] {
        let (reciprocal, offset, crossing) = (
            self.has(PairKind::Reciprocal),
            self.has(PairKind::Offset),
            self.has(PairKind::Crossing),
        );
        // side by side in one direction, a roll looks like an error of the profile: outer beams against inner ones
        let opposite = self.pairs.iter().any(|pair| pair.opposite);
        let unless = |there: bool, why: &'static str| (!there).then_some(why);
        [
            unless(
                reciprocal || crossing,
                "pitch needs a line sailed back on the same track, or one across it",
            ),
            unless(
                opposite || crossing,
                "roll needs a line sailed the other way, on the same track or beside it, or one across",
            ),
            unless(
                offset || crossing,
                "yaw needs a line beside or across the others whose outer beams overlap theirs",
            ),
        ]
    }
}

/// How many tiles each pair of lines shares.
fn shared(scene: &Scene, tiles: &[Tile]) -> BTreeMap<[usize; 2], usize> {
    let mut count = BTreeMap::new();
    for tile in tiles {
        let line = |k: &u32| usize::from(scene.soundings[*k as usize].line);
        let mut lines: Vec<usize> = tile.members.iter().map(line).collect();
        lines.dedup();
        for (k, a) in lines.iter().enumerate() {
            for b in &lines[k + 1..] {
                *count.entry([*a, *b]).or_insert(0) += 1;
            }
        }
    }
    count
}

fn track(scene: &Scene, number: usize) -> Track {
    let line = &scene.lines[number];
    let times = scene.trajectory.times_s();
    let positions = scene.trajectory.positions_m();
    let first = times.partition_point(|t| *t < line.start_s);
    let last = times.partition_point(|t| *t <= line.end_s);
    let place = |k: usize| positions.get(k).map_or_else(Vector2::zeros, Vector3::xy);
    let (begin, end) = (place(first), place(last.saturating_sub(1)));
    let way = end - begin;
    let over_s = (line.end_s - line.start_s).max(1e-9);
    Track {
        name: line.name.clone(),
        course_deg: math::atan2(way.x, way.y).to_degrees().rem_euclid(360.0),
        speed_m_s: way.norm() / over_s,
        length_m: way.norm(),
        middle_m: (begin + end) / 2.0,
        direction: way.try_normalize(0.0).unwrap_or_else(Vector2::zeros),
    }
}

/// Courses closer than this (25 deg) count as parallel.
const PARALLEL: f64 = 0.906;

fn pair(tracks: &[Track], lines: [usize; 2], tiles: usize, depth_m: f64) -> Pair {
    let [a, b] = lines.map(|k| &tracks[k]);
    let along = a.direction.dot(&b.direction);
    let between = b.middle_m - a.middle_m;
    let apart_m = a.direction.perp(&between).abs();
    let kind = match () {
        () if along.abs() < PARALLEL => PairKind::Crossing,
        () if apart_m > 0.5 * depth_m => PairKind::Offset,
        () if along < 0.0 => PairKind::Reciprocal,
        () => PairKind::Same,
    };
    let (slow, fast) = (a.speed_m_s.min(b.speed_m_s), a.speed_m_s.max(b.speed_m_s));
    Pair {
        lines,
        kind,
        apart_m: if kind == PairKind::Crossing {
            0.0
        } else {
            apart_m
        },
        speed_ratio: fast / slow.max(1e-6),
        opposite: kind != PairKind::Crossing && along < 0.0,
        tiles,
    }
}
