//! A laser scan: one row per return.

/// The frame of a scan's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaserCoordinates {
    /// The scanner's own frame; needs mounting and trajectory.
    Sensor,
    /// The target frame of the survey file's origin and azimuth.
    Target,
    /// Geocentric (ECEF). UTM coordinates of a file become geocentric on reading.
    Geocentric,
}

/// A-priori noise of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserNoise {
    /// Range, metres, one sigma.
    pub range_m: f64,
    /// Angle in the scanner's plane, radians, one sigma.
    pub angle_rad: f64,
    /// Isotropic point noise, metres, for already georeferenced points.
    pub point_m: f64,
}

/// Laser returns in columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserScan {
    /// Time of each return on the trajectory's clock, seconds, ascending.
    pub time_s: Vec<f64>,
    /// First coordinate (sensor x, target X or ECEF X), metres.
    pub x_m: Vec<f64>,
    /// Second coordinate, metres.
    pub y_m: Vec<f64>,
    /// Third coordinate, metres.
    pub z_m: Vec<f64>,
    /// Frame of the coordinates.
    pub coordinates: LaserCoordinates,
    /// A-priori noise.
    pub noise: LaserNoise,
}

impl LaserScan {
    /// Number of returns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no return.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Coordinates of return `k`, metres.
    #[must_use]
    pub fn point(&self, k: usize) -> nalgebra::Vector3<f64> {
        nalgebra::Vector3::new(self.x_m[k], self.y_m[k], self.z_m[k])
    }
}
