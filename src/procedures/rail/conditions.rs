//! Conditions of the joint path with their derivatives.
//!
//! A profile point tied to an element lies on it: `g = n . q - d - h = 0` (for an arc `|q - centre| - radius - h`), h the element's offset.
//! An INS mean agrees with the stand: `log(A_k A_ins^T) = 0`, three conditions.

use std::ops::Range;

use nalgebra::{Matrix3, Vector2, Vector3};

use super::model::{Blocks, TURN_HEADING, TURN_PITCH, Turned};
use super::scene::RailScene;
use crate::adjust::{ChainRow, ChainState, Conditions, ParameterSet, Row, VISIBLE};
use crate::geometry::rotation;

/// A point on an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tie {
    /// Row of the campaign's points.
    pub row: u32,
    /// Position of the table.
    pub position: u32,
    /// Element of the rail.
    pub element: u16,
}

/// Conditions of tied points, in the order of positions.
pub struct PointConditions<'a> {
    /// What was observed.
    pub scene: &'a RailScene<'a>,
    /// The unknowns.
    pub blocks: &'a Blocks,
    /// The ties.
    pub ties: &'a [Tie],
}

/// A condition evaluated at one value of its observation.
struct Evaluated {
    /// Misfit, metres.
    misfit_m: f64,
    /// Outward normal in the level frame.
    normal: Vector3<f64>,
    /// Outward normal in the cross-section.
    section: Vector2<f64>,
    /// Derivatives by the two coordinates of the point.
    gradient: [f64; 2],
}

fn chain_row(position: u32, by_heading: f64, by_pitch: f64) -> ChainRow {
    let mut visible = [0.0; VISIBLE];
    visible[TURN_HEADING] = by_heading;
    visible[TURN_PITCH] = by_pitch;
    ChainRow {
        interval: position,
        weight0: 1.0,
        weight1: 0.0,
        visible,
    }
}

impl PointConditions<'_> {
    fn evaluate(
        &self,
        turned: &Turned,
        x: &ParameterSet,
        tie: &Tie,
        u: &Vector3<f64>,
    ) -> Evaluated {
        let profiler = self.scene.campaign.points.profiler[tie.row as usize] as usize;
        let mounting = self.blocks.mounting(x, profiler);
        let q = turned.section(&(mounting.rotation * u + mounting.lever_arm_m));
        let offset = self.scene.rail.elements[usize::from(tie.element)].extended(&q);
        let n = Vector3::new(offset.normal.x, 0.0, offset.normal.y);
        let normal = turned.rail * n;
        let own = (turned.body * mounting.rotation).transpose() * normal;
        let known = self
            .blocks
            .profile
            .map_or(0.0, |id| x.euclidean(id)[usize::from(tie.element)]);
        Evaluated {
            misfit_m: offset.distance_m - known,
            normal,
            section: offset.normal,
            gradient: [own.x, own.z],
        }
    }

    /// Misclosure at the adjusted point, its variance, and the derivatives there.
    fn fill(&self, turned: &Turned, tie: &Tie, x: &ParameterSet, row: &mut Row) {
        let (row_, campaign) = (tie.row as usize, self.scene.campaign);
        let profiler = campaign.points.profiler[row_] as usize;
        let instrument = &campaign.profilers[profiler];
        let variances = [
            instrument.lateral_sigma_m.powi(2),
            instrument.vertical_sigma_m.powi(2),
        ];
        let variance = |g: &[f64; 2]| g[0] * g[0] * variances[0] + g[1] * g[1] * variances[1];
        let raw = campaign.points.point(row_);
        let first = self.evaluate(turned, x, tie, &raw);
        let scale = first.misfit_m / variance(&first.gradient);
        let residual = [0, 1].map(|i| -variances[i] * first.gradient[i] * scale);
        let adjusted = raw + Vector3::new(residual[0], 0.0, residual[1]);
        let at = self.evaluate(turned, x, tie, &adjusted);
        row.misclosure = at.misfit_m - at.gradient[0] * residual[0] - at.gradient[1] * residual[1];
        row.variance = variance(&at.gradient);
        self.derive(turned, tie, x, &adjusted, &at, row);
    }

    fn derive(
        &self,
        turned: &Turned,
        tie: &Tie,
        x: &ParameterSet,
        u: &Vector3<f64>,
        at: &Evaluated,
        row: &mut Row,
    ) {
        let profiler = self.scene.campaign.points.profiler[tie.row as usize] as usize;
        let (own, b) = (&self.blocks.mountings[profiler], self.blocks);
        let mounting = b.mounting(x, profiler);
        let turned_u = mounting.rotation * u;
        let arm = turned_u + mounting.lever_arm_m - turned.pivot_body_m;
        let n_body = turned.body.transpose() * at.normal;
        row.extend(x.offset(own.rotation), turned_u.cross(&n_body).as_slice());
        row.extend(x.offset(own.arm), &[n_body.x, n_body.z]);
        row.push(x.offset(own.along), n_body.y);
        let lever = turned.place_m(&arm).cross(&at.normal);
        row.extend(x.offset(b.level), lever.as_slice());
        let seated = (turned.seat * arm).cross(&(turned.table.transpose() * at.normal));
        row.extend(x.offset(b.seat), seated.as_slice());
        row.extend(x.offset(b.rail), (-lever).as_slice());
        row.extend(x.offset(b.pivot_body), (-n_body).as_slice());
        row.extend(x.offset(b.pivot_rail), at.section.as_slice());
        if let Some(id) = b.profile {
            row.push(x.offset(id) + usize::from(tie.element), -1.0);
        }
        if let Some(id) = b.gap {
            row.push(x.offset(id), at.normal.dot(&turned.by_gap()));
        }
        // a turn about the lateral axis leaves that axis where it is
        let carried = turned.body * arm - turned.table.column(1) * turned.gap_m;
        let (by_heading, by_pitch) = (
            turned.heading_axis.dot(&lever),
            turned.pitch_axis.dot(&carried.cross(&at.normal)),
        );
        row.chain = Some(chain_row(tie.position, by_heading, by_pitch));
    }
}

impl Conditions for PointConditions<'_> {
    fn len(&self) -> usize {
        self.ties.len()
    }

    fn group(&self, k: usize) -> u16 {
        self.scene.campaign.points.profiler[self.ties[k].row as usize] as u16
    }

    fn cell(&self, k: usize) -> u16 {
        super::judge::cell(self.scene, &self.ties[k])
    }

    fn interval(&self, k: usize) -> Option<u32> {
        Some(self.ties[k].position)
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        let tie = &self.ties[k];
        let turned = Turned::at(self.scene, self.blocks, x, chain, tie.position as usize);
        self.fill(&turned, tie, x, row);
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        chain: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        let mut here: Option<(u32, Turned)> = None;
        for (tie, row) in self.ties[range].iter().zip(rows) {
            let turned = match here {
                Some((position, turned)) if position == tie.position => turned,
                _ => Turned::at(self.scene, self.blocks, x, chain, tie.position as usize),
            };
            here = Some((tie.position, turned));
            row.clear();
            self.fill(&turned, tie, x, row);
        }
    }
}

/// Conditions of the INS' mean attitudes.
pub struct AttitudeConditions<'a> {
    /// What was observed.
    pub scene: &'a RailScene<'a>,
    /// The unknowns.
    pub blocks: &'a Blocks,
    /// Group of these conditions.
    pub group: u16,
    /// Positions with a record.
    pub positions: &'a [u32],
}

/// Positions of a scene that have an INS record.
#[must_use]
pub fn recorded(scene: &RailScene) -> Vec<u32> {
    let with = |k: &u32| scene.positions[*k as usize].attitude.is_some();
    (0..scene.positions.len() as u32).filter(with).collect()
}

impl Conditions for AttitudeConditions<'_> {
    fn len(&self) -> usize {
        3 * self.positions.len()
    }

    fn group(&self, _k: usize) -> u16 {
        self.group
    }

    fn cell(&self, _k: usize) -> u16 {
        (self.scene.campaign.profilers.len() * self.scene.rail.elements.len()) as u16
    }

    fn interval(&self, k: usize) -> Option<u32> {
        Some(self.positions[k / 3])
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        let (position, axis) = (self.positions[k / 3], k % 3);
        let turned = Turned::at(self.scene, self.blocks, x, chain, position as usize);
        let p = &self.scene.positions[position as usize];
        let Some(measured) = p.attitude else { return };
        let noise = &self.scene.campaign.attitude_noise;
        let sigma = if axis == 2 {
            noise.heading_rad
        } else {
            noise.roll_pitch_rad
        };
        row.misclosure = rotation::log(&(turned.body * measured.transpose()))[axis];
        row.variance = sigma * sigma / p.records as f64;
        row.push(x.offset(self.blocks.level) + axis, 1.0);
        let by_seat: Matrix3<f64> = turned.table;
        let by_seat: Vec<f64> = by_seat.row(axis).iter().copied().collect();
        row.extend(x.offset(self.blocks.seat), &by_seat);
        row.chain = Some(chain_row(
            position,
            turned.heading_axis[axis],
            turned.pitch_axis[axis],
        ));
    }
}
