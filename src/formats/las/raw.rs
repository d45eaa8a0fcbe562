//! Mirror of the LAS public header block (ASPRS LAS 1.4 R15, table 3), checked against the size of the file.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::compression::Compression;
use super::laz::{Chunks, Item};
use crate::formats::error::{FaultKind, FormatError, Place};

/// Bytes of the header up to LAS 1.2, the shortest there is.
const SHORTEST_HEADER: usize = 227;
/// Bytes of the LAS 1.4 header.
const LONGEST_HEADER: usize = 375;
/// Bytes before the data of a variable length record, and of an extended one.
const RECORD_HEADER: (u64, u64) = (54, 60);
/// User and number of the record that describes the compression.
const LASZIP: (&[u8], u16) = (b"laszip encoded", 22204);

/// What the header block says, as far as a reader of coordinates and times needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Version, the minor number of 1.x.
    pub version_minor: u8,
    /// Bytes of the header block.
    pub header_size: u16,
    /// Where the points begin, bytes.
    pub offset_to_points: u32,
    /// Number of variable length records.
    pub records: u32,
    /// Point format, without the bits of compression.
    pub format: u8,
    /// Whether the points are LAZ compressed.
    pub compressed: bool,
    /// Bytes of an uncompressed point.
    pub point_bytes: u16,
    /// Number of points.
    pub points: u64,
    /// Scale of x, y, z.
    pub scale: [f64; 3],
    /// Offset of x, y, z.
    pub offset: [f64; 3],
    /// Where the first extended record begins, and how many there are.
    pub extended_records: (u64, u32),
}

/// Bytes of a point of each format, without extra bytes.
const LENGTHS: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

/// A cursor over the header's bytes.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut bytes = [0; N];
        if let Some(found) = self.0.get(at..at + N) {
            bytes.copy_from_slice(found);
        }
        bytes
    }
    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes(self.bytes(at))
    }
    fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.bytes(at))
    }
    fn u64(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.bytes(at))
    }
    fn f64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.bytes(at))
    }
}

impl Header {
    fn parse(bytes: &[u8]) -> Self {
        let fields = Fields(bytes);
        let [version_minor] = fields.bytes(25);
        let [format] = fields.bytes(104);
        let legacy = u64::from(fields.u32(107));
        let long = version_minor >= 4;
        Self {
            version_minor,
            header_size: fields.u16(94),
            offset_to_points: fields.u32(96),
            records: fields.u32(100),
            format: format & 0x3f,
            compressed: format & 0xc0 != 0,
            point_bytes: fields.u16(105),
            points: match fields.u64(247) {
                // since LAS 1.4 the long field counts; some writers leave a stale short one, others fill only that
                count if long && count > 0 => count,
                _ => legacy,
            },
            scale: [fields.f64(131), fields.f64(139), fields.f64(147)],
            offset: [fields.f64(155), fields.f64(163), fields.f64(171)],
            extended_records: if long {
                (fields.u64(235), fields.u32(243))
            } else {
                (0, 0)
            },
        }
    }

    /// Whether the points of this format carry a GPS time.
    #[must_use]
    pub fn has_gps_time(&self) -> bool {
        self.time_at().is_some()
    }

    /// Where the GPS time stands in a point that is not compressed.
    #[must_use]
    pub fn time_at(&self) -> Option<usize> {
        match self.format {
            0 | 2 => None,
            1 | 3..=5 => Some(20),
            _ => Some(22),
        }
    }
}

/// A file being checked.
struct Check<'a, R> {
    file: &'a Path,
    source: R,
    size: u64,
}

/// How the points lie in the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Points {
    /// One after the other.
    Plain,
    /// Compressed.
    Compressed(Vec<Item>, Chunks),
}

/// Points that a byte of a compressed file can hold, far beyond what any real one does; bounds what a header can claim.
const MOST_POINTS_PER_BYTE: u64 = 64;

/// Reads the header and follows every offset in it.
///
/// # Errors
/// [`FormatError`]: empty, no LAS, no points, truncated, a header that contradicts itself.
pub fn check(
    file: &Path,
    source: &mut (impl Read + Seek),
    size: u64,
) -> Result<(Header, Points), FormatError> {
    let mut check = Check { file, source, size };
    let header = check.header()?;
    check.plausible(&header)?;
    let compression = check.variable_records(&header)?;
    check.extended_record(&header)?;
    if !header.compressed {
        check.points(&header)?;
        return Ok((header, Points::Plain));
    }
    let items = compression.checked(&header).map_err(|(found, expected)| {
        check.fault(FaultKind::BadValue, Place::Header, found, expected)
    })?;
    check.count(&header)?;
    let table = check.chunk_table(&header, compression.chunked())?;
    Ok((header, Points::Compressed(items, compression.chunks(table))))
}

impl<R: Read + Seek> Check<'_, R> {
    fn fault(
        &self,
        kind: FaultKind,
        place: Place,
        found: String,
        expected: impl Into<String>,
    ) -> FormatError {
        FormatError::new(kind, self.file, place, found, expected)
    }

    fn seek(&mut self, byte: u64) -> Result<(), FormatError> {
        self.source
            .seek(SeekFrom::Start(byte))
            .map(|_| ())
            .map_err(|e| FormatError::unreadable(self.file, &e))
    }

    /// `N` bytes at an offset that was checked to lie inside.
    fn bytes<const N: usize>(&mut self, byte: u64, what: &str) -> Result<[u8; N], FormatError> {
        self.inside(byte, N as u64, what)?;
        self.seek(byte)?;
        let mut bytes = [0; N];
        self.source
            .read_exact(&mut bytes)
            .map_err(|e| FormatError::unreadable(self.file, &e))?;
        Ok(bytes)
    }

    /// `length` bytes at an offset.
    fn piece(&mut self, byte: u64, length: u64, what: &str) -> Result<Vec<u8>, FormatError> {
        self.inside(byte, length, what)?;
        self.seek(byte)?;
        let mut bytes = vec![0; length as usize];
        self.source
            .read_exact(&mut bytes)
            .map_err(|e| FormatError::unreadable(self.file, &e))?;
        Ok(bytes)
    }

    /// Refuses a piece that ends after the file does.
    fn inside(&self, byte: u64, length: u64, what: &str) -> Result<(), FormatError> {
        let end = byte.saturating_add(length);
        if end <= self.size {
            return Ok(());
        }
        let found = format!("{what} up to byte {end} in a file of {} bytes", self.size);
        Err(self.fault(
            FaultKind::Truncated,
            Place::Byte(byte),
            found,
            "all of it: the file is truncated",
        ))
    }

    fn header(&mut self) -> Result<Header, FormatError> {
        if self.size == 0 {
            let found = "an empty file".to_owned();
            return Err(self.fault(FaultKind::Empty, Place::File, found, "a LAS or LAZ file"));
        }
        let signature: [u8; 4] = self.bytes(0, "the signature")?;
        if &signature != b"LASF" {
            let found = crate::formats::error::quoted(&signature);
            return Err(self.fault(FaultKind::UnknownFormat, Place::Byte(0), found, "\"LASF\""));
        }
        let short: [u8; SHORTEST_HEADER] = self.bytes(0, "the header")?;
        let header = Header::parse(&short);
        if header.version_minor < 3 {
            return Ok(header);
        }
        let known = if header.version_minor == 3 {
            235
        } else {
            LONGEST_HEADER
        };
        self.inside(0, known as u64, "the header")?;
        let mut long = [0; LONGEST_HEADER];
        self.seek(0)?;
        self.source
            .read_exact(&mut long[..known])
            .map_err(|e| FormatError::unreadable(self.file, &e))?;
        Ok(Header::parse(&long))
    }

    /// Refuses a header that contradicts itself or lacks what is needed.
    fn plausible(&self, header: &Header) -> Result<(), FormatError> {
        let bad = |found: String, expected: &str| {
            Err(self.fault(FaultKind::BadValue, Place::Header, found, expected))
        };
        if header.format > 10 {
            return bad(format!("point format {}", header.format), "0 to 10");
        }
        if header.points == 0 {
            return bad("0 points".to_owned(), "at least one point");
        }
        if header.points > 1 << 40 {
            return bad(format!("{} points", header.points), "at most 2^40");
        }
        let shortest = LENGTHS[usize::from(header.format)];
        if header.point_bytes < shortest {
            let found = format!("points of {} bytes", header.point_bytes);
            let expected = format!("{shortest} or more in point format {}", header.format);
            return bad(found, &expected);
        }
        if !header.offset.iter().all(|o| o.is_finite()) {
            return bad(format!("offset {:?}", header.offset), "finite numbers");
        }
        if !header.scale.iter().all(|s| *s > 0.0 && *s <= 1e3) {
            return bad(
                format!("scale {:?}", header.scale),
                "above 0 and up to 1000",
            );
        }
        if usize::from(header.header_size) < SHORTEST_HEADER
            || u32::from(header.header_size) > header.offset_to_points
        {
            let found = format!(
                "a header of {} bytes and points from byte {}",
                header.header_size, header.offset_to_points
            );
            return bad(found, "a header of at least 227 bytes, then the points");
        }
        Ok(())
    }

    /// Walks the variable length records; what they say of the compression, if any.
    fn variable_records(&mut self, header: &Header) -> Result<Compression, FormatError> {
        let mut at = u64::from(header.header_size);
        let mut compression = Compression::default();
        for _ in 0..header.records {
            let bytes: [u8; 54] = self.bytes(at, "a variable length record")?;
            let fields = Fields(&bytes);
            let length = u64::from(fields.u16(20));
            if fields.u16(18) == LASZIP.1 && bytes[2..].starts_with(LASZIP.0) {
                let data = self.piece(at + RECORD_HEADER.0, length, "the LASzip record")?;
                compression = Compression::parse(&data);
            }
            at += RECORD_HEADER.0 + length;
        }
        if at > u64::from(header.offset_to_points) {
            let found = format!(
                "{} variable length records up to byte {at}, points from byte {}",
                header.records, header.offset_to_points
            );
            return Err(self.fault(
                FaultKind::BadValue,
                Place::Header,
                found,
                "the points after the records",
            ));
        }
        Ok(compression)
    }

    /// A count that the compressed bytes cannot hold is damaged; room would be made for it.
    fn count(&self, header: &Header) -> Result<(), FormatError> {
        let bytes = self.size - u64::from(header.offset_to_points).min(self.size);
        let most = bytes.saturating_mul(MOST_POINTS_PER_BYTE);
        if header.points <= most {
            return Ok(());
        }
        let found = format!("{} points in {bytes} compressed bytes", header.points);
        let expected = format!("at most {most}");
        Err(self.fault(FaultKind::BadValue, Place::Header, found, expected))
    }

    /// The first extended record must lie in the file.
    fn extended_record(&mut self, header: &Header) -> Result<(), FormatError> {
        let (at, count) = header.extended_records;
        if count == 0 {
            return Ok(());
        }
        let bytes: [u8; 60] = self.bytes(at, "an extended variable length record")?;
        let length = Fields(&bytes).u64(20);
        self.inside(
            at + RECORD_HEADER.1,
            length,
            "an extended variable length record",
        )
    }

    fn points(&self, header: &Header) -> Result<(), FormatError> {
        let (begin, bytes) = (
            u64::from(header.offset_to_points),
            u64::from(header.point_bytes),
        );
        let there = self.size.saturating_sub(begin) / bytes;
        if there >= header.points {
            return Ok(());
        }
        let place = Place::Record {
            record: there,
            byte: begin + there * bytes,
        };
        let found = format!("the end of the file after {there} points");
        let expected = format!("{} points as the header says: truncated", header.points);
        Err(self.fault(FaultKind::Truncated, place, found, expected))
    }

    /// The chunk table stands behind the points; a truncated file has lost it. Its place.
    fn chunk_table(&mut self, header: &Header, chunked: bool) -> Result<Option<u64>, FormatError> {
        let begin = u64::from(header.offset_to_points);
        if !chunked {
            return self.inside(begin, 1, "compressed points").map(|()| None);
        }
        let offset: [u8; 8] = self.bytes(begin, "the offset of the chunk table")?;
        let mut table = i64::from_le_bytes(offset);
        if table <= begin as i64 {
            let last: [u8; 8] =
                self.bytes(self.size.saturating_sub(8), "the chunk table's offset")?;
            table = i64::from_le_bytes(last);
        }
        let table = u64::try_from(table).unwrap_or(u64::MAX);
        if table <= begin {
            let found = format!("a chunk table at byte {table}, points from byte {begin}");
            return Err(self.fault(
                FaultKind::BadValue,
                Place::Byte(begin),
                found,
                "the chunk table after the points",
            ));
        }
        let head: [u8; 8] = self.bytes(table, "the chunk table")?;
        let chunks = u64::from(Fields(&head).u32(4));
        if chunks == 0 || chunks > (table - begin) / 8 {
            let found = format!("{chunks} chunks in {} bytes of points", table - begin);
            return Err(self.fault(
                FaultKind::BadValue,
                Place::Byte(table),
                found,
                "one chunk or more, none empty",
            ));
        }
        Ok(Some(table))
    }
}
