//! Frames, rotations, the ellipsoid, planes: geometry without instruments.

pub mod ellipsoid;
pub mod frames;
pub mod rotation;
pub mod utm;

pub use ellipsoid::{Ellipsoid, Geodetic};
pub use frames::{Body, Ecef, Level, Point, Pose, Rotation, Scanner, Sonar, Target};
pub use utm::{Utm, UtmError};
