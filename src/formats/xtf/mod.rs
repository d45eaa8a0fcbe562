//! XTF with soundings of R2Sonic echo sounders (packet 65), attitude (3) and position (107).
//!
//! ```text
//! file header 1024 bytes | u16 FACE | u8 type | u8 | u16 channels | u32 | u32 size | ...          (little-endian)
//! packet 65: 256-byte ping header | BTH0 | u32 size | u32 id | sections: 2 letters, u16 size, ...   (big-endian)
//! ```
//!
//! Beam angles are in the frame of the head, positive to starboard, with the roll steering in them: roll is applied to them like
//! anything else's (shown on a real file: gain 1.000 against the attitude packets). The time is the head section's, in nanoseconds of
//! UTC. Every other kind of bathymetry in XTF is refused: its packets hold processed depths or a vendor's own layout.

mod convert;
pub mod raw;

use std::io::Read;
use std::path::Path;

use self::raw::{HEADER, LONGEST, PACKET, Packet};
use super::error::{FaultKind, FormatError, Place, open, quoted};
use super::recorder::{Bytes, Frame, Framing, Losses, Sink, Summary, Window, scan};

/// How packets are framed.
struct Packets;

impl Framing for Packets {
    const HEAD: usize = PACKET;
    const END_MARK: bool = false;

    fn length(&self, head: &[u8]) -> Option<usize> {
        let size = Packet::read(&Bytes::little(head))?.size as usize;
        (PACKET..=LONGEST).contains(&size).then_some(size)
    }

    fn check(&self, _: &[u8]) -> Frame {
        Frame::Good
    }
}

/// Whether a file's first bytes are such a header.
#[must_use]
pub fn begins(head: &[u8]) -> bool {
    head.first() == Some(&123) && matches!(head.get(1), Some(0 | 1 | 0xca))
}

/// Reads a file, handing every record to `sink`.
///
/// # Errors
/// [`FormatError`] when it cannot be read or has no header. Damage is counted in the summary.
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
    let mut window = Window::new(file, source);
    let mut reader = convert::Reader::new(sink);
    let head = window.fill(HEADER)?;
    if head.len() < HEADER || head[0] != 123 {
        let found = quoted(&head[..head.len().min(8)]);
        let expected = "an XTF header of 1024 bytes";
        let place = Place::Header;
        return Err(FormatError::new(
            FaultKind::UnknownFormat,
            file,
            place,
            found,
            expected,
        ));
    }
    let blocks = convert::header_blocks(&Bytes::little(head));
    let header = window.fill(blocks * HEADER)?;
    reader.header(&Bytes::little(&header[..header.len().min(blocks * HEADER)]));
    window.advance(blocks * HEADER);
    let mut losses = Losses::default();
    scan(&mut window, &Packets, &mut losses, |packet, losses| {
        reader.take(&Bytes::little(packet), losses);
        Ok(())
    })?;
    Ok(reader.finished(losses))
}

#[cfg(test)]
mod tests;
