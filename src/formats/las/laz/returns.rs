//! Contexts from the return number and the number of returns, and the running median of the last differences.

/// Context of a pair of number of returns and return number, point formats 0 to 5.
const MAP: [[u8; 8]; 8] = [
    [15, 14, 13, 12, 11, 10, 9, 8],
    [14, 0, 1, 3, 6, 10, 10, 9],
    [13, 1, 2, 4, 7, 11, 11, 10],
    [12, 3, 4, 5, 8, 12, 12, 11],
    [11, 6, 7, 8, 9, 13, 13, 12],
    [10, 10, 11, 12, 13, 14, 14, 13],
    [9, 10, 11, 12, 13, 14, 15, 14],
    [8, 9, 10, 11, 12, 13, 14, 15],
];

/// As [`MAP`] in six contexts, point formats 6 to 10.
const MAP_OF_SIX: [[u8; 16]; 16] = [
    [0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5],
    [1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3],
    [2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3],
    [3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5],
];

/// Context of `n` returns and return `r`, both below 8.
pub fn map(n: usize, r: usize) -> usize {
    usize::from(MAP[n][r])
}

/// Context of `n` returns and return `r`, both below 16.
pub fn map_of_six(n: usize, r: usize) -> usize {
    usize::from(MAP_OF_SIX[n][r])
}

/// How deep a return lies, 0 to 7.
pub fn level(n: usize, r: usize) -> usize {
    n.abs_diff(r).min(7)
}

/// Context of the second coordinate, from the bits of the first one's correction.
pub fn after(k: usize, most: usize, single: bool) -> usize {
    usize::from(single) + if k < most { k & !1 } else { most }
}

/// The running median of five: by turns the highest and the lowest makes room.
#[derive(Clone, Copy, Debug)]
pub struct Median {
    sorted: [i32; 5],
    highest_goes: bool,
}

impl Default for Median {
    fn default() -> Self {
        Self {
            sorted: [0; 5],
            highest_goes: true,
        }
    }
}

impl Median {
    /// The middle one.
    pub fn get(&self) -> i32 {
        self.sorted[2]
    }

    /// Takes in one more.
    pub fn add(&mut self, value: i32) {
        let middle = self.sorted[2];
        if self.highest_goes {
            let at = self.sorted[..4].partition_point(|v| *v <= value);
            self.sorted.copy_within(at..4, at + 1);
            self.sorted[at] = value;
            self.highest_goes = value < middle;
        } else {
            let at = self.sorted[1..].partition_point(|v| *v < value);
            self.sorted.copy_within(1..at + 1, 0);
            self.sorted[at] = value;
            self.highest_goes = value <= middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_follows_its_values() {
        let mut median = Median::default();
        let found: Vec<i32> = [5, 6, -3, 7, 8, 9, 9, 9]
            .map(|v| {
                median.add(v);
                median.get()
            })
            .into();
        // worked by hand: 0 0 0 0 0 -> 0 0 0 0 5 -> 0 0 0 5 6 -> -3 0 0 5 6 -> -3 0 0 5 7 -> 0 0 5 7 8 -> 0 5 7 8 9 -> 5 7 8 9 9 -> 7 8 9 9 9
        assert_eq!(found, [0, 0, 0, 0, 5, 7, 8, 9]);
    }
}
