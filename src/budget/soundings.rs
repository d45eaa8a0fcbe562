//! The swath of a scenario's sensors under each path's calibration: the section `swath` of `result.json`.

use std::path::Path;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::analytic::Analytic;
use super::experiment::{Experiment, Role};
use super::ledger::LedgerError;
use super::passes::predicted;
use super::swath::{BeamUncertainty, ORDERS, SwathSensors, Uncertainty, swath};
use super::trial::Trial;
use crate::observe::{SonarNoise, TrajectoryNoise};
use crate::procedures::pool::JointConfig;
use crate::results::{
    BudgetPath, CovarianceOrigin, OrderLimit, PathSwath, SwathBeam, SwathDepth, SwathLimits,
    SwathResult, Uncertainty95,
};
use crate::simulate::Scenario;

/// Depths below the sonar where nobody says others, metres.
pub const DEPTHS_M: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

/// Outermost beam and step, degrees.
const BEAMS_DEG: (i32, i32) = (70, 5);

/// Covariance (rad, m) of a path's calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathCovariance {
    /// Which.
    pub path: BudgetPath,
    /// Where it is from.
    pub origin: CovarianceOrigin,
    /// Of pitch, roll, yaw, lx, ly, lz.
    pub covariance: Matrix6<f64>,
}

/// Of the trials with all sources together: the joint path's mean reported covariance, the reference path's mean squared error about
/// zero; a path without a usable trial is left out.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn of_trials(
    experiment: &Experiment,
    folder: &Path,
) -> Result<Vec<PathCovariance>, LedgerError> {
    let mut sums = BudgetPath::ALL.map(|path| (path, Matrix6::zeros(), 0_u32));
    let together = experiment.cells.iter().find(|c| c.role == Role::Together);
    if let Some(cell) = together {
        for trial in experiment.read(folder, cell)? {
            let trial = trial?;
            for (path, sum, count) in &mut sums {
                if let Some(one) = covariance_of(&trial, *path) {
                    *sum += one;
                    *count += 1;
                }
            }
        }
    }
    let mean = |(path, sum, count): (BudgetPath, Matrix6<f64>, u32)| PathCovariance {
        path,
        origin: match path {
            BudgetPath::Joint => CovarianceOrigin::Reported,
            _ => CovarianceOrigin::Errors,
        },
        covariance: sum / f64::from(count),
    };
    let usable = sums.into_iter().filter(|(.., count)| *count > 0);
    Ok(usable.map(mean).collect())
}

/// The same with the joint path predicted from the scenario where no trial tells of it and a prediction is possible.
#[must_use]
pub fn or_predicted(
    mut found: Vec<PathCovariance>,
    scenario: &Scenario,
    config: &JointConfig,
) -> Vec<PathCovariance> {
    let has_joint = found.iter().any(|c| c.path == BudgetPath::Joint);
    if !has_joint && let Ok(covariance) = predicted(scenario, config) {
        let joint = PathCovariance {
            path: BudgetPath::Joint,
            origin: CovarianceOrigin::Predicted,
            covariance,
        };
        found.insert(0, joint);
    }
    found
}

/// By propagation, for paths that no trial tells of: covariance of the error and its bias squared.
#[must_use]
pub fn or_propagated(mut found: Vec<PathCovariance>, analytic: &Analytic) -> Vec<PathCovariance> {
    let sequential = analytic.sequential.as_ref().ok();
    let paths = [
        (BudgetPath::Joint, Some(&analytic.joint)),
        (BudgetPath::SequentialProjected, sequential),
    ];
    for (path, budget) in paths {
        let Some(budget) = budget.filter(|_| found.iter().all(|c| c.path != path)) else {
            continue;
        };
        found.push(PathCovariance {
            path,
            origin: CovarianceOrigin::Propagated,
            covariance: budget.covariance + budget.bias * budget.bias.transpose(),
        });
    }
    found.sort_by_key(|c| c.path);
    found
}

fn covariance_of(trial: &Trial, path: BudgetPath) -> Option<Matrix6<f64>> {
    let squared = |error: &[f64; 6]| {
        let error = Vector6::from(*error);
        error * error.transpose()
    };
    match path {
        BudgetPath::Joint => trial.joint.as_ref().ok().map(|j| j.covariance),
        BudgetPath::Sequential => trial.sequential.as_ref().ok().map(squared),
        BudgetPath::SequentialProjected => trial.projected.as_ref().ok().map(squared),
    }
}

/// The section for these calibrations.
#[must_use]
pub fn section(
    scenario: &Scenario,
    covariances: &[PathCovariance],
    depths_m: &[f64],
) -> SwathResult {
    let sensors = sensors(scenario);
    let (end, step) = BEAMS_DEG;
    let angles: Vec<f64> = (-end..=end).step_by(step as usize).map(f64::from).collect();
    let path = |of: &PathCovariance| PathSwath {
        path: of.path,
        origin: of.origin,
        covariance: std::array::from_fn(|i| std::array::from_fn(|j| of.covariance[(i, j)])),
        depths: depths_m
            .iter()
            .map(|&depth_m| depth(&of.covariance, &sensors, depth_m, &angles))
            .collect(),
    };
    SwathResult {
        standard: "IHO S-44, edition 6.1.0 (2022), table 1".to_owned(),
        assumptions: "level boat, flat floor, 95 %: 1.96 sigma vertically, 2.45 times the largest horizontal sigma; INS and sonar \
                      noise of the scenario; tide, draught, sound speed and positioning datum are not in it"
            .to_owned(),
        limits: depths_m.iter().map(|&d| limits(d)).collect(),
        paths: covariances.iter().map(path).collect(),
    }
}

fn limits(depth_m: f64) -> SwathLimits {
    let limit = |order: &super::swath::Order| OrderLimit {
        order: order.name.to_owned(),
        horizontal_m: order.horizontal_m(depth_m),
        vertical_m: order.vertical_m(depth_m),
    };
    SwathLimits {
        depth_m,
        orders: ORDERS.iter().map(limit).collect(),
    }
}

fn depth(
    covariance: &Matrix6<f64>,
    sensors: &SwathSensors,
    depth_m: f64,
    angles_deg: &[f64],
) -> SwathDepth {
    let radians: Vec<f64> = angles_deg.iter().map(|a| a.to_radians()).collect();
    let beams = swath(covariance, sensors, depth_m, &radians);
    let with_angle = beams.iter().zip(angles_deg);
    SwathDepth {
        depth_m,
        beams: with_angle.map(|(b, a)| beam(b, *a, depth_m)).collect(),
    }
}

fn beam(beam: &BeamUncertainty, angle_deg: f64, depth_m: f64) -> SwathBeam {
    let both = |u: &Uncertainty| Uncertainty95 {
        horizontal_m: u.horizontal_m,
        vertical_m: u.vertical_m,
    };
    SwathBeam {
        angle_deg,
        calibration: both(&beam.calibration),
        sensors: both(&beam.sensors),
        total: both(&beam.total),
        order: beam.total.order(depth_m).map(|o| o.name.to_owned()),
    }
}

/// What the scenario's INS and multibeam claim of themselves.
fn sensors(scenario: &Scenario) -> SwathSensors {
    let (ins, sonar) = (&scenario.trajectory, &scenario.multibeam);
    SwathSensors {
        trajectory: TrajectoryNoise {
            position_m: ins.position_sigma_m,
            position_drift_m: ins.position_drift_sigma_m,
            drift_correlation_time_s: ins.drift_correlation_time_s,
            roll_pitch_rad: ins.roll_pitch_sigma_deg.to_radians(),
            heading_rad: ins.heading_sigma_deg.to_radians(),
            heading_drift_rad: ins.heading_drift_sigma_deg.to_radians(),
        },
        sonar: SonarNoise {
            range_m: sonar.range_sigma_m,
            across_rad: sonar.angle_sigma_deg.to_radians(),
            along_rad: sonar.along_angle_sigma_deg.to_radians(),
        },
        lever_arm_m: Vector3::from(sonar.lever_arm_m),
    }
}
