//! From bytes to records: framing, checksums, finding the next record after damage.

use std::io::Read;

use super::summary::Losses;
use super::window::Window;
use crate::formats::error::FormatError;

/// What a whole frame turns out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// A record whose checksum holds, or that has none.
    Good,
    /// A record whose checksum is zero: not written.
    ZeroChecksum,
    /// Framed like a record, with a wrong checksum.
    BadChecksum,
    /// No record.
    Nothing,
}

/// How records of a format are framed.
pub trait Framing {
    /// Bytes that [`Self::length`] looks at.
    const HEAD: usize;

    /// Whether a record with a wrong checksum may be passed over whole: yes where an end mark confirms its length.
    const END_MARK: bool;

    /// Bytes of the record that begins here, if one may. Never 0, and bounded: so much memory is taken.
    fn length(&self, head: &[u8]) -> Option<usize>;

    /// Whether these bytes, as many as [`Self::length`] said, are a record.
    fn check(&self, record: &[u8]) -> Frame;
}

/// Hands every record to `each`, in order; counts what lies between them.
///
/// A record with a wrong checksum directly behind a good one is passed over whole where an end mark confirms its length; elsewhere
/// the search goes on byte by byte, and only a record that is good in itself ends it. Time is proportional to the file's length.
///
/// # Errors
/// [`FormatError`] when the source cannot be read, and what `each` returns.
pub fn scan<R: Read, F: Framing>(
    window: &mut Window<'_, R>,
    framing: &F,
    losses: &mut Losses,
    mut each: impl FnMut(&[u8], &mut Losses) -> Result<(), FormatError>,
) -> Result<(), FormatError> {
    let mut search = Search::default();
    loop {
        let head = window.fill(F::HEAD)?;
        if head.is_empty() {
            break;
        }
        let length = framing.length(head).filter(|n| *n > 0);
        let Some(length) = length else {
            search.pass(losses);
            window.advance(1);
            continue;
        };
        let bytes = window.fill(length)?;
        let Some(record) = bytes.get(..length) else {
            search.cut(losses);
            window.advance(1);
            continue;
        };
        match framing.check(record) {
            Frame::Nothing => {}
            Frame::BadChecksum if search.lost => {}
            Frame::BadChecksum => {
                losses.bad_checksums += 1;
                if F::END_MARK {
                    window.advance(length);
                    continue;
                }
            }
            frame => {
                losses.zero_checksums += u64::from(frame == Frame::ZeroChecksum);
                each(record, losses)?;
                search = Search::default();
                window.advance(length);
                continue;
            }
        }
        search.pass(losses);
        window.advance(1);
    }
    search.end(losses);
    Ok(())
}

/// Whether two records, one directly behind the other and both good in themselves, stand anywhere in these bytes: those of a file whose
/// beginning is damaged or cut off.
pub fn holds<F: Framing>(framing: &F, bytes: &[u8]) -> bool {
    let good = |at: usize| {
        let rest = bytes.get(at..)?;
        let length = framing.length(rest.get(..F::HEAD).unwrap_or(rest))?;
        let record = rest.get(..length)?;
        (framing.check(record) == Frame::Good).then_some(at + length)
    };
    (0..bytes.len()).any(|at| good(at).and_then(good).is_some())
}

/// The search for the next record.
#[derive(Debug, Default)]
struct Search {
    /// Whether bytes were passed over since the last record.
    lost: bool,
    /// Bytes passed over since a record that the end of the file cuts, if it stood directly behind a good one.
    since_cut: Option<u64>,
}

impl Search {
    fn pass(&mut self, losses: &mut Losses) {
        losses.skipped_bytes += 1;
        losses.skipped_places += u64::from(!self.lost);
        self.lost = true;
        if let Some(bytes) = &mut self.since_cut {
            *bytes += 1;
        }
    }

    fn cut(&mut self, losses: &mut Losses) {
        if !self.lost {
            self.since_cut = Some(0);
        }
        self.pass(losses);
    }

    /// What was passed over since a cut record, when nothing followed, is that record.
    fn end(&self, losses: &mut Losses) {
        if let Some(bytes) = self.since_cut {
            losses.skipped_bytes -= bytes;
            losses.skipped_places -= 1;
            losses.truncated_bytes += bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// `M`, length of the content, content, sum of the content.
    struct Toy;
    impl Framing for Toy {
        const HEAD: usize = 2;
        const END_MARK: bool = true;
        fn length(&self, head: &[u8]) -> Option<usize> {
            (head.len() >= 2 && head[0] == b'M').then(|| 3 + usize::from(head[1]))
        }
        fn check(&self, record: &[u8]) -> Frame {
            let (last, rest) = record.split_last().expect("three bytes");
            let sum = rest[2..].iter().fold(0u8, |s, b| s.wrapping_add(*b));
            match *last {
                sum_there if sum_there == sum => Frame::Good,
                0 => Frame::ZeroChecksum,
                _ => Frame::BadChecksum,
            }
        }
    }

    fn found(bytes: &[u8]) -> (Vec<Vec<u8>>, Losses) {
        let (mut records, mut losses) = (vec![], Losses::default());
        let mut window = Window::new(Path::new("toy"), bytes);
        scan(&mut window, &Toy, &mut losses, |r, _| {
            records.push(r.to_vec());
            Ok(())
        })
        .expect("readable");
        let kept: usize = records.iter().map(Vec::len).sum();
        let lost = losses.skipped_bytes + losses.truncated_bytes;
        assert!(kept as u64 + lost <= bytes.len() as u64);
        (records, losses)
    }

    const A: &[u8] = &[b'M', 2, 5, 6, 11];
    const B: &[u8] = &[b'M', 1, 7, 7];

    #[test]
    fn garbage_between_records_is_counted() {
        let (records, losses) = found(&[A, &[9, b'M', 200, 3], B].concat());
        assert_eq!(records, [A, B]);
        assert_eq!((losses.skipped_bytes, losses.skipped_places), (4, 1));
        assert_eq!(losses.truncated_bytes, 0);
    }

    #[test]
    fn a_cut_record_is_told_from_garbage() {
        let (records, losses) = found(&[A, B, &A[..3]].concat());
        assert_eq!(records, [A, B]);
        assert_eq!((losses.truncated_bytes, losses.skipped_bytes), (3, 0));
    }

    #[test]
    fn two_good_records_in_a_row_are_found_behind_anything() {
        let garbage: &[u8] = &[9, b'M', 200, 3];
        assert!(holds(&Toy, &[garbage, A, B, &A[..3]].concat()));
        assert!(!holds(&Toy, &[garbage, A, garbage, B].concat()));
        assert!(!holds(&Toy, &[A, &B[..3]].concat()));
        assert!(!holds(&Toy, &[]));
    }

    #[test]
    fn a_wrong_checksum_loses_one_record_and_a_zero_none() {
        let (records, losses) = found(&[A, &[b'M', 1, 7, 8], &[b'M', 1, 7, 0], B].concat());
        assert_eq!(records, [A, &[b'M', 1, 7, 0], B]);
        assert_eq!((losses.bad_checksums, losses.zero_checksums), (1, 1));
    }
}
