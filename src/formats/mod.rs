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
//! | rail profiles, attitude, table CSV | [`rail_csv`] | yes | yes |
//! | attitude CSV | [`attitude_csv`] | yes | yes |
//! | acoustic fixes CSV | [`usbl_fixes_csv`] | yes | yes |
//! | control points CSV | [`usbl_control_csv`] | yes | yes |
//!
//! Each reader has two doors: `read(path)`, and `read_from` for bytes that are already at hand. Files hold degrees, the
//! columns radians. Whatever is wrong with a file comes back as one [`FormatError`]: file, place, found, expected.
//! Readers stream: besides the columns they keep a buffer of about a megabyte.

pub mod attitude_csv;
pub mod digest;
pub mod error;
pub mod las;
pub mod laser_csv;
pub mod rail_csv;
pub mod records;
pub mod sbet;
pub mod sound_speed_csv;
pub mod soundings_csv;
pub mod table;
pub mod trajectory_csv;
pub mod usbl_control_csv;
pub mod usbl_fixes_csv;
pub mod whole;

pub use error::{FaultKind, FormatError, Place};
pub use records::{LaserRecords, SoundingRecords, TrajectoryRecords};

use std::path::Path;

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
