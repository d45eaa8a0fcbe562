//! A fingerprint of the arithmetic: equal on two machines whose last digits agree, as far as a thousand figures tell.
//!
//! Everything that makes figures is asked: the functions of [`crate::math`], those that nalgebra calls, random draws, distributions,
//! dense sums, and one small adjustment over a chain with a robust kernel and its judgement.

use std::sync::LazyLock;

use nalgebra::{DMatrix, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};
use sha2::{Digest, Sha256};

use super::{
    Block, ChainModel, ChainRow, ChainState, Component, Conditions, Estimate, Kernel, Options,
    ParameterSet, Problem, Process, ProcessKind, QualityOptions, Row, Source, Unit, VISIBLE,
    assess, solve,
};
use crate::math;
use crate::math::dense::product;
use crate::math::skyline::Skyline;
use crate::stats::{ChiSquare, normal, stream};

/// SHA-256, 64 hexadecimal digits, of a thousand function values and of a small adjustment. It stands in ledgers and results; trials
/// of different fingerprints do not belong in one ledger. Takes some milliseconds when it is first asked for.
#[must_use]
pub fn fingerprint() -> &'static str {
    static FINGERPRINT: LazyLock<String> = LazyLock::new(|| digest(&figures()));
    &FINGERPRINT
}

fn digest(figures: &[f64]) -> String {
    let mut sha = Sha256::new();
    figures.iter().for_each(|x| sha.update(x.to_le_bytes()));
    sha.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

fn figures() -> Vec<f64> {
    let mut all = functions();
    all.extend(matrices());
    all.extend(distributions());
    // a problem that cannot be solved here would be another arithmetic too
    all.extend(adjusted().unwrap_or_default());
    all
}

/// Arguments without a pattern: half of them in (0, 1), half beyond.
fn argument(k: u32) -> f64 {
    let x = (0.618_033_988_749_894_9 * f64::from(k + 1)).fract();
    if k.is_multiple_of(2) { x } else { 40.0 * x }
}

/// Forty values of each function.
fn functions() -> Vec<f64> {
    let of = |k: u32| {
        let x = argument(k);
        let (unit, y) = (x.fract(), argument(k + 1));
        let (sine, cosine) = math::sin_cos(y);
        [
            math::sin(x),
            math::cos(x),
            sine,
            cosine,
            math::tan(x),
            math::asin(unit),
            math::acos(unit),
            math::atan2(x - 3.0, y - 3.0),
            math::sinh(unit),
            math::asinh(x),
            math::atanh(unit),
            math::exp(-x),
            math::exp_m1(unit),
            math::ln(x),
            math::ln_1p(x),
            math::log10(x),
            math::powf(x, y),
            math::hypot(x, y),
            math::cbrt(x),
            math::erfc(x / 10.0),
            math::ln_gamma(x),
            x.sqrt(),
            x.powi(3),
            x.powi(-2),
            x.mul_add(y, -unit),
        ]
    };
    (0..40).flat_map(of).collect()
}

/// The equations `gram x = right`, column by column of the right-hand side.
fn solved(gram: &DMatrix<f64>, right: &DMatrix<f64>) -> Vec<f64> {
    let all: Vec<usize> = (0..gram.nrows()).collect();
    let mut equations = Skyline::new(all.len(), 1, std::iter::once(&all[..]));
    for i in 0..all.len() {
        (0..=i).for_each(|j| equations.add(i, j, gram[(i, j)]));
    }
    let right: Vec<Vec<f64>> = (right.column_iter())
        .map(|column| column.iter().copied().collect())
        .collect();
    equations.solve(&right).unwrap_or_default().concat()
}

/// Rotations, products, factors and eigenvalues.
fn matrices() -> Vec<f64> {
    let filled = DMatrix::from_fn(12, 12, |i, j| {
        argument((31 * i + 7 * j) as u32).fract() - 0.5
    });
    let gram = product(&filled, &filled.transpose()) + DMatrix::identity(12, 12);
    let solved = solved(&gram, &filled);
    let eigen = SymmetricEigen::new(gram);
    let turn = Rotation3::new(Vector3::new(0.3, -0.5, 1.1));
    let axis = UnitQuaternion::from_rotation_matrix(&turn).scaled_axis();
    let fixed = turn.matrix().svd(true, true);
    let rows = filled.clone().qr().unpack_r();
    [
        &solved,
        eigen.eigenvalues.as_slice(),
        axis.as_slice(),
        fixed.singular_values.as_slice(),
        rows.as_slice(),
    ]
    .concat()
}

fn distributions() -> Vec<f64> {
    let mut random = stream(1, 1);
    let mut all: Vec<f64> = (0..500).map(|_| normal::draw(&mut random)).collect();
    for k in 1..20_u32 {
        let p = f64::from(k) / 20.0;
        all.push(normal::quantile(p));
        all.push(normal::above(6.0 * p));
        if let Some(chi) = ChiSquare::new(f64::from(3 * k)) {
            all.extend([chi.quantile(p), chi.above(f64::from(k))]);
        }
    }
    all
}

/// Conditions in each interval of the small problem.
const EACH: usize = 8;

/// Columns of its parameters.
const COLUMNS: usize = 4;

/// Linear conditions with one gross error.
struct Small(ChainModel);

impl Small {
    fn coefficient(k: usize, place: usize) -> f64 {
        argument((17 * k + 5 * place) as u32).fract() - 0.5
    }
}

impl Conditions for Small {
    fn len(&self) -> usize {
        EACH * self.0.intervals()
    }

    fn interval(&self, k: usize) -> Option<u32> {
        Some((k / EACH) as u32)
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        let interval = (k / EACH) as u32;
        let a: [f64; COLUMNS] = std::array::from_fn(|i| Self::coefficient(k, i));
        let visible: [f64; VISIBLE] = std::array::from_fn(|i| Self::coefficient(k, 9 + i));
        let (weight0, weight1) = (0.25, 0.75);
        let known = a.iter().zip(&x.blocks()[0].value).map(|(a, x)| a * x);
        row.misclosure = known.sum::<f64>() - math::sin(k as f64);
        if let Some(chain) = chain {
            let state = chain.between(interval, weight0, weight1);
            row.misclosure += visible.iter().zip(state).map(|(v, s)| v * s).sum::<f64>();
        }
        row.misclosure += if k == 11 { 50.0 } else { 0.0 };
        row.variance = 0.1;
        row.extend(0, &a);
        row.chain = Some(ChainRow {
            interval,
            weight0,
            weight1,
            visible,
        });
    }
}

/// Parameters, states, covariance and quality of the small problem.
fn adjusted() -> Option<Vec<f64>> {
    let drift = |component| Process {
        component,
        sigma: 0.5,
        kind: ProcessKind::GaussMarkov { tau_s: 20.0 },
    };
    let times = (0..12).map(|k| 0.7 * f64::from(k)).collect();
    let small = Small(ChainModel::new(times, (0..VISIBLE).map(drift).collect()).ok()?);
    let names = ["a", "b", "c", "d"].map(|name| Component::new(name, Unit::Metre));
    let mut start = ParameterSet::new();
    let block = Block::euclidean("small", names.to_vec(), &[0.0; COLUMNS]).sought();
    start.push(block).ok()?;
    let problem = Problem::with_chain(vec![Source::new(&small)], &small.0);
    let options = Options {
        kernel: Kernel::Huber { k: 1.345 },
        ..Options::default()
    };
    let solution = solve(&problem, Estimate::new(start), &options).ok()?;
    let quality = assess(&problem, &solution, &QualityOptions::default()).ok()?;
    let mut all = solution.estimate.parameters.blocks()[0].value.clone();
    if let Some(chain) = &solution.estimate.chain {
        (0..small.0.epochs()).for_each(|epoch| all.extend_from_slice(chain.state(epoch)));
    }
    all.extend(solution.cofactor.iter());
    let global = &quality.global;
    all.extend([global.variance_factor, global.degrees_of_freedom]);
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_values_and_an_adjustment_are_in_it() {
        assert_eq!(functions().len(), 1000);
        assert!(adjusted().is_some_and(|all| all.len() > 90));
        assert!(figures().iter().all(|x| x.is_finite()));
        assert_eq!(fingerprint().len(), 64);
        assert_eq!(fingerprint(), digest(&figures()));
    }

    /// Every machine that boresight is tested on must say the same; a change of it means other last digits, once, for all ledgers.
    #[test]
    fn it_is_the_one_of_all_machines() {
        let stated = "945aa1d613f723360905f17c24ad39bdb749a2ca9e1c907a22089acd5611ecd9";
        assert_eq!(fingerprint(), stated);
    }

    #[test]
    fn one_last_bit_makes_another() {
        let mut all = figures();
        let before = digest(&all);
        all[517] = all[517].next_up();
        assert_ne!(digest(&all), before);
    }
}
