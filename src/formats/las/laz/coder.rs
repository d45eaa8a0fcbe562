//! The arithmetic decoder of LAZ and its adaptive models (A. Said, HP Labs report HPL-2004-76; "`LASzip` specification 1.4").
//!
//! Every division and every index is checked: on damaged bytes the interval or the value leaves what an encoder can produce, and
//! that is a [`Fault`], never a panic.

use super::Fault;

/// Where compressed bytes come from.
pub trait Bytes {
    /// The next byte.
    ///
    /// # Errors
    /// [`Fault::End`] behind the last one.
    fn byte(&mut self) -> Result<u8, Fault>;
}

/// Bits of a distribution of symbols.
const SYMBOL_BITS: u32 = 15;
/// Bits of the probability of a bit.
const BIT_BITS: u32 = 13;
/// An interval never stays shorter than this.
const SHORTEST: u32 = 1 << 24;

/// The interval and the value in it.
#[derive(Clone, Debug)]
pub struct Decoder {
    value: u32,
    length: u32,
}

impl Decoder {
    /// Begins with the next four bytes.
    ///
    /// # Errors
    /// [`Fault::End`].
    pub fn begin(bytes: &mut impl Bytes) -> Result<Self, Fault> {
        let mut value = 0;
        for _ in 0..4 {
            value = value << 8 | u32::from(bytes.byte()?);
        }
        let length = u32::MAX;
        Ok(Self { value, length })
    }

    /// Takes bytes until the interval is long enough again.
    fn refill(&mut self, bytes: &mut impl Bytes) -> Result<(), Fault> {
        if self.length == 0 || self.value >= self.length {
            return Err(Fault::Damaged);
        }
        while self.length < SHORTEST {
            self.value = self.value << 8 | u32::from(bytes.byte()?);
            self.length <<= 8;
        }
        Ok(())
    }

    /// The next bit of an adaptive model.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn bit(&mut self, model: &mut BitModel, bytes: &mut impl Bytes) -> Result<u32, Fault> {
        let zero = model.zero_probability * (self.length >> BIT_BITS);
        let one = self.value >= zero;
        if one {
            self.value -= zero;
            self.length -= zero;
        } else {
            self.length = zero;
            model.zeros += 1;
        }
        self.refill(bytes)?;
        model.count();
        Ok(u32::from(one))
    }

    /// The next symbol of an adaptive model.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn symbol(&mut self, model: &mut Model, bytes: &mut impl Bytes) -> Result<usize, Fault> {
        let unit = self.length >> SYMBOL_BITS;
        if unit == 0 {
            return Err(Fault::Damaged);
        }
        let symbol = model.at(self.value / unit);
        let begin = model.distribution[symbol] * unit;
        let end = match model.distribution.get(symbol + 1) {
            Some(next) => next * unit,
            None => self.length,
        };
        self.value -= begin;
        self.length = end - begin;
        self.refill(bytes)?;
        model.count(symbol);
        Ok(symbol)
    }

    /// The next bits as they are, at most 32.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn bits(&mut self, bits: u32, bytes: &mut impl Bytes) -> Result<u32, Fault> {
        if bits > 19 {
            let low = self.few(16, bytes)?;
            return Ok(self.few(bits - 16, bytes)? << 16 | low);
        }
        self.few(bits, bytes)
    }

    fn few(&mut self, bits: u32, bytes: &mut impl Bytes) -> Result<u32, Fault> {
        let unit = self.length >> bits;
        if unit == 0 {
            return Err(Fault::Damaged);
        }
        let found = self.value / unit;
        self.value -= unit * found;
        self.length = unit;
        self.refill(bytes)?;
        if found >> bits != 0 {
            return Err(Fault::Damaged);
        }
        Ok(found)
    }

    /// The next 64 bits as they are.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn long(&mut self, bytes: &mut impl Bytes) -> Result<u64, Fault> {
        let low = u64::from(self.bits(32, bytes)?);
        Ok(u64::from(self.bits(32, bytes)?) << 32 | low)
    }
}

/// An adaptive model of so many symbols.
#[derive(Clone, Debug)]
pub struct Model {
    /// Where the interval of each symbol begins, ascending from 0.
    distribution: Vec<u32>,
    counts: Vec<u32>,
    total: u32,
    cycle: u32,
    left: u32,
}

impl Model {
    /// All symbols equally likely; 2 to 2048 of them.
    #[must_use]
    pub fn new(symbols: usize) -> Self {
        let n = symbols as u32;
        let mut model = Self {
            distribution: vec![0; symbols],
            counts: vec![1; symbols],
            total: 0,
            cycle: n,
            left: 0,
        };
        model.update();
        model.cycle = (n + 6) >> 1;
        model.left = model.cycle;
        model
    }

    /// The symbol in whose interval a value lies.
    fn at(&self, value: u32) -> usize {
        self.distribution.partition_point(|begin| *begin <= value) - 1
    }

    fn count(&mut self, symbol: usize) {
        self.counts[symbol] += 1;
        self.left -= 1;
        if self.left == 0 {
            self.update();
        }
    }

    fn update(&mut self) {
        self.total += self.cycle;
        if self.total > 1 << SYMBOL_BITS {
            self.total = 0;
            for count in &mut self.counts {
                *count = (*count + 1) >> 1;
                self.total += *count;
            }
        }
        let (mut sum, scale) = (0u32, (1u32 << 31) / self.total);
        for (begin, count) in self.distribution.iter_mut().zip(&self.counts) {
            *begin = (scale * sum) >> (31 - SYMBOL_BITS);
            sum += count;
        }
        let longest = (self.counts.len() as u32 + 6) << 3;
        self.cycle = ((5 * self.cycle) >> 2).min(longest);
        self.left = self.cycle;
    }
}

/// An adaptive model of a bit.
#[derive(Clone, Debug)]
pub struct BitModel {
    zeros: u32,
    total: u32,
    zero_probability: u32,
    cycle: u32,
    left: u32,
}

impl Default for BitModel {
    fn default() -> Self {
        Self {
            zeros: 1,
            total: 2,
            zero_probability: 1 << (BIT_BITS - 1),
            cycle: 4,
            left: 4,
        }
    }
}

impl BitModel {
    fn count(&mut self) {
        self.left -= 1;
        if self.left == 0 {
            self.update();
        }
    }

    fn update(&mut self) {
        self.total += self.cycle;
        if self.total > 1 << BIT_BITS {
            self.total = (self.total + 1) >> 1;
            self.zeros = (self.zeros + 1) >> 1;
            if self.zeros == self.total {
                self.total += 1;
            }
        }
        let scale = (1u32 << 31) / self.total;
        self.zero_probability = (self.zeros * scale) >> (31 - BIT_BITS);
        self.cycle = ((5 * self.cycle) >> 2).min(64);
        self.left = self.cycle;
    }
}

/// Models that are made when they are first needed.
#[derive(Clone, Debug)]
pub struct Models {
    symbols: usize,
    models: Vec<Option<Model>>,
}

impl Models {
    /// So many models of so many symbols each.
    #[must_use]
    pub fn new(count: usize, symbols: usize) -> Self {
        Self {
            symbols,
            models: vec![None; count],
        }
    }

    /// The model of a context.
    pub fn of(&mut self, context: usize) -> &mut Model {
        let symbols = self.symbols;
        self.models[context].get_or_insert_with(|| Model::new(symbols))
    }
}
