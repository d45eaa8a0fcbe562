//! The reference ellipsoid: geodetic and geocentric coordinates, local level and target axes.

use crate::math;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::frames::{Ecef, Level, Point, Pose, Rotation, Target};

/// A reference ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Ellipsoid {
    /// a = 6378137 m, 1/f = 298.257223563 (NIMA TR8350.2).
    #[default]
    #[serde(rename = "WGS84")]
    Wgs84,
    /// a = 6378137 m, 1/f = 298.257222101 (GB 22021-2008).
    #[serde(rename = "CGCS2000")]
    Cgcs2000,
}

/// Latitude and longitude (radians) and ellipsoidal height (metres).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Geodetic latitude, radians, north positive.
    pub latitude_rad: f64,
    /// Longitude, radians, east positive.
    pub longitude_rad: f64,
    /// Height above the ellipsoid, metres.
    pub height_m: f64,
}

impl Ellipsoid {
    /// Semi-major axis, metres.
    #[must_use]
    pub fn semi_major_axis_m(self) -> f64 {
        6_378_137.0
    }

    /// Flattening f.
    #[must_use]
    pub fn flattening(self) -> f64 {
        match self {
            Self::Wgs84 => 1.0 / 298.257_223_563,
            Self::Cgcs2000 => 1.0 / 298.257_222_101,
        }
    }

    fn eccentricity_squared(self) -> f64 {
        let f = self.flattening();
        f * (2.0 - f)
    }

    /// Geodetic to geocentric.
    #[must_use]
    pub fn to_geocentric(self, g: &Geodetic) -> Point<Ecef> {
        let (sin_lat, cos_lat) = math::sin_cos(g.latitude_rad);
        let (sin_lon, cos_lon) = math::sin_cos(g.longitude_rad);
        let e2 = self.eccentricity_squared();
        let normal = self.semi_major_axis_m() / (1.0 - e2 * sin_lat * sin_lat).sqrt();
        let parallel = (normal + g.height_m) * cos_lat;
        Point::new(Vector3::new(
            parallel * cos_lon,
            parallel * sin_lon,
            (normal * (1.0 - e2) + g.height_m) * sin_lat,
        ))
    }

    /// Geocentric to geodetic: Bowring's iteration (Survey Review 1976), better than 10 nm from the ocean floor to orbit.
    #[must_use]
    pub fn to_geodetic(self, point: &Point<Ecef>) -> Geodetic {
        let p = &point.coordinates;
        let (a, f, e2) = (
            self.semi_major_axis_m(),
            self.flattening(),
            self.eccentricity_squared(),
        );
        let (b, second) = (a * (1.0 - f), e2 / (1.0 - e2));
        let radius = math::hypot(p.x, p.y);
        let mut beta = math::atan2(p.z * a, radius * b);
        let mut latitude_rad = 0.0;
        for _ in 0..3 {
            let (sin, cos) = math::sin_cos(beta);
            latitude_rad = math::atan2(
                p.z + second * b * sin.powi(3),
                radius - e2 * a * cos.powi(3),
            );
            beta = math::atan2((1.0 - f) * math::sin(latitude_rad), math::cos(latitude_rad));
        }
        let (sin, cos) = math::sin_cos(latitude_rad);
        let height_m = radius * cos + p.z * sin - a * (1.0 - e2 * sin * sin).sqrt();
        Geodetic {
            latitude_rad,
            longitude_rad: math::atan2(p.y, p.x),
            height_m,
        }
    }
}

/// `R_l^e`: local east-north-up at a geodetic position into ECEF.
#[must_use]
pub fn ecef_from_level(g: &Geodetic) -> Rotation<Ecef, Level> {
    let (sin_lat, cos_lat) = math::sin_cos(g.latitude_rad);
    let (sin_lon, cos_lon) = math::sin_cos(g.longitude_rad);
    Rotation::new(Matrix3::new(
        -sin_lon,
        -sin_lat * cos_lon,
        cos_lat * cos_lon,
        cos_lon,
        -sin_lat * sin_lon,
        cos_lat * sin_lon,
        0.0,
        cos_lat,
        sin_lat,
    ))
}

/// Where a target stands: the origin of its frame and the azimuth (clockwise from north) of its +Y axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPose {
    /// Ellipsoid of `origin`.
    pub ellipsoid: Ellipsoid,
    /// Origin of the target frame.
    pub origin: Geodetic,
    /// Azimuth of the +Y axis, radians.
    pub azimuth_rad: f64,
}

impl TargetPose {
    /// The transform from the target frame into ECEF.
    #[must_use]
    pub fn ecef_from_target(&self) -> Pose<Ecef, Target> {
        let (sin, cos) = math::sin_cos(self.azimuth_rad);
        let level_from_target = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        Pose::new(
            ecef_from_level(&self.origin).matrix * level_from_target,
            self.ellipsoid.to_geocentric(&self.origin).coordinates,
        )
    }

    /// The pose after moving the origin by `offset_m` (in this target frame) and turning the azimuth by `turn_rad`.
    #[must_use]
    pub fn moved(&self, offset_m: &Vector3<f64>, turn_rad: f64) -> Self {
        let origin = self.ecef_from_target() * Point::<Target>::new(*offset_m);
        Self {
            ellipsoid: self.ellipsoid,
            origin: self.ellipsoid.to_geodetic(&origin),
            azimuth_rad: self.azimuth_rad + turn_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_level_axes_point_east_north_up() {
        let g = Geodetic {
            latitude_rad: 0.6,
            longitude_rad: 2.1,
            height_m: 30.0,
        };
        let step = 1e-7;
        let north = Geodetic {
            latitude_rad: 0.6 + step,
            ..g
        };
        let d = Ellipsoid::Wgs84.to_geocentric(&north).coordinates
            - Ellipsoid::Wgs84.to_geocentric(&g).coordinates;
        let level = ecef_from_level(&g).matrix.transpose() * d;
        assert!(level.y > 0.6 && level.x.abs() < 1e-6 && level.z.abs() < 1e-6);
    }

    #[test]
    fn a_target_looking_north_has_x_east() {
        let origin = Geodetic {
            latitude_rad: 0.6,
            longitude_rad: 2.1,
            height_m: 30.0,
        };
        let pose = TargetPose {
            ellipsoid: Ellipsoid::Wgs84,
            origin,
            azimuth_rad: 0.0,
        };
        assert_eq!(
            pose.ecef_from_target().rotation.matrix,
            ecef_from_level(&origin).matrix
        );
        let east = TargetPose {
            azimuth_rad: std::f64::consts::FRAC_PI_2,
            ..pose
        };
        let y = ecef_from_level(&origin).matrix.transpose()
            * east.ecef_from_target().rotation.matrix
            * Vector3::y();
        assert!((y - Vector3::x()).norm() < 1e-15);
    }

    proptest! {
        #[test]
        fn geodetic_returns(lat in -1.57..1.57f64, lon in -3.1..3.1f64, h in -1e4..1e4f64) {
            let g = Geodetic { latitude_rad: lat, longitude_rad: lon, height_m: h };
            for ellipsoid in [Ellipsoid::Wgs84, Ellipsoid::Cgcs2000] {
                let back = ellipsoid.to_geodetic(&ellipsoid.to_geocentric(&g));
                prop_assert!((back.latitude_rad - lat).abs() < 2e-15);
                prop_assert!((back.height_m - h).abs() < 1e-8);
            }
        }
    }
}
