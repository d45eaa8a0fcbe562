//! The swath of a scenario's sensors under each path's calibration: the section `swath` of `result.json`.

use nalgebra::{DMatrix, Matrix6, Vector3};

use super::passes::predicted;
use super::swath::{BeamUncertainty, ORDERS, SwathSensors, Uncertainty, swath};
use crate::calibrate::tried::PathCovariance;
use crate::observe::{SonarNoise, TrajectoryNoise};
use crate::procedures::pool::JointConfig;
use crate::results::{
    CovarianceOrigin, JOINT, OrderLimit, PathSwath, SwathBeam, SwathDepth, SwathLimits,
    SwathResult, Uncertainty95,
};
use crate::simulate::Scenario;

/// Outermost beam and step, degrees.
const BEAMS_DEG: (i32, i32) = (70, 5);

/// The joint path's covariance predicted from the scenario where neither trials nor propagation tell of it and a prediction is possible.
#[must_use]
pub fn or_predicted(
    mut found: Vec<PathCovariance>,
    scenario: &Scenario,
    config: &JointConfig,
) -> Vec<PathCovariance> {
    let has_joint = found.iter().any(|c| c.name == JOINT);
    if !has_joint && let Ok(covariance) = predicted(scenario, config) {
        let joint = PathCovariance {
            name: JOINT.to_owned(),
            origin: CovarianceOrigin::Predicted,
            covariance: DMatrix::from_column_slice(6, 6, covariance.as_slice()),
        };
        found.insert(0, joint);
    }
    found
}

/// The mounting's six, which come first.
fn six(of: &PathCovariance) -> Matrix6<f64> {
    of.covariance.fixed_view::<6, 6>(0, 0).into_owned()
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
        path: of.name.clone(),
        origin: of.origin,
        covariance: std::array::from_fn(|i| std::array::from_fn(|j| of.covariance[(i, j)])),
        depths: depths_m
            .iter()
            .map(|&depth_m| depth(&six(of), &sensors, depth_m, &angles))
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
