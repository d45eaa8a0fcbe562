//! A file without name for what exceeds memory: it is gone when the program ends, however that ends.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Bytes of a word.
pub const WORD: u64 = 8;
/// Words that are turned into bytes at a time.
const CHUNK: usize = 4096;

/// Such a file, and where its next free place is. Several threads may write and read it.
#[derive(Debug)]
pub struct Spill {
    file: Mutex<(File, u64)>,
    folder: String,
}

/// What failed, where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot {what} in {folder}: {why}")]
pub struct SpillError {
    /// What was tried.
    pub what: &'static str,
    /// Folder of the file.
    pub folder: String,
    /// What the system says.
    pub why: String,
}

impl SpillError {
    /// What failed, where the folder is named besides.
    #[must_use]
    pub fn refused(&self) -> String {
        format!("{}: cannot {}", self.why, self.what)
    }
}

impl Spill {
    /// A new one in a folder; in that of the system's temporary files where there is none.
    ///
    /// # Errors
    /// [`SpillError`] when no file can be made there.
    pub fn new(folder: Option<&Path>) -> Result<Self, SpillError> {
        let place = folder.map_or_else(std::env::temp_dir, Path::to_owned);
        let folder = place.display().to_string();
        match tempfile::tempfile_in(&place) {
            Ok(file) => Ok(Self::over(file, folder)),
            Err(error) => Err(SpillError {
                what: "open a file",
                folder,
                why: error.to_string(),
            }),
        }
    }

    /// Over an open file; `folder` names it in messages.
    #[must_use]
    pub fn over(file: File, folder: String) -> Self {
        Self {
            file: Mutex::new((file, 0)),
            folder,
        }
    }

    /// The same, to be written from its begin.
    #[must_use]
    pub fn emptied(self) -> Self {
        let (file, _) = (self.file.into_inner()).unwrap_or_else(PoisonError::into_inner);
        Self::over(file, self.folder)
    }

    /// Writes words behind what is there, least significant byte first; returns their place.
    ///
    /// # Errors
    /// [`SpillError`]: the disk is full, for one. Nothing is kept then.
    pub fn append(&self, words: impl Iterator<Item = u64>) -> Result<u64, SpillError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, end) = &mut *file;
        let place = *end;
        match written(file, place, words) {
            Ok(bytes) => *end += bytes,
            Err(error) => return Err(self.fault("write", &error)),
        }
        Ok(place)
    }

    /// Reads `count` words from a place and hands them to `take`, one after the other.
    ///
    /// # Errors
    /// [`SpillError`] when the system cannot read them.
    pub fn read(
        &self,
        place: u64,
        count: usize,
        mut take: impl FnMut(u64),
    ) -> Result<(), SpillError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        read(&mut file.0, place, count, &mut take).map_err(|error| self.fault("read", &error))
    }

    fn fault(&self, what: &'static str, error: &io::Error) -> SpillError {
        SpillError {
            what,
            folder: self.folder.clone(),
            why: error.to_string(),
        }
    }
}

fn written(file: &mut File, place: u64, words: impl Iterator<Item = u64>) -> io::Result<u64> {
    file.seek(SeekFrom::Start(place))?;
    let (mut bytes, mut filled, mut count) = ([0; CHUNK * WORD as usize], 0, 0);
    for word in words {
        bytes[filled..filled + WORD as usize].copy_from_slice(&word.to_le_bytes());
        filled += WORD as usize;
        if filled == bytes.len() {
            file.write_all(&bytes)?;
            (count, filled) = (count + filled as u64, 0);
        }
    }
    file.write_all(&bytes[..filled])?;
    Ok(count + filled as u64)
}

fn read(file: &mut File, place: u64, count: usize, take: &mut impl FnMut(u64)) -> io::Result<()> {
    file.seek(SeekFrom::Start(place))?;
    let mut bytes = [0; CHUNK * WORD as usize];
    for start in (0..count).step_by(CHUNK) {
        let words = CHUNK.min(count - start);
        let bytes = &mut bytes[..words * WORD as usize];
        file.read_exact(bytes)?;
        for word in bytes.as_chunks().0 {
            take(u64::from_le_bytes(*word));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_back_from_their_places() {
        let spill = Spill::new(None).expect("a file");
        let words = |first: u64, count: u64| {
            (first..first + count).map(|k| k.wrapping_mul(0x9e37_79b9_7f4a_7c15))
        };
        let places = [(7, 10_000), (90_000, 3), (1, 4096)];
        let at = places.map(|(first, count)| spill.append(words(first, count)).expect("written"));
        for k in [2, 0, 1] {
            let (first, count) = places[k];
            let mut found = vec![];
            let read = spill.read(at[k], count as usize, |word| found.push(word));
            assert_eq!(read, Ok(()));
            assert!(found.into_iter().eq(words(first, count)));
        }
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = Spill::new(Some(Path::new("/no/such/folder"))).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("cannot open a file in /no/such/folder: "),
            "{text}"
        );
    }
}
