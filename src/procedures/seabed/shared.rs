//! What the white noise of the INS does beyond what the blocks know.
//!
//! A tile takes the noise of its soundings as independent. That of range and angle is; that of an INS record is not: every beam of a ping,
//! and every ping between the same two records, has it in common, in all tiles that the ping meets. With many beams the mean over a ping
//! would be believed better than the INS record it hangs on. The estimate stays what it is; its covariance is that of the same linear
//! estimator under the noise as it is:
//!
//! `C = N^-1 + sum_i sigma^2 (g_i g_i') - 2/3 sum_k sigma^2 c_k^2 q_k q_k'`
//!
//! with `q_k` the change of the parameters with sounding k's height, `c_k` the change of that height with a component of the record's
//! error, `g_i` the sum of `w_ik c_k q_k` over the soundings that record i takes part in with weight `w_ik` (linear interpolation), and
//! 2/3 the mean of `w^2 + (1 - w)^2`, which is what the blocks have.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::field::Field;
use super::model::Locator;
use super::normal::{Part, Placed, Rows, Solved, Sought};
use super::scene::InsNoise;
use super::states::Component;
use super::tiles::Tile;

/// One value of each parameter.
pub type Parameters = DVector<f64>;
/// A covariance of the parameters.
pub type Covariance = DMatrix<f64>;

/// Components of a record's error.
const COMPONENTS: [Component; 6] = [
    Component::East,
    Component::North,
    Component::Up,
    Component::Pitch,
    Component::Roll,
    Component::Heading,
];

fn sigma(component: Component, ins: &InsNoise) -> f64 {
    match component {
        Component::East | Component::North | Component::Up | Component::LineHeight => {
            ins.position_m
        }
        Component::Pitch | Component::Roll => ins.roll_pitch_rad,
        Component::Heading => ins.heading_rad,
    }
}

/// One sounding's part in the parameters.
#[derive(Clone, Debug, PartialEq)]
struct Influence {
    /// Record before it, and the weight of the one after.
    record: usize,
    weight: f64,
    /// Change of the parameters with its height.
    parameters: Parameters,
    /// Change of its height with each component of an error of the INS, times that component's sigma.
    errors: [f64; 6],
    /// Variance that the blocks have of the INS, square metres.
    known_m2: f64,
}

/// The white noise of the INS in the covariance of the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedNoise {
    /// What is to be added to `N^-1`.
    pub extra: Covariance,
    /// All of it.
    pub all: Covariance,
}

/// What the white noise of the INS does.
#[must_use]
pub fn shared_noise(
    locator: &Locator<'_>,
    tiles: &[Tile],
    alive: &[bool],
    (field, sought): (&Field, &Sought),
    solved: &Solved,
) -> SharedNoise {
    let of = |tile: &Tile| {
        let placed = Placed::new(locator.scene, locator, tile, alive);
        influences(locator, &placed, field, sought, solved).unwrap_or_default()
    };
    let all: Vec<Vec<Influence>> = tiles.par_iter().map(of).collect();
    together(solved.inverse.len(), all.iter().flatten())
}

fn influences(
    locator: &Locator<'_>,
    placed: &Placed,
    field: &Field,
    sought: &Sought,
    solved: &Solved,
) -> Option<Vec<Influence>> {
    let rows = Rows::new(locator, placed, field, sought, Part::All)?;
    let pulls = rows.pulls()?;
    let trajectory = &locator.scene.trajectory;
    let times = trajectory.times_s();
    let one = |k: usize| {
        let located = &placed.located[k];
        let record = trajectory.record_before(located.time_s).ok()?;
        let change = |p: usize| -> f64 {
            let unknowns = rows.unknowns.iter().enumerate();
            unknowns
                .map(|(c, u)| pulls[(k, c)] * solved.inverse[p][*u])
                .sum()
        };
        let error = |component: Component| {
            let moved = located.state_column(component, &rows.adjusted[k]);
            rows.off_bed_m(k, &moved) * sigma(component, &locator.scene.ins)
        };
        Some(Influence {
            record,
            weight: (located.time_s - times[record]) / (times[record + 1] - times[record]),
            parameters: Parameters::from_fn(solved.inverse.len(), |p, _| change(p)),
            errors: COMPONENTS.map(error),
            known_m2: placed.points.noise[k].ins_m2,
        })
    };
    (0..placed.numbers.len()).map(one).collect()
}

/// Adds `factor a a'` to a covariance.
pub(super) fn add_square(sum: &mut Covariance, a: &Parameters, factor: f64) {
    for (column, y) in a.iter().enumerate() {
        for (row, x) in a.iter().enumerate() {
            sum[(row, column)] += x * y * factor;
        }
    }
}

/// Sums over the records, with and without what the blocks have, of so many parameters.
fn together<'a>(count: usize, all: impl Iterator<Item = &'a Influence>) -> SharedNoise {
    let nothing = || Parameters::zeros(count);
    let mut records: BTreeMap<usize, [Parameters; 6]> = BTreeMap::new();
    let (mut sum, mut known) = (
        Covariance::zeros(count, count),
        Covariance::zeros(count, count),
    );
    for one in all {
        for (record, weight) in [(one.record, 1.0 - one.weight), (one.record + 1, one.weight)] {
            let each = || std::array::from_fn(|_| nothing());
            let moved = records.entry(record).or_insert_with(each);
            for (total, error) in moved.iter_mut().zip(one.errors) {
                *total += &one.parameters * (weight * error);
            }
        }
        add_square(&mut known, &one.parameters, one.known_m2);
    }
    for moved in records.values().flatten() {
        add_square(&mut sum, moved, 1.0);
    }
    SharedNoise {
        extra: &sum - known,
        all: sum,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: usize = 10;

    fn beam(record: usize, weight: f64) -> Influence {
        Influence {
            record,
            weight,
            parameters: Parameters::from_fn(COUNT, |p, _| if p == 0 { 0.5 } else { 0.0 }),
            errors: [0.0, 0.0, 0.002, 0.0, 0.0, 0.0],
            known_m2: 0.002 * 0.002,
        }
    }

    /// Beams of one ping on a record: their common 2 mm moves the parameter by n / 2 of 2 mm, not by sqrt(n) / 2.
    #[test]
    fn beams_of_one_ping_share_its_record() {
        let n = 40.0;
        let ping: Vec<Influence> = (0..40).map(|_| beam(7, 0.0)).collect();
        let known = n * 0.25 * 0.002 * 0.002;
        let expected = (n * 0.5 * 0.002_f64).powi(2) - known;
        assert!((together(COUNT, ping.iter()).extra[(0, 0)] - expected).abs() < 1e-15);
    }

    /// One beam on each of many records is what the blocks take it for.
    #[test]
    fn beams_on_records_of_their_own_add_nothing() {
        let apart: Vec<Influence> = (0..40).map(|k| beam(3 * k, 0.0)).collect();
        assert!(together(COUNT, apart.iter()).extra.amax() < 1e-18);
    }

    /// Half way between two records the noise is halved in variance, whoever shares it.
    #[test]
    fn between_records_the_noise_is_their_mean() {
        let middle = Influence {
            known_m2: 0.0,
            ..beam(3, 0.5)
        };
        let variance = together(COUNT, [&middle].into_iter()).all[(0, 0)];
        assert!((variance - 0.5 * 0.25 * 4e-6).abs() < 1e-18, "{variance}");
    }
}
