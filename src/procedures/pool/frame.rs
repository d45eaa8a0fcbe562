//! The target frame as the laser points place it: origin and azimuth, and how they follow each of these points.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector4};

use super::scene::Scene;
use crate::matching::{Movable, Patches, Response, Sight, Water, responses};
use crate::math;

/// What the surveyor is expected to know beforehand about the target: one sigma of origin (metres) and azimuth (radians).
const PRIOR_ORIGIN_M: f64 = 0.5;
const PRIOR_AZIMUTH_RAD: f64 = 0.035;
/// Width of the kernel with which the registration ends, metres.
pub(super) const LAST_WIDTH_M: f64 = 0.025;

pub(super) fn prior_sigma() -> Vector4<f64> {
    let origin_m = PRIOR_ORIGIN_M;
    Vector4::new(origin_m, origin_m, origin_m, PRIOR_AZIMUTH_RAD)
}

/// First derivatives of the frame's origin (metres) and azimuth (radians) by the laser points of its registration; `point` is a
/// row of the returns. At the frame that was found.
#[must_use]
pub fn of_returns(scene: &Scene) -> Vec<Response<4>> {
    let (target, campaign) = (scene.target, scene.campaign);
    let origins = scene.origins(&campaign.scanner);
    let patches = Patches::new(target, Water::Above, campaign.water_level_m, &origins);
    let sample = LaserSample::of(scene);
    let found = responses(
        &sample,
        &patches,
        &SVector::zeros(),
        &prior_sigma(),
        LAST_WIDTH_M,
    );
    let named = |r: Response<4>| Response {
        point: sample.0[r.point].row as usize,
        ..r
    };
    found.into_iter().map(named).collect()
}

/// Target frame turned about up: azimuth grows by `turn`.
pub(super) fn turned(turn_rad: f64) -> Matrix3<f64> {
    let (s, c) = math::sin_cos(turn_rad);
    Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0)
}

/// A laser point with the ray from its scanner.
struct LaserPoint {
    row: u32,
    point_m: Vector3<f64>,
    ray: Vector3<f64>,
}

/// Laser points that move with the target's pose: origin (metres) and azimuth (radians).
pub(super) struct LaserSample(Vec<LaserPoint>);

impl LaserSample {
    /// The registered points, where the scene's frame has them.
    pub(super) fn of(scene: &Scene) -> Self {
        let one = |&row: &u32| {
            let (point_m, ray) = scene.laser_point(row as usize)?;
            Some(LaserPoint { row, point_m, ray })
        };
        Self(scene.registered.iter().filter_map(one).collect())
    }
}

impl Movable<4> for LaserSample {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn sight(&self, k: usize, parameters: &SVector<f64, 4>) -> Sight<4> {
        let LaserPoint { point_m, ray, .. } = &self.0[k];
        let back = turned(parameters[3]).transpose();
        let moved = point_m - parameters.fixed_rows::<3>(0);
        let (s, c) = math::sin_cos(parameters[3]);
        let slope = Matrix3::new(-s, -c, 0.0, c, -s, 0.0, 0.0, 0.0, 0.0) * moved;
        let mut jacobian = SMatrix::<f64, 3, 4>::zeros();
        jacobian.fixed_columns_mut::<3>(0).copy_from(&-back);
        jacobian.set_column(3, &slope);
        Sight {
            point_m: back * moved,
            ray: back * ray,
            jacobian,
        }
    }
}
