//! Frames, rotations, the ellipsoid, planes: geometry without instruments.

pub mod axes;
pub mod curve;
pub mod ellipsoid;
pub mod fit2d;
pub mod frames;
pub mod hausdorff;
pub mod plane;
pub mod ransac;
pub mod robust_plane;
pub mod rotation;
pub mod utm;

pub use axes::Axes;
pub use ellipsoid::{Ellipsoid, Geodetic};
pub use frames::{Body, Ecef, Level, Point, Pose, Rotation, Scanner, Sonar, Target};
pub use plane::{Plane, PlaneError, PlaneFit, PlaneMoments};
pub use utm::{Utm, UtmError};
