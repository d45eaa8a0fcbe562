//! Kongsberg `.kmall`: soundings and own solution (MRZ), motion (SKM), position (SPO), sound speed (SVP), installation (IIP).
//!
//! ```text
//! u32 size | #ABC | u8 version | u8 system | u16 sounder | u32 s | u32 ns | ... | u32 size again
//! ```
//!
//! There is no checksum: the size at the end is all that tells damage. Datagrams that were split are joined. Layouts are taken by the
//! byte counts in the file, so that versions 0 to 2 of MRZ are read alike. Angles in the file: receive angle positive to **port**,
//! tilt positive forward. The beams' angle and time corrections are already in them. Motion (SKM) is raw: the sensor's mounting is
//! *not* in it, unlike in `.all`.

mod convert;
mod installation;
pub mod raw;
pub mod write;

use std::io::Read;
use std::path::Path;

use self::raw::{HEADER, LONGEST};
use super::error::{FormatError, open};
use super::recorder::{Bytes, Frame, Framing, Losses, Sink, Summary, Window, holds, scan};

/// How datagrams are framed.
struct Datagrams;

impl Framing for Datagrams {
    const HEAD: usize = HEADER;
    const END_MARK: bool = true;

    fn length(&self, head: &[u8]) -> Option<usize> {
        let kind = head.get(4..8)?;
        let named = kind[0] == b'#' && kind[1..].iter().all(u8::is_ascii_uppercase);
        let size = Bytes::little(head).u32(0)? as usize;
        (named && (HEADER + 4..=LONGEST).contains(&size)).then_some(size)
    }

    fn check(&self, record: &[u8]) -> Frame {
        let b = Bytes::little(record);
        if b.u32(record.len() - 4) == b.u32(0) {
            Frame::Good
        } else {
            Frame::Nothing
        }
    }
}

/// Whether a file's first bytes are such a datagram.
#[must_use]
pub fn begins(head: &[u8]) -> bool {
    Datagrams.length(head).is_some()
}

/// Whether two such datagrams stand one behind the other anywhere in these bytes.
#[must_use]
pub fn within(bytes: &[u8]) -> bool {
    holds(&Datagrams, bytes)
}

/// Reads a file, handing every record to `sink`.
///
/// # Errors
/// [`FormatError`] when it cannot be read. Damage is counted in the summary.
pub fn read(path: &Path, sink: &mut dyn Sink) -> Result<Summary, FormatError> {
    read_from(path, open(path)?.0, sink)
}

/// Reads from `source`; `file` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(
    file: &Path,
    source: impl Read,
    sink: &mut dyn Sink,
) -> Result<Summary, FormatError> {
    let mut reader = convert::Reader::new(sink);
    let mut losses = Losses::default();
    scan(
        &mut Window::new(file, source),
        &Datagrams,
        &mut losses,
        |record, losses| {
            reader.take(&Bytes::little(record), losses);
            Ok(())
        },
    )?;
    Ok(reader.finished(losses))
}

#[cfg(test)]
mod tests;
