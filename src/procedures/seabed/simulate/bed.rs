//! A seabed with a known height everywhere: a slope, cosines of random direction and length, ripples, boulders.

use std::collections::BTreeMap;

use nalgebra::Vector2;
use rand::RngExt;

use super::super::survey::scenario::Bed;
use crate::math;
use crate::stats::normal;
use crate::stats::stream;

/// Cosines that make up the relief.
const COSINES: usize = 200;

/// A seabed.
pub struct Seabed {
    depth_m: f64,
    slope: Vector2<f64>,
    cosines: Vec<Cosine>,
    boulders: BTreeMap<[i64; 2], Vec<Boulder>>,
}

/// A hump: height, place and radius.
struct Boulder {
    at: Vector2<f64>,
    height_m: f64,
    radius_m: f64,
}

/// Side of the squares in which boulders are looked for, metres: more than a boulder reaches.
const SQUARE_M: f64 = 5.0;

struct Cosine {
    amplitude_m: f64,
    wave: Vector2<f64>,
    phase: f64,
}

impl Seabed {
    /// The seabed of a scenario under a seed; boulders lie in the rectangle `around` (two corners, metres).
    #[must_use]
    pub fn new(bed: &Bed, around: [Vector2<f64>; 2], seed: u64) -> Self {
        let fall = bed.azimuth_deg.to_radians();
        let steep = math::tan(bed.slope_deg.to_radians());
        let mut draws = stream(seed, 1);
        let mut cosines: Vec<Cosine> = (0..COSINES)
            .map(|_| {
                // wave numbers of a Matern 3/2 field: a normal vector over the root of a chi-square of 3 over 3
                let spread = (0..3)
                    .map(|_| normal::draw(&mut draws).powi(2))
                    .sum::<f64>()
                    / 3.0;
                let wave = Vector2::new(normal::draw(&mut draws), normal::draw(&mut draws));
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
            boulders: boulders(bed, around, seed),
            depth_m: bed.depth_m,
            slope: Vector2::new(-steep * math::sin(fall), -steep * math::cos(fall)),
            cosines,
        }
    }

    /// Height at a place, metres.
    #[must_use]
    pub fn height_m(&self, at: &Vector2<f64>) -> f64 {
        let relief: f64 = self
            .cosines
            .iter()
            .map(|c| c.amplitude_m * math::cos(c.wave.dot(at) + c.phase))
            .sum();
        self.slope.dot(at) - self.depth_m + relief + self.boulder_m(at)
    }

    /// Height of the boulders at a place.
    fn boulder_m(&self, at: &Vector2<f64>) -> f64 {
        if self.boulders.is_empty() {
            return 0.0;
        }
        let [x, y] = square(at);
        let near = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
        let all = near.filter_map(|place| self.boulders.get(&place)).flatten();
        let hump = |b: &Boulder| {
            b.height_m * math::exp(-0.5 * (at - b.at).norm_squared() / (b.radius_m * b.radius_m))
        };
        all.map(hump).sum()
    }
}

fn square(at: &Vector2<f64>) -> [i64; 2] {
    [at.x, at.y].map(|x| (x / SQUARE_M).floor() as i64)
}

/// Humps 0.2 to 0.8 m high, half a metre to a metre in radius.
fn boulders(
    bed: &Bed,
    [low, high]: [Vector2<f64>; 2],
    seed: u64,
) -> BTreeMap<[i64; 2], Vec<Boulder>> {
    let span = high - low;
    let count = (bed.boulders_per_ha * span.x * span.y / 1e4) as usize;
    let mut draws = stream(seed, 5);
    let mut all: BTreeMap<[i64; 2], Vec<Boulder>> = BTreeMap::new();
    for _ in 0..count {
        let part = Vector2::new(draws.random_range(0.0..1.0), draws.random_range(0.0..1.0));
        let boulder = Boulder {
            at: low + span.component_mul(&part),
            height_m: draws.random_range(0.2..0.8),
            radius_m: draws.random_range(0.5..1.0),
        };
        all.entry(square(&boulder.at)).or_default().push(boulder);
    }
    all
}
