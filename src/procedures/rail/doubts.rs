//! Unknowns that the rail's joint path could have and has not: the columns of their score tests (`docs/verdict-measured.md`).
//!
//! A point's condition is `g = n . D^T A (R u + l - v) + ...`; with the level frame's normal `n` of its element:
//!
//! | unknown | column |
//! |---|---|
//! | gap between the table's axes | `n . (Rz - Rz Rx) y`: the lateral axis lies that far before the vertical one |
//! | offset of an element | `-1` |
//! | the INS turned against the table | `-1` on its own conditions (heading clockwise, so `-1` about the vertical too) |

use nalgebra::Vector3;

use super::conditions::Tie;
use super::model::{Blocks, Turned};
use super::scene::RailScene;
use crate::adjust::{ChainState, Component, ParameterSet, Row, ScoreColumns, Solved, Unit};
use crate::calibrate::verdict::Doubt;
use crate::calibrate::verdict::doubts::append;

/// Ties that an element needs for a test of its own.
const LEAST: usize = 20;

/// The doubts of a rail calibration with their columns.
pub struct Doubts<'a> {
    scene: &'a RailScene<'a>,
    blocks: &'a Blocks,
    x: &'a ParameterSet,
    chain: Option<&'a ChainState>,
    ties: &'a [Tie],
    /// First column of the gap, of the INS, and the column of each element.
    gap: Option<usize>,
    ins: usize,
    elements: Vec<Option<usize>>,
    /// What is doubted, in the order of the columns.
    pub list: Vec<Doubt>,
}

impl<'a> Doubts<'a> {
    /// Everything that these ties could tell of.
    #[must_use]
    pub fn of(
        scene: &'a RailScene<'a>,
        (blocks, x, chain): (&'a Blocks, &'a ParameterSet, Option<&'a ChainState>),
        ties: &'a [Tie],
    ) -> Self {
        let gap = Doubt::single(
            "axes_gap",
            "the table's lateral axis lies in front of its vertical one",
            Unit::Metre,
            "state how well the table's axes meet ([table] axes_gap_sigma_m), or use a table whose axes meet",
        );
        let axes = ["about x", "about y", "heading"].map(|name| Component::new(name, Unit::Radian));
        let ins = Doubt::several(
            "ins_attitude",
            "the INS is turned against the table",
            axes.to_vec(),
            "check the INS' heading (alignment, grid or magnetic north), the table's zero and the seat of the beam",
        );
        let mut doubts = Self {
            scene,
            blocks,
            x,
            chain,
            ties,
            gap: None,
            ins: 0,
            elements: vec![None; scene.rail.elements.len()],
            list: vec![ins],
        };
        if blocks.gap.is_none() {
            doubts.gap = Some(append(&mut doubts.list, gap));
        }
        if blocks.profile.is_none() {
            doubts.elements();
        }
        doubts
    }

    fn elements(&mut self) {
        for element in 0..self.elements.len() {
            let seen = self
                .ties
                .iter()
                .filter(|tie| usize::from(tie.element) == element);
            if seen.count() < LEAST {
                continue;
            }
            let what = format!(
                "the rail's {} does not follow its model",
                self.scene.rail.names[element]
            );
            let advice = "the rail is worn or of another type: clean it, use a new one, or state [rail] profile_sigma_m";
            let doubt = Doubt::single("rail_element", &what, Unit::Metre, advice);
            self.elements[element] = Some(append(&mut self.list, doubt));
        }
    }

    /// The columns of the points' conditions.
    #[must_use]
    pub fn of_points(&self) -> OfPoints<'_> {
        OfPoints(self)
    }

    /// The columns of the INS' conditions.
    #[must_use]
    pub fn of_ins(&self) -> OfIns {
        OfIns(self.ins)
    }
}

/// [`Doubts`] as the points see them.
pub struct OfPoints<'a>(&'a Doubts<'a>);

impl ScoreColumns for OfPoints<'_> {
    fn derive(&self, k: usize, _: &Solved, row: &Row, push: &mut dyn FnMut(usize, f64)) {
        let doubts = self.0;
        let tie = doubts.ties[k];
        let turned = Turned::at(
            doubts.scene,
            doubts.blocks,
            doubts.x,
            doubts.chain,
            tie.position as usize,
        );
        let pivot = doubts.x.offset(doubts.blocks.pivot_rail);
        // the normal in the cross-section stands in the row, as the derivative by the centre of rotation
        let by = |column: usize| {
            let place = row.columns().iter().position(|c| usize::from(*c) == column);
            place.map_or(0.0, |place| row.values()[place])
        };
        let normal = turned.rail * Vector3::new(by(pivot), 0.0, by(pivot + 1));
        if let Some(column) = doubts.gap {
            push(column, normal.dot(&turned.by_gap()));
        }
        if let Some(column) = doubts.elements[usize::from(tie.element)] {
            push(column, -1.0);
        }
    }
}

/// [`Doubts`] as the INS' conditions see them.
pub struct OfIns(usize);

impl ScoreColumns for OfIns {
    fn derive(&self, k: usize, _: &Solved, _: &Row, push: &mut dyn FnMut(usize, f64)) {
        let sign = if k % 3 == 2 { -1.0 } else { 1.0 };
        push(self.0 + k % 3, sign);
    }
}
