//! Marks on single conditions, one bit each.

/// So many marks, each set or not.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Bits {
    words: Vec<u64>,
    len: usize,
}

impl Bits {
    /// None of `len` set.
    #[must_use]
    pub fn none(len: usize) -> Self {
        Bits {
            words: vec![0; len.div_ceil(64)],
            len,
        }
    }

    /// How many there are, set or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether mark `k` is set; none is beyond the last.
    #[inline]
    #[must_use]
    pub fn get(&self, k: usize) -> bool {
        (self.words.get(k / 64)).is_some_and(|word| word >> (k % 64) & 1 == 1)
    }

    /// Sets mark `k`; nothing beyond the last.
    pub fn set(&mut self, k: usize) {
        if k < self.len {
            self.words[k / 64] |= 1 << (k % 64);
        }
    }

    /// How many are set.
    #[must_use]
    pub fn count(&self) -> usize {
        let ones = |word: &u64| word.count_ones() as usize;
        self.words.iter().map(ones).sum()
    }

    /// All in order.
    pub fn iter(&self) -> impl Iterator<Item = bool> + '_ {
        (0..self.len).map(|k| self.get(k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_set_counted_and_found() {
        let mut bits = Bits::none(130);
        [0, 63, 64, 129, 130, 500]
            .into_iter()
            .for_each(|k| bits.set(k));
        assert_eq!((bits.len(), bits.count()), (130, 4));
        let set: Vec<usize> = bits
            .iter()
            .enumerate()
            .filter(|b| b.1)
            .map(|b| b.0)
            .collect();
        assert_eq!(set, [0, 63, 64, 129]);
        assert!(!bits.get(130) && !bits.get(500));
    }
}
