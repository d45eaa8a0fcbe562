//! What the directions of the tied faces determine, the boat's motion aside.
//!
//! A plain quay wall gives a formally regular normal matrix: roll and pitch of the boat turn its one normal a little in the
//! body frame, and pitch, yaw and two components of the lever arm hang on that alone (`docs/joint-path.md`). Such a result
//! stands and falls with errors that no residual shows (latency of the attitude, flexing of the mount), so it is refused. The
//! judgement takes the mean attitude of each pass, gives every plane the same weight, and looks at the directions that remain.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::joint::SIX;
use super::planes::PASS_GAP_S;
use super::scene::Scene;
use super::ties::{Tie, TieSet};
use crate::geometry::rotation;
use crate::observe::Mounting;

/// Ties that are looked at, at the most.
const LOOKED_AT: usize = 20_000;
/// Fewest ties of a plane that counts.
const LEAST_TIES: usize = 10;
/// A direction with less than this share of the best determined one hangs on the boat's motion alone.
const LEAST_SHARE: f64 = 8e-3;

/// Shares of information by direction, best first, and the directions themselves (columns), in the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Of the three angles (pitch, roll, yaw).
    pub rotation: (Vector3<f64>, Matrix3<f64>),
    /// Of the lever arm.
    pub lever_arm: (Vector3<f64>, Matrix3<f64>),
}

impl Coverage {
    /// Of these ties under a mounting.
    #[must_use]
    pub fn of(scene: &Scene, ties: &TieSet, mounting: &Mounting) -> Self {
        let groups = scene.target.groups.len();
        let mut rotation = vec![Matrix3::zeros(); groups];
        let mut lever = vec![Matrix3::zeros(); groups];
        let mut count = vec![0usize; groups];
        for pass in passes(scene, ties) {
            let Some(mean) = mean_attitude(scene, &pass) else {
                continue;
            };
            for tie in pass {
                let k = tie.row as usize;
                let Some(pose) = scene.sounding_pose(k, 0.0) else {
                    continue;
                };
                let Some(beam) = scene.beam(k, &pose, mounting) else {
                    continue;
                };
                let group = scene.target.faces[tie.face as usize].group;
                let in_body = mean.tr_mul(&scene.target.groups[group].normal);
                let turn = (mounting.rotation * beam.vector_m()).cross(&in_body);
                rotation[group] += turn * turn.transpose();
                lever[group] += in_body * in_body.transpose();
                count[group] += 1;
            }
        }
        let mean = |sums: &[Matrix3<f64>]| {
            let counted = sums.iter().zip(&count).filter(|(_, n)| **n >= LEAST_TIES);
            counted.fold(Matrix3::zeros(), |all, (m, n)| all + m / *n as f64)
        };
        Self {
            rotation: shares(&mean(&rotation)),
            lever_arm: shares(&mean(&lever)),
        }
    }

    /// The parameters, in the order of [`SIX`], that lie along directions without enough share.
    #[must_use]
    pub fn uncovered(&self) -> [bool; 6] {
        let mut found = [false; 6];
        for (first, (share, directions)) in [(0, &self.rotation), (3, &self.lever_arm)] {
            for (k, share) in share.iter().enumerate() {
                for axis in 0..3 {
                    let along = directions[(axis, k)].abs() > 0.5;
                    found[first + axis] |= !(*share >= LEAST_SHARE) && along;
                }
            }
        }
        found
    }

    /// Names of the uncovered parameters.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        SIX.iter()
            .zip(self.uncovered())
            .filter(|(_, u)| *u)
            .map(|(n, _)| *n)
            .collect()
    }
}

/// Ties thinned evenly and split where the time jumps.
fn passes(scene: &Scene, ties: &TieSet) -> Vec<Vec<Tie>> {
    let time_s = |t: &Tie| scene.campaign.soundings.at_s(t.row as usize);
    let mut passes: Vec<Vec<Tie>> = vec![];
    for tie in ties.iter().step_by(ties.len().div_ceil(LOOKED_AT).max(1)) {
        match passes.last_mut() {
            Some(pass)
                if pass
                    .last()
                    .is_some_and(|l| time_s(&tie) - time_s(l) <= PASS_GAP_S) =>
            {
                pass.push(tie);
            }
            _ => passes.push(vec![tie]),
        }
    }
    passes
}

fn mean_attitude(scene: &Scene, pass: &[Tie]) -> Option<Matrix3<f64>> {
    let sum = pass
        .iter()
        .filter_map(|t| scene.sounding_pose(t.row as usize, 0.0))
        .fold(Matrix3::zeros(), |sum, pose| sum + pose.rotation);
    (sum.norm() > 0.0).then(|| rotation::orthonormalised(&sum))
}

fn shares(information: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let eigen = SymmetricEigen::new(*information);
    let best = eigen.eigenvalues.max();
    let share = if best > 0.0 {
        eigen.eigenvalues / best
    } else {
        Vector3::zeros()
    };
    (share, eigen.eigenvectors)
}
