//! Integers of LAZ: the correction of a prediction, as the number of its bits and the bits.

use super::Fault;
use super::coder::{BitModel, Bytes, Decoder, Models};

/// Bits of a correction that one symbol holds.
const HIGH: u32 = 8;

/// The models of one kind of integer.
#[derive(Clone, Debug)]
pub struct Integer {
    /// Bits of the integer, 8, 16 or 32.
    bits: u32,
    /// Number of bits of the correction, by context.
    lengths: Models,
    /// Corrections of one bit.
    single: BitModel,
    /// Corrections of more bits, by their number.
    corrections: Vec<Models>,
    /// Number of bits of the last correction.
    pub k: usize,
}

impl Integer {
    /// Integers of 8, 16 or 32 bits in so many contexts.
    #[must_use]
    pub fn new(bits: u32, contexts: usize) -> Self {
        let symbols = |k: u32| 1usize << k.min(HIGH);
        Self {
            bits,
            lengths: Models::new(contexts, bits as usize + 1),
            single: BitModel::default(),
            corrections: (1..=bits).map(|k| Models::new(1, symbols(k))).collect(),
            k: 0,
        }
    }

    /// The next integer.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn next(
        &mut self,
        predicted: i32,
        context: usize,
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<i32, Fault> {
        self.k = decoder.symbol(self.lengths.of(context), bytes)?;
        let found = predicted.wrapping_add(self.correction(decoder, bytes)?);
        Ok(self.folded(found))
    }

    /// Corrections of k bits are -(2^k - 1) to -2^(k-1) and 2^(k-1) + 1 to 2^k; those of none 0 and 1.
    fn correction(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<i32, Fault> {
        let k = self.k as u32;
        if k == 0 {
            return Ok(decoder.bit(&mut self.single, bytes)? as i32);
        }
        if k >= 32 {
            return Ok(i32::MIN);
        }
        let model = self.corrections[k as usize - 1].of(0);
        let mut found = decoder.symbol(model, bytes)? as u32;
        if k > HIGH {
            found = found << (k - HIGH) | decoder.bits(k - HIGH, bytes)?;
        }
        let found = i64::from(found);
        let shift = if found >= 1 << (k - 1) {
            1
        } else {
            1 - (1 << k)
        };
        Ok((found + shift) as i32)
    }

    /// Back into the range of integers of fewer than 32 bits.
    fn folded(&self, found: i32) -> i32 {
        if self.bits >= 32 {
            return found;
        }
        let range = 1 << self.bits;
        match found {
            v if v < 0 => v.wrapping_add(range),
            v if v >= range => v - range,
            v => v,
        }
    }
}
