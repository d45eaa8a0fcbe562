//! Mountings, parameters and matrices as they stand in a result, the same for every procedure.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::metric;
use crate::adjust::{self, Unit};
use crate::calibrate::quality::readable;
use crate::geometry::rotation;
use crate::observe::{ArrayMountings, Mounting};
use crate::results::{
    Angles, Comparison, Difference, Finding, Iteration, MountingAngles, MountingResult, Parameter,
    Severity, Status, Verdict,
};

/// Names of a mounting's six parameters in their order, and what a positive correction means.
pub const MOUNTING_PARAMETERS: [(&str, Unit, &str); 6] = [
    ("pitch", Unit::Radian, "bow up"),
    ("roll", Unit::Radian, "starboard down"),
    ("yaw", Unit::Radian, "counter-clockwise"),
    ("lx", Unit::Metre, "to the right"),
    ("ly", Unit::Metre, "forward"),
    ("lz", Unit::Metre, "up"),
];

/// A mounting before and after, to be written into a result.
#[derive(Clone, Copy, Debug)]
pub struct Mounted<'a> {
    /// The sensor.
    pub name: &'a str,
    /// Rotations, sensor to body: found, nominal.
    pub rotation: (&'a Matrix3<f64>, &'a Matrix3<f64>),
    /// Lever arms in the body, metres: found, nominal; `None` where the procedure seeks none.
    pub lever_arm_m: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Covariance of pitch, roll, yaw (rad) and, with a lever arm, lx, ly, lz (m); `None` for a path that has none.
    pub covariance: Option<&'a DMatrix<f64>>,
    /// The two arrays before the calibration, where the mounting stands for both.
    pub arrays: Option<&'a ArrayMountings>,
}

impl Mounted<'_> {
    /// As matrices and angles.
    #[must_use]
    pub fn result(&self) -> MountingResult {
        let (found, nominal) = self.rotation;
        let sigma = |i: usize| self.covariance.map(|c| c[(i, i)].sqrt());
        let arm_sigma = || Some([sigma(3)?, sigma(4)?, sigma(5)?]);
        MountingResult {
            name: self.name.to_owned(),
            rotation_matrix: rows(found),
            nominal_rotation_matrix: rows(nominal),
            mounting_deg: mounting_angles(found),
            nominal_mounting_deg: mounting_angles(nominal),
            mounting_sigma_deg: self.covariance.and_then(|c| {
                let three = c.fixed_view::<3, 3>(0, 0).into_owned();
                angle_sigmas(found, &three)
            }),
            correction_deg: angles_deg(&rotation::log(&(found * nominal.transpose()))),
            lever_arm_m: self.lever_arm_m.map(|(found, _)| found.into()),
            nominal_lever_arm_m: self.lever_arm_m.map(|(_, nominal)| nominal.into()),
            lever_arm_correction_m: self
                .lever_arm_m
                .map(|(found, nominal)| (found - nominal).into()),
            lever_arm_sigma_m: self.lever_arm_m.and_then(|_| arm_sigma()),
            arrays: self
                .arrays
                .map_or_else(Vec::new, |arrays| self.each(arrays)),
        }
    }

    /// Both arrays, each moved as the mounting has moved; none where they are one head at one place, which has one record.
    fn each(&self, arrays: &ArrayMountings) -> Vec<MountingResult> {
        if arrays.transmitter == arrays.receiver {
            return vec![];
        }
        let one = |(rotation, arm_m): (&Matrix3<f64>, Vector3<f64>)| Mounting {
            rotation: *rotation,
            lever_arm_m: arm_m,
        };
        let arms_m = self.lever_arm_m.unwrap_or_default();
        let found = one((self.rotation.0, arms_m.0));
        let nominal = one((self.rotation.1, arms_m.1));
        let moved = arrays.moved(&nominal, &found);
        let named = [
            ("transmit array", &moved.transmitter, &arrays.transmitter),
            ("receive array", &moved.receiver, &arrays.receiver),
        ];
        let result = |(name, found, nominal): (&'static str, &Mounting, &Mounting)| {
            Mounted {
                name,
                rotation: (&found.rotation, &nominal.rotation),
                lever_arm_m: self
                    .lever_arm_m
                    .map(|_| (found.lever_arm_m, nominal.lever_arm_m)),
                covariance: self.covariance,
                arrays: None,
            }
            .result()
        };
        named.into_iter().map(result).collect()
    }

    /// As named parameters: pitch, roll, yaw and, with a lever arm, lx, ly, lz, each name behind `prefix`.
    #[must_use]
    pub fn parameters(&self, prefix: &str) -> Vec<Parameter> {
        let m = self.result();
        let (after, before) = (m.mounting_deg, m.nominal_mounting_deg);
        let turn = m.correction_deg;
        let mut numbers = vec![
            [after.pitch, before.pitch, turn.pitch],
            [after.roll, before.roll, turn.roll],
            [-after.heading, -before.heading, turn.yaw],
        ];
        if let Some((found, nominal)) = self.lever_arm_m {
            let arm = found - nominal;
            numbers.extend((0..3).map(|i| [found[i], nominal[i], arm[i]]));
        }
        let all = numbers.into_iter().zip(MOUNTING_PARAMETERS).enumerate();
        all.map(
            |(i, ([value, nominal, correction], (name, unit, positive)))| {
                let sigma = self.covariance.map(|c| readable(c[(i, i)].sqrt(), unit).0);
                Parameter {
                    name: format!("{prefix}{name}"),
                    unit: readable(0.0, unit).1.to_owned(),
                    positive: positive.to_owned(),
                    value: Some(value),
                    nominal: Some(nominal),
                    correction: Some(correction),
                    ..judged(sigma)
                }
            },
        )
        .collect()
    }
}

/// A parameter whose value is counted from its nominal one, in the units of the engine.
#[must_use]
pub fn parameter(name: &str, unit: Unit, value: f64, sigma: Option<f64>) -> Parameter {
    let (value, word) = readable(value, unit);
    Parameter {
        name: name.to_owned(),
        unit: word.to_owned(),
        value: Some(value),
        nominal: Some(0.0),
        correction: Some(value),
        ..judged(sigma.map(|s| readable(s, unit).0))
    }
}

/// Of a prior's sigma that a survey leaves, from which on the survey says next to nothing.
const PRIOR_DECIDES: f64 = 0.9;

/// What is noted of a parameter of whose prior so much is left; nothing where the survey decides or there is no prior.
#[must_use]
pub fn prior_note(prior_sigma: Option<f64>, sigma: f64) -> &'static str {
    match prior_sigma {
        Some(prior) if sigma > PRIOR_DECIDES * prior => "its prior decides",
        _ => "",
    }
}

/// An unknown of the caller's own, by its name and in its own unit.
#[must_use]
pub fn own_unknown(
    (name, unit): (&str, &str),
    prior_sigma: Option<f64>,
    value: f64,
    sigma: f64,
) -> Parameter {
    Parameter {
        unit: unit.to_owned(),
        positive: "what is added to the measurement by one unit of its derivative".to_owned(),
        note: prior_note(prior_sigma, sigma).to_owned(),
        ..parameter(name, Unit::One, value, Some(sigma))
    }
}

/// The details of a solution that has unknowns of the caller's own; nothing where there are none.
#[must_use]
pub fn own_names(names: &[String]) -> serde_json::Value {
    match names {
        [] => serde_json::Value::Null,
        _ => serde_json::json!({ "extra": names }),
    }
}

/// Sigma, whether determined, and the note: a sigma of exactly 0 is that of a parameter that was held.
fn judged(sigma: Option<f64>) -> Parameter {
    let held = sigma == Some(0.0);
    Parameter {
        name: String::new(),
        unit: String::new(),
        positive: String::new(),
        value: None,
        nominal: None,
        correction: None,
        sigma: sigma.filter(|_| !held),
        determined: !held,
        note: if held { "held" } else { "" }.to_owned(),
    }
}

/// Standard deviations of the mounting angles, degrees: `psi = d_pitch Rz x + d_roll Rz Rx y - d_heading z` is solved for the angles.
/// `None` with the pitch at 90 deg, where roll and heading are one angle.
fn angle_sigmas(r: &Matrix3<f64>, covariance: &Matrix3<f64>) -> Option<MountingAngles> {
    let (_, pitch, heading) = rotation::to_attitude(r);
    let turned = rotation::from_attitude(0.0, 0.0, heading);
    let pitched = rotation::from_attitude(0.0, pitch, heading);
    let axes = Matrix3::from_columns(&[
        turned.column(0).into_owned(),
        pitched.column(1).into_owned(),
        -Vector3::z(),
    ]);
    let inverse = axes.try_inverse()?;
    let angles = inverse * covariance * inverse.transpose();
    let sigma = |i: usize| angles[(i, i)].max(0.0).sqrt().to_degrees();
    let found = [sigma(0), sigma(1), sigma(2)];
    found
        .iter()
        .all(|s| s.is_finite())
        .then_some(MountingAngles {
            pitch: found[0],
            roll: found[1],
            heading: found[2],
        })
}

/// Mounting angles in the sense of a survey file, degrees.
#[must_use]
pub fn mounting_angles(r: &Matrix3<f64>) -> MountingAngles {
    let (roll, pitch, heading) = rotation::to_attitude(r);
    MountingAngles {
        roll: roll.to_degrees(),
        pitch: pitch.to_degrees(),
        heading: heading.to_degrees(),
    }
}

/// A rotation vector (radians, body frame) as angles in degrees.
#[must_use]
pub fn angles_deg(vector_rad: &Vector3<f64>) -> Angles {
    Angles {
        pitch: vector_rad.x.to_degrees(),
        roll: vector_rad.y.to_degrees(),
        yaw: vector_rad.z.to_degrees(),
    }
}

/// A 3 by 3 matrix by rows.
#[must_use]
pub fn rows(m: &Matrix3<f64>) -> crate::results::Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]))
}

/// A matrix by rows.
pub type ByRows = Vec<Vec<f64>>;

/// Covariance and correlations by rows; `None` for a covariance that is not finite throughout.
#[must_use]
pub fn matrices(covariance: &DMatrix<f64>) -> (Option<ByRows>, Option<ByRows>) {
    let finite = covariance.iter().all(|v| v.is_finite());
    let correlation = || list(&metric::correlation(covariance));
    (finite.then(|| list(covariance)), finite.then(correlation))
}

fn list(m: &DMatrix<f64>) -> ByRows {
    m.row_iter()
        .map(|row| row.iter().copied().collect())
        .collect()
}

/// The reference path minus the joint one, in the units of the engine, in the metric of the joint covariance.
#[must_use]
pub fn compared(
    parameters: impl IntoIterator<Item = (String, Unit)>,
    apart: &[f64],
    covariance: &DMatrix<f64>,
) -> Option<Comparison> {
    let d = DVector::from_column_slice(apart);
    let (chi_square, degrees, p_value) = metric::chi_square(&d, covariance)?;
    let difference = |(k, (name, unit)): (usize, (String, Unit))| {
        let (difference, unit) = readable(apart[k], unit);
        let variance = covariance[(k, k)];
        // a parameter that was held has none
        let sigmas = if variance > 0.0 {
            apart[k] / variance.sqrt()
        } else {
            0.0
        };
        Difference {
            name,
            unit: unit.to_owned(),
            difference,
            in_joint_sigmas: sigmas,
        }
    };
    Some(Comparison {
        differences: parameters.into_iter().enumerate().map(difference).collect(),
        chi_square,
        degrees_of_freedom: degrees as u32,
        p_value,
    })
}

/// How an adjustment ended, as a result says it; one that converged may be refused still.
#[must_use]
pub fn status(ended: &adjust::Status, refused: bool) -> Status {
    match ended {
        adjust::Status::RankDeficient { .. } => Status::RankDeficient,
        adjust::Status::Stalled => Status::Stalled,
        adjust::Status::OutOfIterations => Status::OutOfIterations,
        adjust::Status::Converged if refused => Status::Refused,
        adjust::Status::Converged => Status::Converged,
    }
}

/// The verdict on a result that a reason refuses, or that nothing refuses.
#[must_use]
pub fn verdict(reason: Option<&str>) -> Verdict {
    reason.map_or_else(Verdict::default, |reason| {
        let refusal = Finding::new("refused", Severity::Refuses, reason, "", "");
        Verdict::not_determined(vec![refusal])
    })
}

/// Iterations of one round as a result lists them; `round` counts from 0, each step is its cost and its size in sigmas.
pub fn iterations(
    round: usize,
    reassigned: u64,
    steps: impl Iterator<Item = (f64, f64)>,
) -> impl Iterator<Item = Iteration> {
    steps
        .enumerate()
        .map(move |(inner, (cost, sigmas))| Iteration {
            outer: round as u32 + 1,
            inner: inner as u32 + 1,
            cost: finite(cost),
            largest_step_in_sigma: finite(sigmas),
            reassigned: if inner == 0 { reassigned } else { 0 },
        })
}

/// JSON knows no infinity.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against differences: each angle changed alone, and how far a turn of the whole moves it.
    #[test]
    fn sigmas_of_the_angles_are_not_those_of_the_turn() {
        let (roll, pitch, heading) = (-0.8, 0.3, 0.7);
        let r = rotation::from_attitude(roll, pitch, heading);
        let sigma = [1e-4, 2e-4, 4e-4];
        let covariance = Matrix3::from_diagonal(&Vector3::from(sigma.map(|s| s * s)));
        let found = angle_sigmas(&r, &covariance).expect("regular");
        let mut squares = [0.0; 3];
        for (i, s) in sigma.iter().enumerate() {
            let mut turn = Vector3::zeros();
            turn[i] = *s;
            let moved = mounting_angles(&(rotation::exp(&turn) * r));
            let before = mounting_angles(&r);
            squares[0] += (moved.roll - before.roll).powi(2);
            squares[1] += (moved.pitch - before.pitch).powi(2);
            squares[2] += (moved.heading - before.heading).powi(2);
        }
        for (found, squares) in [found.roll, found.pitch, found.heading].iter().zip(squares) {
            assert!(
                (found / squares.sqrt() - 1.0).abs() < 1e-3,
                "{found} {}",
                squares.sqrt()
            );
        }
        assert!((found.heading / sigma[2].to_degrees() - 1.0).abs() > 1e-3);
    }

    #[test]
    fn a_held_parameter_differs_by_nothing() {
        let variances = [1.0, 4.0, 9.0, 0.01, 0.04, 0.0];
        let covariance = DMatrix::from_diagonal(&DVector::from_column_slice(&variances));
        let named = MOUNTING_PARAMETERS.map(|(name, unit, _)| (name.to_owned(), unit));
        let found = compared(named, &[2.0; 6], &covariance).expect("a comparison");
        let all = &found.differences;
        assert_eq!((all[1].in_joint_sigmas, all[5].in_joint_sigmas), (1.0, 0.0));
        assert_eq!(
            (&*all[1].unit, all[1].difference),
            ("deg", 2_f64.to_degrees())
        );
        assert_eq!(found.degrees_of_freedom, 5);
    }

    #[test]
    fn a_held_parameter_has_no_sigma_and_says_so() {
        let nominal = Matrix3::identity();
        let mut covariance = DMatrix::identity(6, 6) * 1e-6;
        covariance[(5, 5)] = 0.0;
        let mounted = Mounted {
            name: "multibeam",
            rotation: (&nominal, &nominal),
            lever_arm_m: Some((Vector3::new(1.0, 2.0, 3.0), Vector3::zeros())),
            covariance: Some(&covariance),
            arrays: None,
        };
        let all = mounted.parameters("head ");
        assert_eq!(all[4].name, "head ly");
        assert_eq!((all[4].sigma, all[4].determined), (Some(1e-3), true));
        assert_eq!((all[5].sigma, all[5].determined), (None, false));
        assert_eq!((all[5].value, &*all[5].note), (Some(3.0), "held"));
    }

    #[test]
    fn two_arrays_are_turned_and_moved_as_their_mounting() {
        let nominal = Mounting::from_angles(0.1, 0.2, 0.3, Vector3::new(1.0, 2.0, 3.0));
        let found = nominal.corrected(
            &Vector3::new(0.02, -0.01, 0.03),
            &Vector3::new(0.1, 0.0, -0.2),
        );
        let receiver = Mounting::from_angles(-0.4, 0.1, 3.1, Vector3::new(1.0, 1.7, 3.0));
        let arrays = ArrayMountings {
            transmitter: nominal,
            receiver,
        };
        let mounted = Mounted {
            name: "multibeam",
            rotation: (&found.rotation, &nominal.rotation),
            lever_arm_m: Some((found.lever_arm_m, nominal.lever_arm_m)),
            covariance: None,
            arrays: Some(&arrays),
        };
        let both = mounted.result().arrays;
        let due = receiver.corrected(
            &found.correction_from(&nominal),
            &Vector3::new(0.1, 0.0, -0.2),
        );
        assert_eq!(both[0].name, "transmit array");
        assert!((found.rotation - matrix_of(&both[0])).norm() < 1e-12);
        let off = rotation::log(&(due.rotation * matrix_of(&both[1]).transpose()));
        assert!(off.norm() < 1e-12, "{off}");
        let arm = Vector3::from(both[1].lever_arm_m.expect("an arm"));
        assert!((arm - due.lever_arm_m).norm() < 1e-12, "{arm}");
        let one = ArrayMountings {
            transmitter: nominal,
            receiver: nominal,
        };
        let one = Mounted {
            arrays: Some(&one),
            ..mounted
        };
        assert!(one.result().arrays.is_empty(), "one head has one record");
    }

    fn matrix_of(found: &MountingResult) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| found.rotation_matrix[i][j])
    }
}
