//! The joint conditions: each fix is three observations, the range and two components of the direction (`docs/usbl.md`).
//!
//! `c (T(X_T, X_B) - (1 + s) t) = 0` and `a_i . ((R_b^l R_u^b)^T d(X_T, X_B) - d_obs) = 0`, where `T` and `d` are travel time and
//! launch direction of the ray from the transducer to the beacon in the level frame, `R_b^l = Exp(psi + datum) R_measured`, `s` is
//! the range scale, and `a_1`, `a_2` are the axes along which the transducer measured the direction. The three are independent of
//! each other; the attitude's noise `psi`, which the fixes between two records share, is a state of the chain.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::scene::Scene;
use crate::adjust::{BlockId, ChainRow, ChainState, Conditions, ParameterSet, Row, VISIBLE};
use crate::geometry::rotation;
use crate::georef::Eigenray;

/// Observation group of the ranges.
pub const RANGES: u16 = 0;
/// Observation group of the angles.
pub const ANGLES: u16 = 1;
/// Conditions of a fix.
pub const PER_FIX: usize = 3;

/// Where the unknowns live.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// `R_u^b`, left perturbation in the body: pitch, roll, yaw.
    pub mounting: BlockId,
    /// The transducer's centre in the level frame, metres.
    pub transducer: BlockId,
    /// Scale of the ranges.
    pub scale: BlockId,
    /// Turn between the level frames of attitude sensor and total station, radians about east, north, up.
    pub datum: BlockId,
    /// Every common beacon's position in the level frame, metres; `None` for a check beacon.
    pub beacons: Vec<Option<BlockId>>,
}

fn vector(x: &ParameterSet, id: BlockId) -> Vector3<f64> {
    Vector3::from_column_slice(x.euclidean(id))
}

impl Blocks {
    /// The transducer's centre, metres.
    #[must_use]
    pub fn transducer_m(&self, x: &ParameterSet) -> Vector3<f64> {
        vector(x, self.transducer)
    }

    /// The turn of the datum, radians.
    #[must_use]
    pub fn datum_rad(&self, x: &ParameterSet) -> Vector3<f64> {
        vector(x, self.datum)
    }

    /// The range scale.
    #[must_use]
    pub fn scale_of(&self, x: &ParameterSet) -> f64 {
        x.euclidean(self.scale)[0]
    }
}

/// Conditions of the fixes of common beacons, three per fix, in the order of time.
#[derive(Debug)]
pub struct FixConditions<'a> {
    /// The scene.
    pub scene: &'a Scene<'a>,
    /// The unknowns.
    pub blocks: &'a Blocks,
    /// Rows of the fixes.
    pub fixes: &'a [u32],
    /// Epoch of the chain of each attitude record; `None` without attitude noise.
    pub epochs: Option<&'a [u32]>,
}

/// The rays to the beacons at the current parameters, each found when it is first asked for.
struct Rays<'a> {
    conditions: &'a FixConditions<'a>,
    x: &'a ParameterSet,
    found: Vec<Option<Option<Eigenray>>>,
}

impl Rays<'_> {
    fn to(&mut self, beacon: usize) -> Option<Eigenray> {
        if let Some(known) = self.found[beacon] {
            return known;
        }
        let blocks = self.conditions.blocks;
        let ray = blocks.beacons[beacon].and_then(|id| {
            let transducer_m = blocks.transducer_m(self.x);
            let scene = self.conditions.scene;
            scene.ray(&transducer_m, &vector(self.x, id)).ok()
        });
        self.found[beacon] = Some(ray);
        ray
    }
}

impl<'a> FixConditions<'a> {
    fn rays(&'a self, x: &'a ParameterSet) -> Rays<'a> {
        Rays {
            conditions: self,
            x,
            found: vec![None; self.blocks.beacons.len()],
        }
    }

    fn fill(
        &self,
        k: usize,
        x: &ParameterSet,
        rays: &mut Rays,
        chain: Option<&ChainState>,
        row: &mut Row,
    ) -> Option<()> {
        let fix = self.fixes[k / PER_FIX] as usize;
        let beacon = self.scene.campaign.fixes.beacon[fix] as usize;
        let ray = rays.to(beacon)?;
        let position = self.blocks.beacons[beacon]?;
        match k % PER_FIX {
            0 => self.range(fix, x, &ray, position, row),
            component => self.angle(fix, component - 1, x, (&ray, position), chain, row),
        }
        if row.chain.is_none() {
            row.chain = self.no_share(fix);
        }
        Some(())
    }

    /// The range; it does not see the attitude.
    fn range(
        &self,
        fix: usize,
        x: &ParameterSet,
        ray: &Eigenray,
        position: BlockId,
        row: &mut Row,
    ) {
        let fixes = &self.scene.campaign.fixes;
        let (speed, scale) = (fixes.speed_m_s, self.blocks.scale_of(x));
        row.misclosure = speed * (ray.time_s - (1.0 + scale) * fixes.travel_time_s[fix]);
        let sigma_m = fixes.noise.range_at(speed * ray.time_s) * (1.0 + scale);
        row.variance = sigma_m * sigma_m;
        row.extend(
            x.offset(self.blocks.transducer),
            (ray.time_by_start * speed).as_slice(),
        );
        row.extend(x.offset(position), (ray.time_by_end * speed).as_slice());
        // by the adjusted time: the measured one errs together with the misclosure
        row.push(
            x.offset(self.blocks.scale),
            -speed * ray.time_s / (1.0 + scale),
        );
    }

    /// One component of the direction.
    fn angle(
        &self,
        fix: usize,
        component: usize,
        x: &ParameterSet,
        (ray, position): (&Eigenray, BlockId),
        chain: Option<&ChainState>,
        row: &mut Row,
    ) {
        let fixes = &self.scene.campaign.fixes;
        let observed = fixes.direction[fix];
        let axis = fixes.noise.axes(&observed)[component];
        let mounting = x.rotation(self.blocks.mounting);
        let level_from_body = self.attitude(fix, x, chain);
        let in_body = mounting * axis;
        let in_level = level_from_body * in_body;
        row.misclosure = in_level.dot(&ray.direction) - axis.dot(&observed);
        row.variance = fixes.noise.angle_rad.powi(2);

        let arriving = level_from_body.tr_mul(&ray.direction);
        let turned = in_level.cross(&ray.direction);
        row.extend(
            x.offset(self.blocks.mounting),
            in_body.cross(&arriving).as_slice(),
        );
        let by = |derivative: &Matrix3<f64>| derivative.tr_mul(&in_level);
        row.extend(
            x.offset(self.blocks.transducer),
            by(&ray.direction_by_start).as_slice(),
        );
        row.extend(x.offset(position), by(&ray.direction_by_end).as_slice());
        row.extend(x.offset(self.blocks.datum), turned.as_slice());
        if let Some(mut share) = self.no_share(fix) {
            share.visible[3..].copy_from_slice(turned.as_slice());
            row.chain = Some(share);
        }
    }

    /// The interval of a fix without derivatives.
    fn no_share(&self, fix: usize) -> Option<ChainRow> {
        let pose = &self.scene.poses[fix];
        Some(ChainRow {
            interval: self.epochs?[pose.record as usize],
            weight0: pose.weight_before,
            weight1: 1.0 - pose.weight_before,
            visible: [0.0; VISIBLE],
        })
    }

    /// `Exp(psi + datum) R_measured` at a fix.
    fn attitude(&self, fix: usize, x: &ParameterSet, chain: Option<&ChainState>) -> Matrix3<f64> {
        let pose = &self.scene.poses[fix];
        let mut turn = self.blocks.datum_rad(x);
        if let (Some(epochs), Some(chain)) = (self.epochs, chain) {
            let interval = epochs[pose.record as usize];
            let y = chain.between(interval, pose.weight_before, 1.0 - pose.weight_before);
            turn += Vector3::new(y[3], y[4], y[5]);
        }
        rotation::exp(&turn) * pose.rotation
    }
}

impl Conditions for FixConditions<'_> {
    fn len(&self) -> usize {
        PER_FIX * self.fixes.len()
    }

    fn group(&self, k: usize) -> u16 {
        if k.is_multiple_of(PER_FIX) {
            RANGES
        } else {
            ANGLES
        }
    }

    fn cell(&self, k: usize) -> u16 {
        self.scene.campaign.fixes.beacon[self.fixes[k / PER_FIX] as usize] as u16
    }

    fn interval(&self, k: usize) -> Option<u32> {
        let fix = self.fixes[k / PER_FIX] as usize;
        Some(self.epochs?[self.scene.poses[fix].record as usize])
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        // an unfilled row keeps its misclosure that is not a number
        let _ = self.fill(k, x, &mut self.rays(x), chain, row);
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        chain: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        let mut rays = self.rays(x);
        for (k, row) in range.zip(rows) {
            row.clear();
            if self.fill(k, x, &mut rays, chain, row).is_none() {
                row.clear();
            }
        }
    }
}
