//! What the reference path compares, in a target frame that is moved a little.

use nalgebra::{Matrix3, Vector3, Vector4};

use super::super::frame::turned;
use super::super::sequential::ScannerPlanes;
use crate::geometry::PlaneFit;

/// A frame whose origin is shifted and whose azimuth has grown, as the registration moves it.
pub(super) struct Frame {
    /// Rotation into it.
    pub back: Matrix3<f64>,
    shift_m: Vector3<f64>,
}

impl Frame {
    /// From the shift of the origin (metres) and the growth of the azimuth (radians).
    pub(super) fn of(knobs: &Vector4<f64>) -> Self {
        Self {
            back: turned(knobs[3]).transpose(),
            shift_m: knobs.fixed_rows::<3>(0).into_owned(),
        }
    }

    /// A point in it.
    pub(super) fn point(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.back * (point_m - self.shift_m)
    }

    /// The scanner's planes in it; `wall_m` is the mean of the wall's returns.
    pub(super) fn planes(&self, planes: &ScannerPlanes, wall_m: &Vector3<f64>) -> ScannerPlanes {
        let wall_m = Vector3::new(planes.wall_mean_x_m, wall_m.y, wall_m.z);
        let mut moved = planes.clone();
        for fit in [&mut moved.p1, &mut moved.p2, &mut moved.p3] {
            self.plane(fit);
        }
        moved.wall_mean_x_m = self.point(&wall_m).x;
        for h in &mut moved.horizontal {
            h.mean_height_m -= self.shift_m.z;
        }
        moved
    }

    fn plane(&self, fit: &mut PlaneFit) {
        fit.centroid_m = self.point(&fit.centroid_m);
        fit.plane.normal = self.back * fit.plane.normal;
        fit.plane.offset_m = fit.plane.normal.dot(&fit.centroid_m);
        fit.along = fit.along.map(|axis| self.back * axis);
    }
}
