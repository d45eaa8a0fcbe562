//! Solutions against the truth of a simulated survey.

use nalgebra::{Matrix3, Vector3};

use super::solution::MOUNTING_PARAMETERS;
use crate::calibrate::quality::readable;
use crate::geometry::rotation;
use crate::results::{AgainstTruth, MountingResult, Solution, Solutions, TruthRow};

/// The truth of one survey in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrueValues {
    /// Of every mounting, in the order of a solution's mountings.
    pub mountings: Vec<TrueMounting>,
    /// Of parameters beside the mountings: name and value in the unit of the result.
    pub others: Vec<(&'static str, f64)>,
}

/// A mounting as it truly is.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueMounting {
    /// What stands before the names of its parameters, such as `left head `.
    pub prefix: String,
    /// Rotation, sensor to body.
    pub rotation: Matrix3<f64>,
    /// Lever arm in the body, metres; `None` where the procedure seeks none.
    pub lever_arm_m: Option<Vector3<f64>>,
}

impl TrueValues {
    /// Errors of every usable solution.
    #[must_use]
    pub fn against(&self, solutions: &Solutions) -> AgainstTruth {
        let of_mountings = self.mountings.iter().enumerate();
        let mut rows: Vec<TruthRow> = of_mountings
            .flat_map(|(place, truth)| truth.rows(place, solutions))
            .collect();
        rows.extend(
            self.others
                .iter()
                .filter_map(|truth| other(truth, solutions)),
        );
        AgainstTruth { rows }
    }
}

impl TrueMounting {
    fn rows(&self, place: usize, solutions: &Solutions) -> Vec<TruthRow> {
        let mounting = |solution: &Option<Solution>| {
            let usable = solution.as_ref().filter(|s| s.usable)?;
            Some(usable.mountings.get(place)?.clone())
        };
        let names = MOUNTING_PARAMETERS
            .iter()
            .take(if self.lever_arm_m.is_some() { 6 } else { 3 });
        let row = |(i, (name, unit, _)): (usize, &(&str, _, &str))| {
            let name = format!("{}{name}", self.prefix);
            let error = |solution: &Option<Solution>| {
                let sought = solution.as_ref()?.parameter(&name)?.value.is_some();
                let error = self.errors(&mounting(solution)?).get(i).copied()?;
                sought.then(|| readable(error, *unit).0)
            };
            let any = [&solutions.joint, &solutions.reference];
            let nominal = any.into_iter().find_map(mounting);
            let correction = nominal.and_then(|m| self.correction(&m).get(i).copied());
            filled(
                TruthRow {
                    unit: readable(0.0, *unit).1.to_owned(),
                    correction: correction.map(|c| readable(c, *unit).0),
                    reference: error(&solutions.reference),
                    joint: error(&solutions.joint),
                    joint_simple: error(&solutions.joint_simple),
                    joint_in_sigmas: None,
                    name: name.clone(),
                },
                solutions,
            )
        };
        names.enumerate().map(row).collect()
    }

    /// From the truth to what was found: rotation vector (radians) and lever arm (metres), body frame.
    fn errors(&self, found: &MountingResult) -> Vec<f64> {
        let turn = rotation::log(&(matrix(&found.rotation_matrix) * self.rotation.transpose()));
        let arm = self.lever_arm_m.zip(found.lever_arm_m);
        let arm = arm.map(|(truth, found)| Vector3::from(found) - truth);
        six(&turn, arm)
    }

    /// From the nominal mounting to the truth.
    fn correction(&self, found: &MountingResult) -> Vec<f64> {
        let nominal = matrix(&found.nominal_rotation_matrix);
        let turn = rotation::log(&(self.rotation * nominal.transpose()));
        let arm = self.lever_arm_m.zip(found.nominal_lever_arm_m);
        six(
            &turn,
            arm.map(|(truth, nominal)| truth - Vector3::from(nominal)),
        )
    }
}

fn matrix(rows: &crate::results::Matrix3) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn six(turn: &Vector3<f64>, arm: Option<Vector3<f64>>) -> Vec<f64> {
    let arm = arm.iter().flat_map(|a| a.iter().copied());
    turn.iter().copied().chain(arm).collect()
}

/// `None` where no solution seeks the parameter.
fn other((name, truth): &(&str, f64), solutions: &Solutions) -> Option<TruthRow> {
    let value = |solution: &Option<Solution>| {
        let usable = solution.as_ref().filter(|s| s.usable)?;
        Some(usable.parameter(name)?.value? - truth)
    };
    let any = solutions.named().find_map(|(_, s)| s.parameter(name))?;
    Some(filled(
        TruthRow {
            name: (*name).to_owned(),
            unit: any.unit.clone(),
            correction: any.nominal.map(|nominal| truth - nominal),
            reference: value(&solutions.reference),
            joint: value(&solutions.joint),
            joint_simple: value(&solutions.joint_simple),
            joint_in_sigmas: None,
        },
        solutions,
    ))
}

/// With the joint error in its own standard deviation.
fn filled(row: TruthRow, solutions: &Solutions) -> TruthRow {
    let joint = solutions.joint.as_ref();
    let sigma = joint.and_then(|j| j.parameter(&row.name)?.sigma);
    TruthRow {
        joint_in_sigmas: row.joint.zip(sigma).map(|(error, sigma)| error / sigma),
        ..row
    }
}
