//! What the report draws: how far the lines differ from each other, before and after by each path, over the ground, by beam and by line.

use crate::math;
use std::collections::BTreeMap;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::layout::{Layout, Pair};
use super::model::{Locator, Values};
use super::run::SeabedOutcome;
use super::scene::Scene;
use super::states::States;
use super::surface::{Surface, cell_side_m, least_cell_m, surfaces};
use super::tiles::Cell;
use crate::results::DriftSample;

/// Everything that the report draws of the lines.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Views {
    /// `before`, `reference`, `joint`: those that there are.
    pub solutions: Vec<&'static str>,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Pairs of lines with the most common ground, one of each kind.
    pub pairs: Vec<PairView>,
    /// Lines against the others by beam angle, degrees.
    pub by_angle: Vec<Curve>,
    /// The same by distance across the track, metres.
    pub by_distance: Vec<Curve>,
    /// Mean height of each line over the others, metres, in the order of the solutions.
    pub lines: Vec<LineView>,
    /// How densely the seabed is covered by the soundings that the calibration takes.
    pub coverage: Vec<Covered>,
    /// What the joint path estimates of the trajectory's drift.
    pub drift: Vec<DriftSample>,
}

/// One cell of the seabed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Covered {
    /// East and north of its middle, metres.
    at_m: [f64; 2],
    /// Soundings per square metre, of all lines together.
    per_m2: f64,
    /// Lines that have soundings there.
    lines: u32,
}

/// Two lines' surfaces, the first less the second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct PairView {
    /// Numbers of the lines.
    lines: [usize; 2],
    /// Of each cell: east and north of its middle, metres, then the difference by each solution, millimetres.
    cells: Vec<(f64, f64, Vec<Option<i32>>)>,
    /// Root mean square of the differences by each solution, metres.
    rms_m: Vec<Option<f64>>,
}

/// Mean height of one line over the others in one solution, by beam.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Curve {
    line: usize,
    solution: usize,
    /// Angle or distance, and height in millimetres.
    points: Vec<(f64, f64)>,
}

/// One line against the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct LineView {
    /// Mean height over the others, metres, by each solution.
    over_m: Vec<Option<f64>>,
    /// Height of the line as the joint path estimates it (tide, datum), metres.
    height_m: Option<f64>,
}

/// Soundings of which the views are made at most.
const MOST_SOUNDINGS: usize = 240_000;
/// Bins on either side of the middle.
const BINS: i32 = 16;
/// Width of a bin of beam angles, degrees.
const BIN_DEG: f64 = 5.0;
/// Soundings of a bin at least.
const FEWEST_OF_BIN: u32 = 25;

/// The views of an outcome; nothing where the lines do not meet.
pub(super) fn views(outcome: &SeabedOutcome, scene: &Scene) -> Views {
    let states = States::new(&scene.lines, &scene.ins, &scene.drift);
    let nominal = Values::nominal(scene, &states);
    let mut solutions = vec![("before", &nominal)];
    if let Some(Ok(reference)) = &outcome.reference {
        solutions.push(("reference", reference.values()));
    }
    let joint = outcome.joint.as_ref().and_then(|found| found.as_ref().ok());
    if let Some((joint, _)) = joint {
        solutions.push(("joint", &joint.values));
    }
    if outcome.alive.is_empty() {
        return Views::default();
    }
    let chosen = chosen(outcome);
    let cell_m = cell_m(scene, &outcome.layout, chosen.len());
    let sheets: Vec<Sheet> = solutions
        .iter()
        .filter_map(|(_, values)| Sheet::new(scene, &states, values, &chosen, cell_m))
        .collect();
    let heights = joint.map(|(joint, _)| {
        let height = |line: usize| joint.values.states[joint.states.height_of(line)];
        (0..scene.lines.len()).map(height).collect::<Vec<f64>>()
    });
    let drift = joint.map(|(joint, _)| joint.states.drifts(&joint.values.states));
    let views = drawn(scene, &outcome.layout, &sheets, heights.as_deref());
    Views {
        drift: drift.unwrap_or_default(),
        ..views.named(&solutions, cell_m)
    }
    .thinned_by(stride(outcome))
}

impl Views {
    /// Of soundings of which one in `stride` was taken.
    fn thinned_by(mut self, stride: usize) -> Self {
        let one = |cell: &mut Covered| cell.per_m2 = round_to(cell.per_m2 * stride as f64, 1000.0);
        self.coverage.iter_mut().for_each(one);
        self
    }

    fn named(self, solutions: &[(&'static str, &Values)], cell_m: f64) -> Self {
        Self {
            solutions: solutions.iter().map(|s| s.0).collect(),
            cell_m,
            ..self
        }
    }
}

fn drawn(scene: &Scene, layout: &Layout, sheets: &[Sheet], heights: Option<&[f64]>) -> Views {
    let bins: Vec<Bins> = sheets.iter().map(|sheet| sheet.bins(scene)).collect();
    let curves = |pick: fn(&Bins) -> &BTreeMap<(usize, i32), Mean>, width: f64| {
        let of = |(solution, bins): (usize, &Bins)| curves(pick(bins), solution, width);
        bins.iter().enumerate().flat_map(of).collect()
    };
    let wide_m = bin_m(scene);
    let line = |line: usize| LineView {
        over_m: bins.iter().map(|b| b.lines.get(&line)?.value()).collect(),
        height_m: heights.map(|all| all[line]),
    };
    Views {
        pairs: widest_pairs(layout)
            .map(|pair| pair_view(pair, sheets))
            .collect(),
        by_angle: curves(|b| &b.angles, BIN_DEG),
        by_distance: curves(|b| &b.distances, wide_m),
        lines: (0..scene.lines.len()).map(line).collect(),
        coverage: sheets.last().map(|s| s.coverage(scene)).unwrap_or_default(),
        ..Views::default()
    }
}

/// One in so many soundings is taken.
fn stride(outcome: &SeabedOutcome) -> usize {
    let alive = outcome.alive.iter().filter(|alive| **alive).count();
    alive.div_ceil(MOST_SOUNDINGS).max(1)
}

fn chosen(outcome: &SeabedOutcome) -> Vec<usize> {
    let alive = (0..outcome.alive.len()).filter(|k| outcome.alive[*k]);
    alive.step_by(stride(outcome)).collect()
}

/// Side of the cells: a dozen soundings of a line in each.
fn cell_m(scene: &Scene, layout: &Layout, soundings: usize) -> f64 {
    let depth_m = scene.typical_depth_m();
    let length_m: f64 = layout.tracks.iter().map(|t| t.length_m).sum();
    let widest = scene.soundings.iter().map(|s| scene.abeam_rad(s).abs());
    let wide_m = 2.0 * depth_m * math::tan(widest.fold(0.0, f64::max).min(1.2));
    cell_side_m(length_m * wide_m, soundings).max(least_cell_m(depth_m))
}

/// Width of a bin of distances across the track, metres.
fn bin_m(scene: &Scene) -> f64 {
    (scene.typical_depth_m() / 8.0).max(0.1)
}

/// Of each kind of pair the one with the most common tiles.
fn widest_pairs(layout: &Layout) -> impl Iterator<Item = &Pair> {
    let mut best = BTreeMap::new();
    for pair in &layout.pairs {
        let held = best.entry(pair.kind).or_insert(pair);
        if pair.tiles > held.tiles {
            *held = pair;
        }
    }
    best.into_values()
}

/// All chosen soundings on the bed by one solution.
struct Sheet {
    cell_m: f64,
    points: Vec<(usize, Vector3<f64>)>,
    /// Of each line.
    surfaces: Vec<BTreeMap<Cell, Surface>>,
}

/// Sums to a mean.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> Option<f64> {
        (self.count >= FEWEST_OF_BIN).then(|| self.sum / f64::from(self.count))
    }
}

/// Heights of the lines over the others by line and beam.
#[derive(Default)]
struct Bins {
    angles: BTreeMap<(usize, i32), Mean>,
    distances: BTreeMap<(usize, i32), Mean>,
    lines: BTreeMap<usize, Mean>,
}

impl Sheet {
    fn new(
        scene: &Scene,
        states: &States,
        values: &Values,
        chosen: &[usize],
        cell_m: f64,
    ) -> Option<Self> {
        let locator = Locator::new(scene, states, values)?;
        let place = |k: &usize| Some((*k, locator.locate(*k)?.point_m));
        let points: Vec<_> = chosen.par_iter().filter_map(place).collect();
        let of_line = |line: usize| {
            let own = points
                .iter()
                .filter(|(k, _)| usize::from(scene.soundings[*k].line) == line);
            let own: Vec<Vector3<f64>> = own.map(|(_, point)| *point).collect();
            surfaces(&own, cell_m)
        };
        Some(Self {
            cell_m,
            surfaces: (0..scene.lines.len()).map(of_line).collect(),
            points,
        })
    }

    /// Soundings by square metre and lines of every cell.
    fn coverage(&self, scene: &Scene) -> Vec<Covered> {
        let mut cells: BTreeMap<Cell, BTreeMap<u16, u32>> = BTreeMap::new();
        for (k, point) in &self.points {
            let line = scene.soundings[*k].line;
            let cell = cells.entry(Cell::of(point, self.cell_m)).or_default();
            *cell.entry(line).or_default() += 1;
        }
        let area_m2 = self.cell_m * self.cell_m;
        let one = |(cell, by_line): (Cell, BTreeMap<u16, u32>)| {
            let middle = cell.centre_m(self.cell_m);
            Covered {
                at_m: [middle.x, middle.y].map(|m| round_to(m, 100.0)),
                per_m2: f64::from(by_line.values().sum::<u32>()) / area_m2,
                lines: by_line.len() as u32,
            }
        };
        cells.into_iter().map(one).collect()
    }

    /// Height of a sounding over the mean of the other lines' surfaces under it; nothing where no other line was.
    fn over_others_m(&self, line: usize, point: &Vector3<f64>) -> Option<f64> {
        let cell = Cell::of(point, self.cell_m);
        let others = self.surfaces.iter().enumerate().filter(|(k, _)| *k != line);
        let mut mean = Mean::default();
        for surface in others.filter_map(|(_, all)| all.get(&cell)) {
            mean.add(point.z - surface.height_at(point));
        }
        (mean.count > 0).then(|| mean.sum / f64::from(mean.count))
    }

    fn bins(&self, scene: &Scene) -> Bins {
        let (mut bins, wide_m) = (Bins::default(), bin_m(scene));
        let speed_m_s = scene.water.surface_speed_m_s();
        for (k, point) in &self.points {
            let sounding = &scene.soundings[*k];
            let line = usize::from(sounding.line);
            let Some(over_m) = self.over_others_m(line, point) else {
                continue;
            };
            let abeam_rad = scene.abeam_rad(sounding);
            let across_m = sounding.one_way_s * speed_m_s * math::sin(abeam_rad);
            for (bins, place) in [
                (&mut bins.angles, abeam_rad.to_degrees() / BIN_DEG),
                (&mut bins.distances, across_m / wide_m),
            ] {
                let bin = (place.round() as i32).clamp(-BINS, BINS);
                bins.entry((line, bin)).or_default().add(over_m);
            }
            bins.lines.entry(line).or_default().add(over_m);
        }
        bins
    }
}

fn curves(bins: &BTreeMap<(usize, i32), Mean>, solution: usize, width: f64) -> Vec<Curve> {
    let mut all: BTreeMap<usize, Vec<(f64, f64)>> = BTreeMap::new();
    for ((line, bin), mean) in bins {
        if let Some(over_m) = mean.value() {
            let point = (f64::from(*bin) * width, round_to(1e3 * over_m, 100.0));
            all.entry(*line).or_default().push(point);
        }
    }
    let curve = |(line, points)| Curve {
        line,
        solution,
        points,
    };
    all.into_iter().map(curve).collect()
}

fn round_to(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}

fn pair_view(pair: &Pair, sheets: &[Sheet]) -> PairView {
    let differences: Vec<BTreeMap<Cell, f64>> = sheets
        .iter()
        .map(|sheet| differences(sheet, pair))
        .collect();
    let places: std::collections::BTreeSet<Cell> =
        differences.iter().flat_map(|d| d.keys().copied()).collect();
    let row = |cell: &Cell| {
        let side_m = sheets.first().map_or(1.0, |s| s.cell_m);
        let middle = cell.centre_m(side_m);
        let off = |d: &BTreeMap<Cell, f64>| d.get(cell).map(|off_m| (1e3 * off_m).round() as i32);
        let each = differences.iter().map(off).collect();
        (round_to(middle.x, 100.0), round_to(middle.y, 100.0), each)
    };
    let rms = |d: &BTreeMap<Cell, f64>| {
        let mean = d.values().map(|x| x * x).sum::<f64>() / d.len() as f64;
        (!d.is_empty()).then(|| mean.sqrt())
    };
    PairView {
        lines: pair.lines,
        cells: places.iter().map(row).collect(),
        rms_m: differences.iter().map(rms).collect(),
    }
}

/// First line less second in every cell that both have, metres.
fn differences(sheet: &Sheet, pair: &Pair) -> BTreeMap<Cell, f64> {
    let [first, second] = pair.lines.map(|k| &sheet.surfaces[k]);
    let both = first
        .iter()
        .filter_map(|(cell, a)| Some((cell, a, second.get(cell)?)));
    let off = |(cell, a, b): (&Cell, &Surface, &Surface)| {
        let middle = (a.centre + b.centre) / 2.0;
        (*cell, a.height_at(&middle) - b.height_at(&middle))
    };
    both.map(off).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Line 1 lies 5 cm over line 0 everywhere: the difference and the means say so.
    #[test]
    fn a_line_that_lies_higher_is_seen_to() {
        let bed = |line: usize| {
            let at = move |k: usize| {
                let (x, y) = ((k % 40) as f64 * 0.5, (k / 40) as f64 * 0.5);
                Vector3::new(x, y, -14.0 + 0.1 * x + 0.05 * line as f64)
            };
            (0..1600).map(at).collect::<Vec<_>>()
        };
        let sheet = Sheet {
            cell_m: 3.0,
            points: vec![],
            surfaces: (0..2).map(|line| surfaces(&bed(line), 3.0)).collect(),
        };
        let pair = Pair {
            lines: [0, 1],
            kind: super::super::layout::PairKind::Same,
            apart_m: 0.0,
            speed_ratio: 1.0,
            opposite: false,
            tiles: 20,
        };
        let all = differences(&sheet, &pair);
        assert!(all.len() > 30 && all.values().all(|d| (d + 0.05).abs() < 1e-9));
        let view = pair_view(&pair, &[sheet]);
        assert!((view.rms_m[0].expect("cells") - 0.05).abs() < 1e-9);
        assert_eq!(view.cells[0].2, [Some(-50)]);
    }

    #[test]
    fn a_sounding_is_measured_against_the_other_lines_only() {
        let flat = |z: f64| {
            let at = |k: usize| Vector3::new((k % 10) as f64 * 0.2, (k / 10) as f64 * 0.2, z);
            surfaces(&(0..100).map(at).collect::<Vec<_>>(), 3.0)
        };
        let sheet = Sheet {
            cell_m: 3.0,
            points: vec![],
            surfaces: vec![flat(-10.0), flat(-10.2), flat(-10.4)],
        };
        let over = sheet.over_others_m(0, &Vector3::new(1.0, 1.0, -10.0));
        assert!((over.expect("others") - 0.3).abs() < 1e-9);
        assert_eq!(
            sheet.over_others_m(0, &Vector3::new(99.0, 1.0, -10.0)),
            None
        );
    }
}
