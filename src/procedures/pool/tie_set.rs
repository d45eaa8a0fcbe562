//! The ties of one sensor, two bytes a row: a row's face, or why it has none.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::matching::Verdict;

/// One observation on one face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tie {
    /// Row of the raw observation.
    pub row: u32,
    /// Index of the face in the target.
    pub face: u16,
}

/// What became of an observation; the number is what Python's arrays hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Reason {
    /// It is tied to a face.
    Used,
    /// The trajectory gives no position at its time.
    OutsideTrajectory,
    /// No face is within the gate.
    NoFace,
    /// Within the gate of a face's plane, but outside of its outline, or too close to the edge.
    OutsideOutline,
    /// Two faces are as good.
    Ambiguous,
    /// It lies on an obstacle.
    Obstacle,
    /// It lies on a face whose plane the scanner did not see.
    Unseen,
    /// Data snooping rejected it.
    GrossError,
    /// Only of a simulation, where it is known: it struck something else.
    StruckOther,
    /// The calibration ended before it was looked at.
    NotLookedAt,
}

impl Reason {
    /// All, by their numbers.
    pub const ALL: [Self; 10] = [
        Self::Used,
        Self::OutsideTrajectory,
        Self::NoFace,
        Self::OutsideOutline,
        Self::Ambiguous,
        Self::Obstacle,
        Self::Unseen,
        Self::GrossError,
        Self::StruckOther,
        Self::NotLookedAt,
    ];

    /// As a reader sees it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Used => "used",
            Self::OutsideTrajectory => "outside the trajectory",
            Self::NoFace => "no face within the gate",
            Self::OutsideOutline => "outside outline",
            Self::Ambiguous => "ambiguous",
            Self::Obstacle => "on an obstacle",
            Self::Unseen => "on a plane that the scanner did not see",
            Self::GrossError => "gross error",
            Self::StruckOther => "hit another surface",
            Self::NotLookedAt => "not looked at",
        }
    }

    /// What a row holds that is not tied for this reason.
    #[must_use]
    pub(super) const fn code(self) -> u16 {
        UNTIED + self as u16
    }
}

/// From here on a row's number is that of a reason; below it is that of a face.
const UNTIED: u16 = u16::MAX - 31;

/// What a row holds of which this was found.
pub(super) fn code(verdict: Option<Verdict>) -> u16 {
    match verdict {
        Some(Verdict::Tie(face)) => face.min(UNTIED - 1),
        Some(Verdict::NoFace) => Reason::NoFace.code(),
        Some(Verdict::OutsideOutline) => Reason::OutsideOutline.code(),
        Some(Verdict::Ambiguous) => Reason::Ambiguous.code(),
        Some(Verdict::Obstacle) => Reason::Obstacle.code(),
        None => Reason::OutsideTrajectory.code(),
    }
}

/// The row of every tie with a number divisible by this is noted, so that a tie is found by its number.
const STEP: usize = 8;

/// Ties of one sensor and what became of the other rows. Copies share their rows until one is changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TieSet {
    /// Of each row its face, or why it has none; empty where none was looked at.
    codes: Arc<Vec<u16>>,
    /// Row of every [`STEP`]-th tie; of a thinned set of every tie.
    marks: Arc<Vec<u32>>,
    /// Number of ties.
    count: usize,
    /// Whether only the rows of `marks` are tied.
    thin: bool,
}

impl TieSet {
    /// Of what became of each row ([`code`]).
    #[must_use]
    pub(super) fn of_codes(codes: Vec<u16>) -> Self {
        let mut set = Self {
            codes: Arc::new(codes),
            ..Self::default()
        };
        set.mark();
        set
    }

    /// Of ties in order of their rows among so many rows, the others not looked at.
    #[must_use]
    pub fn of_ties(rows: usize, ties: impl IntoIterator<Item = Tie>) -> Self {
        let mut codes = vec![Reason::NotLookedAt.code(); rows];
        for tie in ties {
            codes[tie.row as usize] = tie.face;
        }
        Self::of_codes(codes)
    }

    /// Notes where the ties are.
    fn mark(&mut self) {
        let (mut marks, mut count) = (vec![], 0);
        for (row, code) in self.codes.iter().enumerate() {
            if *code < UNTIED {
                if count % STEP == 0 {
                    marks.push(row as u32);
                }
                count += 1;
            }
        }
        marks.shrink_to_fit();
        (self.marks, self.count, self.thin) = (Arc::new(marks), count, false);
    }

    /// Number of ties.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether nothing is tied.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether no row was looked at.
    #[must_use]
    pub fn is_blank(&self) -> bool {
        self.codes.is_empty()
    }

    /// The ties in order of their rows.
    #[must_use]
    pub fn iter(&self) -> Ties<'_> {
        self.from(0)
    }

    /// The ties from the `k`-th on.
    #[must_use]
    pub fn from(&self, k: usize) -> Ties<'_> {
        if self.thin {
            let rows = self.marks.get(k..).unwrap_or_default();
            return Ties::Thin(&self.codes, rows.iter());
        }
        let Some(row) = self.marks.get(k / STEP) else {
            return Ties::Rows(&self.codes, self.codes.len());
        };
        let mut ties = Ties::Rows(&self.codes, *row as usize);
        for _ in 0..k % STEP {
            ties.next();
        }
        ties
    }

    /// The ties from a row on.
    #[must_use]
    pub(super) fn beginning_at(&self, row: usize) -> Ties<'_> {
        if self.thin {
            let first = self.marks.partition_point(|mark| (*mark as usize) < row);
            return self.from(first);
        }
        Ties::Rows(&self.codes, row)
    }

    /// The `k`-th tie.
    #[must_use]
    #[inline]
    pub fn get(&self, k: usize) -> Option<Tie> {
        self.from(k).next()
    }

    /// What every row holds, as the start of another association.
    pub(super) fn codes(&self) -> Vec<u16> {
        self.codes.to_vec()
    }

    /// Number of rows tied here but not there, or to another face.
    #[must_use]
    pub fn changed_from(&self, other: &Self) -> usize {
        let (mut here, mut there, mut same) = (self.iter(), other.iter(), 0);
        let (mut a, mut b) = (here.next(), there.next());
        while let (Some(x), Some(y)) = (a, b) {
            same += usize::from(x == y);
            if x.row <= y.row {
                a = here.next();
            }
            if y.row <= x.row {
                b = there.next();
            }
        }
        self.count.max(other.count) - same
    }

    /// At most `most` of the ties, evenly chosen.
    #[must_use]
    pub fn thinned(&self, most: usize) -> Self {
        let stride = self.count.div_ceil(most).max(1);
        let rows: Vec<u32> = self.iter().step_by(stride).map(|tie| tie.row).collect();
        Self {
            codes: self.codes.clone(),
            count: rows.len(),
            marks: Arc::new(rows),
            thin: true,
        }
    }

    /// What became of a row.
    #[must_use]
    pub fn reason(&self, row: usize) -> Reason {
        let code = self.codes.get(row).copied();
        let reason = code.map_or(Reason::NotLookedAt as usize, number);
        Reason::ALL.get(reason).copied().unwrap_or(Reason::Used)
    }

    /// Rows that were looked at and are not tied, by reason.
    #[must_use]
    pub fn rejected(&self) -> BTreeMap<Reason, u64> {
        let mut counts = [0; Reason::ALL.len()];
        for code in self.codes.iter() {
            counts[number(*code)] += 1;
        }
        let all = Reason::ALL.into_iter().zip(counts);
        all.filter(|(reason, n)| *reason != Reason::Used && *n > 0)
            .collect()
    }

    /// Leaves out ties that are not to be kept, and notes why.
    pub(super) fn retain(&mut self, why: Reason, mut keep: impl FnMut(&Tie) -> bool) {
        let out: Vec<u32> = self
            .iter()
            .filter(|tie| !keep(tie))
            .map(|tie| tie.row)
            .collect();
        if out.is_empty() {
            return;
        }
        let codes = Arc::make_mut(&mut self.codes);
        out.iter().for_each(|row| codes[*row as usize] = why.code());
        if self.thin {
            let codes = &self.codes;
            let marks = Arc::make_mut(&mut self.marks);
            marks.retain(|row| codes[*row as usize] < UNTIED);
            self.count = marks.len();
        } else {
            self.mark();
        }
    }

    /// Leaves out ties to a face that the observation did not strike, where that is known.
    pub(super) fn keep_true(&mut self, struck: Option<&[u16]>) {
        let Some(struck) = struck else { return };
        self.retain(Reason::StruckOther, |t| struck[t.row as usize] == t.face);
    }

    /// Number of ties on faces that `keep`.
    #[must_use]
    pub fn count(&self, keep: impl Fn(usize) -> bool) -> usize {
        self.iter().filter(|t| keep(t.face as usize)).count()
    }

    /// Number of ties on each of so many faces.
    #[must_use]
    pub(super) fn by_face(&self, faces: usize) -> Vec<usize> {
        let mut counts = vec![0; faces];
        self.iter().for_each(|tie| counts[tie.face as usize] += 1);
        counts
    }
}

/// Number of the reason that a row holds; that of a tied one is 0.
fn number(code: u16) -> usize {
    usize::from(code.saturating_sub(UNTIED))
}

impl<'a> IntoIterator for &'a TieSet {
    type Item = Tie;
    type IntoIter = Ties<'a>;

    fn into_iter(self) -> Ties<'a> {
        self.iter()
    }
}

/// Ties in order of their rows.
#[derive(Clone, Debug)]
pub enum Ties<'a> {
    /// The tied ones of all rows, and the next row.
    Rows(&'a [u16], usize),
    /// Those of chosen rows.
    Thin(&'a [u16], std::slice::Iter<'a, u32>),
}

impl Iterator for Ties<'_> {
    type Item = Tie;

    #[inline]
    fn next(&mut self) -> Option<Tie> {
        match self {
            Self::Rows(codes, next) => loop {
                let (row, face) = (*next as u32, *codes.get(*next)?);
                *next += 1;
                if face < UNTIED {
                    return Some(Tie { row, face });
                }
            },
            Self::Thin(codes, rows) => {
                let row = *rows.next()?;
                let face = *codes.get(row as usize)?;
                Some(Tie { row, face })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(pairs: &[(u32, u16)]) -> TieSet {
        TieSet::of_ties(40, pairs.iter().map(|&(row, face)| Tie { row, face }))
    }

    #[test]
    fn changes_are_counted_in_rows() {
        let before = set(&[(1, 0), (2, 0), (5, 1)]);
        assert_eq!(before.changed_from(&before), 0);
        assert_eq!(set(&[(1, 0), (2, 3), (5, 1)]).changed_from(&before), 1);
        assert_eq!(
            set(&[(1, 0), (5, 1), (6, 1), (7, 1)]).changed_from(&before),
            2
        );
    }

    #[test]
    fn ties_are_found_by_number_and_by_row_and_left_out_with_a_reason() {
        let pairs: Vec<(u32, u16)> = (0..19).map(|k| (2 * k + 1, k as u16 % 5)).collect();
        let mut all = set(&pairs);
        for (k, &(row, face)) in pairs.iter().enumerate() {
            assert_eq!(all.get(k), Some(Tie { row, face }));
            assert_eq!(all.beginning_at(row as usize).next(), all.get(k));
            assert_eq!(all.from(k).count(), 19 - k);
        }
        assert_eq!((all.get(19), all.len()), (None, 19));
        let thin = all.thinned(7);
        assert_eq!((thin.len(), thin.get(6)), (7, all.get(18)));
        assert_eq!(thin.beginning_at(8).next(), all.get(6));
        all.retain(Reason::GrossError, |tie| tie.row != 17);
        assert_eq!(
            (all.len(), all.get(8)),
            (18, Some(Tie { row: 19, face: 4 }))
        );
        assert_eq!(all.reason(17), Reason::GrossError);
        assert_eq!(
            (all.reason(19), all.reason(0)),
            (Reason::Used, Reason::NotLookedAt)
        );
        assert_eq!(all.rejected()[&Reason::NotLookedAt], 21);
        assert_eq!(all.by_face(5), [4, 4, 4, 3, 3]);
    }
}
