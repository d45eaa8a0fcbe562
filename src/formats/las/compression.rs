//! The `LASzip` record of a file: how its points are compressed, checked before anything is decoded.

use super::laz::{Chunks, Item, Kind};
use super::raw::Header;

/// Chunk size that stands for chunks of their own sizes.
const VARIABLE: u32 = u32::MAX;

/// What the `LASzip` record says of the compressed points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compression {
    /// 1 point by point, 2 in chunks, 3 in chunks of layers.
    pub compressor: u16,
    /// Points of a chunk.
    pub chunk_points: u32,
    /// Number, bytes and version of each item of a point.
    pub items: Vec<[u16; 3]>,
}

impl Compression {
    /// Whether the points come in chunks, with a table behind them.
    #[must_use]
    pub fn chunked(&self) -> bool {
        self.compressor >= 2
    }

    /// From the data of a `LASzip` record; missing bytes count as 0.
    #[must_use]
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
                .map(|k| [u16(34 + 6 * k), u16(36 + 6 * k), u16(38 + 6 * k)])
                .collect(),
        }
    }

    /// How the points are cut, with the place of the chunk table.
    #[must_use]
    pub fn chunks(&self, table: Option<u64>) -> Chunks {
        match (table, self.chunk_points) {
            (Some(at), VARIABLE) => Chunks::Table(at),
            (Some(_), points) => Chunks::Of(points),
            (None, _) => Chunks::One,
        }
    }

    /// The items, or what is wrong with them: found and expected.
    ///
    /// # Errors
    /// Unknown items, items of another point format, sizes that contradict the header, a compressor that they do not go with.
    pub fn checked(&self, header: &Header) -> Result<Vec<Item>, (String, &'static str)> {
        let mut items = Vec::new();
        for [number, bytes, version] in &self.items {
            let item = Item::of(*number, *bytes, *version);
            items.push(item.ok_or_else(|| {
                let found = format!("compressed item {number} of {bytes} bytes, version {version}");
                (found, "an item of the LASzip specification")
            })?);
        }
        let kinds: Vec<Kind> = items.iter().map(|i| i.kind).collect();
        if !goes_with(&kinds, header) {
            let found = format!(
                "compressed items {kinds:?} in point format {}",
                header.format
            );
            return Err((found, "the items of that point format, each once"));
        }
        let bytes: u64 = items.iter().map(|i| u64::from(i.bytes)).sum();
        if bytes != u64::from(header.point_bytes) {
            let found = format!("compressed points of {bytes} bytes");
            return Err((found, "as many bytes as the header says"));
        }
        let layered = kinds.first() == Some(&Kind::Point14);
        if layered != (self.compressor == 3) || !(1..=3).contains(&self.compressor) {
            let found = format!("compressor {} with items {kinds:?}", self.compressor);
            return Err((found, "3 for point formats 6 to 10, else 1 or 2"));
        }
        if self.chunked() && self.chunk_points == 0 {
            return Err(("chunks of 0 points".to_owned(), "one point or more"));
        }
        Ok(items)
    }
}

/// Whether the items begin as the point format does, and have a time where it has one.
fn goes_with(kinds: &[Kind], header: &Header) -> bool {
    if header.format >= 6 {
        let rest = kinds.iter().skip(1);
        return kinds.first() == Some(&Kind::Point14)
            && rest.into_iter().all(|k| matches!(k, Kind::Layers14(_)));
    }
    let old = |k: &Kind| !matches!(k, Kind::Point10 | Kind::Point14 | Kind::Layers14(_));
    let times = kinds.iter().filter(|k| **k == Kind::Time11).count();
    kinds.first() == Some(&Kind::Point10)
        && kinds.iter().skip(1).all(old)
        && times == usize::from(header.has_gps_time())
}
