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

/// A format of recorders.
pub struct Recorder {
    /// Its name.
    pub name: &'static str,
    /// Whether a file with these first bytes is of it.
    pub begins: fn(&[u8]) -> bool,
    /// Reads a file into a sink.
    pub read: fn(&Path, &mut dyn Sink) -> Result<Summary, FormatError>,
}

/// All of them; the first that claims a file's first bytes reads it.
pub const RECORDERS: [Recorder; 7] = [
    Recorder {
        name: "kongsberg-all",
        begins: kongsberg_all::begins,
        read: kongsberg_all::read,
    },
    Recorder {
        name: "kmall",
        begins: kmall::begins,
        read: kmall::read,
    },
    Recorder {
        name: "s7k",
        begins: s7k::begins,
        read: s7k::read,
    },
    Recorder {
        name: "xtf",
        begins: xtf::begins,
        read: xtf::read,
    },
    Recorder {
        name: "gsf",
        begins: gsf::begins,
        read: gsf::read,
    },
    Recorder {
        name: "novatel",
        begins: novatel::begins,
        read: novatel::read,
    },
    Recorder {
        name: "pos-mv",
        begins: pos_mv::begins,
        read: pos_mv::read,
    },
];

/// The format of a file's first bytes.
#[must_use]
pub fn recorder_of(head: &[u8]) -> Option<&'static Recorder> {
    RECORDERS.iter().find(|r| (r.begins)(head))
}

/// The first bytes of a file.
fn head_of(path: &Path) -> Result<Vec<u8>, FormatError> {
    let mut head = vec![];
    let beginning = open(path)?.0.take(HEAD as u64).read_to_end(&mut head);
    beginning.map_err(|e| FormatError::unreadable(path, &e))?;
    Ok(head)
}

/// Whether a file is a recorder's by its first bytes; one that cannot be read is none, and whoever reads it says why.
#[must_use]
pub fn is_recorder(path: &Path) -> bool {
    head_of(path).is_ok_and(|head| recorder_of(&head).is_some())
}

/// Reads any recorder's file, its format told by its first bytes; an SBET, which has none, by its extension.
///
/// # Errors
/// [`FormatError`] when it cannot be read or no reader knows it.
pub fn read(path: &Path, sink: &mut dyn Sink) -> Result<Summary, FormatError> {
    let extension = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    if extension.is_some_and(|e| e == "sbet" || e == "out") {
        return read_sbet(path, sink);
    }
    let head = head_of(path)?;
    match recorder_of(&head) {
        Some(recorder) => (recorder.read)(path, sink),
        None => Err(FormatError::new(
            FaultKind::UnknownFormat,
            path,
            Place::File,
            kind_of(&head),
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
