//! Teledyne `.s7k`: soundings (7000 with 7027), installation (7030), position (1003, 1015), attitude (1012, 1013, 1016), sound speed
//! (1009, 1010). Written from the specification and tried on no real file.
//!
//! ```text
//! u16 protocol | u16 offset | u32 0000FFFF | u32 size | .. | time at 20 | u32 kind at 32 | u32 device | .. | data at 64 | u32 sum
//! ```
//!
//! Axes are ours (starboard, forward, up), angles radians, roll positive port up. The receive angle of 7027 is in the sonar's frame with
//! the roll steering in it: roll is applied to it. The angles of 7004 are levelled under roll stabilisation; files that have only
//! them (with 7006) are refused for calibration.

mod convert;
pub mod raw;

use std::io::Read;
use std::path::Path;

use self::raw::{FRAME, LONGEST, SYNC};
use super::error::{FormatError, open};
use super::recorder::{Bytes, Frame, Framing, Losses, Sink, Summary, Window, holds, scan};

/// How records are framed.
struct Records;

impl Framing for Records {
    const HEAD: usize = FRAME;
    const END_MARK: bool = false;

    fn length(&self, head: &[u8]) -> Option<usize> {
        let b = Bytes::little(head);
        let size = b.u32(8)? as usize;
        let framed = b.u32(4)? == SYNC && b.u16(0)? < 100;
        (framed && (FRAME + 4..=LONGEST).contains(&size)).then_some(size)
    }

    fn check(&self, record: &[u8]) -> Frame {
        let end = record.len() - 4;
        let b = Bytes::little(record);
        let written = b.u32(end).unwrap_or(0);
        let said = b.u16(48).is_some_and(|flags| flags & 1 == 1);
        match written {
            _ if !said => Frame::Good,
            sum if sum == checksum(&record[..end]) => Frame::Good,
            0 => Frame::ZeroChecksum,
            _ => Frame::BadChecksum,
        }
    }
}

/// Sum of the bytes, modulo 2 to the 32nd.
fn checksum(bytes: &[u8]) -> u32 {
    let sum = |chunk: &[u8]| chunk.iter().map(|b| u32::from(*b)).sum::<u32>();
    bytes.chunks(1 << 16).map(sum).fold(0, u32::wrapping_add)
}

/// Whether a file's first bytes are such a record.
#[must_use]
pub fn begins(head: &[u8]) -> bool {
    Records.length(head).is_some()
}

/// Whether two such records stand one behind the other anywhere in these bytes.
#[must_use]
pub fn within(bytes: &[u8]) -> bool {
    holds(&Records, bytes)
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
    let mut window = Window::new(file, source);
    scan(&mut window, &Records, &mut losses, |record, losses| {
        reader.take(&Bytes::little(record), losses);
        Ok(())
    })?;
    Ok(reader.finished(losses))
}

#[cfg(test)]
mod tests;
