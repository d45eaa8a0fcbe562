//! Sound-speed profile CSV: `depth_m,sound_speed_m_s`, depth positive down from the water level.

use std::io::{Read, Write};
use std::path::Path;

use super::error::{FaultKind, FormatError, open};
use super::rows::Rows;
use super::table::{Limits, Table};
use super::whole::write_whole;
use crate::observe::SoundSpeedProfile;

// LAYOUT

const COLUMNS: [&str; 2] = ["depth_m", "sound_speed_m_s"];
const DEPTH: Limits = Limits {
    min: 0.0,
    max: 12_000.0,
    expected: "a depth from 0 to 12000 m, positive down",
};
/// What sound travels at in water between freezing and boiling, fresh or salt.
pub const SPEED: Limits = Limits {
    min: 1300.0,
    max: 1700.0,
    expected: "a sound speed from 1300 to 1700 m/s",
};

// READ

/// Reads a sound-speed profile.
///
/// # Errors
/// [`FormatError`]: unreadable, empty, a column missing, a value impossible, depths that do not strictly ascend.
pub fn read(path: &Path) -> Result<SoundSpeedProfile, FormatError> {
    let (file, size) = open(path)?;
    read_from(path, file, size)
}

/// Reads a sound-speed profile of `size` bytes from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    size: u64,
) -> Result<SoundSpeedProfile, FormatError> {
    let mut table = Table::open(file, source, size, &COLUMNS, &[])?;
    let mut profile = SoundSpeedProfile {
        depth_m: vec![],
        speed_m_s: vec![],
    };
    table.each(None, |table| {
        let (depth_m, speed_m_s) = (table.number(0, &DEPTH)?, table.number(1, &SPEED)?);
        if let Some(before) = profile.depth_m.last()
            && depth_m <= *before
        {
            let found = format!("{depth_m} after {before}");
            return Err(table.fault(FaultKind::Order, 0, found, "strictly ascending depths"));
        }
        profile.depth_m.push(depth_m);
        profile.speed_m_s.push(speed_m_s);
        Ok(())
    })?;
    Ok(profile)
}

// WRITE

/// Writes a sound-speed profile, every digit.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`.
pub fn write(path: &Path, profile: &SoundSpeedProfile) -> Result<(), FormatError> {
    write_whole(path, |w| write_to(w, profile))
}

/// Writes a sound-speed profile into `out`, see [`write()`].
///
/// # Errors
/// Those of `out`.
pub fn write_to(out: &mut impl Write, profile: &SoundSpeedProfile) -> std::io::Result<()> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    for (depth, speed) in profile.depth_m.iter().zip(&profile.speed_m_s) {
        writeln!(out, "{depth},{speed}")?;
    }
    Ok(())
}
