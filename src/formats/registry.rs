//! The one list of file formats: what a survey file may name, how a format is told, and which streams it gives.
//!
//! # To add a format
//! 1. Write its reader: a file or folder beside this one, `read(path)` for every stream that it gives, with the record types of
//!    [`super::records`] or [`crate::observe`]. Columns carry no noise: a sensor has noise, a file has columns.
//! 2. Add one [`Format`] to [`FORMATS`]. A recorder's file that holds several streams lists one [`Reader`] for each; it is read anew for
//!    every stream that a survey file wants of it.
//! 3. A stream that no format gave before is a new variant of [`Reader`], with a word in [`Reader::stream`].
//!
//! A file that one procedure alone reads stands in that procedure's folder instead, with its reader: `Procedure::formats` lists it, as
//! [`Reader::Own`], and [`choose`] finds its reader.
//!
//! The loaders, the messages about unknown files, the page `docs/formats.md` and the suites for bad input go through the table by
//! themselves.

use std::path::Path;

use super::attitude_csv::{self, Layout};
use super::error::{FaultKind, FormatError, Place, open};
use super::faults::Invalid;
use super::kind::kind_of;
use super::records::{LaserRecords, SoundingRecords, TrajectoryRecords};
use super::{las, laser_csv, sbet, sound_speed_csv, soundings_csv, tide_csv, trajectory_csv};
use crate::observe::{AttitudeRecord, Room, SoundSpeedProfile, SoundingFile, TideCurve};

type Read<T> = fn(&Path) -> Result<T, FormatError>;
/// Reads observations, of which a few may be invalid.
type ReadSome<T> = fn(&Path, Invalid) -> Result<T, FormatError>;

/// What a file gives, with the function that reads it.
#[derive(Clone, Copy, Debug)]
pub enum Reader {
    /// Position and attitude of the vessel.
    Trajectory(ReadSome<TrajectoryRecords>),
    /// Attitude alone, within the limits of a procedure.
    Attitude(fn(&Path, &Layout) -> Result<AttitudeRecord, FormatError>),
    /// Laser returns.
    Laser(ReadSome<LaserRecords>),
    /// Beams of a multibeam.
    Soundings(ReadSome<SoundingRecords>),
    /// Sound speed by depth.
    SoundSpeed(Read<SoundSpeedProfile>),
    /// Height of the water over time.
    Tide(Read<TideCurve>),
    /// What one procedure alone reads, in its own folder: the stream in a word or two, and whether a file can be read at all.
    Own(&'static str, Read<()>),
}

impl Reader {
    /// The stream in a word or two.
    #[must_use]
    pub fn stream(&self) -> &'static str {
        match self {
            Self::Trajectory(_) => "trajectory",
            Self::Attitude(_) => "attitude",
            Self::Laser(_) => "laser returns",
            Self::Soundings(_) => "soundings",
            Self::SoundSpeed(_) => "sound speed",
            Self::Tide(_) => "tide",
            Self::Own(stream, _) => stream,
        }
    }

    /// Reads a file and throws the records away: whether it can be read at all.
    ///
    /// # Errors
    /// Those of the reader.
    pub fn probe(&self, path: &Path) -> Result<(), FormatError> {
        match self {
            Self::Trajectory(read) => read(path, Invalid::Error).map(drop),
            Self::Attitude(read) => read(path, &attitude_csv::VESSEL).map(drop),
            Self::Laser(read) => read(path, Invalid::Error).map(drop),
            Self::Soundings(read) => read(path, Invalid::Error).map(drop),
            Self::SoundSpeed(read) => read(path).map(drop),
            Self::Tide(read) => read(path).map(drop),
            Self::Own(_, read) => read(path),
        }
    }
}

/// A file format.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Its name, as the documentation and messages say it.
    pub name: &'static str,
    /// The ends of its files' names, in small letters without the dot; the first is the usual one.
    pub extensions: &'static [&'static str],
    /// What every such file begins with; empty where nothing is fixed.
    pub magic: &'static [u8],
    /// What it holds: columns or records, for the documentation.
    pub holds: &'static str,
    /// The streams that it gives.
    pub readers: &'static [Reader],
    /// Whether this program writes it too.
    pub written: bool,
}

impl Format {
    /// Whether a file that begins so is of it, where that can be told.
    fn begins(&self, begin: &[u8]) -> bool {
        !self.magic.is_empty() && begin.starts_with(self.magic)
    }
}

/// Names of small tables that people make by hand.
pub const TEXT: &[&str] = &["csv", "txt"];

/// Every format that more than one procedure may read.
pub const FORMATS: &[Format] = &[
    Format {
        name: "trajectory CSV",
        extensions: &["csv"],
        magic: b"",
        holds: "`time_s,latitude_deg,longitude_deg,height_m,roll_deg,pitch_deg,heading_deg`, optional velocities",
        readers: &[Reader::Trajectory(trajectory_csv::read)],
        written: true,
    },
    Format {
        name: "SBET",
        extensions: &["out", "sbet"],
        magic: b"",
        holds: "17 little-endian doubles a record",
        readers: &[Reader::Trajectory(sbet::read)],
        written: true,
    },
    Format {
        name: "LAS, LAZ",
        extensions: &["laz", "las"],
        magic: b"LASF",
        holds: "points with GPS time",
        readers: &[Reader::Laser(las::read)],
        written: true,
    },
    Format {
        name: "laser CSV",
        extensions: &["csv"],
        magic: b"",
        holds: "`time_s,x_m,y_m,z_m`",
        readers: &[Reader::Laser(laser_csv::read)],
        written: true,
    },
    Format {
        name: "soundings CSV",
        extensions: &["csv"],
        magic: b"",
        holds: "`time_s,ping,beam,across_angle_deg,along_angle_deg` and `range_m` or `two_way_travel_time_s`; of two arrays `rx_angle_deg,tx_tilt_deg` instead, with `tx_delay_s`, `sector`, `head_sound_speed_m_s` where known; `head` where there are several",
        readers: &[Reader::Soundings(soundings_csv::read)],
        written: true,
    },
    Format {
        name: "sound-speed CSV",
        extensions: TEXT,
        magic: b"",
        holds: "`depth_m,sound_speed_m_s`, depth positive down from the water level",
        readers: &[Reader::SoundSpeed(sound_speed_csv::read)],
        written: true,
    },
    Format {
        name: "tide CSV",
        extensions: TEXT,
        magic: b"",
        holds: "`time_s,height_m`, the height of the water over a datum",
        readers: &[Reader::Tide(tide_csv::read)],
        written: true,
    },
    Format {
        name: "attitude CSV",
        extensions: TEXT,
        magic: b"",
        holds: "`time_s,roll_deg,pitch_deg,heading_deg`",
        readers: &[Reader::Attitude(attitude_csv::read)],
        written: true,
    },
];

/// The extension in small letters, empty if there is none.
#[must_use]
pub fn extension(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}

/// The reader of a file among those of the table that `pick` takes.
fn reader<T: Copy>(path: &Path, pick: impl Fn(&Reader) -> Option<T>) -> Result<T, FormatError> {
    let of = |format: &'static Format| Some((format, format.readers.iter().find_map(&pick)?));
    choose(path, &FORMATS.iter().filter_map(of).collect::<Vec<_>>())
}

/// The reader of a file among formats that give the same stream: by the end of its name, else by what it begins with.
///
/// # Errors
/// [`FormatError`] of kind `UnknownFormat` with the formats that give the stream, of kind `Unreadable` for a file that is not there.
pub fn choose<T: Copy>(path: &Path, among: &[(&Format, T)]) -> Result<T, FormatError> {
    let named = extension(path);
    let by_name = |(format, _): &&(&Format, T)| format.extensions.contains(&named.as_str());
    if let Some((_, reader)) = among.iter().find(by_name) {
        return Ok(*reader);
    }
    let begin = begin_of(path)?;
    let by_magic = |(format, _): &&(&Format, T)| format.begins(&begin);
    match among.iter().find(by_magic) {
        Some((_, reader)) => Ok(*reader),
        None => Err(unknown(
            path,
            &begin,
            among.iter().map(|(format, _)| *format),
        )),
    }
}

/// The first bytes of a file.
fn begin_of(path: &Path) -> Result<Vec<u8>, FormatError> {
    let (file, _) = open(path)?;
    let mut begin = vec![];
    std::io::Read::read_to_end(&mut std::io::Read::take(file, 16), &mut begin)
        .map_err(|error| FormatError::unreadable(path, &error))?;
    Ok(begin)
}

/// A file that no format of the wanted stream claims, called by the format that it is of.
fn unknown<'f>(path: &Path, begin: &[u8], wanted: impl Iterator<Item = &'f Format>) -> FormatError {
    let ends = path
        .extension()
        .map_or("no extension".to_owned(), |e| format!("extension {e:?}"));
    let found = match FORMATS.iter().find(|format| format.begins(begin)) {
        Some(format) => format!("{ends}, a file of format {}", format.name),
        None => format!("{ends}, {}", kind_of(begin)),
    };
    let known: Vec<_> = wanted.map(called).collect();
    let expected = format!("one of {}", known.join(", "));
    FormatError::new(FaultKind::UnknownFormat, path, Place::File, found, expected)
}

/// `.out or .sbet (SBET)`.
fn called(format: &Format) -> String {
    let dotted: Vec<_> = format.extensions.iter().map(|e| format!(".{e}")).collect();
    format!("{} ({})", dotted.join(" or "), format.name)
}

/// Declares a door of the table: reads one stream from whatever file gives it.
macro_rules! doors {
    ($($(#[$doc:meta])* $name:ident, $stream:ident($($more:ident: $kind:ty),*) -> $records:ty;)*) => {$(
        $(#[$doc])*
        ///
        /// # Errors
        /// [`FormatError`] for a file of no known format and for everything the reader refuses.
        pub fn $name(path: &Path $(, $more: $kind)*) -> Result<$records, FormatError> {
            let read = reader(path, |reader| match reader {
                Reader::$stream(read) => Some(*read),
                _ => None,
            })?;
            read(path $(, $more)*)
        }
    )*};
}

doors! {
    /// Reads a trajectory, of whose records a few may be `invalid`.
    read_trajectory, Trajectory(invalid: Invalid) -> TrajectoryRecords;
    /// Reads an attitude record within the limits of a layout.
    read_attitude, Attitude(layout: &Layout) -> AttitudeRecord;
    /// Reads laser returns, of which a few may be `invalid`.
    read_laser, Laser(invalid: Invalid) -> LaserRecords;
    /// Reads soundings, of which a few may be `invalid`.
    read_soundings, Soundings(invalid: Invalid) -> SoundingRecords;
    /// Reads a sound-speed profile.
    read_sound_speed, SoundSpeed() -> SoundSpeedProfile;
    /// Reads a tide curve.
    read_tide, Tide() -> TideCurve;
}

/// Reads soundings as [`read_soundings`] does; those for which there is no room in memory go to a file as they are read, of
/// several heads those of `head`.
///
/// # Errors
/// As [`read_soundings`], and [`FaultKind::Unwritable`] with the folder in which that file cannot be written.
pub fn read_soundings_within(
    path: &Path,
    invalid: Invalid,
    room: &Room,
    head: Option<u32>,
) -> Result<(SoundingRecords, Option<SoundingFile>), FormatError> {
    // one format holds soundings alone
    reader(path, |reader| {
        matches!(reader, Reader::Soundings(_)).then_some(())
    })?;
    soundings_csv::read_within(path, invalid, room, head)
}

/// Formats as a table in Markdown, for `docs/formats.md`.
#[must_use]
pub fn markdown<'f>(formats: impl Iterator<Item = &'f Format>) -> String {
    let mut text =
        String::from("| format | files | gives | holds | written |\n|---|---|---|---|---|\n");
    for format in formats {
        let files: Vec<_> = format
            .extensions
            .iter()
            .map(|e| format!("`.{e}`"))
            .collect();
        let gives: Vec<_> = format.readers.iter().map(Reader::stream).collect();
        text.push_str(&format!(
            "| {} | {} | {} | {} | {} |\n",
            format.name,
            files.join(", "),
            gives.join(", "),
            format.holds,
            if format.written { "yes" } else { "no" },
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_procedure_s_own_file_is_probed_by_its_own_reader() {
        let refused = |path: &Path| {
            let fault = FaultKind::Unreadable;
            Err(FormatError::new(
                fault,
                path,
                Place::File,
                "nothing",
                "more",
            ))
        };
        let own = Reader::Own("points", refused);
        assert_eq!(own.stream(), "points");
        let said = own.probe(Path::new("p.csv")).expect_err("refused");
        assert!(said.to_string().starts_with("p.csv: "), "{said}");
    }
}
