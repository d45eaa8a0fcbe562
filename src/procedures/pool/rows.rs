//! Chosen rows of a sensor, one bit a row.

use rayon::prelude::*;

/// Bits of a word.
const WORD: usize = u64::BITS as usize;
/// Words per parallel task.
const CHUNK: usize = 256;
/// The word of every chosen row with a number divisible by this is noted, so that one is found by its number.
const STEP: usize = 1024;

/// Chosen rows, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    words: Vec<u64>,
    /// Word of every [`STEP`]-th chosen row, and how many were chosen in the words before it.
    marks: Vec<(u32, u32)>,
    count: usize,
}

impl Rows {
    /// Those of so many rows for which `keep` holds; worked out in parallel.
    #[must_use]
    pub fn chosen(rows: usize, keep: impl Fn(usize) -> bool + Sync) -> Self {
        let mut words = vec![0; rows.div_ceil(WORD)];
        let fill = |(chunk, words): (usize, &mut [u64])| {
            for (k, word) in words.iter_mut().enumerate() {
                let first = (chunk * CHUNK + k) * WORD;
                for row in (first..(first + WORD).min(rows)).filter(|row| keep(*row)) {
                    *word |= 1 << (row - first);
                }
            }
        };
        words.par_chunks_mut(CHUNK).enumerate().for_each(fill);
        let mut chosen = Self {
            words,
            ..Self::default()
        };
        chosen.mark();
        chosen
    }

    fn mark(&mut self) {
        let (mut count, mut marks) = (0, vec![]);
        for (place, word) in self.words.iter().enumerate() {
            let own = word.count_ones() as usize;
            if marks.len() * STEP < count + own {
                marks.push((place as u32, count as u32));
            }
            count += own;
        }
        (self.count, self.marks) = (count, marks);
    }

    /// How many are chosen.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether none is.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The chosen rows from the `k`-th on.
    pub fn from(&self, k: usize) -> impl Iterator<Item = u32> + '_ {
        let mark = self.marks.get(k / STEP);
        let (first, before) = mark.map_or((self.words.len(), k), |(word, before)| {
            (*word as usize, *before as usize)
        });
        let words = self.words[first..].iter().zip(first..);
        words
            .flat_map(|(word, place)| bits(*word, place))
            .skip(k - before)
    }

    /// All chosen rows.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.from(0)
    }

    /// At most `most` of them, evenly.
    #[must_use]
    pub(super) fn thinned(&self, most: usize) -> Vec<u32> {
        if self.count <= most {
            return self.iter().collect();
        }
        let one = |i: usize| self.from(i * self.count / most).next();
        (0..most).filter_map(one).collect()
    }
}

/// The bits that are set in a word, as rows.
fn bits(word: u64, place: usize) -> impl Iterator<Item = u32> {
    let mut rest = word;
    std::iter::from_fn(move || {
        let bit = rest.trailing_zeros();
        (rest != 0).then(|| {
            rest &= rest - 1;
            (place * WORD) as u32 + bit
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_by_number() {
        let keep = |row: usize| row % 3 == 1 || (20_000..30_000).contains(&row);
        let all: Vec<u32> = (0..70_000u32).filter(|row| keep(*row as usize)).collect();
        let rows = Rows::chosen(70_000, keep);
        assert_eq!(rows.len(), all.len());
        assert!(rows.iter().eq(all.iter().copied()));
        for k in [0, 1, 1023, 1024, 1025, 9000, 15_359, 15_360, all.len() - 1] {
            assert_eq!(rows.from(k).next(), Some(all[k]), "{k}");
        }
        assert_eq!(rows.from(all.len()).next(), None);
        let few = rows.thinned(100);
        assert_eq!((few.len(), few[7]), (100, all[7 * all.len() / 100]));
        assert!(Rows::chosen(0, |_| true).is_empty());
    }
}
