//! Kongsberg `.all`: soundings (N), attitude (A), position (P), water level (h), sound speed (U), installation (I), own solution (X).
//!
//! Little-endian and, from old systems, big-endian. Angles in the file: receive angle positive to **port**, tilt positive forward;
//! roll port up, pitch bow up: roll and pitch are ours, the receive angle is turned round on reading.
//!
//! ```text
//! u32 length of the rest | 02 | u8 kind | u16 model | u32 yyyymmdd | u32 ms of day | u16 counter | u16 serial | body | 03 | u16 sum
//! ```
//!
//! Attitude in `A` is already turned by the motion sensor's mounting (MSR, MSP, MSG): it is never turned again. Water column and
//! everything else not named above is passed over by its length. Files of sounders that record only corrected depths (D) or the raw
//! ranges of before 2009 (f, F) are refused with the model's name.

mod convert;
mod installation;
pub mod raw;
pub mod write;

pub use convert::model_name;

use std::io::Read;
use std::path::Path;

use self::raw::{ETX, HEADER, LONGEST, STX, TRAILER};
use super::error::{FormatError, open};
use super::recorder::{Bytes, Frame, Framing, Sink, Summary, Window, holds, scan};

/// Kinds of datagrams that stand in such files.
const KINDS: &[u8] = b"01234ACDEFGHIJKLNOPQRSTUVWXYZefhijklmnpruv";

/// How datagrams are framed.
struct Datagrams;

impl Framing for Datagrams {
    const HEAD: usize = HEADER;
    const END_MARK: bool = true;

    fn length(&self, head: &[u8]) -> Option<usize> {
        length_in(head, false).or_else(|| length_in(head, true))
    }

    fn check(&self, record: &[u8]) -> Frame {
        let end = record.len() - TRAILER;
        let Some(written) = ordered(record).u16(end + 1) else {
            return Frame::Nothing;
        };
        match written {
            _ if record[end] != ETX => Frame::Nothing,
            sum if sum == checksum(&record[5..end]) => Frame::Good,
            0 => Frame::ZeroChecksum,
            _ => Frame::BadChecksum,
        }
    }
}

/// Bytes of the datagram that begins here, if its numbers make sense in that order.
fn length_in(head: &[u8], big_endian: bool) -> Option<usize> {
    let b = Bytes {
        data: head,
        big_endian,
    };
    if b.u8(4)? != STX || !KINDS.contains(&b.u8(5)?) || !(100..=3100).contains(&b.u16(6)?) {
        return None;
    }
    let length = (b.u32(0)? as usize).checked_add(4)?;
    (HEADER + TRAILER..=LONGEST)
        .contains(&length)
        .then_some(length)
}

/// A whole datagram in its order of bytes.
fn ordered(record: &[u8]) -> Bytes<'_> {
    Bytes {
        data: record,
        big_endian: length_in(record, false) != Some(record.len()),
    }
}

/// Sum of the bytes, modulo 65536.
fn checksum(bytes: &[u8]) -> u16 {
    let sum = |chunk: &[u8]| chunk.iter().map(|b| u32::from(*b)).sum::<u32>();
    bytes.chunks(1 << 16).map(sum).fold(0u32, u32::wrapping_add) as u16
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
    let mut losses = super::recorder::Losses::default();
    scan(
        &mut Window::new(file, source),
        &Datagrams,
        &mut losses,
        |record, losses| {
            reader.take(&ordered(record), losses);
            Ok(())
        },
    )?;
    Ok(reader.finished(losses))
}

#[cfg(test)]
mod tests;
