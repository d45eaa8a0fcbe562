//! The table of recorder formats: told by their first bytes, read into a sink.

use std::io::Read;
use std::path::Path;

use super::types::{Attitude, Position, Sink};
use super::{Summary, TimeScale};
use crate::formats::error::{FaultKind, FormatError, Place, open};
use crate::formats::faults::Invalid;
use crate::formats::kind::kind_of;
use crate::formats::{gsf, kmall, kongsberg_all, novatel, pos_mv, s7k, sbet, xtf};

/// Bytes of a file's beginning that tell its format.
const HEAD: usize = 2048;

/// Bytes in which records are looked for where a file does not begin with one.
const SEARCHED: usize = 1 << 18;

/// A format of recorders.
pub struct Recorder {
    /// Its name.
    pub name: &'static str,
    /// Whether a file with these first bytes is of it.
    pub begins: fn(&[u8]) -> bool,
    /// Whether such records stand somewhere in these bytes, for a file whose beginning is damaged or cut off. Never where a reader needs
    /// the file's own header.
    pub within: fn(&[u8]) -> bool,
    /// Reads a file into a sink.
    pub read: fn(&Path, &mut dyn Sink) -> Result<Summary, FormatError>,
}

/// All of them; the first that claims a file's first bytes reads it.
pub const RECORDERS: [Recorder; 7] = [
    Recorder {
        name: "kongsberg-all",
        begins: kongsberg_all::begins,
        within: kongsberg_all::within,
        read: kongsberg_all::read,
    },
    Recorder {
        name: "kmall",
        begins: kmall::begins,
        within: kmall::within,
        read: kmall::read,
    },
    Recorder {
        name: "s7k",
        begins: s7k::begins,
        within: s7k::within,
        read: s7k::read,
    },
    Recorder {
        name: "xtf",
        begins: xtf::begins,
        within: |_| false,
        read: xtf::read,
    },
    Recorder {
        name: "gsf",
        begins: gsf::begins,
        within: |_| false,
        read: gsf::read,
    },
    Recorder {
        name: "novatel",
        begins: novatel::begins,
        within: novatel::within,
        read: novatel::read,
    },
    Recorder {
        name: "pos-mv",
        begins: pos_mv::begins,
        within: pos_mv::within,
        read: pos_mv::read,
    },
];

/// The format of a file's first bytes.
#[must_use]
pub fn recorder_of(head: &[u8]) -> Option<&'static Recorder> {
    RECORDERS.iter().find(|r| (r.begins)(head))
}

/// The first bytes of a file, as many as records are looked for in.
fn head_of(path: &Path) -> Result<Vec<u8>, FormatError> {
    let mut head = vec![];
    let beginning = open(path)?.0.take(SEARCHED as u64).read_to_end(&mut head);
    beginning.map_err(|e| FormatError::unreadable(path, &e))?;
    Ok(head)
}

/// Those of them that tell a format.
fn beginning(bytes: &[u8]) -> &[u8] {
    &bytes[..bytes.len().min(HEAD)]
}

/// Whether a file is a recorder's by its first bytes; one that cannot be read is none, and whoever reads it says why.
#[must_use]
pub fn is_recorder(path: &Path) -> bool {
    head_of(path).is_ok_and(|bytes| {
        recorder_of(beginning(&bytes)).is_some() || recorder_within(&bytes).is_some()
    })
}

/// Whether a file is called as an SBET is.
#[must_use]
pub fn is_named_sbet(path: &Path) -> bool {
    let extension = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    extension.is_some_and(|e| e == "sbet" || e == "out")
}

/// The format of the records behind a beginning that is damaged or cut off.
fn recorder_within(bytes: &[u8]) -> Option<&'static Recorder> {
    RECORDERS.iter().find(|r| (r.within)(bytes))
}

/// Reads any recorder's file, its format told by its first bytes or, where they are damaged or cut off, by the first records behind
/// them; an SBET, which says nothing of itself, by its extension, unless it is another's file under that name.
///
/// # Errors
/// [`FormatError`] when it cannot be read or no reader knows it.
pub fn read(path: &Path, sink: &mut dyn Sink) -> Result<Summary, FormatError> {
    let sbet = is_named_sbet(path);
    let bytes = head_of(path)?;
    let head = beginning(&bytes);
    // the first bytes of an SBET are any number's: only whole records tell another's file from it
    let by_beginning = recorder_of(head).filter(|_| !sbet);
    match by_beginning.or_else(|| recorder_within(&bytes)) {
        Some(recorder) => (recorder.read)(path, sink),
        None if sbet => read_sbet(path, sink),
        None => Err(FormatError::new(
            FaultKind::UnknownFormat,
            path,
            Place::File,
            kind_of(head),
            "Kongsberg .all or .kmall, Teledyne .s7k, XTF, GSF, a NovAtel log, POS MV groups, or an SBET named .sbet or .out",
        )),
    }
}

fn read_sbet(path: &Path, sink: &mut dyn Sink) -> Result<Summary, FormatError> {
    let records = sbet::read(path, Invalid::Error)?;
    for (k, time_s) in records.time_s.iter().enumerate() {
        sink.attitude(&Attitude {
            time_s: *time_s,
            roll_rad: records.roll_rad[k],
            pitch_rad: records.pitch_rad[k],
            heading_rad: Some(records.heading_rad[k]),
            ..Attitude::default()
        });
        sink.position(&Position {
            time_s: *time_s,
            latitude_rad: records.latitude_rad[k],
            longitude_rad: records.longitude_rad[k],
            height_m: Some(records.height_m[k]),
            ..Position::default()
        });
    }
    let mut summary = Summary {
        time: TimeScale::SecondsOfWeek,
        device: "SBET".to_owned(),
        refusal: Some("navigation only: no soundings".to_owned()),
        ..Summary::of("sbet")
    };
    let count = records.time_s.len() as u64;
    summary.records.insert("records".to_owned(), count);
    Ok(summary)
}
