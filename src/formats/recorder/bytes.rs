//! Numbers out of a record's bytes, either byte order, never beyond its end.

/// A record's bytes and their order. Every getter is `None` where the record is too short.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a> {
    /// The bytes.
    pub data: &'a [u8],
    /// Most significant byte first.
    pub big_endian: bool,
}

macro_rules! getters {
    ($($(#[$doc:meta])* $name:ident: $kind:ty),* $(,)?) => {$(
        $(#[$doc])*
        #[inline]
        #[must_use]
        pub fn $name(&self, at: usize) -> Option<$kind> {
            let bytes = *self.data.get(at..)?.first_chunk()?;
            Some(if self.big_endian { <$kind>::from_be_bytes(bytes) } else { <$kind>::from_le_bytes(bytes) })
        }
    )*};
}

impl<'a> Bytes<'a> {
    /// Least significant byte first.
    #[must_use]
    pub fn little(data: &'a [u8]) -> Self {
        Self {
            data,
            big_endian: false,
        }
    }

    /// Most significant byte first.
    #[must_use]
    pub fn big(data: &'a [u8]) -> Self {
        Self {
            data,
            big_endian: true,
        }
    }

    /// The part of `length` bytes that begins at `at`.
    #[must_use]
    pub fn part(&self, at: usize, length: usize) -> Option<Self> {
        let data = self.data.get(at..at.checked_add(length)?)?;
        Some(Self { data, ..*self })
    }

    /// `count` parts of `size` bytes each, from `at` on: there, or `None`. Nothing is allocated for a count that is not in the bytes.
    #[must_use]
    pub fn parts(
        &self,
        at: usize,
        count: usize,
        size: usize,
    ) -> Option<impl ExactSizeIterator<Item = Self> + use<'a>> {
        let whole = self.part(at, count.checked_mul(size)?)?;
        let big_endian = self.big_endian;
        let chunks = whole.data.chunks_exact(size.max(1));
        Some(chunks.map(move |data| Bytes { data, big_endian }))
    }

    /// Text up to the first zero byte, spaces trimmed.
    #[must_use]
    pub fn text(&self, at: usize, length: usize) -> Option<String> {
        let raw = self.part(at, length)?.data;
        let end = raw.iter().position(|b| *b == 0).unwrap_or(raw.len());
        Some(String::from_utf8_lossy(&raw[..end]).trim().to_owned())
    }

    getters! {
        /// One byte.
        u8: u8,
        /// One byte, signed.
        i8: i8,
        /// Two bytes.
        u16: u16,
        /// Two bytes, signed.
        i16: i16,
        /// Four bytes.
        u32: u32,
        /// Four bytes, signed.
        i32: i32,
        /// Eight bytes.
        u64: u64,
        /// Four bytes of a real number.
        f32: f32,
        /// Eight bytes of a real number.
        f64: f64,
    }

    /// A four-byte real number as eight.
    #[inline]
    #[must_use]
    pub fn real(&self, at: usize) -> Option<f64> {
        self.f32(at).map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_orders_and_the_end() {
        let data = [1, 2, 3, 4];
        assert_eq!(Bytes::little(&data).u16(0), Some(0x0201));
        assert_eq!(Bytes::big(&data).u16(0), Some(0x0102));
        assert_eq!(Bytes::big(&data).u32(1), None);
        assert_eq!(Bytes::big(&data).u8(usize::MAX), None);
        assert!(Bytes::big(&data).parts(0, usize::MAX, 20).is_none());
        assert_eq!(Bytes::big(&data).parts(0, 2, 2).map(|p| p.len()), Some(2));
    }
}
