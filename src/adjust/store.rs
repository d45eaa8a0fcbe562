//! Where the factor of a chain is kept: page by page in memory or in a file without name, or nowhere when nobody will ask for it.

use std::ops::Range;

use super::error::AdjustError;
use super::factor::Factor;
use super::large::Large;
use crate::files::spill::{Spill, SpillError};

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
            _ => Ok(Store::File(
                Spill::new(large.spill.as_deref()).map_err(no_spill)?,
            )),
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
                place: spill.append(numbers(&page)).map_err(no_spill)?,
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
            read(spill, *place, &mut self.loaded)?;
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

/// The numbers of a page as words.
fn numbers(page: &Factor) -> impl Iterator<Item = u64> + '_ {
    page.parts().into_iter().flatten().map(|x| x.to_bits())
}

/// Fills a page from its place.
fn read(spill: &Spill, place: u64, page: &mut Factor) -> Result<(), AdjustError> {
    let count = page.parts().iter().map(|part| part.len()).sum();
    let mut parts = page.parts_mut().into_iter().flatten();
    let take = |word| {
        if let Some(number) = parts.next() {
            *number = f64::from_bits(word);
        }
    };
    spill.read(place, count, take).map_err(no_spill)
}

fn no_spill(error: SpillError) -> AdjustError {
    AdjustError::NoSpill {
        what: error.what,
        folder: error.folder,
        why: error.why,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

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
