//! The field's parameters by restricted maximum likelihood over a few tiles, with the simplex of Nelder and Mead.

use crate::math;
use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;
use argmin_math::{ArgminAdd, ArgminMul, ArgminSub};
use rayon::prelude::*;

use super::field::{Field, Points};

/// Where the parameters are looked for; an estimate at the upper bound of `noise_factor` or `sigma_m` or the lower one of `length_m` is no
/// estimate. At the lower bound of `noise_factor` the relief swallows the noise: the claimed noise is taken then, which makes no sigma
/// smaller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Relief, metres.
    pub sigma_m: [f64; 2],
    /// Correlation length, metres.
    pub length_m: [f64; 2],
    /// Noise factor.
    pub noise_factor: [f64; 2],
    /// How far the claimed noise is believed beforehand, one sigma of the factor's logarithm.
    pub noise_factor_sigma: f64,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            sigma_m: [2e-4, 5.0],
            length_m: [0.5, 60.0],
            noise_factor: [0.5, 1.9],
            // where soundings lie as far apart as the relief is correlated, relief and noise look the same, and nothing else tells them
            // apart; soundings that lie closer know the factor to a few per cent, and the belief costs nothing
            noise_factor_sigma: 0.2,
        }
    }
}

/// Slopes of the relief that are steep, one sigma: a twentieth.
const STEEP: f64 = 0.05;

/// Whether the relief is steep and yet smooth over more than two tiles, as sand waves are. Height and length then grow together as the
/// simplex happens to go, up to the bound of the height, for tiles tell only one figure made of both; the angles hang on that figure alone.
fn is_waves(field: &Field, tile_m: f64) -> bool {
    let steepness = 3f64.sqrt() * field.sigma_m / field.length_m;
    field.length_m > 2.0 * tile_m && steepness > STEEP
}

impl Bounds {
    /// Which of the parameters lies at a bound (within a hundredth), or beyond what tiles of this side can tell, in words.
    #[must_use]
    pub fn reached(&self, field: &Field, tile_m: f64) -> Option<String> {
        if field.noise_factor > self.noise_factor[1] * 0.99 {
            return Some(format!(
                "the noise of the soundings is {:.2} times the claimed one",
                field.noise_factor
            ));
        }
        if field.sigma_m > self.sigma_m[1] * 0.99 && !is_waves(field, tile_m) {
            return Some(format!(
                "the ground has steps, not the random relief that the sigmas assume: as random relief it would be {:.1} m high and \
                 correlated over {:.0} m, from tiles of {tile_m:.0} m",
                field.sigma_m, field.length_m
            ));
        }
        (field.length_m < self.length_m[0] * 1.01).then(|| {
            format!(
                "the relief is correlated over {:.2} m only, which is noise",
                field.length_m
            )
        })
    }

    /// That the ground has waves, in words; nothing where it has none.
    #[must_use]
    pub fn waves(field: &Field, tile_m: f64) -> Option<String> {
        is_waves(field, tile_m).then(|| {
            format!(
                "the ground has waves, steep and smooth over more than a tile: as random relief, which it is taken for, it is {:.1} m high and \
                 correlated over {:.0} m",
                field.sigma_m, field.length_m
            )
        })
    }

    fn of(&self, field: &Field) -> [(f64, [f64; 2]); 3] {
        [
            (field.sigma_m, self.sigma_m),
            (field.length_m, self.length_m),
            (field.noise_factor, self.noise_factor),
        ]
    }
}

struct Deviance<'a> {
    tiles: &'a [Points],
    bounds: Bounds,
}

/// Logarithms of the three parameters, as the simplex moves them.
#[derive(Clone, Debug)]
struct Logs([f64; 3]);

impl ArgminAdd<Self, Self> for Logs {
    fn add(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl ArgminSub<Self, Self> for Logs {
    fn sub(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl ArgminMul<f64, Self> for Logs {
    fn mul(&self, factor: &f64) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

fn field_of(log: &[f64; 3]) -> Field {
    Field {
        sigma_m: math::exp(log[0]),
        length_m: math::exp(log[1]),
        noise_factor: math::exp(log[2]),
    }
}

impl Deviance<'_> {
    /// The deviance, and outside the bounds that at the nearest allowed parameters plus a rising wall.
    fn of(&self, log: &[f64; 3]) -> f64 {
        let wanted = field_of(log);
        let inside = |k: usize| {
            let (x, [low, high]) = self.bounds.of(&wanted)[k];
            x.clamp(low, high)
        };
        let field = Field {
            sigma_m: inside(0),
            length_m: inside(1),
            noise_factor: inside(2),
        };
        let allowed = self.bounds.of(&field);
        let wall: f64 = self
            .bounds
            .of(&wanted)
            .iter()
            .zip(&allowed)
            .map(|(w, a)| math::ln(w.0 / a.0).powi(2))
            .sum();
        let each: Vec<f64> = self
            .tiles
            .par_iter()
            .map(|t| t.restricted_deviance(&field).unwrap_or(1e12))
            .collect();
        let belief = (math::ln(field.noise_factor) / self.bounds.noise_factor_sigma).powi(2);
        (each.iter().sum::<f64>() + belief) * (1.0 + wall.min(1.0) * 1e-3) + 1e3 * wall
    }
}

impl CostFunction for Deviance<'_> {
    type Param = Logs;
    type Output = f64;

    fn cost(&self, log: &Logs) -> Result<f64, Error> {
        Ok(self.of(&log.0))
    }
}

/// Iterations of the simplex.
const ITERATIONS: u64 = 60;

/// The noise factor of the noise as it is claimed.
pub const CLAIMED: f64 = 1.0;

/// Parameters of the field from these tiles, starting at `start`; `None` without tiles. Where the noise ends at its lower bound it is held
/// at the claimed one ([`CLAIMED`]) and the others are estimated under it.
#[must_use]
pub fn restricted_likelihood(tiles: &[Points], start: &Field, bounds: &Bounds) -> Option<Field> {
    let free = likeliest(tiles, start, bounds)?;
    if free.noise_factor > bounds.noise_factor[0] * 1.01 {
        return Some(free);
    }
    let held = Bounds {
        noise_factor: [CLAIMED; 2],
        ..*bounds
    };
    let start = Field {
        noise_factor: CLAIMED,
        ..free
    };
    likeliest(tiles, &start, &held)
}

fn likeliest(tiles: &[Points], start: &Field, bounds: &Bounds) -> Option<Field> {
    if tiles.is_empty() {
        return None;
    }
    let middle = [
        math::ln(start.sigma_m),
        math::ln(start.length_m),
        math::ln(start.noise_factor),
    ];
    let corner = |k: usize, by: f64| {
        let mut vertex = middle;
        vertex[k] += by;
        Logs(vertex)
    };
    let simplex = vec![
        Logs(middle),
        corner(0, 0.7),
        corner(1, 0.6),
        corner(2, 0.25),
    ];
    let solver = NelderMead::new(simplex).with_sd_tolerance(1e-3).ok()?;
    let problem = Deviance {
        tiles,
        bounds: *bounds,
    };
    let done = Executor::new(problem, solver)
        .configure(|state| state.max_iters(ITERATIONS))
        .ctrlc(false)
        .timer(false)
        .run()
        .ok()?;
    let best = field_of(&done.state().get_best_param()?.0);
    let [sigma, length, factor] = bounds.of(&best).map(|(x, [low, high])| x.clamp(low, high));
    Some(Field {
        sigma_m: sigma,
        length_m: length,
        noise_factor: factor,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps and noise are refused; sand waves, which tiles know by one figure of height and length, are not.
    #[test]
    fn a_field_at_a_bound_is_no_estimate() {
        let sound = Field {
            sigma_m: 0.12,
            length_m: 5.0,
            noise_factor: 1.0,
        };
        let bounds = Bounds::default();
        assert_eq!(bounds.reached(&sound, 7.0), None);
        let steps = Field {
            sigma_m: 4.999,
            length_m: 10.0,
            ..sound
        };
        let words = bounds.reached(&steps, 7.0).expect("refused");
        assert!(words.contains("steps"), "{words}");
        let field = |(sigma_m, length_m): (f64, f64)| Field {
            sigma_m,
            length_m,
            ..sound
        };
        // sand waves of 0.3 m, 14 m long, on four seeds: one ground, four fields
        for waves in [(1.13, 19.1), (3.02, 36.7), (1.60, 24.3), (4.999, 53.0)].map(field) {
            assert!(Bounds::waves(&waves, 7.0).is_some(), "{waves:?}");
            assert_eq!(bounds.reached(&waves, 7.0), None);
        }
        // the same in tiles that see it, a gentle swell, random relief
        for (other, tile_m) in [((1.13, 19.1), 28.0), ((0.2, 30.0), 7.0), ((0.3, 6.0), 7.0)] {
            assert_eq!(Bounds::waves(&field(other), tile_m), None);
            assert_eq!(bounds.reached(&field(other), tile_m), None);
        }
        let noise = Field {
            noise_factor: 1.9,
            ..sound
        };
        assert!(
            bounds
                .reached(&noise, 7.0)
                .expect("refused")
                .contains("1.90")
        );
        let swallowed = Field {
            noise_factor: CLAIMED,
            ..sound
        };
        assert_eq!(bounds.reached(&swallowed, 7.0), None);
    }

    /// A swell of the ground, sounded without an error and claimed to 0.1 m.
    fn rough(phase: f64) -> Points {
        let at = |k: usize| {
            let (x, y) = ((k % 8) as f64 - 3.5, 1.2 * (k / 8) as f64 - 3.0);
            nalgebra::Vector3::new(x, y, 0.2 * math::sin(0.9 * x + 0.5 * y + phase))
        };
        let noise = super::super::field::Noise {
            sonar_m2: 1e-2,
            ins_m2: 1e-6,
        };
        Points {
            at_m: (0..40).map(at).collect(),
            noise: vec![noise; 40],
        }
    }

    /// A rough plane of which every sounding is claimed to be far worse than it is: the noise comes out at its lower bound, and the
    /// claimed one is held.
    #[test]
    fn a_noise_that_the_relief_swallows_is_the_claimed_one() {
        let bounds = Bounds::default();
        let start = Field {
            sigma_m: 0.1,
            length_m: 3.0,
            noise_factor: 1.0,
        };
        let tiles = [rough(0.5), rough(0.7)];
        let free = likeliest(&tiles, &start, &bounds).expect("an estimate");
        assert!(free.noise_factor < 0.505, "{free:?}");
        let held = restricted_likelihood(&tiles, &start, &bounds).expect("an estimate");
        assert_eq!(held.noise_factor, CLAIMED);
    }
}
