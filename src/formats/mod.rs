//! Files to columns and back: trajectories, laser returns, soundings, sound-speed profiles.
//!
//! [`registry`] is the one list of formats that any procedure may read; what one alone reads stands in its folder.
//!
//! Each reader has two doors: `read(path)`, and `read_from` for bytes that are already at hand. Files hold degrees, the
//! columns radians. Whatever is wrong with a file comes back as one [`FormatError`]: file, place, found, expected.
//! Readers stream: besides the columns they keep a buffer of about a megabyte.

pub mod attitude_csv;
#[cfg(feature = "parquet")]
pub mod columns;
pub mod digest;
pub mod error;
pub mod faults;
pub mod geotiff;
pub mod gsf;
pub mod kind;
pub mod kmall;
pub mod kongsberg_all;
pub mod las;
pub mod laser_csv;
pub mod novatel;
pub mod pos_mv;
pub mod recorder;
pub mod records;
pub mod registry;
pub mod rows;
pub mod s7k;
pub mod sbet;
pub mod smrmsg;
pub mod sound_speed_csv;
pub mod soundings_csv;
pub mod table;
pub mod tide_csv;
pub mod tidy;
pub mod trajectory_csv;
pub mod week;
pub mod whole;
pub mod xtf;

pub use error::{FaultKind, FormatError, Place};
pub use faults::Invalid;
pub use records::{LaserRecords, SoundingRecords, TrajectoryRecords};
pub use registry::{
    FORMATS, Format, Reader, read_attitude, read_laser, read_sound_speed, read_soundings,
    read_soundings_within, read_tide, read_trajectory,
};

use std::path::Path;

use registry::extension;

/// As [`read_laser`], for georeferenced points: a LAS or LAZ without GPS time will do.
///
/// # Errors
/// As [`read_laser`].
pub fn read_laser_cloud(path: &Path, invalid: Invalid) -> Result<LaserRecords, FormatError> {
    match extension(path).as_str() {
        "las" | "laz" => las::read_untimed(path, invalid),
        _ => read_laser(path, invalid),
    }
}
