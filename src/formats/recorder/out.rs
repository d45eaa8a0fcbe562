//! Numbers into a record's bytes, either byte order.

/// Bytes of a record that is being written.
#[derive(Clone, Debug, Default)]
pub struct Out {
    /// The bytes so far.
    pub data: Vec<u8>,
    /// Most significant byte first.
    pub big_endian: bool,
}

macro_rules! putters {
    ($($(#[$doc:meta])* $name:ident: $kind:ty),* $(,)?) => {$(
        $(#[$doc])*
        pub fn $name(&mut self, value: $kind) -> &mut Self {
            let bytes = if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
            self.data.extend_from_slice(&bytes);
            self
        }
    )*};
}

impl Out {
    /// Nothing written yet.
    #[must_use]
    pub fn new(big_endian: bool) -> Self {
        Self {
            data: vec![],
            big_endian,
        }
    }

    putters! {
        /// One byte.
        u8: u8,
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

    /// A real number as four bytes.
    pub fn real(&mut self, value: f64) -> &mut Self {
        self.f32(value as f32)
    }

    /// Bytes as they are.
    pub fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.data.extend_from_slice(bytes);
        self
    }

    /// Zero bytes.
    pub fn zeros(&mut self, count: usize) -> &mut Self {
        self.data.resize(self.data.len() + count, 0);
        self
    }

    /// Writes over four bytes that were written before.
    pub fn set_u32(&mut self, at: usize, value: u32) {
        let bytes = if self.big_endian {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        };
        self.data[at..at + 4].copy_from_slice(&bytes);
    }
}
