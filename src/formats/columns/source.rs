//! The bytes of a column chunk, with a look at each page's header before the parquet crate makes room for the page: it believes any
//! size up to 2 GiB.

use std::fs::File;
use std::io::{BufReader, Read};

use bytes::Bytes;
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{ChunkReader, Length};

/// A file whose pages must not grow beyond `most` bytes. Pages must be read from the first to the last, so that every read that the
/// crate begins is that of a page's header.
pub(super) struct BoundedPages {
    pub(super) file: File,
    pub(super) most: u64,
}

impl Length for BoundedPages {
    fn len(&self) -> u64 {
        self.file.len()
    }
}

impl ChunkReader for BoundedPages {
    type T = BufReader<File>;

    fn get_read(&self, start: u64) -> Result<Self::T> {
        let mut header = vec![];
        let looked = self.file.get_read(start)?;
        looked.take(LONGEST).read_to_end(&mut header)?;
        match unpacked_size(&header) {
            Some(size) if u64::from(size) <= self.most => self.file.get_read(start),
            Some(size) => Err(ParquetError::General(format!(
                "a page of {size} bytes where {} suffice",
                self.most
            ))),
            None => Err(ParquetError::General(
                "a page header that does not begin with type and size".to_owned(),
            )),
        }
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        self.file.get_bytes(start, length)
    }
}

/// Of two fields, each a byte and at most five bytes.
const LONGEST: u64 = 12;

/// The header of a field that follows the one before and holds 32 bits, in Thrift's compact protocol.
const NEXT_I32: u8 = 0x15;

/// `uncompressed_page_size` at the beginning of a `PageHeader` (parquet.thrift: the second field, after the type).
fn unpacked_size(header: &[u8]) -> Option<u32> {
    let (_, rest) = varint(header.strip_prefix(&[NEXT_I32])?)?;
    let (zigzag, _) = varint(rest.strip_prefix(&[NEXT_I32])?)?;
    // an odd number is a negative size
    (zigzag & 1 == 0).then(|| u32::try_from(zigzag >> 1).ok())?
}

/// A number in groups of seven bits, the lowest first, and what follows it.
fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let end = bytes.iter().take(5).position(|byte| byte & 0x80 == 0)?;
    let (number, rest) = bytes.split_at(end + 1);
    let groups = number.iter().rev().map(|byte| u64::from(byte & 0x7f));
    Some((groups.fold(0, |sum, group| sum << 7 | group), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: type 0, then zigzag 600 is 300 as 0xd8 0x04; zigzag 1 is -1.
    #[test]
    fn the_size_of_a_page_is_read_from_its_header() {
        assert_eq!(
            unpacked_size(&[0x15, 0x00, 0x15, 0xd8, 0x04, 0x15]),
            Some(300)
        );
        assert_eq!(unpacked_size(&[0x15, 0x06, 0x15, 0x01]), None);
        let most = [0x15, 0x00, 0x15, 0xfe, 0xff, 0xff, 0xff, 0x0f];
        assert_eq!(unpacked_size(&most), Some(i32::MAX.cast_unsigned()));
        assert_eq!(unpacked_size(&most[..7]), None);
        assert_eq!(unpacked_size(&[0x25, 0x00, 0x15, 0x02]), None);
    }
}
