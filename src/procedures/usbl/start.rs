//! A start that gross errors do not move: the rotation that turns most observed directions into the surveyed ones.

use nalgebra::{Matrix3, Vector3};

use super::scene::Scene;
use crate::geometry::rotation::orthonormalised;

/// Reweighted fits; each halves what the first one was wrong by.
const ROUNDS: usize = 40;

/// `R_u^b` by the smallest sum of distances (not squares) between unit vectors: reweighted least squares (Wahba 1965, solved by the
/// polar factor). `None` without fixes.
#[must_use]
pub fn rotation(scene: &Scene) -> Option<Matrix3<f64>> {
    let pairs = pairs(scene);
    if pairs.is_empty() {
        return None;
    }
    let floor = scene.campaign.fixes.noise.angle_rad.max(1e-9);
    let mut found = fit(pairs.iter().map(|pair| (pair, 1.0)));
    for _ in 0..ROUNDS {
        let weight = |pair: &Pair| 1.0 / (pair.body - found * pair.transducer).norm().max(floor);
        let weighted: Vec<f64> = pairs.iter().map(weight).collect();
        found = fit(pairs.iter().zip(weighted));
    }
    Some(found)
}

/// One direction in both frames.
struct Pair {
    transducer: Vector3<f64>,
    body: Vector3<f64>,
}

fn pairs(scene: &Scene) -> Vec<Pair> {
    let fixes = &scene.campaign.fixes;
    let beacons = &scene.campaign.beacons;
    let rays: Vec<_> = beacons
        .iter()
        .map(|beacon| scene.ray(&Vector3::zeros(), &beacon.point.position_m).ok())
        .collect();
    let pair = |fix: &u32| {
        let fix = *fix as usize;
        let ray = rays[fixes.beacon[fix] as usize].as_ref()?;
        Some(Pair {
            transducer: fixes.direction[fix],
            body: scene.poses[fix].rotation.tr_mul(&ray.direction),
        })
    };
    scene.common.iter().filter_map(pair).collect()
}

fn fit<'p>(pairs: impl Iterator<Item = (&'p Pair, f64)>) -> Matrix3<f64> {
    let outer = |(pair, weight): (&Pair, f64)| pair.body * pair.transducer.transpose() * weight;
    orthonormalised(&pairs.map(outer).sum())
}
