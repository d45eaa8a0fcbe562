//! What a calibration's covariance means for a sounding: uncertainty across the swath, against the orders of IHO S-44.
//!
//! The boat lies level; a beam at angle `b` from the vertical (positive to starboard) reaches the flat floor `d` below the sonar at
//! `v = d (tan b, 0, -1)` in the body. Then `dX = delta x v + dl + dp + psi x (v + l) + dv` with the calibration's error
//! `(delta, dl)`, the INS's `(dp, psi)` and the sonar's own `dv` (`docs/georeferencing.md`).

use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3};

use crate::geometry::rotation::skew;
use crate::math;
use crate::observe::{SonarNoise, TrajectoryNoise};

/// Quantile of a normal deviate, both sides, at 95 %.
const ONE_AXIS_95: f64 = 1.959_963_984_540_054;
/// Radius that holds 95 % of a circular normal distribution, in its sigma: `sqrt(-2 ln 0.05)`.
const CIRCLE_95: f64 = 2.447_746_830_680_816;

/// Limits of an order of survey (IHO S-44, edition 6.1.0, 2022, table 1), at 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Its name.
    pub name: &'static str,
    /// Horizontal: constant part, metres, and part of the depth.
    pub horizontal: (f64, f64),
    /// Vertical: `sqrt(a^2 + (b depth)^2)`, `a` in metres.
    pub vertical: (f64, f64),
}

/// The orders, the strictest first.
pub const ORDERS: [Order; 5] = [
    Order {
        name: "Exclusive",
        horizontal: (1.0, 0.0),
        vertical: (0.15, 0.0075),
    },
    Order {
        name: "Special",
        horizontal: (2.0, 0.0),
        vertical: (0.25, 0.0075),
    },
    Order {
        name: "1a",
        horizontal: (5.0, 0.05),
        vertical: (0.5, 0.013),
    },
    Order {
        name: "1b",
        horizontal: (5.0, 0.05),
        vertical: (0.5, 0.013),
    },
    Order {
        name: "2",
        horizontal: (20.0, 0.1),
        vertical: (1.0, 0.023),
    },
];

impl Order {
    /// Largest horizontal uncertainty at a depth, metres, 95 %.
    #[must_use]
    pub fn horizontal_m(&self, depth_m: f64) -> f64 {
        self.horizontal.0 + self.horizontal.1 * depth_m
    }

    /// Largest vertical uncertainty at a depth, metres, 95 %.
    #[must_use]
    pub fn vertical_m(&self, depth_m: f64) -> f64 {
        math::hypot(self.vertical.0, self.vertical.1 * depth_m)
    }
}

/// Horizontal and vertical uncertainty at 95 %, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Radius that holds 95 % if the error were as large in every direction as in the worst.
    pub horizontal_m: f64,
    /// 1.96 sigma.
    pub vertical_m: f64,
}

impl Uncertainty {
    fn of(covariance: &Matrix3<f64>) -> Self {
        let plane = covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let worst = plane.symmetric_eigenvalues().max().max(0.0);
        Self {
            horizontal_m: CIRCLE_95 * worst.sqrt(),
            vertical_m: ONE_AXIS_95 * covariance[(2, 2)].max(0.0).sqrt(),
        }
    }

    /// The strictest order that this keeps at a depth (metres).
    #[must_use]
    pub fn order(&self, depth_m: f64) -> Option<Order> {
        ORDERS.into_iter().find(|order| {
            self.horizontal_m <= order.horizontal_m(depth_m)
                && self.vertical_m <= order.vertical_m(depth_m)
        })
    }
}

/// One beam of a swath.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamUncertainty {
    /// Angle from the vertical, radians, positive to starboard.
    pub angle_rad: f64,
    /// What the calibration adds.
    pub calibration: Uncertainty,
    /// INS and sonar noise alone.
    pub sensors: Uncertainty,
    /// All together.
    pub total: Uncertainty,
}

/// What the sounder's own errors are in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwathSensors {
    /// INS.
    pub trajectory: TrajectoryNoise,
    /// Sonar.
    pub sonar: SonarNoise,
    /// Sonar in the body frame, metres.
    pub lever_arm_m: Vector3<f64>,
}

/// Uncertainty of the soundings of a level boat at a depth (metres below the sonar), beam by beam; `covariance` of pitch, roll, yaw
/// (rad), lx, ly, lz (m).
#[must_use]
pub fn swath(
    covariance: &Matrix6<f64>,
    sensors: &SwathSensors,
    depth_m: f64,
    angles_rad: &[f64],
) -> Vec<BeamUncertainty> {
    let beam = |&angle_rad: &f64| {
        let v = Vector3::new(math::tan(angle_rad), 0.0, -1.0) * depth_m;
        let own = calibration_part(covariance, &v);
        let others = sensor_part(sensors, &v, angle_rad);
        BeamUncertainty {
            angle_rad,
            calibration: Uncertainty::of(&own),
            sensors: Uncertainty::of(&others),
            total: Uncertainty::of(&(own + others)),
        }
    };
    angles_rad.iter().map(beam).collect()
}

fn calibration_part(covariance: &Matrix6<f64>, v: &Vector3<f64>) -> Matrix3<f64> {
    let mut jacobian = Matrix3x6::zeros();
    jacobian.fixed_columns_mut::<3>(0).copy_from(&-skew(v));
    jacobian
        .fixed_columns_mut::<3>(3)
        .copy_from(&Matrix3::identity());
    jacobian * covariance * jacobian.transpose()
}

fn sensor_part(sensors: &SwathSensors, v: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let (ins, sonar) = (&sensors.trajectory, &sensors.sonar);
    let position = ins.position_m.powi(2) + ins.position_drift_m.powi(2);
    let level = ins.roll_pitch_rad.powi(2);
    let heading = ins.heading_rad.powi(2) + ins.heading_drift_rad.powi(2);
    let swing = skew(&(v + sensors.lever_arm_m));
    let attitude = Matrix3::from_diagonal(&Vector3::new(level, level, heading));
    let (range_m, ray) = (v.norm(), v.normalize());
    let across = Vector3::new(math::cos(angle_rad), 0.0, math::sin(angle_rad)) * range_m;
    let along = Vector3::y() * range_m;
    let spread = |axis: &Vector3<f64>, sigma: f64| axis * axis.transpose() * (sigma * sigma);
    Matrix3::identity() * position
        + swing * attitude * swing.transpose()
        + spread(&ray, sonar.range_m)
        + spread(&across, sonar.across_rad)
        + spread(&along, sonar.along_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn silent() -> SwathSensors {
        SwathSensors {
            trajectory: TrajectoryNoise {
                position_m: 0.0,
                position_drift_m: 0.0,
                drift_correlation_time_s: 60.0,
                roll_pitch_rad: 0.0,
                heading_rad: 0.0,
                heading_drift_rad: 0.0,
            },
            sonar: SonarNoise {
                range_m: 0.0,
                across_rad: 0.0,
                along_rad: 0.0,
            },
            lever_arm_m: Vector3::zeros(),
        }
    }

    /// A roll error of 0.1 deg at 45 deg and 20 m lifts the floor by d tan b times the error, and shifts it by d times the error.
    #[test]
    fn roll_alone_is_known_by_hand() {
        let mut covariance = Matrix6::zeros();
        covariance[(1, 1)] = 0.1f64.to_radians().powi(2);
        let beams = swath(&covariance, &silent(), 20.0, &[0.0, 45f64.to_radians()]);
        let roll = 0.1f64.to_radians();
        assert_relative_eq!(beams[0].total.vertical_m, 0.0);
        assert_relative_eq!(
            beams[0].total.horizontal_m,
            CIRCLE_95 * 20.0 * roll,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            beams[1].total.vertical_m,
            ONE_AXIS_95 * 20.0 * roll,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            beams[1].total.horizontal_m,
            CIRCLE_95 * 20.0 * roll,
            max_relative = 1e-12
        );
    }

    /// Values of the standard's own text: special order at 100 m allows 0.79 m, order 1a 1.39 m, order 2 2.51 m vertically.
    #[test]
    fn orders_as_the_standard_has_them() {
        let vertical = |k: usize| ORDERS[k].vertical_m(100.0);
        assert_relative_eq!(vertical(1), 0.790_569, epsilon = 1e-6);
        assert_relative_eq!(vertical(2), 1.392_839, epsilon = 1e-6);
        assert_relative_eq!(vertical(4), 2.507_987, epsilon = 1e-6);
        assert_relative_eq!(ORDERS[4].horizontal_m(100.0), 30.0);
        let fine = Uncertainty {
            horizontal_m: 1.5,
            vertical_m: 0.2,
        };
        assert_eq!(fine.order(10.0).map(|o| o.name), Some("Special"));
        let bad = Uncertainty {
            horizontal_m: 50.0,
            vertical_m: 0.2,
        };
        assert!(bad.order(10.0).is_none());
    }

    #[test]
    fn range_noise_is_vertical_at_nadir() {
        let mut sensors = silent();
        sensors.sonar.range_m = 0.02;
        let beams = swath(&Matrix6::zeros(), &sensors, 10.0, &[0.0]);
        assert_relative_eq!(
            beams[0].total.vertical_m,
            ONE_AXIS_95 * 0.02,
            max_relative = 1e-12
        );
        assert_relative_eq!(beams[0].total.horizontal_m, 0.0);
    }
}
