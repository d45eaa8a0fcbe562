//! The reference path, as the patent: means of the fixes of the common beacons, its printed rotation matrix, Taylor linearisation,
//! iteration, adjusted minus measured attitude (usbl-patent, steps 1 to 5, equations 1-1 to 1-4).
//!
//! The printed matrix is `Rz(-H) Ry(-R) Rx(-P)`: P is positive bow down and R positive starboard up, opposite to the attitude
//! sensor's pitch and roll and in another order. Of the printed linearisation T11 is corrected: `-sin R cos H dR - cos R sin H dH`
//! (the text has `cos P`). Geocentric control has been turned into the local level frame before, which the patent leaves out.

use nalgebra::{Matrix3, Vector3};

use super::config::ReferenceConfig;
use super::scene::Scene;
use crate::geometry::rotation;
use crate::math;
use crate::units::wrap_angle;

/// Corrections below this end the iteration, radians.
const TOLERANCE_RAD: f64 = 1e-12;
/// Rounds of bending the rays with the attitude found so far.
const RAY_ROUNDS: usize = 3;
/// Smallest eigenvalue of the normal matrix by the largest, below which there is no solution.
const SINGULAR: f64 = 1e-9;

/// The patent's angles of a rotation, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedAngles {
    /// About the vertical, clockwise from north, as a heading.
    pub h: f64,
    /// About y, positive starboard up.
    pub r: f64,
    /// About x, positive bow down.
    pub p: f64,
}

impl PrintedAngles {
    /// The matrix of equation 1-4, entry by entry as printed.
    #[must_use]
    pub fn matrix(&self) -> Matrix3<f64> {
        let ((sh, ch), (sr, cr), (sp, cp)) = (
            math::sin_cos(self.h),
            math::sin_cos(self.r),
            math::sin_cos(self.p),
        );
        Matrix3::new(
            ch * cr,
            ch * sr * sp + sh * cp,
            sh * sp - ch * sr * cp,
            -sh * cr,
            ch * cp - sh * sr * sp,
            sh * sr * cp + ch * sp,
            sr,
            -cr * sp,
            cr * cp,
        )
    }

    /// The angles of a rotation; R within a right angle.
    #[must_use]
    pub fn of(m: &Matrix3<f64>) -> Self {
        Self {
            h: math::atan2(-m[(1, 0)], m[(0, 0)]),
            r: math::atan2(m[(2, 0)], math::hypot(m[(2, 1)], m[(2, 2)])),
            p: math::atan2(-m[(2, 1)], m[(2, 2)]),
        }
    }

    /// Derivatives of [`Self::matrix`] by H, R and P: the coefficients `T` of step 5, with T11 corrected.
    #[must_use]
    pub fn derivatives(&self) -> [Matrix3<f64>; 3] {
        let ((sh, ch), (sr, cr), (sp, cp)) = (
            math::sin_cos(self.h),
            math::sin_cos(self.r),
            math::sin_cos(self.p),
        );
        let by_h = Matrix3::new(
            -sh * cr,
            -sh * sr * sp + ch * cp,
            ch * sp + sh * sr * cp,
            -ch * cr,
            -sh * cp - ch * sr * sp,
            ch * sr * cp - sh * sp,
            0.0,
            0.0,
            0.0,
        );
        let by_r = Matrix3::new(
            -sr * ch,
            ch * cr * sp,
            -ch * cr * cp,
            sh * sr,
            -sh * cr * sp,
            sh * cr * cp,
            cr,
            sr * sp,
            -sr * cp,
        );
        let by_p = Matrix3::new(
            0.0,
            ch * sr * cp - sh * sp,
            sh * cp + ch * sr * sp,
            0.0,
            -ch * sp - sh * sr * cp,
            ch * cp - sh * sr * sp,
            0.0,
            -cr * cp,
            -cr * sp,
        );
        [by_h, by_r, by_p]
    }
}

/// One iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceIteration {
    /// Corrections of H, R, P, radians.
    pub step: [f64; 3],
    /// Root mean square of the coordinate differences before it, metres.
    pub rms_m: f64,
}

/// What the reference path found.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceOutcome {
    /// Adjusted attitude of the transducer.
    pub adjusted: PrintedAngles,
    /// The attitude sensor's mean over the common fixes: roll, pitch, heading in its own sense, radians.
    pub measured: [f64; 3],
    /// The patent's calibration: adjusted minus measured, the sensor's pitch and roll taken with the patent's signs.
    pub difference: PrintedAngles,
    /// The same as a rotation, `R_u^b = (R_b^l)^T R_u^l`.
    pub rotation: Matrix3<f64>,
    /// Formal covariance of pitch, roll, yaw (rad^2) from the residuals of the means; `None` without redundancy.
    pub covariance: Option<Matrix3<f64>>,
    /// Largest turn of the attitude sensor away from its mean, radians: the means presume that it stands still.
    pub unrest_rad: f64,
    /// Every iteration.
    pub iterations: Vec<ReferenceIteration>,
    /// Whether the corrections fell below the tolerance.
    pub converged: bool,
}

/// Why there is no solution of the reference path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// Nothing to calculate from.
    #[error("no common beacon has a fix")]
    NoBeacon,
    /// The common beacons leave a rotation free.
    #[error(
        "the common beacons ({beacons}) lie on one line with the transducer: the rotation about that line is not determined"
    )]
    Singular {
        /// Their names.
        beacons: String,
    },
    /// The common beacons hardly hold an angle.
    #[error("the common beacons do not determine {}", parameters.join(", "))]
    Weak {
        /// The angles with their formal standard deviation and the limit.
        parameters: Vec<String>,
    },
    /// The rays of a beacon's fixes leave the water.
    #[error("the rays of beacon {beacon} cannot be followed: {reason}")]
    Ray {
        /// Its name.
        beacon: String,
        /// Why not.
        reason: String,
    },
}

/// A beacon: the mean of its fixes in the transducer frame, and where it was surveyed from the transducer.
struct Mean {
    fixed_m: Vector3<f64>,
    surveyed_m: Vector3<f64>,
}

/// Runs the reference path.
///
/// # Errors
/// [`ReferenceError`].
pub fn run(scene: &Scene, config: &ReferenceConfig) -> Result<ReferenceOutcome, ReferenceError> {
    let level_from_body = mean_attitude(scene).ok_or(ReferenceError::NoBeacon)?;
    let mut angles = PrintedAngles::of(&(level_from_body * scene.campaign.nominal));
    let mut iterations = vec![];
    let mut converged = false;
    let mut means = vec![];
    for round in 0..RAY_ROUNDS {
        means = bent_means(scene, (round > 0).then(|| angles.matrix()))?;
        converged = iterate(scene, &means, &mut angles, &mut iterations, config)?;
    }
    let (roll, pitch, heading) = rotation::to_attitude(&level_from_body);
    let rotation = level_from_body.tr_mul(&angles.matrix());
    let covariance = formal(&means, &angles, &level_from_body);
    if let Some(covariance) = &covariance {
        refuse_weak(covariance, config.max_sigma_deg)?;
    }
    Ok(ReferenceOutcome {
        adjusted: angles,
        measured: [roll, pitch, heading],
        difference: PrintedAngles {
            h: wrap_angle(angles.h - heading),
            r: wrap_angle(angles.r + roll),
            p: wrap_angle(angles.p + pitch),
        },
        covariance,
        unrest_rad: unrest(scene, &level_from_body),
        rotation,
        iterations,
        converged,
    })
}

/// The mean of the attitude at the common fixes: the rotation nearest to the mean of the matrices.
fn mean_attitude(scene: &Scene) -> Option<Matrix3<f64>> {
    let matrices = scene
        .common
        .iter()
        .map(|fix| scene.poses[*fix as usize].rotation);
    (!scene.common.is_empty()).then(|| rotation::orthonormalised(&matrices.sum()))
}

fn unrest(scene: &Scene, mean: &Matrix3<f64>) -> f64 {
    let away = |fix: &u32| {
        let turn = scene.poses[*fix as usize].rotation * mean.transpose();
        rotation::log(&turn).norm()
    };
    scene.common.iter().map(away).fold(0.0, f64::max)
}

/// Means of the fixes corrected for the bend of their rays. The first time each ray is bent with the attitude of its own moment
/// and the nominal mounting, then with the attitude found.
fn bent_means(scene: &Scene, attitude: Option<Matrix3<f64>>) -> Result<Vec<Mean>, ReferenceError> {
    let campaign = scene.campaign;
    let mut sums = vec![(Vector3::zeros(), 0.0); campaign.beacons.len()];
    for &fix in &scene.common {
        let fix = fix as usize;
        let beacon = campaign.fixes.beacon[fix] as usize;
        let level = attitude.unwrap_or_else(|| scene.poses[fix].rotation * campaign.nominal);
        let point = scene.point(fix, &level, &Vector3::zeros(), 0.0);
        let point_m = point.map_err(|error| ReferenceError::Ray {
            beacon: campaign.beacons[beacon].point.name.clone(),
            reason: error.to_string(),
        })?;
        sums[beacon].0 += level.tr_mul(&point_m);
        sums[beacon].1 += 1.0;
    }
    let seen = sums
        .iter()
        .zip(&campaign.beacons)
        .filter(|((_, n), _)| *n > 0.0);
    Ok(seen
        .map(|((sum, n), beacon)| Mean {
            fixed_m: sum / *n,
            surveyed_m: beacon.point.position_m,
        })
        .collect())
}

/// `X_CGCS - X_T = r(H, R, P) X_USBL`, linearised and solved until the corrections vanish; whether they did.
fn iterate(
    scene: &Scene,
    means: &[Mean],
    angles: &mut PrintedAngles,
    iterations: &mut Vec<ReferenceIteration>,
    config: &ReferenceConfig,
) -> Result<bool, ReferenceError> {
    for _ in 0..config.max_iterations {
        let matrix = angles.matrix();
        let derivatives = angles.derivatives();
        let (mut normal, mut right, mut squares) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        for mean in means {
            let columns = derivatives.map(|d| d * mean.fixed_m);
            let design = Matrix3::from_columns(&columns);
            let rest = mean.surveyed_m - matrix * mean.fixed_m;
            normal += design.tr_mul(&design);
            right += design.tr_mul(&rest);
            squares += rest.norm_squared();
        }
        let step = solved(&normal, &right).ok_or_else(|| singular(scene))?;
        (angles.h, angles.r, angles.p) = (angles.h + step.x, angles.r + step.y, angles.p + step.z);
        iterations.push(ReferenceIteration {
            step: step.into(),
            rms_m: (squares / (3 * means.len()) as f64).sqrt(),
        });
        if step.amax() < TOLERANCE_RAD {
            return Ok(true);
        }
    }
    Ok(false)
}

fn solved(normal: &Matrix3<f64>, right: &Vector3<f64>) -> Option<Vector3<f64>> {
    let eigen = normal.symmetric_eigenvalues();
    if !(eigen.min() > SINGULAR * eigen.max()) {
        return None;
    }
    normal.cholesky().map(|factor| factor.solve(right))
}

fn singular(scene: &Scene) -> ReferenceError {
    let beacons = &scene.campaign.beacons;
    let seen = scene.common_beacons();
    let names: Vec<_> = seen
        .iter()
        .map(|b| beacons[*b as usize].point.name.as_str())
        .collect();
    ReferenceError::Singular {
        beacons: names.join(", "),
    }
}

fn refuse_weak(covariance: &Matrix3<f64>, limit_deg: f64) -> Result<(), ReferenceError> {
    let mut parameters = vec![];
    for (i, name) in super::joint::MOUNTING.iter().enumerate() {
        let sigma_deg = covariance[(i, i)].sqrt().to_degrees();
        if !(sigma_deg <= limit_deg) {
            parameters.push(format!(
                "{name} (formal standard deviation {sigma_deg:.3} deg, limit {limit_deg} deg)"
            ));
        }
    }
    if parameters.is_empty() {
        Ok(())
    } else {
        Err(ReferenceError::Weak { parameters })
    }
}

/// Covariance of the body-frame turn from the residuals of the means, `s0^2 (sum [x]^T [x])^-1`.
fn formal(
    means: &[Mean],
    angles: &PrintedAngles,
    level_from_body: &Matrix3<f64>,
) -> Option<Matrix3<f64>> {
    let redundancy = 3.0 * means.len() as f64 - 3.0;
    let (mut normal, mut squares) = (Matrix3::zeros(), 0.0);
    for mean in means {
        let in_level = angles.matrix() * mean.fixed_m;
        let cross = rotation::skew(&level_from_body.tr_mul(&in_level));
        normal += cross.tr_mul(&cross);
        squares += (mean.surveyed_m - in_level).norm_squared();
    }
    let inverse = normal.try_inverse()?;
    (redundancy > 0.0).then(|| inverse * (squares / redundancy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation::exp;

    const ANGLES: PrintedAngles = PrintedAngles {
        h: 0.7,
        r: -0.2,
        p: 0.15,
    };

    fn about(axis: usize, angle: f64) -> Matrix3<f64> {
        exp(&Vector3::ith(axis, angle))
    }

    #[test]
    fn the_printed_matrix_is_three_turns_against_their_senses() {
        let product = about(2, -ANGLES.h) * about(1, -ANGLES.r) * about(0, -ANGLES.p);
        assert!((product - ANGLES.matrix()).norm() < 1e-15);
        let back = PrintedAngles::of(&ANGLES.matrix());
        assert!((back.h - ANGLES.h).abs() + (back.r - ANGLES.r).abs() < 1e-15);
        assert!((back.p - ANGLES.p).abs() < 1e-15);
    }

    /// R is positive starboard up and P positive bow down: opposite to the attitude sensor's roll and pitch.
    #[test]
    fn the_printed_roll_and_pitch_have_the_opposite_sense() {
        let sensor = rotation::from_attitude(0.1, 0.0, 0.0);
        assert!((PrintedAngles::of(&sensor).r + 0.1).abs() < 1e-15);
        let sensor = rotation::from_attitude(0.0, 0.1, 0.0);
        assert!((PrintedAngles::of(&sensor).p + 0.1).abs() < 1e-15);
        let sensor = rotation::from_attitude(0.0, 0.0, 0.1);
        assert!((PrintedAngles::of(&sensor).h - 0.1).abs() < 1e-15);
    }

    /// All nine coefficients of the linearisation, T11 among them: with the misprint the first is off by 0.03.
    #[test]
    fn the_corrected_linearisation_is_that_of_differences() {
        let step = 1e-6;
        let moved = |k: usize, d: f64| {
            let mut a = [ANGLES.h, ANGLES.r, ANGLES.p];
            a[k] += d;
            let [h, r, p] = a;
            PrintedAngles { h, r, p }.matrix()
        };
        for (k, derivative) in ANGLES.derivatives().iter().enumerate() {
            let difference = (moved(k, step) - moved(k, -step)) / (2.0 * step);
            assert!((difference - derivative).amax() < 1e-9, "{k}");
        }
        let misprinted = -math::sin(ANGLES.r) * math::cos(ANGLES.p);
        let t11_by_r = ANGLES.derivatives()[1][(0, 0)];
        assert!((misprinted - t11_by_r).abs() > 0.03);
    }
}
