//! A seabed with a known height everywhere: a slope, cosines of random direction and length, ripples.

use nalgebra::Vector2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::scenario::Bed;
use crate::stats::stream;

/// Cosines that make up the relief.
const COSINES: usize = 200;

/// A seabed.
pub struct Seabed {
    depth_m: f64,
    slope: Vector2<f64>,
    cosines: Vec<Cosine>,
}

struct Cosine {
    amplitude_m: f64,
    wave: Vector2<f64>,
    phase: f64,
}

impl Seabed {
    /// The seabed of a scenario under a seed.
    #[must_use]
    pub fn new(bed: &Bed, seed: u64) -> Self {
        let fall = bed.azimuth_deg.to_radians();
        let steep = bed.slope_deg.to_radians().tan();
        let mut draws = stream(seed, 1);
        let mut cosines: Vec<Cosine> = (0..COSINES)
            .map(|_| {
                // wave numbers of a Matern 3/2 field: a normal vector over the root of a chi-square of 3 over 3
                let normal = |d: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(d) };
                let spread = (0..3).map(|_| normal(&mut draws).powi(2)).sum::<f64>() / 3.0;
                let wave = Vector2::new(normal(&mut draws), normal(&mut draws));
                Cosine {
                    amplitude_m: bed.relief_m * (2.0 / COSINES as f64).sqrt(),
                    wave: wave / (spread.max(0.02).sqrt() * bed.length_m),
                    phase: draws.random_range(0.0..std::f64::consts::TAU),
                }
            })
            .collect();
        let wave = std::f64::consts::TAU / bed.ripple_length_m;
        cosines.push(Cosine {
            amplitude_m: bed.ripple_m,
            wave: Vector2::new(0.5 * wave, 0.75f64.sqrt() * wave),
            phase: 0.3,
        });
        Self {
            depth_m: bed.depth_m,
            slope: Vector2::new(-steep * fall.sin(), -steep * fall.cos()),
            cosines,
        }
    }

    /// Height at a place, metres.
    #[must_use]
    pub fn height_m(&self, at: &Vector2<f64>) -> f64 {
        let relief: f64 = self
            .cosines
            .iter()
            .map(|c| c.amplitude_m * (c.wave.dot(at) + c.phase).cos())
            .sum();
        self.slope.dot(at) - self.depth_m + relief
    }
}
