//! The patent's verification: the correction applied to the sensor's attitude, the beacons predicted, compared with the total
//! station.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::joint::{JointOutcome, SOUGHT};
use super::observed::Role;
use super::scene::Scene;
use crate::geometry::rotation::skew;
use crate::math;
use crate::stats::ChiSquare;

/// A fix is an outlier beyond this many standard deviations in any direction.
const GATE: f64 = 5.0;

/// A calibration to verify.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// `R_u^b`.
    pub rotation: Matrix3<f64>,
    /// The transducer's centre, level frame, metres.
    pub transducer_m: Vector3<f64>,
    /// Scale of the ranges.
    pub scale: f64,
    /// Turn of the datum, radians.
    pub datum_rad: Vector3<f64>,
}

impl Calibrated {
    /// As the reference path leaves it: the transducer as surveyed, ranges as measured.
    #[must_use]
    pub fn reference(rotation: &Matrix3<f64>) -> Self {
        Self {
            rotation: *rotation,
            transducer_m: Vector3::zeros(),
            scale: 0.0,
            datum_rad: Vector3::zeros(),
        }
    }

    /// As the joint path leaves it.
    #[must_use]
    pub fn joint(outcome: &JointOutcome) -> Self {
        Self {
            rotation: outcome.rotation,
            transducer_m: outcome.transducer_m,
            scale: outcome.scale,
            datum_rad: outcome
                .blocks
                .datum_rad(&outcome.solution.estimate.parameters),
        }
    }
}

/// A predicted beacon minus the surveyed one, for one fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Row of the fix.
    pub fix: u32,
    /// East, north, up, metres.
    pub enu_m: Vector3<f64>,
    /// The same as the device measures: range, first and second component of the direction, each in what the survey states of its
    /// noise (of fix and attitude).
    pub in_sigmas: [f64; 3],
    /// Whether it lies beyond the gate.
    pub outlier: bool,
}

/// The residuals of one beacon.
#[derive(Clone, Debug, PartialEq)]
pub struct BeaconResiduals {
    /// Index of the beacon.
    pub beacon: u32,
    /// Every fix, outliers among them.
    pub residuals: Vec<Residual>,
    /// Mean of those that are no outliers, east, north, up, metres.
    pub mean_m: Vector3<f64>,
    /// Root mean square length of the same, metres.
    pub rms_m: f64,
    /// Fixes that are no outliers.
    pub good: usize,
    /// Predicted covariance of the mean: noise of fixes and attitude, survey of the beacon, and the calibration where it has a
    /// covariance.
    pub covariance_m2: Matrix3<f64>,
}

impl BeaconResiduals {
    /// Squared mean in the metric of its predicted covariance, and the probability of a larger value (3 degrees of freedom).
    #[must_use]
    pub fn test(&self) -> Option<(f64, f64)> {
        let solved = self.covariance_m2.cholesky()?.solve(&self.mean_m);
        let statistic = self.mean_m.dot(&solved);
        let p = ChiSquare::new(3.0)?.above(statistic);
        (self.good > 0).then_some((statistic, p))
    }
}

/// Covariance of one fix in the level frame around its own direction, attitude noise included, square metres.
fn of_fix(scene: &Scene, fix: usize, level: &Matrix3<f64>, way_m: &Vector3<f64>) -> Matrix3<f64> {
    let fixes = &scene.campaign.fixes;
    let (range_m, observed) = (way_m.norm(), fixes.direction[fix]);
    let axes = fixes.noise.axes(&observed);
    // the unit direction from its two measured components: rows a1, a2 and the direction itself, which has no error of length
    let rows = Matrix3::from_rows(&[
        axes[0].transpose(),
        axes[1].transpose(),
        observed.transpose(),
    ]);
    let angle = fixes.noise.angle_rad;
    let in_level = rows.try_inverse().map_or_else(Matrix3::zeros, |inverse| {
        let spread = Matrix3::from_diagonal(&Vector3::new(angle * angle, angle * angle, 0.0));
        let in_level = level * inverse;
        in_level * spread * in_level.transpose()
    });
    let direction = way_m / range_m;
    let range = fixes.noise.range_at(range_m);
    in_level * (range_m * range_m)
        + direction * direction.transpose() * (range * range)
        + of_attitude(scene, way_m)
}

/// What the noise of one attitude record does to a predicted point, square metres.
fn of_attitude(scene: &Scene, way_m: &Vector3<f64>) -> Matrix3<f64> {
    let noise = &scene.campaign.attitude_noise;
    let (tilt, azimuth) = (noise.roll_pitch_rad.powi(2), noise.heading_rad.powi(2));
    let cross = skew(way_m);
    cross * Matrix3::from_diagonal(&Vector3::new(tilt, tilt, azimuth)) * cross.transpose()
}

/// A residual as range and the two components of the direction, each over its stated sigma.
fn in_sigmas(
    scene: &Scene,
    fix: usize,
    level: &Matrix3<f64>,
    way_m: &Vector3<f64>,
    enu_m: &Vector3<f64>,
) -> [f64; 3] {
    let (fixes, attitude) = (&scene.campaign.fixes, &scene.campaign.attitude_noise);
    let range_m = way_m.norm();
    let direction = way_m / range_m;
    let along_m = direction.dot(enu_m);
    let across = (enu_m - direction * along_m) / range_m;
    let [first, second] = fixes.noise.axes(&fixes.direction[fix]).map(|axis| {
        let axis = level * axis;
        let turned = axis.cross(&direction);
        let tilt = attitude.roll_pitch_rad * math::hypot(turned.x, turned.y);
        let azimuth = attitude.heading_rad * turned.z;
        axis.dot(&across) / (fixes.noise.angle_rad.powi(2) + tilt * tilt + azimuth * azimuth).sqrt()
    });
    [along_m / fixes.noise.range_at(range_m), first, second]
}

/// Residuals of every beacon that has a fix, check beacons too; with `joint` its covariance counts.
#[must_use]
pub fn verify(
    scene: &Scene,
    calibrated: &Calibrated,
    joint: Option<&JointOutcome>,
) -> Vec<BeaconResiduals> {
    let beacons = 0..scene.campaign.beacons.len() as u32;
    beacons
        .filter_map(|beacon| of_beacon(scene, calibrated, joint, beacon))
        .collect()
}

fn of_beacon(
    scene: &Scene,
    calibrated: &Calibrated,
    joint: Option<&JointOutcome>,
    beacon: u32,
) -> Option<BeaconResiduals> {
    let campaign = scene.campaign;
    let surveyed = &campaign.beacons[beacon as usize].point;
    let turn = crate::geometry::rotation::exp(&calibrated.datum_rad);
    let (mut residuals, mut noise) = (vec![], Matrix3::zeros());
    let (mut sum, mut squares, mut good) = (Vector3::zeros(), 0.0, 0_usize);
    let mut jacobian = DMatrix::zeros(3, SOUGHT);
    for fix in (0..campaign.fixes.len()).filter(|f| campaign.fixes.beacon[*f] == beacon) {
        let body = turn * scene.poses[fix].rotation;
        let level = body * calibrated.rotation;
        let point = scene.point(fix, &level, &calibrated.transducer_m, calibrated.scale);
        let Ok(way_m) = point else { continue };
        let enu_m = calibrated.transducer_m + way_m - surveyed.position_m;
        let own = of_fix(scene, fix, &level, &way_m);
        let all = own + surveyed.covariance_m2 + campaign.transducer.covariance_m2;
        let distance = all.cholesky().map_or(0.0, |f| enu_m.dot(&f.solve(&enu_m)));
        let outlier = !(distance <= GATE * GATE);
        residuals.push(Residual {
            fix: fix as u32,
            enu_m,
            in_sigmas: in_sigmas(scene, fix, &level, &way_m, &enu_m),
            outlier,
        });
        if outlier {
            continue;
        }
        sum += enu_m;
        squares += enu_m.norm_squared();
        good += 1;
        noise += own;
        jacobian += derivatives(&body, &way_m);
    }
    let n = good.max(1) as f64;
    let mut covariance_m2 = noise / (n * n) + surveyed.covariance_m2;
    if let Some(joint) = joint {
        covariance_m2 += propagated(scene, joint, beacon, &(jacobian / n));
    }
    (!residuals.is_empty()).then(|| BeaconResiduals {
        beacon,
        residuals,
        mean_m: sum / n,
        rms_m: (squares / n).sqrt(),
        good,
        covariance_m2,
    })
}

/// Derivatives of a predicted point by mounting, transducer and scale.
fn derivatives(level_from_body: &Matrix3<f64>, way_m: &Vector3<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(3, SOUGHT);
    let by_mounting = -skew(way_m) * level_from_body;
    all.view_mut((0, 0), (3, 3)).copy_from(&by_mounting);
    all.view_mut((0, 3), (3, 3)).copy_from(&Matrix3::identity());
    all.view_mut((0, 6), (3, 1)).copy_from(way_m);
    all
}

/// The calibration's share in the mean of a check beacon. A common beacon has helped to find the calibration, which would call for
/// the correlation with its survey; its share is left out, and its test with it.
fn propagated(
    scene: &Scene,
    joint: &JointOutcome,
    beacon: u32,
    jacobian: &DMatrix<f64>,
) -> Matrix3<f64> {
    if scene.campaign.beacons[beacon as usize].role == Role::Common {
        return Matrix3::zeros();
    }
    let all = jacobian * &joint.covariance * jacobian.transpose();
    Matrix3::from_fn(|i, j| all[(i, j)])
}
