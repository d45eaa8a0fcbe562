//! Pages whose headers are held against their bytes before a decoder believes them: the decoders of the parquet crate (60.1) panic or
//! allocate without bound on headers that are wrong.

use parquet::basic::{Encoding, Type};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::schema::types::ColumnDescriptor;

/// The pages of a column chunk of numbers, checked.
pub(super) struct CheckedPages {
    pages: Box<dyn PageReader>,
    /// Bytes of a value.
    width: u64,
    /// Whether values may be null.
    optional: bool,
    dictionary: bool,
}

impl CheckedPages {
    pub(super) fn new(pages: Box<dyn PageReader>, column: &ColumnDescriptor) -> Self {
        let width = match column.physical_type() {
            Type::INT32 | Type::FLOAT => 4,
            _ => 8,
        };
        Self {
            pages,
            width,
            optional: column.max_def_level() > 0,
            dictionary: false,
        }
    }

    fn check(&mut self, page: &Page) -> Result<()> {
        match page {
            Page::DictionaryPage {
                buf, num_values, ..
            } => {
                self.dictionary = true;
                let needed = u64::from(*num_values) * self.width;
                wrong(
                    needed > buf.len() as u64,
                    "a dictionary longer than its page",
                )
            }
            Page::DataPage {
                encoding,
                def_level_encoding,
                ..
            } => {
                // the deprecated encoding's length is not checked by the decoder
                let levels = self.optional && *def_level_encoding != Encoding::RLE;
                wrong(levels, "definition levels of an encoding that is not RLE")?;
                self.check_encoding(*encoding)
            }
            Page::DataPageV2 {
                buf,
                encoding,
                def_levels_byte_len,
                rep_levels_byte_len,
                ..
            } => {
                let levels = u64::from(*def_levels_byte_len) + u64::from(*rep_levels_byte_len);
                wrong(levels > buf.len() as u64, "levels longer than their page")?;
                self.check_encoding(*encoding)
            }
        }
    }

    fn check_encoding(&self, encoding: Encoding) -> Result<()> {
        let indices = matches!(
            encoding,
            Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY
        );
        wrong(
            indices && !self.dictionary,
            "indices into a dictionary that is not there",
        )
    }
}

fn wrong(is: bool, what: &str) -> Result<()> {
    if is {
        return Err(ParquetError::General(what.to_owned()));
    }
    Ok(())
}

impl Iterator for CheckedPages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for CheckedPages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let page = self.pages.get_next_page()?;
        if let Some(page) = &page {
            self.check(page)?;
        }
        Ok(page)
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.pages.skip_next_page()
    }
}
