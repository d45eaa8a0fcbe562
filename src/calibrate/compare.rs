//! Has a mounting changed between two calibrations? The test of equal means with two covariances: `d = after - before`, covariance the
//! sum of both, chi-square for all parameters together and a normal test for each.
//!
//! The turn between two rotations is `log(R_after R_before^T)` in the body frame. Both covariances are of left perturbations, so the
//! earlier one is carried over by that turn.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::metric;
use crate::geometry::rotation;
use crate::math::dense::product;
use crate::results::{Calibration, Change, MountingResult, ParameterChange, Solution};
use crate::stats::normal;

/// Version of [`Change`]'s layout.
const SCHEMA: u32 = 1;
/// Names of a mounting's parameters behind its prefix: the turn, then the arm.
const NAMES: [&str; 6] = ["pitch", "roll", "yaw", "lx", "ly", "lz"];

/// A mounting in a solution.
struct Sought<'a> {
    solution: &'a Solution,
    mounting: &'a MountingResult,
    prefix: String,
}

impl<'a> Sought<'a> {
    fn new(solution: &'a Solution, mounting: &'a MountingResult) -> Self {
        let alone = solution.parameter(NAMES[0]).is_some();
        let prefix = if alone {
            String::new()
        } else {
            format!("{} ", mounting.name)
        };
        Self {
            solution,
            mounting,
            prefix,
        }
    }

    /// Where one of the six stands among the solution's parameters, if it was determined.
    fn place(&self, name: &str) -> Option<usize> {
        let name = format!("{}{name}", self.prefix);
        let mut all = self.solution.parameters.iter();
        all.position(|p| p.name == name && p.determined)
    }

    fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_row_iterator(self.mounting.rotation_matrix.into_iter().flatten())
    }

    fn arm(&self) -> Vector3<f64> {
        self.mounting
            .lever_arm_m
            .map_or_else(Vector3::zeros, Vector3::from)
    }
}

/// Covariance of all mountings' six, rad and m, of one solution; rows of what was not determined are zero.
fn covariance(all: &[&Sought<'_>]) -> Option<DMatrix<f64>> {
    let whole = all.first()?.solution.covariance.as_ref()?;
    let places: Vec<_> = all
        .iter()
        .flat_map(|sought| NAMES.map(|name| sought.place(name)))
        .collect();
    let entry = |i: usize, j: usize| places[i].zip(places[j]).map(|(i, j)| whole[i][j]);
    let size = places.len();
    Some(DMatrix::from_fn(size, size, |i, j| {
        entry(i, j).unwrap_or(0.0)
    }))
}

/// After minus before of every mounting's six, and the covariance; rows of what one of the two did not determine are zero.
fn difference(pairs: &[(Sought<'_>, Sought<'_>)]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let size = 6 * pairs.len();
    let (mut d, mut carried) = (DVector::zeros(size), DMatrix::identity(size, size));
    for (k, (before, after)) in pairs.iter().enumerate() {
        let turn = after.rotation() * before.rotation().transpose();
        d.fixed_rows_mut::<3>(6 * k)
            .copy_from(&rotation::log(&turn));
        let moved = after.arm() - before.arm();
        d.fixed_rows_mut::<3>(6 * k + 3).copy_from(&moved);
        carried
            .fixed_view_mut::<3, 3>(6 * k, 6 * k)
            .copy_from(&turn);
    }
    let (earlier, later): (Vec<_>, Vec<_>) = pairs.iter().map(|(b, a)| (b, a)).unzip();
    let mut sum = covariance(&later)?
        + product(
            &product(&carried, &covariance(&earlier)?),
            &carried.transpose(),
        );
    for (i, name) in (0..size).zip(NAMES.iter().cycle()) {
        let (before, after) = &pairs[i / 6];
        if before.place(name).is_none() || after.place(name).is_none() {
            d[i] = 0.0;
            sum.row_mut(i).fill(0.0);
            sum.column_mut(i).fill(0.0);
        }
    }
    Some((d, sum))
}

/// Mountings of the two that are the same sensor's: by name, or the only ones there are.
fn pairs<'a>(before: &'a Solution, after: &'a Solution) -> Vec<(Sought<'a>, Sought<'a>)> {
    let all = match (&before.mountings[..], &after.mountings[..]) {
        ([b], [a]) => vec![(b, a)],
        (many, others) => many
            .iter()
            .filter_map(|b| Some((b, others.iter().find(|a| a.name == b.name)?)))
            .collect(),
    };
    all.into_iter()
        .map(|(b, a)| (Sought::new(before, b), Sought::new(after, a)))
        .collect()
}

/// Compares the deciding solutions of two calibrations.
///
/// # Errors
/// What stands against a comparison: a result that is not usable, no covariance, no mounting in common.
pub fn compare(
    before: &Calibration,
    after: &Calibration,
    significance: f64,
) -> Result<Change, String> {
    let [earlier, later] = [(before, "first"), (after, "second")].map(|(result, which)| {
        let solution = result.deciding().filter(|_| result.usable);
        solution.ok_or_else(|| format!("the {which} result is not usable"))
    });
    let pairs = pairs(earlier?, later?);
    if pairs.is_empty() {
        return Err("no mounting of the same name in both".to_owned());
    }
    let (d, covariance) = difference(&pairs)
        .ok_or("a solution without a covariance, expected one that states its sigmas")?;
    let named = |after: &Sought<'_>| NAMES.map(|name| format!("{}{name}", after.prefix));
    let names: Vec<String> = pairs.iter().flat_map(|(_, after)| named(after)).collect();
    let (chi_square, degrees, p_value) = metric::chi_square(&d, &covariance)
        .filter(|(_, degrees, _)| *degrees > 0)
        .ok_or("no parameter that both determined")?;
    let each = significance / (2 * degrees) as f64;
    let parameters = single(&names, d.as_slice(), &covariance, each);
    Ok(Change {
        schema: SCHEMA,
        chi_square,
        degrees_of_freedom: degrees as u64,
        p_value,
        significance,
        changed: p_value < 0.5 * significance || parameters.iter().any(|p| p.changed),
        notes: notes(before, after),
        parameters,
    })
}

/// Each parameter that both determined, significant below the error probability `each`.
fn single(
    names: &[String],
    d: &[f64],
    covariance: &DMatrix<f64>,
    each: f64,
) -> Vec<ParameterChange> {
    let free = (0..d.len()).filter(|&i| covariance[(i, i)] > 0.0);
    free.map(|i| {
        let angle = i % NAMES.len() < 3;
        let (unit, scale) = if angle {
            ("deg", 1f64.to_degrees())
        } else {
            ("m", 1.0)
        };
        let sigma = covariance[(i, i)].sqrt();
        let in_sigmas = d[i] / sigma;
        let p_value = 2.0 * normal::above(in_sigmas.abs());
        ParameterChange {
            name: names[i].clone(),
            unit: unit.to_owned(),
            change: d[i] * scale,
            sigma: sigma * scale,
            in_sigmas,
            p_value,
            changed: p_value < each,
        }
    })
    .collect()
}

fn notes(before: &Calibration, after: &Calibration) -> Vec<String> {
    let mut notes = vec![];
    let of = |result: &Calibration| -> Vec<String> {
        let inputs = &result.provenance.inputs;
        inputs.iter().map(|file| file.sha256.clone()).collect()
    };
    let (earlier, later) = (of(before), of(after));
    let shared = later
        .iter()
        .filter(|digest| earlier.contains(digest))
        .count();
    if shared > 0 {
        notes.push(format!(
            "{shared} of the second calibration's {} input files are the first one's too; the sigmas hold for calibrations that share no observations",
            later.len()
        ));
    }
    if before.procedure != after.procedure {
        notes.push(format!(
            "the calibrations are of different procedures ({}, {})",
            before.procedure, after.procedure
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::Unit;
    use crate::calibrate::solution::{MOUNTING_PARAMETERS, Mounted, matrices};

    /// A solution with this mounting and these standard deviations of pitch, roll, yaw (rad) and the arm (m).
    fn solution(turn: Vector3<f64>, arm: Vector3<f64>, sigmas: [f64; 6]) -> Solution {
        let (rotation, nominal) = (rotation::exp(&turn), Matrix3::identity());
        let covariance = DMatrix::from_diagonal(&DVector::from_iterator(6, sigmas.map(|s| s * s)));
        let mounted = Mounted {
            name: "multibeam",
            rotation: (&rotation, &nominal),
            lever_arm_m: Some((arm, Vector3::zeros())),
            covariance: Some(&covariance),
            arrays: None,
        };
        let mut found = Solution::without_result(crate::results::Status::Converged, String::new());
        found.usable = true;
        found.parameters = mounted.parameters("");
        found.mountings = vec![mounted.result()];
        found.covariance = matrices(&covariance).0;
        found
    }

    fn change(before: &Solution, after: &Solution) -> (Vec<ParameterChange>, f64, usize) {
        let pairs = pairs(before, after);
        let (d, covariance) = difference(&pairs).expect("covariances");
        let (chi_square, n, _) = metric::chi_square(&d, &covariance).expect("regular");
        let names: Vec<String> = NAMES.map(str::to_owned).to_vec();
        let single = single(&names, d.as_slice(), &covariance, 0.01 / 12.0);
        (single, chi_square, n)
    }

    #[test]
    fn names_and_units_are_a_mounting_s() {
        for (k, (name, unit, _)) in MOUNTING_PARAMETERS.iter().enumerate() {
            assert_eq!((*name, *unit == Unit::Radian), (NAMES[k], k < 3));
        }
    }

    /// 3 mm against sqrt(1.8^2 + 2.4^2) mm is one sigma, 0.5 mrad against sqrt(0.03^2 + 0.04^2) mrad is ten: chi-square 101.
    #[test]
    fn a_change_is_held_against_both_covariances() {
        let sigmas = |roll: f64, arm: f64| [1e-4, roll, 1e-4, arm, 1e-3, 1e-3];
        let arm = Vector3::new(0.5, -0.2, -1.6);
        let before = solution(Vector3::zeros(), arm, sigmas(3e-5, 0.0018));
        let moved = arm + Vector3::new(0.003, 0.0, 0.0);
        let after = solution(Vector3::new(0.0, 5e-4, 0.0), moved, sigmas(4e-5, 0.0024));
        let (single, chi_square, n) = change(&before, &after);
        // the turn carries the earlier covariance over by half a milliradian
        assert!((chi_square - 101.0).abs() < 1e-3, "{chi_square}");
        assert_eq!(n, 6);
        let found: Vec<bool> = single.iter().map(|p| p.changed).collect();
        assert_eq!(found, [false, true, false, false, false, false]);
        assert!((single[1].in_sigmas - 10.0).abs() < 1e-4);
        assert!((single[3].in_sigmas - 1.0).abs() < 1e-9);
    }

    /// Two turns of 30 degrees about different axes: the components are those of the turn between them, not differences of angles.
    #[test]
    fn a_turn_is_one_rotation() {
        let [a, b] = [Vector3::x(), Vector3::y()].map(|axis| axis * 30f64.to_radians());
        let [before, after] = [a, b].map(|turn| solution(turn, Vector3::zeros(), [1e-4; 6]));
        let (single, ..) = change(&before, &after);
        let found: Vec<f64> = single[..3].iter().map(|p| p.change).collect();
        let wanted = rotation::log(&(rotation::exp(&b) * rotation::exp(&a).transpose()));
        for (found, wanted) in found.iter().zip(wanted.iter()) {
            assert!((found - wanted.to_degrees()).abs() < 1e-9);
        }
    }

    #[test]
    fn what_one_of_them_held_is_left_out() {
        let before = solution(Vector3::zeros(), Vector3::zeros(), [1e-4; 6]);
        let mut after = solution(Vector3::zeros(), Vector3::x(), [1e-4; 6]);
        after.parameters[3].determined = false;
        let (single, chi_square, n) = change(&before, &after);
        assert_eq!((n, chi_square), (5, 0.0));
        assert!(single.iter().all(|p| p.name != "lx"));
    }
}
