//! The profiles of a rail calibration as Parquet: columns `time_s`, `profiler` (counted from 1), `y_m`, `z_m` of any numeric type.

use std::path::Path;

use super::super::observed::ProfilePoints;
use super::rail_csv::{PROFILES, profiles};
use crate::formats::columns::Columns;
use crate::formats::error::FormatError;

/// Reads a profiles Parquet file of so many profilers.
///
/// # Errors
/// As [`super::rail_csv::read_profiles`], and [`FormatError`] for what [`Columns`] refuses.
pub fn read_profiles(path: &Path, profilers: usize) -> Result<ProfilePoints, FormatError> {
    profiles(Columns::open(path, &PROFILES)?, profilers)
}
