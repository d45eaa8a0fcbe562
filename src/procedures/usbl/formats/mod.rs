//! The files that only a USBL calibration reads: acoustic fixes and control points.

use std::path::Path;

pub mod control_csv;
pub mod fixes_csv;

use crate::formats::registry::{TEXT, choose};
use crate::formats::{Format, FormatError, Invalid, Reader};
use control_csv::ControlRecords;
use fixes_csv::FixRecords;

const FIXES: Format = Format {
    name: "acoustic fixes CSV",
    extensions: TEXT,
    magic: b"",
    holds: "`time_s,beacon` with ranges or travel times and angles, or coordinates",
    readers: &[Reader::Own("fixes", |path| {
        fixes_csv::read(path, Invalid::Error).map(drop)
    })],
    written: true,
};
const CONTROL: Format = Format {
    name: "control points CSV",
    extensions: TEXT,
    magic: b"",
    holds: "`name,role`, coordinates and their standard deviations",
    readers: &[Reader::Own("control points", |path| {
        control_csv::read(path).map(drop)
    })],
    written: true,
};

/// Every format of this folder.
pub const FORMATS: &[Format] = &[FIXES, CONTROL];

/// Reads acoustic fixes, of which a few may be `invalid`.
///
/// # Errors
/// [`FormatError`] for a file of no known format and for everything the reader refuses.
pub fn read_fixes(path: &Path, invalid: Invalid) -> Result<FixRecords, FormatError> {
    choose(path, &[(&FIXES, fixes_csv::read)])?(path, invalid)
}

/// Reads control points.
///
/// # Errors
/// As [`read_fixes`].
pub fn read_control(path: &Path) -> Result<ControlRecords, FormatError> {
    choose(path, &[(&CONTROL, control_csv::read)])?(path)
}
