//! Soundings in a file without name, of which each thread holds the blocks that it looks at.
//!
//! A block holds 4096 rows in three parts, so that a pass reads what it asks for: the times; angles and ranges; ping and beam numbers.

use std::cell::RefCell;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use crate::files::spill::{Spill, SpillError, WORD};

/// Rows of a block.
const BLOCK: usize = 4096;
/// Words of a row in each part of a block.
const WIDTHS: [usize; 3] = [1, 3, 1];
const TIMES: usize = 0;
const MEASURED: usize = 1;
const NAMES: usize = 2;
/// Parts of blocks that a thread holds at a time.
const HELD: usize = 6;

/// What soundings may take in memory, and where they go beyond that.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Room {
    /// Bytes in memory.
    pub bytes: u64,
    /// Folder of the file; that of the system's temporary files where there is none.
    pub folder: Option<PathBuf>,
}

impl Room {
    /// What a sounding takes in memory, bytes.
    pub const SOUNDING: u64 = 40;

    /// Whether so many soundings stay in memory.
    #[must_use]
    pub fn holds(&self, soundings: usize) -> bool {
        soundings as u64 * Self::SOUNDING <= self.bytes
    }

    /// Begins the file.
    ///
    /// # Errors
    /// [`SpillError`] when no file can be made in the folder.
    pub fn writer(&self) -> Result<SoundingWriter, SpillError> {
        SoundingWriter::new(self.folder.as_deref())
    }
}

/// One sounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sounding {
    /// Time of the ping, seconds.
    pub time_s: f64,
    /// Ping number.
    pub ping: u32,
    /// Beam number within the ping.
    pub beam: u32,
    /// Across-track angle, radians.
    pub across_rad: f64,
    /// Along-track angle, radians.
    pub along_rad: f64,
    /// Range, metres, or two-way travel time, seconds.
    pub range: f64,
}

/// Soundings being written.
#[derive(Debug)]
pub struct SoundingWriter {
    spill: Spill,
    /// The rows that are not yet in the file, by part.
    open: [Vec<u64>; 3],
    rows: usize,
}

impl SoundingWriter {
    /// Begins a file in a folder; in that of the system's temporary files where there is none.
    ///
    /// # Errors
    /// [`SpillError`] when no file can be made there.
    pub fn new(folder: Option<&Path>) -> Result<Self, SpillError> {
        Ok(Self::over(Spill::new(folder)?))
    }

    /// Over an open file.
    #[must_use]
    pub fn over(spill: Spill) -> Self {
        Self {
            spill,
            open: WIDTHS.map(|width| Vec::with_capacity(width * BLOCK)),
            rows: 0,
        }
    }

    /// Adds a sounding.
    ///
    /// # Errors
    /// [`SpillError`]: the disk is full, for one.
    pub fn push(&mut self, row: &Sounding) -> Result<(), SpillError> {
        let measured = [row.across_rad, row.along_rad, row.range];
        self.open[TIMES].push(row.time_s.to_bits());
        self.open[MEASURED].extend(measured.map(f64::to_bits));
        self.open[NAMES].push(u64::from(row.ping) << 32 | u64::from(row.beam));
        self.rows += 1;
        if self.rows.is_multiple_of(BLOCK) {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SpillError> {
        let words = self.open.iter().zip(WIDTHS).flat_map(|(part, width)| {
            let missing = std::iter::repeat_n(0, width * BLOCK - part.len());
            part.iter().copied().chain(missing)
        });
        self.spill.append(words)?;
        self.open.iter_mut().for_each(Vec::clear);
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn finish(mut self) -> Result<SoundingFile, SpillError> {
        if !self.open[TIMES].is_empty() {
            self.flush()?;
        }
        static FILES: AtomicU64 = AtomicU64::new(0);
        let file = Written {
            spill: self.spill,
            number: FILES.fetch_add(1, Ordering::Relaxed),
            fault: OnceLock::new(),
        };
        Ok(SoundingFile {
            file: Arc::new(file),
            rows: self.rows,
            offset_s: 0.0,
        })
    }
}

#[derive(Debug)]
struct Written {
    spill: Spill,
    /// Tells its blocks from those of other files.
    number: u64,
    /// The first reading that failed.
    fault: OnceLock<SpillError>,
}

/// Soundings in a file without name. Copies share the file.
#[derive(Clone, Debug)]
pub struct SoundingFile {
    file: Arc<Written>,
    rows: usize,
    /// What is added to the times, seconds.
    offset_s: f64,
}

impl PartialEq for SoundingFile {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.file, &other.file) && self.offset_s == other.offset_s
    }
}

/// A part of a block that a thread holds.
struct Part {
    /// File, block, part.
    of: (u64, usize, usize),
    words: Vec<u64>,
}

thread_local! {
    /// The parts that this thread holds, and which of them the next one takes the place of.
    static PARTS: RefCell<(Vec<Part>, usize)> = const { RefCell::new((Vec::new(), 0)) };
}

impl SoundingFile {
    /// Number of soundings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    /// The same with another clock: `offset_s` is added to every time.
    #[must_use]
    pub fn shifted(self, offset_s: f64) -> Self {
        Self { offset_s, ..self }
    }

    /// The first reading that failed: whatever was made of the soundings since is worth nothing.
    #[must_use]
    pub fn fault(&self) -> Option<&SpillError> {
        self.file.fault.get()
    }

    /// Time of sounding `k`, seconds; not a number where it cannot be read.
    #[must_use]
    #[inline]
    pub fn time_s(&self, k: usize) -> f64 {
        let time_s = self
            .words::<1>(TIMES, k)
            .map_or(f64::NAN, |[time]| f64::from_bits(time));
        if self.offset_s == 0.0 {
            time_s
        } else {
            time_s + self.offset_s
        }
    }

    /// Across-track angle, along-track angle (radians) and range of sounding `k`; not numbers where they cannot be read.
    #[must_use]
    #[inline]
    pub fn measured(&self, k: usize) -> [f64; 3] {
        let words = self.words::<3>(MEASURED, k);
        words.map_or([f64::NAN; 3], |words| words.map(f64::from_bits))
    }

    /// Ping and beam number of sounding `k`; zero where they cannot be read.
    #[must_use]
    pub fn name(&self, k: usize) -> (u32, u32) {
        let [name] = self.words::<1>(NAMES, k).unwrap_or([0]);
        ((name >> 32) as u32, name as u32)
    }

    /// The same without some rows, given as ascending ranges, in another file.
    ///
    /// # Errors
    /// [`SpillError`] when they cannot be read or written.
    pub fn without(&self, rows: &[Range<usize>], room: &Room) -> Result<Self, SpillError> {
        let mut writer = room.writer()?;
        let mut begin = 0;
        for left_out in rows.iter().chain([&(self.rows..self.rows)]) {
            for k in begin..left_out.start {
                writer.push(&self.row(k))?;
            }
            begin = left_out.end;
        }
        match self.fault() {
            Some(fault) => Err(fault.clone()),
            None => writer.finish(),
        }
    }

    /// Sounding `k`.
    #[must_use]
    pub fn row(&self, k: usize) -> Sounding {
        let ([across_rad, along_rad, range], (ping, beam)) = (self.measured(k), self.name(k));
        Sounding {
            time_s: self.time_s(k),
            ping,
            beam,
            across_rad,
            along_rad,
            range,
        }
    }

    /// The words of row `k` in a part of its block.
    #[inline]
    fn words<const W: usize>(&self, part: usize, k: usize) -> Option<[u64; W]> {
        if k >= self.rows {
            return None;
        }
        let (of, first) = ((self.file.number, k / BLOCK, part), k % BLOCK * W);
        PARTS.with_borrow_mut(|(parts, next)| {
            let place = match parts.iter().position(|held| held.of == of) {
                Some(place) => place,
                None => self.load(of, parts, next)?,
            };
            let words = parts[place].words.get(first..first + W)?;
            words.try_into().ok()
        })
    }

    /// Reads a part of a block into the memory of the one that was read longest ago.
    fn load(
        &self,
        of: (u64, usize, usize),
        parts: &mut Vec<Part>,
        next: &mut usize,
    ) -> Option<usize> {
        if parts.len() < HELD {
            *next = parts.len();
            parts.push(Part { of, words: vec![] });
        }
        let place = *next;
        *next = (place + 1) % HELD;
        let (_, block, part) = of;
        let before: usize = WIDTHS[..part].iter().sum();
        let first = (block * WIDTHS.iter().sum::<usize>() + before) * BLOCK;
        let held = &mut parts[place];
        // nothing of it can be taken for what is not read
        held.of = (u64::MAX, 0, 0);
        held.words.clear();
        let take = |word| held.words.push(word);
        let read = self
            .file
            .spill
            .read(first as u64 * WORD, WIDTHS[part] * BLOCK, take);
        if let Err(fault) = read {
            let _ = self.file.fault.set(fault);
            return None;
        }
        held.of = of;
        Some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(k: u32) -> Sounding {
        Sounding {
            time_s: 0.1 * f64::from(k),
            ping: k / 7,
            beam: u32::MAX - k,
            across_rad: -1.0 / (1.0 + f64::from(k)),
            along_rad: -0.0,
            range: f64::from(k).sqrt(),
        }
    }

    #[test]
    fn soundings_come_back_in_any_order_and_by_any_thread() {
        let file = |first: u32, rows: u32| {
            let mut writer = SoundingWriter::new(None).expect("a file");
            (first..first + rows).for_each(|k| writer.push(&row(k)).expect("written"));
            writer.finish().expect("a file")
        };
        let (long, short) = (file(0, 20_000), file(50_000, 10));
        assert_eq!((long.len(), short.len()), (20_000, 10));
        let look = |seed: u32| {
            for k in 0..20_000u32 {
                let k = k.wrapping_mul(7919).wrapping_add(seed) % 20_000;
                assert_eq!(long.row(k as usize), row(k));
                assert_eq!(short.row(k as usize % 10), row(50_000 + k % 10));
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(|| look(1));
            scope.spawn(|| look(2));
        });
        assert!(long.time_s(20_000).is_nan() && long.fault().is_none());
        let late = short.clone().shifted(0.3);
        assert_eq!(late.time_s(1), short.time_s(1) + 0.3);
        let room = Room {
            bytes: 0,
            folder: None,
        };
        let rest = long.without(&[3..5000, 19_000..20_000], &room);
        let rest = rest.expect("a file");
        assert_eq!(
            (rest.len(), rest.row(2), rest.row(3)),
            (14_003, row(2), row(5000))
        );
        assert_eq!(rest.row(14_002), row(18_999));
    }

    /// What Linux says when the disk is full.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_told_and_a_failed_reading_is_remembered() {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let spill = Spill::over(full.expect("the device"), "/scratch".to_owned());
        let mut writer = SoundingWriter::over(spill);
        writer.push(&row(1)).expect("not yet written");
        let told = writer.finish().unwrap_err().to_string();
        assert!(
            told.starts_with("cannot write in /scratch: No space left"),
            "{told}"
        );
        let null = std::fs::File::options().write(true).open("/dev/null");
        let spill = Spill::over(null.expect("the device"), "/scratch".to_owned());
        let mut writer = SoundingWriter::over(spill);
        writer.push(&row(1)).expect("written");
        let file = writer.finish().expect("a file");
        assert!(file.measured(0)[0].is_nan());
        assert_eq!(file.fault().map(|fault| fault.what), Some("read"));
    }
}
