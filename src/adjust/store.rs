//! Where the factor of a chain is kept: page by page in memory or in a file without name, or nowhere when nobody will ask for it.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use super::error::AdjustError;
use super::factor::Factor;
use super::large::Large;

/// Numbers that are turned into bytes at a time.
const CHUNK: usize = 4096;
/// Bytes of a number.
const BYTES: usize = 8;

/// Where pages are kept.
#[derive(Debug)]
pub(super) enum Store {
    /// In memory.
    Memory,
    /// In a file.
    File(Spill),
    /// Nowhere: only the reduced system is wanted.
    Nowhere,
}

impl Store {
    /// The store for a factor of so many bytes; an old file is used again.
    pub(super) fn of_size(
        bytes: u64,
        large: &Large,
        old: Option<Store>,
    ) -> Result<Store, AdjustError> {
        if bytes <= large.factor_memory {
            return Ok(Store::Memory);
        }
        match old {
            Some(Store::File(spill)) => Ok(Store::File(spill.emptied())),
            _ => Ok(Store::File(Spill::new(large.spill.as_deref())?)),
        }
    }

    /// Keeps a page; returns its memory where that is free again.
    pub(super) fn keep(
        &self,
        page: Factor,
        shelf: &mut Vec<Page>,
    ) -> Result<Option<Factor>, AdjustError> {
        match self {
            Store::Memory => {
                shelf.push(Page::Memory(page));
                return Ok(None);
            }
            Store::File(spill) => shelf.push(Page::File {
                place: spill.write(&page)?,
                size: page.size,
                width: page.width,
                epochs: page.epochs.clone(),
            }),
            Store::Nowhere => {}
        }
        Ok(Some(page))
    }
}

/// The factor of some epochs.
#[derive(Debug)]
pub(super) enum Page {
    /// In memory.
    Memory(Factor),
    /// In the file of the store.
    File {
        /// First byte.
        place: u64,
        /// Compiled state size.
        size: usize,
        /// Columns beside the states.
        width: usize,
        /// The epochs.
        epochs: Range<usize>,
    },
}

impl Page {
    fn epochs(&self) -> &Range<usize> {
        match self {
            Page::Memory(factor) => &factor.epochs,
            Page::File { epochs, .. } => epochs,
        }
    }

    /// Its memory, to be used again.
    pub(super) fn memory(self) -> Option<Factor> {
        match self {
            Page::Memory(factor) => Some(factor),
            Page::File { .. } => None,
        }
    }
}

/// Reads the pages of a stretch of epochs, one at a time.
pub(super) struct Reader<'a> {
    store: &'a Store,
    pages: &'a [Page],
    open: usize,
    /// The open page where it came from a file.
    loaded: Factor,
}

impl<'a> Reader<'a> {
    pub(super) fn new(store: &'a Store, pages: &'a [Page]) -> Self {
        Reader {
            store,
            pages,
            open: pages.len(),
            loaded: Factor::default(),
        }
    }

    /// Number of pages.
    pub(super) fn len(&self) -> usize {
        self.pages.len()
    }

    /// Opens a page.
    pub(super) fn open(&mut self, page: usize) -> Result<&Factor, AdjustError> {
        if let (
            Page::File {
                place,
                size,
                width,
                epochs,
            },
            Store::File(spill),
        ) = (&self.pages[page], self.store)
        {
            let memory = std::mem::take(&mut self.loaded);
            self.loaded = memory.sized(*size, *width, epochs.clone());
            spill.read(*place, &mut self.loaded)?;
        }
        self.open = page;
        Ok(self.page())
    }

    /// Opens the page with an epoch unless it is open.
    pub(super) fn open_at(&mut self, epoch: usize) -> Result<(), AdjustError> {
        let open = self.pages.get(self.open);
        if open.is_none_or(|page| !page.epochs().contains(&epoch)) {
            let page = self
                .pages
                .partition_point(|page| page.epochs().end <= epoch);
            self.open(page)?;
        }
        Ok(())
    }

    /// The open page.
    pub(super) fn page(&self) -> &Factor {
        match &self.pages[self.open] {
            Page::Memory(factor) => factor,
            Page::File { .. } => &self.loaded,
        }
    }
}

/// A file without name: it is gone when the program ends, however that ends.
#[derive(Debug)]
pub(super) struct Spill {
    /// The file, and where its next page goes.
    file: Mutex<(File, u64)>,
    folder: String,
}

impl Spill {
    fn new(folder: Option<&Path>) -> Result<Self, AdjustError> {
        let place = folder.map_or_else(std::env::temp_dir, Path::to_owned);
        let folder = place.display().to_string();
        match tempfile::tempfile_in(&place) {
            Ok(file) => Ok(Self::over(file, folder)),
            Err(error) => Err(AdjustError::NoSpill {
                what: "open a file",
                folder,
                why: error.to_string(),
            }),
        }
    }

    fn over(file: File, folder: String) -> Self {
        Spill {
            file: Mutex::new((file, 0)),
            folder,
        }
    }

    /// The same, to be written from its begin.
    fn emptied(self) -> Self {
        let (file, _) = (self.file.into_inner()).unwrap_or_else(PoisonError::into_inner);
        Self::over(file, self.folder)
    }

    /// Appends a page; returns its place.
    fn write(&self, page: &Factor) -> Result<u64, AdjustError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, end) = &mut *file;
        let place = *end;
        match written(file, place, page.parts()) {
            Ok(bytes) => *end += bytes,
            Err(error) => return Err(self.fault("write", &error)),
        }
        Ok(place)
    }

    fn read(&self, place: u64, page: &mut Factor) -> Result<(), AdjustError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        read(&mut file.0, place, page.parts_mut()).map_err(|error| self.fault("read", &error))
    }

    fn fault(&self, what: &'static str, error: &io::Error) -> AdjustError {
        AdjustError::NoSpill {
            what,
            folder: self.folder.clone(),
            why: error.to_string(),
        }
    }
}

/// Writes numbers, least significant byte first; returns how many bytes.
fn written(file: &mut File, place: u64, parts: [&[f64]; 2]) -> io::Result<u64> {
    file.seek(SeekFrom::Start(place))?;
    let (mut bytes, mut count) = ([0; CHUNK * BYTES], 0);
    for numbers in parts.into_iter().flat_map(|part| part.chunks(CHUNK)) {
        for (out, number) in bytes.as_chunks_mut::<BYTES>().0.iter_mut().zip(numbers) {
            *out = number.to_le_bytes();
        }
        let bytes = &bytes[..numbers.len() * BYTES];
        file.write_all(bytes)?;
        count += bytes.len() as u64;
    }
    Ok(count)
}

fn read(file: &mut File, place: u64, parts: [&mut [f64]; 2]) -> io::Result<()> {
    file.seek(SeekFrom::Start(place))?;
    let mut bytes = [0; CHUNK * BYTES];
    for numbers in parts.into_iter().flat_map(|part| part.chunks_mut(CHUNK)) {
        let bytes = &mut bytes[..numbers.len() * BYTES];
        file.read_exact(bytes)?;
        for (number, bytes) in numbers.iter_mut().zip(bytes.as_chunks::<BYTES>().0) {
            *number = f64::from_le_bytes(*bytes);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(first: usize, value: f64) -> Factor {
        let mut page = Factor::default().sized(3, 5, first..first + 40);
        for (i, x) in page.parts_mut().into_iter().flatten().enumerate() {
            *x = value / (i as f64 + 1.0);
        }
        page
    }

    #[test]
    fn pages_come_back_as_they_went() {
        let folder = tempfile::tempdir().unwrap();
        let large = Large {
            factor_memory: 100,
            spill: Some(folder.path().to_owned()),
            ..Large::default()
        };
        let mut shelf = Vec::new();
        let store = Store::of_size(101, &large, None).unwrap();
        assert!(matches!(store, Store::File(_)));
        for k in 0..3 {
            let memory = store.keep(page(40 * k, -7.3 + k as f64), &mut shelf);
            assert!(memory.unwrap().is_some());
        }
        let mut reader = Reader::new(&store, &shelf);
        for k in [2, 0, 1] {
            reader.open_at(40 * k + 39).unwrap();
            assert_eq!(reader.page().epochs, 40 * k..40 * k + 40);
            assert_eq!(reader.page().parts(), page(0, -7.3 + k as f64).parts());
        }
        assert!(matches!(
            Store::of_size(100, &large, Some(store)).unwrap(),
            Store::Memory
        ));
    }

    /// What Linux says when the disk is full.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_told_in_a_sentence() {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let spill = Spill::over(full, "/scratch".to_owned());
        let error = Store::File(spill).keep(page(0, 1.0), &mut Vec::new());
        let text = error.unwrap_err().to_string();
        assert!(text.starts_with("cannot write in /scratch, where the adjustment keeps what exceeds its memory: No space left on device"), "{text}");
    }
}
