//! Files to columns and back: trajectories, laser returns, soundings, sound-speed profiles.
//!
//! | format | module | read | write |
//! |---|---|---|---|
//! | trajectory CSV | [`trajectory_csv`] | yes | yes |
//! | SBET `.out`, `.sbet` | [`sbet`] | yes | yes |
//! | LAS, LAZ | [`las`] | yes | yes |
//! | laser CSV | [`laser_csv`] | yes | yes |
//! | soundings CSV | [`soundings_csv`] | yes | yes |
//! | sound-speed profile CSV | [`sound_speed_csv`] | yes | yes |
//! | rail profiles, table CSV | [`rail_csv`] | yes | yes |
//! | rail profiles Parquet | `rail_parquet` (cargo feature `parquet`) | yes | no |
//! | attitude CSV | [`attitude_csv`] | yes | yes |
//! | acoustic fixes CSV | [`usbl_fixes_csv`] | yes | yes |
//! | control points CSV | [`usbl_control_csv`] | yes | yes |
//!
//! Each reader has two doors: `read(path)`, and `read_from` for bytes that are already at hand. Files hold degrees, the
//! columns radians. Whatever is wrong with a file comes back as one [`FormatError`]: file, place, found, expected.
//! Readers stream: besides the columns they keep a buffer of about a megabyte.

pub mod attitude_csv;
#[cfg(feature = "parquet")]
pub mod columns;
pub mod digest;
pub mod error;
pub mod las;
pub mod laser_csv;
pub mod rail_csv;
#[cfg(feature = "parquet")]
pub mod rail_parquet;
pub mod records;
pub mod rows;
pub mod sbet;
pub mod sound_speed_csv;
pub mod soundings_csv;
pub mod table;
pub mod tidy;
pub mod trajectory_csv;
pub mod usbl_control_csv;
pub mod usbl_fixes_csv;
pub mod whole;

pub use error::{FaultKind, FormatError, Place};
pub use records::{LaserRecords, SoundingRecords, TrajectoryRecords};

use std::path::Path;

use crate::observe::ProfilePoints;

/// The extension in lower case, empty if there is none.
fn extension(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}

/// Reads a trajectory, the format told by the extension: `.csv`, or SBET as `.out` or `.sbet`.
///
/// # Errors
/// [`FormatError`] for an unknown extension and for everything the readers refuse.
pub fn read_trajectory(path: &Path) -> Result<TrajectoryRecords, FormatError> {
    match extension(path).as_str() {
        "csv" => trajectory_csv::read(path),
        "out" | "sbet" => sbet::read(path),
        _ => Err(FormatError::unknown_extension(path, ".csv, .out or .sbet")),
    }
}

/// Reads laser returns, the format told by the extension: `.las`, `.laz` or `.csv`.
///
/// # Errors
/// [`FormatError`] for an unknown extension and for everything the readers refuse.
pub fn read_laser(path: &Path) -> Result<LaserRecords, FormatError> {
    match extension(path).as_str() {
        "csv" => laser_csv::read(path),
        "las" | "laz" => las::read(path),
        _ => Err(FormatError::unknown_extension(path, ".las, .laz or .csv")),
    }
}

/// As [`read_laser`], for georeferenced points: a LAS or LAZ without GPS time will do.
///
/// # Errors
/// As [`read_laser`].
pub fn read_laser_cloud(path: &Path) -> Result<LaserRecords, FormatError> {
    match extension(path).as_str() {
        "las" | "laz" => las::read_untimed(path),
        _ => read_laser(path),
    }
}

/// Reads soundings from a `.csv`.
///
/// # Errors
/// [`FormatError`] for an unknown extension and for everything the reader refuses.
pub fn read_soundings(path: &Path) -> Result<SoundingRecords, FormatError> {
    match extension(path).as_str() {
        "csv" => soundings_csv::read(path),
        _ => Err(FormatError::unknown_extension(
            path,
            ".csv (Kongsberg .all and .kmall, XTF and Parquet are not built yet)",
        )),
    }
}

/// Reads the profiles of a rail survey of so many profilers: from Parquet if the file's name ends in `.parquet`, else from CSV.
///
/// # Errors
/// [`FormatError`] for everything the readers refuse, and for a `.parquet` without the cargo feature of that name.
pub fn read_rail_profiles(path: &Path, profilers: usize) -> Result<ProfilePoints, FormatError> {
    match extension(path).as_str() {
        "parquet" => rail_profiles_parquet(path, profilers),
        _ => rail_csv::read_profiles(path, profilers),
    }
}

#[cfg(feature = "parquet")]
use rail_parquet::read_profiles as rail_profiles_parquet;

#[cfg(not(feature = "parquet"))]
fn rail_profiles_parquet(path: &Path, _: usize) -> Result<ProfilePoints, FormatError> {
    Err(FormatError::new(
        FaultKind::UnknownFormat,
        path,
        Place::File,
        "a Parquet file, which this program was built without",
        "CSV, or a program built with it (cargo install --path . --features parquet)",
    ))
}
