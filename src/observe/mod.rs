//! What instruments say: trajectory, laser scan, soundings, sound speed, and the rig that carries them.

mod arrays;
mod attitude;
pub mod campaign;
pub mod extra;
pub mod laser;
pub mod rig;
pub mod sound_speed;
pub mod sounding_file;
pub mod soundings;
pub mod struck;
pub mod tide;
pub mod trajectory;

pub use attitude::AttitudeRecord;
pub use campaign::Campaign;
pub use extra::{Acts, Extra, ExtraFault, MOST_EXTRAS};
pub use laser::{LaserCoordinates, LaserNoise, LaserScan};
pub use rig::{ArrayMountings, Mounting, MountingSigma};
pub use sound_speed::{SoundSpeed, SoundSpeedProfile};
pub use sounding_file::{Room, Sounding, SoundingFile, SoundingWriter};
pub use soundings::{SonarNoise, SoundingArrays, SoundingRange, Soundings};
pub use struck::{NO_FACE, Struck};
pub use tide::TideCurve;
pub use trajectory::{
    GeodeticTrajectory, Outside, PoseSample, PositionInterpolation, Trajectory, TrajectoryError,
    TrajectoryNoise,
};
