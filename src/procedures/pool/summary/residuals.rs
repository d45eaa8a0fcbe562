//! Distances of the soundings from the planes of their faces, the same soundings under every path's mounting.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::super::joint::JointOutcome;
use super::super::planes;
use super::super::run::PoolOutcome;
use super::super::scene::Scene;
use super::super::ties::{PlacedBy, Tie, TieSet, tie_soundings_first};
use super::sample_types::PerPath;
use crate::geometry::plane::Plane;
use crate::georef::georeference;
use crate::matching::{Patches, Water};
use crate::observe::Mounting;

/// Rows per parallel task; fixed, so that sums do not depend on the threads.
const CHUNK: usize = 16_384;
/// Gate (sigmas) of the ties that are found here when no joint path ran.
const GATE: f64 = 5.0;

/// The model that a joint path found.
fn of_joint(joint: &JointOutcome) -> PlacedBy<'_> {
    PlacedBy {
        sensor: joint.blocks.sensor(&joint.solution.estimate.parameters),
        extras: &joint.extras,
    }
}

/// Which soundings lie on which plane, and the sensor models that place them.
#[derive(Clone, Debug)]
pub struct Residuals<'a> {
    /// The soundings: those of the joint path where it ran.
    pub ties: TieSet,
    /// Plane of every face, normal to the outside: the joint path's where it ran, else the scanner's.
    pub faces: Vec<Option<Plane>>,
    /// The models of the paths that found one.
    pub models: PerPath<PlacedBy<'a>>,
}

impl<'a> Residuals<'a> {
    /// Of an outcome.
    #[must_use]
    pub fn of(outcome: &'a PoolOutcome) -> Self {
        let sequential = match &outcome.sequential {
            Some(Ok(found)) => Some(PlacedBy::mounting(found.mounting)),
            _ => None,
        };
        let model = |joint: &'a Option<JointOutcome>| {
            joint
                .as_ref()
                .filter(|j| is_finite(&j.mounting))
                .map(of_joint)
        };
        let models = PerPath {
            reference: sequential,
            joint: model(&outcome.joint),
            joint_simple: model(&outcome.simple),
        };
        let faces = face_planes(outcome);
        let ties = match (&outcome.joint, sequential) {
            (Some(joint), _) => joint.soundings.clone(),
            (None, Some(model)) => tie_again(outcome, &model.sensor.mounting),
            (None, None) => TieSet::default(),
        };
        Self {
            ties,
            faces,
            models,
        }
    }

    /// Signed distance of a tied sounding from its face, outwards, metres.
    #[must_use]
    pub fn distance_m(&self, outcome: &PoolOutcome, tie: &Tie, model: &PlacedBy) -> Option<f64> {
        let plane = self.faces[tie.face as usize]?;
        Some(plane.distance_m(&sounding_point(&outcome.scene, tie.row as usize, model)?))
    }

    /// Count, sum and sum of squares of the distances on every face, metres; summed in the order of the rows.
    #[must_use]
    pub fn sums(&self, outcome: &PoolOutcome, model: &PlacedBy) -> Vec<Sums> {
        let starts = (0..self.ties.len()).into_par_iter().step_by(CHUNK);
        let part = |start| self.part(outcome, model, self.ties.from(start).take(CHUNK));
        let chunks: Vec<Vec<Sums>> = starts.map(part).collect();
        let mut all = vec![Sums::default(); self.faces.len()];
        for chunk in &chunks {
            all.iter_mut().zip(chunk).for_each(|(a, b)| a.merge(b));
        }
        all
    }

    fn part(
        &self,
        outcome: &PoolOutcome,
        model: &PlacedBy,
        ties: impl Iterator<Item = Tie>,
    ) -> Vec<Sums> {
        let mut faces = vec![Sums::default(); self.faces.len()];
        for tie in ties {
            if let Some(distance_m) = self.distance_m(outcome, &tie, model) {
                faces[tie.face as usize].add(distance_m);
            }
        }
        faces
    }
}

/// Count, sum and sum of squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// How many.
    pub count: u64,
    sum: f64,
    squares: f64,
}

impl Sums {
    fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
    }

    /// Both together.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// The mean; `None` of nothing.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// The root mean square; `None` of nothing.
    #[must_use]
    pub fn rms(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }
}

/// Sounding `row` in the target frame under a sensor model, metres; `None` where it has no position.
#[must_use]
pub fn sounding_point(scene: &Scene, row: usize, model: &PlacedBy) -> Option<Vector3<f64>> {
    let (pose, beam) = model.beam(scene, row)?;
    Some(georeference(
        &pose,
        &model.sensor.mounting,
        &beam.vector_m(),
    ))
}

fn is_finite(mounting: &Mounting) -> bool {
    mounting
        .rotation
        .iter()
        .chain(mounting.lever_arm_m.iter())
        .all(|v| v.is_finite())
}

/// Every face's plane, normal to the outside.
fn face_planes(outcome: &PoolOutcome) -> Vec<Option<Plane>> {
    let target = outcome.scene.target;
    let plane = |(k, face): (usize, &crate::target::Face)| {
        let group = match &outcome.joint {
            Some(joint) => {
                let found = joint.blocks.faces[k].as_ref()?;
                let x = &joint.solution.estimate.parameters;
                let own_m = found.offset.map_or(found.design_m, |id| x.euclidean(id)[0]);
                Plane {
                    normal: x.normal(found.normal),
                    offset_m: x.euclidean(found.distance)[0] + own_m,
                }
            }
            None => {
                let fitted = outcome.planes.get(face.group)?.as_ref()?.fit.plane;
                Plane {
                    offset_m: fitted.offset_m + target.design_offset_m(k),
                    ..fitted
                }
            }
        };
        Some(if face.facing < 0.0 {
            group.flipped()
        } else {
            group
        })
    };
    target.faces.iter().enumerate().map(plane).collect()
}

/// Ties of all soundings under a mounting, against the scanner's planes.
fn tie_again(outcome: &PoolOutcome, mounting: &Mounting) -> TieSet {
    let scene = &outcome.scene;
    let mut patches = Patches::new(
        scene.target,
        Water::Below,
        scene.campaign.water_level_m,
        &scene.origins(mounting),
    );
    let fitted: Vec<Option<Plane>> = outcome
        .planes
        .iter()
        .map(|p| p.map(|p| p.fit.plane))
        .collect();
    planes::apply(&mut patches, scene, &fitted);
    let near = scene.soundings_near(&patches, mounting, 0.5);
    tie_soundings_first(scene, &patches, &near, mounting, GATE)
}
