//! The layers of LAZ chunks of point formats 6 to 10, walked before they are decoded.
//!
//! A chunk is its first point as it stands, the number of its points, the size of every layer, then the layers. The decoder makes
//! room for a layer as large as its size says, up to 4 GiB, before it reads it: a damaged size must be found before.

use std::io::{Read, Seek};

use super::raw::{Check, Header};
use crate::formats::error::{FaultKind, FormatError, Place};

/// Chunk size that stands for chunks of their own sizes.
const VARIABLE: u32 = u32::MAX;

/// What the `LASzip` record says of the compressed points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compression {
    /// 1 point by point, 2 in chunks, 3 in chunks of layers.
    pub compressor: u16,
    /// Points of a chunk.
    pub chunk_points: u32,
    /// Kind and bytes of each item of a point.
    pub items: Vec<(u16, u16)>,
}

impl Compression {
    /// Whether the points come in chunks, with a table behind them.
    pub fn chunked(&self) -> bool {
        self.compressor >= 2
    }

    /// From the data of a `LASzip` record; missing bytes count as 0.
    pub fn parse(data: &[u8]) -> Self {
        let u16 = |at: usize| {
            data.get(at..at + 2)
                .map_or(0, |b| u16::from_le_bytes([b[0], b[1]]))
        };
        let count = usize::from(u16(32));
        Self {
            compressor: u16(0),
            chunk_points: u32::from(u16(12)) | u32::from(u16(14)) << 16,
            items: (0..count)
                .map(|k| (u16(34 + 6 * k), u16(36 + 6 * k)))
                .collect(),
        }
    }

    /// Bytes of a point.
    fn point_bytes(&self) -> u64 {
        self.items.iter().map(|(_, bytes)| u64::from(*bytes)).sum()
    }

    /// Layers of a chunk: point, colour, near infrared, wave packet, extra bytes.
    fn layers(&self) -> u64 {
        let of_item = |(kind, bytes): &(u16, u16)| match kind {
            10 => 9,
            12 => 2,
            14 => u64::from(*bytes),
            _ => 1,
        };
        self.items.iter().map(of_item).sum()
    }

    /// Chunks that hold `points`; `table` are those of the chunk table.
    fn chunks(&self, points: u64, table: u64) -> u64 {
        match self.chunk_points {
            VARIABLE => table,
            size => points.div_ceil(u64::from(size.max(1))),
        }
    }
}

impl<R: Read + Seek> Check<'_, R> {
    /// Follows the chunks from layer sizes to layer sizes; all must lie before the chunk table.
    pub(super) fn layers(
        &mut self,
        header: &Header,
        compression: &Compression,
        (table, chunks): (u64, u64),
    ) -> Result<(), FormatError> {
        if compression.compressor != 3 {
            return Ok(());
        }
        if compression.chunk_points == 0
            || compression.point_bytes() != u64::from(header.point_bytes)
        {
            let found = format!(
                "compressed points of {} bytes in chunks of {}",
                compression.point_bytes(),
                compression.chunk_points
            );
            let expected = format!(
                "{} bytes as the header says, one point or more",
                header.point_bytes
            );
            return Err(self.fault(FaultKind::BadValue, Place::Header, found, expected));
        }
        let mut at = u64::from(header.offset_to_points) + 8;
        for _ in 0..compression.chunks(header.points, chunks) {
            at = self.chunk_end(at, compression)?;
            if at > table {
                let found = format!("a chunk up to byte {at}, the chunk table at byte {table}");
                return Err(self.fault(
                    FaultKind::Truncated,
                    Place::Byte(at),
                    found,
                    "chunks that end before their table",
                ));
            }
        }
        Ok(())
    }

    /// Where the chunk that begins at `at` ends.
    fn chunk_end(&mut self, at: u64, compression: &Compression) -> Result<u64, FormatError> {
        let sizes_at = at + compression.point_bytes() + 4;
        let bytes = 4 * compression.layers();
        let sizes = self.piece(sizes_at, bytes, "the layer sizes of a chunk")?;
        let size = |b: &[u8]| {
            b.iter()
                .rev()
                .fold(0, |all, byte| all << 8 | u64::from(*byte))
        };
        Ok(sizes_at + bytes + sizes.chunks_exact(4).map(size).sum::<u64>())
    }
}
