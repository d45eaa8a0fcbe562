//! The files that only a rail calibration reads: its profiles and the positions of its table.

use std::path::Path;

pub mod rail_csv;
#[cfg(feature = "parquet")]
pub mod rail_parquet;

use super::observed::{ProfilePoints, TableRecord};
use crate::formats::registry::{TEXT, choose};
use crate::formats::{Format, FormatError, Reader};

/// Reads profiles of so many profilers.
type ReadProfiles = fn(&Path, usize) -> Result<ProfilePoints, FormatError>;

const PROFILES: Format = Format {
    name: "rail profiles CSV",
    extensions: TEXT,
    magic: b"",
    holds: "`time_s,profiler,y_m,z_m`",
    readers: &[Reader::Own("rail profiles", |path| {
        rail_csv::read_profiles(path, ANY).map(drop)
    })],
    written: true,
};
const PARQUET: Format = Format {
    name: "rail profiles Parquet",
    extensions: &["parquet"],
    magic: b"PAR1",
    holds: "the same columns (cargo feature `parquet`)",
    readers: &[Reader::Own("rail profiles", |path| {
        parquet_profiles(path, ANY).map(drop)
    })],
    written: false,
};
const TABLE: Format = Format {
    name: "table positions CSV",
    extensions: TEXT,
    magic: b"",
    holds: "when the table rested, and at which angles",
    readers: &[Reader::Own("table positions", |path| {
        rail_csv::read_table(path).map(drop)
    })],
    written: true,
};

/// Every format of this folder.
pub const FORMATS: &[Format] = &[PROFILES, PARQUET, TABLE];

/// More profilers than a beam carries.
const ANY: usize = u8::MAX as usize;

/// Reads the profiles of a rail survey of so many profilers.
///
/// # Errors
/// [`FormatError`] for a file of no known format and for everything the reader refuses.
pub fn read_profiles(path: &Path, profilers: usize) -> Result<ProfilePoints, FormatError> {
    let among: [(&Format, ReadProfiles); 2] = [
        (&PROFILES, rail_csv::read_profiles),
        (&PARQUET, parquet_profiles),
    ];
    choose(path, &among)?(path, profilers)
}

/// Reads the positions of a measuring table.
///
/// # Errors
/// As [`read_profiles`].
pub fn read_table(path: &Path) -> Result<TableRecord, FormatError> {
    choose(path, &[(&TABLE, rail_csv::read_table)])?(path)
}

#[cfg(feature = "parquet")]
use rail_parquet::read_profiles as parquet_profiles;

#[cfg(not(feature = "parquet"))]
fn parquet_profiles(path: &Path, _: usize) -> Result<ProfilePoints, FormatError> {
    use crate::formats::{FaultKind, Place};
    Err(FormatError::new(
        FaultKind::UnknownFormat,
        path,
        Place::File,
        "a Parquet file, which this program was built without",
        "CSV, or a program built with it (cargo install --path . --features parquet)",
    ))
}
