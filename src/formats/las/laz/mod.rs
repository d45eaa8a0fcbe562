//! Coordinates and times of LAZ, decoded without recursion, with bounds on everything that a file says of itself.
//!
//! A decoder of our own, for the two columns that are needed (`docs/decisions`). The layout is that of the
//! "`LASzip` specification 1.4"; the `laz` crate, by which the program writes, is what the tests compare with.
//!
//! | module | what |
//! |---|---|
//! | [`coder`], [`integer`] | arithmetic decoder, adaptive models, integers as corrections of predictions |
//! | [`time`], [`returns`] | GPS times; contexts and medians |
//! | [`pointwise`], [`layered`] | the points of a chunk: formats 0 to 5, formats 6 to 10 |

pub mod coder;
pub mod integer;
pub mod layered;
pub mod pointwise;
pub mod returns;
pub mod time;

use std::io::{self, Read, Seek, SeekFrom};

use coder::{Bytes, Decoder};
use integer::Integer;
use layered::Layer;

/// Why compressed bytes cannot be decoded.
#[derive(Debug)]
pub enum Fault {
    /// The bytes end before the points do.
    End,
    /// No encoder makes these bytes.
    Damaged,
    /// The file cannot be read.
    Io(io::Error),
}

/// A point as it stands in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RawPoint {
    /// Integers to be scaled.
    pub xyz: [i32; 3],
    /// Bits of the GPS time.
    pub time: i64,
}

impl RawPoint {
    /// From the bytes of a point that is not compressed; `time_at` is where its time stands.
    #[must_use]
    pub fn of(raw: &[u8], time_at: Option<usize>) -> Self {
        let at = |k: usize| raw.get(k).copied().unwrap_or(0);
        let word = |k: usize| i32::from_le_bytes([at(k), at(k + 1), at(k + 2), at(k + 3)]);
        let time = time_at.map_or(0, |k| {
            i64::from(word(k + 4)) << 32 | i64::from(word(k) as u32)
        });
        Self {
            xyz: [word(0), word(4), word(8)],
            time,
        }
    }
}

/// Kind of a compressed item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Coordinates and fields of formats 0 to 5.
    Point10,
    /// GPS time of formats 1, 3, 4, 5.
    Time11,
    /// Colours of formats 2, 3, 5.
    Colour12,
    /// Wave packets of formats 4 and 5.
    Wave13,
    /// Extra bytes of formats 0 to 5.
    Extra,
    /// Coordinates, fields and time of formats 6 to 10.
    Point14,
    /// What else formats 6 to 10 have, with its number of layers.
    Layers14(u16),
}

/// One compressed item of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// What it is.
    pub kind: Kind,
    /// Bytes when not compressed.
    pub bytes: u16,
    /// Version of its compression.
    pub version: u16,
}

impl Item {
    /// From the numbers in the file; nothing for one that no specification names.
    #[must_use]
    pub fn of(number: u16, bytes: u16, version: u16) -> Option<Self> {
        let (kind, size, versions) = match number {
            0 => (Kind::Extra, bytes, 1..=2),
            6 => (Kind::Point10, 20, 1..=2),
            7 => (Kind::Time11, 8, 1..=2),
            8 => (Kind::Colour12, 6, 1..=2),
            9 => (Kind::Wave13, 29, 1..=2),
            10 => (Kind::Point14, 30, 3..=4),
            11 => (Kind::Layers14(1), 6, 3..=4),
            12 => (Kind::Layers14(2), 8, 3..=4),
            13 => (Kind::Layers14(1), 29, 3..=4),
            14 => (Kind::Layers14(bytes), bytes, 3..=4),
            _ => return None,
        };
        let known = bytes == size && bytes > 0 && versions.contains(&version);
        known.then_some(Self {
            kind,
            bytes,
            version,
        })
    }

    /// Layers of formats 6 to 10.
    fn layers(&self) -> u64 {
        match self.kind {
            Kind::Point14 => 9,
            Kind::Layers14(n) => n.into(),
            _ => 0,
        }
    }
}

/// How the points of a file are cut into chunks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Chunks {
    /// All points in one.
    One,
    /// So many points each.
    Of(u32),
    /// As the chunk table says, at this byte of the file.
    Table(u64),
}

/// A reader of compressed points: from the point data's first byte to the end of the file.
pub struct Points<R> {
    source: Source<R>,
    items: Vec<Item>,
    chunks: Chunks,
    /// Points of each chunk, where the table says it; the next one is the last.
    table: Vec<u64>,
    left_in_chunk: u64,
    state: State,
    /// Where the next chunk of layers begins.
    next_chunk: u64,
}

enum State {
    Between,
    Pointwise(pointwise::Chunk),
    Layered(layered::Chunk),
}

impl<R: Read + Seek> Points<R> {
    /// Begins at `byte`, where the point data begin in a file of `size` bytes.
    ///
    /// # Errors
    /// [`Fault`] of the chunk table, where one is needed.
    pub fn begin(
        reader: R,
        (byte, size): (u64, u64),
        items: Vec<Item>,
        chunks: Chunks,
    ) -> Result<Self, Fault> {
        let mut source = Source::new(reader, size);
        let mut table = Vec::new();
        if let Chunks::Table(at) = chunks {
            source.seek(at)?;
            table = sizes(&mut source)?;
            table.reverse();
        }
        // the offset of the chunk table stands before the first chunk
        let first = byte + if chunks == Chunks::One { 0 } else { 8 };
        source.seek(first)?;
        Ok(Self {
            source,
            items,
            chunks,
            table,
            left_in_chunk: 0,
            state: State::Between,
            next_chunk: first,
        })
    }

    /// The next point.
    ///
    /// # Errors
    /// [`Fault`]; also for one behind the last.
    pub fn point(&mut self) -> Result<RawPoint, Fault> {
        if self.left_in_chunk == 0 {
            return self.begin_chunk();
        }
        self.left_in_chunk -= 1;
        match &mut self.state {
            State::Pointwise(chunk) => chunk.next(&mut self.source),
            State::Layered(chunk) => chunk.point(),
            State::Between => Err(Fault::End),
        }
    }

    fn begin_chunk(&mut self) -> Result<RawPoint, Fault> {
        let points = match self.chunks {
            Chunks::One => u64::MAX,
            Chunks::Of(points) => points.into(),
            Chunks::Table(_) => self.table.pop().ok_or(Fault::End)?,
        };
        self.left_in_chunk = points.checked_sub(1).ok_or(Fault::Damaged)?;
        let layered = self.items.first().map(|i| i.kind) == Some(Kind::Point14);
        let point = if layered {
            self.begin_layers()?
        } else {
            let (chunk, point) = pointwise::Chunk::begin(&self.items, &mut self.source)?;
            self.state = State::Pointwise(chunk);
            point
        };
        Ok(point)
    }

    /// The first point, the number of points, the sizes of all layers, then the layers.
    fn begin_layers(&mut self) -> Result<RawPoint, Fault> {
        let raw_bytes: u64 = self.items.iter().map(|i| u64::from(i.bytes)).sum();
        let count: u64 = self.items.iter().map(Item::layers).sum();
        self.source.seek(self.next_chunk)?;
        let raw = self.source.piece(raw_bytes + 4)?;
        let sizes = self.source.piece(4 * count)?;
        let size = |k: usize| {
            sizes[4 * k..4 * k + 4]
                .iter()
                .rev()
                .fold(0, |all, b| all << 8 | u64::from(*b))
        };
        let mut at = self.next_chunk + raw_bytes + 4 + 4 * count;
        let mut layers: [Layer; 3] = Default::default();
        for k in 0..count as usize {
            // coordinates, heights and times among the nine of a point
            if let Some(place) = [0, 1, 8].iter().position(|wanted| *wanted == k) {
                self.source.seek(at)?;
                layers[place] = Layer::new(self.source.piece(size(k))?);
            }
            at += size(k);
        }
        self.next_chunk = at;
        let (chunk, point) = layered::Chunk::begin(&raw, layers)?;
        self.state = State::Layered(chunk);
        Ok(point)
    }
}

/// Points of every chunk, from the table of chunks of their own sizes.
fn sizes<R: Read + Seek>(source: &mut Source<R>) -> Result<Vec<u64>, Fault> {
    let head = source.piece(8)?;
    let count = u32::from_le_bytes([head[4], head[5], head[6], head[7]]);
    let mut decoder = Decoder::begin(source)?;
    let mut numbers = Integer::new(32, 2);
    let (mut points, mut bytes) = (0, 0);
    let mut found = Vec::new();
    for _ in 0..count {
        points = numbers.next(points, 0, &mut decoder, source)?;
        bytes = numbers.next(bytes, 1, &mut decoder, source)?;
        found.push(u64::from(points as u32));
    }
    Ok(found)
}

/// A buffered file that knows its size.
struct Source<R> {
    reader: R,
    size: u64,
    buffer: Vec<u8>,
    at: usize,
}

impl<R: Read + Seek> Source<R> {
    fn new(reader: R, size: u64) -> Self {
        Self {
            reader,
            size,
            buffer: Vec::new(),
            at: 0,
        }
    }

    fn seek(&mut self, byte: u64) -> Result<(), Fault> {
        self.buffer.clear();
        self.at = 0;
        self.reader.seek(SeekFrom::Start(byte)).map_err(Fault::Io)?;
        Ok(())
    }

    /// The next bytes; room is made for no more than the file has.
    fn piece(&mut self, bytes: u64) -> Result<Vec<u8>, Fault> {
        if bytes > self.size {
            return Err(Fault::End);
        }
        let mut piece = Vec::with_capacity(bytes as usize);
        while piece.len() < bytes as usize {
            piece.push(self.byte()?);
            let rest = (bytes as usize - piece.len()).min(self.buffer.len() - self.at);
            piece.extend_from_slice(&self.buffer[self.at..self.at + rest]);
            self.at += rest;
        }
        Ok(piece)
    }
}

impl<R: Read + Seek> Bytes for Source<R> {
    #[inline]
    fn byte(&mut self) -> Result<u8, Fault> {
        if self.at == self.buffer.len() {
            self.buffer.resize(1 << 16, 0);
            let read = loop {
                match self.reader.read(&mut self.buffer) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    read => break read.map_err(Fault::Io)?,
                }
            };
            self.buffer.truncate(read);
            self.at = 0;
            if read == 0 {
                return Err(Fault::End);
            }
        }
        self.at += 1;
        Ok(self.buffer[self.at - 1])
    }
}
