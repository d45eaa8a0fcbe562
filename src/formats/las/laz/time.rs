//! GPS times of LAZ, as the integers of their bits: up to four sequences whose differences repeat.

use super::Fault;
use super::coder::{Bytes, Decoder, Model};
use super::integer::Integer;

/// Multiples of the last difference that have a symbol of their own: 0 to this, and -1 to [`LOWEST`].
const HIGHEST: i32 = 500;
const LOWEST: i32 = -10;
/// A time changes its sequence once; a decoder that does so without end reads damaged bytes.
const MOST_CHANGES: u32 = 16;

/// The models of version 2 (point by point) and 3 (layers).
#[derive(Clone, Debug)]
pub struct Times {
    last: usize,
    next: usize,
    times: [i64; 4],
    differences: [i32; 4],
    extremes: [u32; 4],
    /// 1 where a time may also be said to be the one before.
    unchanged: usize,
    first_symbols: Model,
    symbols: Model,
    differences_coder: Integer,
}

impl Times {
    /// Times of points that are compressed one after the other; `first` are the bits of the first.
    #[must_use]
    pub fn pointwise(first: i64) -> Self {
        Self::new(first, 1)
    }

    /// Times of a layer, which holds only those that change.
    #[must_use]
    pub fn layered(first: i64) -> Self {
        Self::new(first, 0)
    }

    fn new(first: i64, unchanged: usize) -> Self {
        Self {
            last: 0,
            next: 0,
            times: [first, 0, 0, 0],
            differences: [0; 4],
            extremes: [0; 4],
            unchanged,
            first_symbols: Model::new(5 + unchanged),
            symbols: Model::new((HIGHEST - LOWEST) as usize + 5 + unchanged),
            differences_coder: Integer::new(32, 9),
        }
    }

    /// The next time.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn next(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<i64, Fault> {
        for _ in 0..MOST_CHANGES {
            let done = if self.differences[self.last] == 0 {
                self.first(decoder, bytes)?
            } else {
                self.further(decoder, bytes)?
            };
            if done {
                return Ok(self.times[self.last]);
            }
        }
        Err(Fault::Damaged)
    }

    /// While the sequence has no difference yet; false when another sequence goes on.
    fn first(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<bool, Fault> {
        let symbol = decoder.symbol(&mut self.first_symbols, bytes)?;
        let Some(symbol) = symbol.checked_sub(self.unchanged) else {
            return Ok(true);
        };
        match symbol {
            0 => {
                let difference = self.differences_coder.next(0, 0, decoder, bytes)?;
                self.differences[self.last] = difference;
                self.extremes[self.last] = 0;
                self.advance(difference);
            }
            1 => self.begin(decoder, bytes)?,
            _ => {
                self.last = (self.last + symbol - 1) & 3;
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// With a difference to compare with; false when another sequence goes on.
    fn further(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<bool, Fault> {
        let symbol = decoder.symbol(&mut self.symbols, bytes)?;
        let multiples = (HIGHEST - LOWEST) as usize + 1;
        if symbol < multiples {
            self.multiple(symbol as i32, decoder, bytes)?;
            return Ok(true);
        }
        let Some(change) = (symbol - multiples).checked_sub(self.unchanged) else {
            return Ok(true);
        };
        if change == 0 {
            self.begin(decoder, bytes)?;
            return Ok(true);
        }
        self.last = (self.last + change) & 3;
        Ok(false)
    }

    /// A difference that is about a multiple of the last one.
    fn multiple(
        &mut self,
        symbol: i32,
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<(), Fault> {
        let multiple = if symbol > HIGHEST {
            HIGHEST - symbol
        } else {
            symbol
        };
        let context = match multiple {
            0 => 7,
            1 => 1,
            2..=9 => 2,
            HIGHEST => 4,
            10.. => 3,
            LOWEST => 6,
            _ => 5,
        };
        let predicted = multiple.wrapping_mul(self.differences[self.last]);
        let found = self
            .differences_coder
            .next(predicted, context, decoder, bytes)?;
        self.advance(found);
        match multiple {
            1 => self.extremes[self.last] = 0,
            0 | HIGHEST | LOWEST => self.extreme(found),
            _ => {}
        }
        Ok(())
    }

    /// After four extreme differences the last of them is the one to compare with.
    fn extreme(&mut self, difference: i32) {
        let seen = &mut self.extremes[self.last];
        *seen += 1;
        if *seen > 3 {
            *seen = 0;
            self.differences[self.last] = difference;
        }
    }

    fn advance(&mut self, difference: i32) {
        let time = &mut self.times[self.last];
        *time = time.wrapping_add(difference.into());
    }

    /// A new sequence with a time of its own.
    fn begin(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<(), Fault> {
        let predicted = (self.times[self.last] >> 32) as i32;
        let high = self.differences_coder.next(predicted, 8, decoder, bytes)?;
        let low = decoder.bits(32, bytes)?;
        self.next = (self.next + 1) & 3;
        self.last = self.next;
        self.times[self.last] = i64::from(high) << 32 | i64::from(low);
        self.differences[self.last] = 0;
        self.extremes[self.last] = 0;
        Ok(())
    }
}

/// Symbols of version 1.
const OLD_SYMBOLS: usize = 512;

/// The models of version 1: one sequence.
#[derive(Clone, Debug)]
pub struct OldTimes {
    time: i64,
    difference: i32,
    extremes: u32,
    first_symbols: Model,
    symbols: Model,
    differences_coder: Integer,
}

impl OldTimes {
    /// With the bits of the first time.
    #[must_use]
    pub fn new(first: i64) -> Self {
        Self {
            time: first,
            difference: 0,
            extremes: 0,
            first_symbols: Model::new(3),
            symbols: Model::new(OLD_SYMBOLS),
            differences_coder: Integer::new(32, 6),
        }
    }

    /// The next time.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn next(&mut self, decoder: &mut Decoder, bytes: &mut impl Bytes) -> Result<i64, Fault> {
        if self.difference == 0 {
            match decoder.symbol(&mut self.first_symbols, bytes)? {
                1 => {
                    self.difference = self.differences_coder.next(0, 0, decoder, bytes)?;
                    self.time = self.time.wrapping_add(self.difference.into());
                }
                2 => self.time = decoder.long(bytes)? as i64,
                _ => {}
            }
            return Ok(self.time);
        }
        let symbol = decoder.symbol(&mut self.symbols, bytes)?;
        if symbol < OLD_SYMBOLS - 2 {
            self.multiple(symbol as i32, decoder, bytes)?;
        } else if symbol == OLD_SYMBOLS - 2 {
            self.time = decoder.long(bytes)? as i64;
        }
        Ok(self.time)
    }

    fn multiple(
        &mut self,
        multiple: i32,
        decoder: &mut Decoder,
        bytes: &mut impl Bytes,
    ) -> Result<(), Fault> {
        let (predicted, context) = match multiple {
            0 => (self.difference / 4, 2),
            1 => (self.difference, 1),
            m => {
                let context = if m < 10 {
                    3
                } else if m < 50 {
                    4
                } else {
                    5
                };
                (self.difference.wrapping_mul(m), context)
            }
        };
        let found = self
            .differences_coder
            .next(predicted, context, decoder, bytes)?;
        self.time = self.time.wrapping_add(found.into());
        let extreme = multiple == 0 || multiple == OLD_SYMBOLS as i32 - 3;
        if multiple == 1 {
            self.difference = found;
            self.extremes = 0;
        } else if extreme {
            self.extremes += 1;
            if self.extremes > 3 {
                self.difference = found;
                self.extremes = 0;
            }
        }
        Ok(())
    }
}
