//! Numbers as bytes for another process, and back.

use thiserror::Error;

/// Bytes in the making.
#[derive(Clone, Debug, Default)]
pub struct Packer(Vec<u8>);

/// Bytes that end too early, go on too long or are of another kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a message between two processes cannot be read; is one boresight installed everywhere?")]
pub struct Torn;

impl Packer {
    /// A byte.
    pub fn byte(&mut self, value: u8) -> &mut Self {
        self.0.push(value);
        self
    }

    /// A whole number, the shorter the smaller.
    pub fn count(&mut self, mut value: usize) -> &mut Self {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.byte(value as u8)
    }

    /// A number, bit by bit.
    pub fn number(&mut self, value: f64) -> &mut Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    /// How many numbers, and the numbers.
    pub fn numbers(&mut self, values: &[f64]) -> &mut Self {
        self.count(values.len());
        self.0.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        self
    }

    /// How many bytes, and the bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.count(bytes.len());
        self.0.extend_from_slice(bytes);
        self
    }

    /// All of it.
    #[must_use]
    pub fn done(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.0)
    }
}

/// Bytes that are read from the first to the last.
#[derive(Clone, Debug)]
pub struct Unpacker<'a>(&'a [u8]);

impl<'a> Unpacker<'a> {
    /// Begins.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Torn> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(Torn)?;
        self.0 = rest;
        Ok(taken)
    }

    /// The next byte.
    ///
    /// # Errors
    /// [`Torn`], as all of these.
    pub fn byte(&mut self) -> Result<u8, Torn> {
        Ok(self.take(1)?[0])
    }

    /// The next whole number.
    ///
    /// # Errors
    /// [`Torn`].
    pub fn count(&mut self) -> Result<usize, Torn> {
        let mut value = 0;
        for shift in (0..usize::BITS).step_by(7) {
            let byte = self.byte()?;
            value |= usize::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(Torn)
    }

    /// The next number.
    ///
    /// # Errors
    /// [`Torn`].
    pub fn number(&mut self) -> Result<f64, Torn> {
        let bytes = self.take(size_of::<f64>())?;
        Ok(f64::from_le_bytes(bytes.try_into().map_err(|_| Torn)?))
    }

    /// The next list of numbers.
    ///
    /// # Errors
    /// [`Torn`].
    pub fn numbers(&mut self) -> Result<Vec<f64>, Torn> {
        let count = self.count()?;
        let bytes = self.take(count.checked_mul(size_of::<f64>()).ok_or(Torn)?)?;
        let (words, _) = bytes.as_chunks();
        Ok(words.iter().map(|word| f64::from_le_bytes(*word)).collect())
    }

    /// The next bytes.
    ///
    /// # Errors
    /// [`Torn`].
    pub fn bytes(&mut self) -> Result<&'a [u8], Torn> {
        let count = self.count()?;
        self.take(count)
    }

    /// So many things, each read by `one`.
    ///
    /// # Errors
    /// [`Torn`].
    pub fn list<T>(
        &mut self,
        mut one: impl FnMut(&mut Self) -> Result<T, Torn>,
    ) -> Result<Vec<T>, Torn> {
        let count = self.count()?;
        (0..count).map(|_| one(self)).collect()
    }

    /// Nothing may be left.
    ///
    /// # Errors
    /// [`Torn`].
    pub fn end(&self) -> Result<(), Torn> {
        self.0.is_empty().then_some(()).ok_or(Torn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_is_unpacked_and_what_is_torn_is_refused() {
        let numbers = [0.1, -0.0, f64::NAN, f64::MIN_POSITIVE];
        let mut packer = Packer::default();
        packer
            .byte(7)
            .count(0)
            .count(127)
            .count(128)
            .count(usize::MAX);
        packer.number(1.0 / 3.0).numbers(&numbers).bytes(b"abc");
        let bytes = packer.done();
        let read = |bytes: &[u8]| -> Result<Vec<f64>, Torn> {
            let mut all = Unpacker::new(bytes);
            assert_eq!(all.byte()?, 7);
            for expected in [0, 127, 128, usize::MAX] {
                assert_eq!(all.count()?, expected);
            }
            assert_eq!(all.number()?, 1.0 / 3.0);
            let numbers = all.numbers()?;
            assert_eq!(all.bytes()?, b"abc");
            all.end()?;
            Ok(numbers)
        };
        let found = read(&bytes).expect("whole");
        assert!(
            found
                .iter()
                .zip(numbers)
                .all(|(a, b)| a.to_bits() == b.to_bits())
        );
        for length in 0..bytes.len() {
            assert_eq!(read(&bytes[..length]), Err(Torn), "{length}");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert_eq!(read(&longer), Err(Torn));
        assert_eq!(Unpacker::new(&[0xff; 12]).count(), Err(Torn));
        let claims = Packer::default().count(usize::MAX).done();
        assert_eq!(Unpacker::new(&claims).numbers(), Err(Torn));
        assert_eq!(Unpacker::new(&claims).list(Unpacker::byte), Err(Torn));
    }
}
