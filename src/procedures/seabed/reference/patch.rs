//! The classical patch test: each parameter from one pair of lines, the others held, in a fixed order (IHO Manual on Hydrography;
//! Li 2019 lists five orders that are in use).
//!
//! | parameter | pair | beams |
//! |---|---|---|
//! | latency | one track, one direction, two speeds | middle |
//! | pitch | one track, opposite directions | middle |
//! | roll | one track, opposite directions | all |
//! | yaw | tracks side by side, where another pair gives pitch and roll: what is left of them would be taken for yaw | all in the overlap |
//!
//! Each is where the two lines' surfaces differ least: planes in small cells, their differences weighted and cut off.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::super::layout::{Layout, Pair, PairKind};
use super::super::model::{Locator, Values};
use super::super::scene::Scene;
use super::super::states::States;
use super::super::surface::{Surface, cell_side_m, least_cell_m, surfaces};
use super::super::tiles::Cell;
use super::config::ReferenceConfig;
use crate::math;
use crate::stats::median;

/// The orders that Li 2019 lists.
pub(super) const ORDERS: &[&str] = &[
    "latency-pitch-yaw-roll",
    "latency-pitch-roll-yaw",
    "latency-roll-pitch-yaw",
    "roll-latency-pitch-yaw",
    "roll-yaw-latency-pitch",
];

/// What one step of the test found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// The parameter.
    pub parameter: &'static str,
    /// Names of the two lines; empty when there is no pair for it.
    pub lines: Vec<String>,
    /// Change, radians or seconds.
    pub change: f64,
    /// Difference of the surfaces before and after, metres.
    pub before_m: f64,
    /// After.
    pub after_m: f64,
    /// Cells compared.
    pub cells: usize,
}

/// The whole test.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Values found.
    pub values: Values,
    /// Every step, in order.
    pub steps: Vec<Step>,
    /// Pitch, roll, yaw, latency: whether a pair was there.
    pub found: [bool; 4],
}

/// One of the four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sought {
    Pitch,
    Roll,
    Yaw,
    Latency,
}

impl Sought {
    fn of(word: &str) -> Option<Self> {
        match word {
            "pitch" => Some(Self::Pitch),
            "roll" => Some(Self::Roll),
            "yaw" => Some(Self::Yaw),
            "latency" => Some(Self::Latency),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        ["pitch", "roll", "yaw", "latency"][self.column()]
    }

    fn column(self) -> usize {
        match self {
            Self::Pitch => 0,
            Self::Roll => 1,
            Self::Yaw => 2,
            Self::Latency => 3,
        }
    }

    /// Half the range that is searched: radians or seconds.
    fn reach(self) -> f64 {
        match self {
            Self::Latency => 0.3,
            _ => 5f64.to_radians(),
        }
    }

    /// Widest beam that takes part, radians.
    fn widest_rad(self, config_rad: f64) -> f64 {
        match self {
            Self::Pitch | Self::Latency => config_rad.min(25f64.to_radians()),
            Self::Roll | Self::Yaw => config_rad,
        }
    }

    /// How well a pair suits; `None` where it does not.
    fn suits(self, pair: &Pair) -> Option<f64> {
        let tiles = pair.tiles as f64;
        match (self, pair.kind) {
            (Self::Latency, PairKind::Same) if pair.speed_ratio > 1.2 => {
                Some(tiles * (pair.speed_ratio - 1.0))
            }
            (Self::Pitch | Self::Roll, PairKind::Reciprocal) => Some(tiles / pair.speed_ratio),
            (Self::Yaw, PairKind::Offset) => Some(tiles),
            _ => None,
        }
    }

    /// The pair that suits best; none for a parameter that would take up what no pair gives.
    fn best(self, layout: &Layout) -> Option<&Pair> {
        let suited = |pair| Some((self.suits(pair)?, pair));
        let best = (layout.pairs.iter().filter_map(suited)).max_by(|a, b| a.0.total_cmp(&b.0));
        let clean = self != Self::Yaw
            || Self::Roll
                .best(layout)
                .and(Self::Pitch.best(layout))
                .is_some();
        best.map(|(_, pair)| pair).filter(|_| clean)
    }

    fn moved(self, values: &Values, by: f64) -> Values {
        let mut step = values.no_step();
        step[self.column()] = by;
        values.stepped(&step)
    }
}

/// Soundings of a line that a comparison uses at most.
const MOST_SOUNDINGS: usize = 30_000;

/// Runs the test. `alive` marks soundings that passed the screen.
#[must_use]
pub fn patch_test(
    scene: &Scene,
    states: &States,
    alive: &[bool],
    layout: &Layout,
    config: &ReferenceConfig,
    widest_rad: f64,
) -> Patch {
    let mut patch = Patch {
        values: Values::nominal(scene, states),
        steps: vec![],
        found: [false; 4],
    };
    for _ in 0..config.rounds {
        for sought in config.order.split('-').filter_map(Sought::of) {
            let Some(pair) = sought.best(layout) else {
                patch.steps.push(no_pair(sought));
                continue;
            };
            let duel = Duel::new(
                scene,
                states,
                alive,
                layout,
                pair.lines,
                sought.widest_rad(widest_rad),
            );
            let step = duel.least(sought, &patch.values);
            if step.cells > 0 {
                patch.values = sought.moved(&patch.values, step.change);
                patch.found[sought.column()] = true;
            }
            patch.steps.push(step);
        }
    }
    patch
}

fn no_pair(sought: Sought) -> Step {
    Step {
        parameter: sought.name(),
        lines: vec![],
        change: 0.0,
        before_m: 0.0,
        after_m: 0.0,
        cells: 0,
    }
}

/// Two lines against each other.
struct Duel<'a> {
    scene: &'a Scene,
    states: &'a States,
    lines: [usize; 2],
    soundings: [Vec<usize>; 2],
    cell_m: f64,
}

impl<'a> Duel<'a> {
    fn new(
        scene: &'a Scene,
        states: &'a States,
        alive: &[bool],
        layout: &Layout,
        lines: [usize; 2],
        widest_rad: f64,
    ) -> Self {
        let of = |line: usize| {
            let all: Vec<usize> = (0..scene.soundings.len())
                .filter(|k| {
                    let s = &scene.soundings[*k];
                    usize::from(s.line) == line
                        && alive[*k]
                        && scene.aside_rad(*k).abs() <= widest_rad
                })
                .collect();
            let stride = all.len().div_ceil(MOST_SOUNDINGS).max(1);
            all.into_iter().step_by(stride).collect()
        };
        let soundings: [Vec<usize>; 2] = lines.map(of);
        let depth_m = scene.typical_depth_m();
        let wide_m = 2.0 * depth_m * math::tan(widest_rad.min(1.2));
        let areas_m2 = lines.map(|k| layout.tracks[k].length_m * wide_m);
        Self {
            scene,
            states,
            lines,
            cell_m: [0, 1]
                .map(|k| cell_side_m(areas_m2[k], soundings[k].len()))
                .into_iter()
                .fold(least_cell_m(depth_m), f64::max),
            soundings,
        }
    }

    /// Scans the range, then narrows down on the least difference.
    fn least(&self, sought: Sought, values: &Values) -> Step {
        let (mut middle, mut reach) = (0.0, sought.reach());
        let before = self.difference(values, 0);
        let least = before.map_or(0, |d| d.1 / 2);
        let cost = |by: f64| self.difference(&sought.moved(values, by), least);
        for _ in 0..6 {
            let scanned: Vec<(f64, f64)> = (-6..=6)
                .map(|k| middle + reach * f64::from(k) / 6.0)
                .map(|by| (by, cost(by).map_or(f64::INFINITY, |d| d.0)))
                .collect();
            middle = parabola(&scanned).unwrap_or(middle);
            reach *= 0.35;
        }
        let after = cost(middle);
        let name = |k: usize| self.scene.lines[k].name.clone();
        let root = |d: Option<(f64, usize)>| d.map_or(0.0, |d| d.0.sqrt());
        Step {
            parameter: sought.name(),
            lines: self.lines.map(name).to_vec(),
            change: middle,
            before_m: root(before),
            after_m: root(after),
            cells: after.map_or(0, |d| d.1),
        }
    }

    /// How far the two surfaces differ at these values, squared and weighted; and the cells. `None` with fewer than `least` cells: a shift
    /// that moves the surfaces apart must not win by leaving few.
    fn difference(&self, values: &Values, least: usize) -> Option<(f64, usize)> {
        let locator = Locator::new(self.scene, self.states, values)?;
        let [first, second] = [0, 1].map(|side: usize| self.patches(&locator, side));
        let both = first
            .iter()
            .filter_map(|(cell, a)| Some((a, second.get(cell)?)));
        let off = |(a, b): (&Surface, &Surface)| {
            let middle = (a.centre + b.centre) / 2.0;
            let off_m = a.height_at(&middle) - b.height_at(&middle);
            (off_m, 1.0 / (a.variance + b.variance + 1e-4))
        };
        let offs: Vec<(f64, f64)> = both.map(off).collect();
        let height_m2 = |side: &Vec<usize>| {
            let sounding = side.first().map(|k| &self.scene.soundings[*k]);
            let line = sounding.map(|s| &self.scene.lines[usize::from(s.line)]);
            line.map_or(0.0, |line| line.height_sigma_m.powi(2))
        };
        let heights_m2 = self.soundings.iter().map(height_m2).sum();
        (offs.len() >= least.max(9)).then(|| (misfit(&offs, heights_m2), offs.len()))
    }

    fn patches(&self, locator: &Locator<'_>, side: usize) -> BTreeMap<Cell, Surface> {
        let points: Vec<Vector3<f64>> = self.soundings[side]
            .par_iter()
            .filter_map(|k| locator.locate(*k).map(|l| l.point_m))
            .collect();
        surfaces(&points, self.cell_m)
    }
}

/// Differences beyond this count no more, metres.
const CUT_M: f64 = 0.5;

/// Weighted mean square of the differences about an offset that all share, such as a tide, of variance `heights_m2`. On a slope an offset
/// looks like a shift along it, so that it must not be taken for one, nor be left free.
fn misfit(offs: &[(f64, f64)], heights_m2: f64) -> f64 {
    let mut all: Vec<f64> = offs.iter().map(|o| o.0).collect();
    let centre = median(&mut all).unwrap_or(0.0);
    let near = || offs.iter().filter(|o| (o.0 - centre).abs() < CUT_M);
    let near_weight: f64 = near().map(|o| o.1).sum();
    let weight: f64 = offs.iter().map(|o| o.1).sum();
    let offset = near().map(|o| o.0 * o.1).sum::<f64>() / near_weight;
    let square = |o: &(f64, f64)| o.1 * (o.0 - offset).powi(2).min(CUT_M * CUT_M);
    let sum: f64 = offs.iter().map(square).sum();
    (sum + offset * offset / (heights_m2 + 1.0 / near_weight)) / weight
}

/// Lowest point of the parabola through the least scanned value and its neighbours.
fn parabola(scanned: &[(f64, f64)]) -> Option<f64> {
    let least = (0..scanned.len()).min_by(|a, b| scanned[*a].1.total_cmp(&scanned[*b].1))?;
    let best = scanned[least];
    if !best.1.is_finite() {
        return None;
    }
    let (Some(left), Some(right)) = (
        least.checked_sub(1).and_then(|k| scanned.get(k)),
        scanned.get(least + 1),
    ) else {
        return Some(best.0);
    };
    let bend = left.1 - 2.0 * best.1 + right.1;
    if !(bend.is_finite() && bend > 0.0) {
        return Some(best.0);
    }
    Some(best.0 + 0.5 * (right.0 - best.0) * (left.1 - right.1) / bend)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_its_lowest_point_where_it_should() {
        let scanned: Vec<_> = (-3..=3)
            .map(|k| (f64::from(k), (f64::from(k) - 0.3).powi(2) + 5.0))
            .collect();
        assert!((parabola(&scanned).expect("a minimum") - 0.3).abs() < 1e-12);
        assert_eq!(parabola(&[(0.0, f64::INFINITY)]), None);
    }

    /// A tide of 10 cm counts as what it is when lines are known to 10 cm, and as a misfit when they are known to a millimetre.
    #[test]
    fn an_offset_of_a_line_is_no_misfit_within_its_sigma() {
        let offs: Vec<(f64, f64)> = (0..40)
            .map(|k| (0.1 + 0.01 * f64::from(k % 3 - 1), 1e4))
            .collect();
        let flat = misfit(&offs, 0.0);
        assert!(misfit(&offs, 0.01) < 0.02 * flat, "{flat}");
        let mut spoiled = offs.clone();
        spoiled[5].0 = 40.0;
        assert!(misfit(&spoiled, 0.01) < misfit(&offs, 0.01) + CUT_M * CUT_M / 39.0);
    }

    /// Production lines side by side without one sailed back: their outer beams would give a yaw of degrees out of roll and pitch.
    #[test]
    fn yaw_waits_for_pitch_and_roll() {
        let pair = |kind, tiles| Pair {
            lines: [0, 1],
            kind,
            apart_m: 30.0,
            speed_ratio: 1.0,
            opposite: true,
            tiles,
        };
        let layout = |pairs| Layout {
            tracks: vec![],
            pairs,
        };
        let beside = pair(PairKind::Offset, 50);
        let alone = layout(vec![beside.clone(), pair(PairKind::Crossing, 80)]);
        assert_eq!(Sought::Yaw.best(&alone), None);
        let whole = layout(vec![
            pair(PairKind::Offset, 30),
            beside.clone(),
            pair(PairKind::Reciprocal, 90),
        ]);
        assert_eq!(Sought::Yaw.best(&whole), Some(&beside));
        assert_eq!(Sought::Roll.best(&whole), Some(&whole.pairs[2]));
        assert_eq!(Sought::Latency.best(&whole), None);
    }

    #[test]
    fn every_listed_order_names_all_four() {
        for order in ORDERS {
            let mut columns: Vec<_> = order
                .split('-')
                .filter_map(Sought::of)
                .map(Sought::column)
                .collect();
            columns.sort_unstable();
            assert_eq!(columns, [0, 1, 2, 3]);
        }
    }
}
