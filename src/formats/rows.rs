//! A table of numbers read row by row, whatever the file's format, so that a reader checks its rows in one place.

use std::path::Path;

use super::error::{FaultKind, FormatError, Place};
use super::faults::{Faults, Invalid};
use super::table::Limits;
use super::week;

/// A table being read row by row; columns are counted in the order in which the reader named them.
pub trait Rows {
    /// The file, for messages.
    fn file(&self) -> &Path;

    /// Goes to the next row; `false` at the end.
    ///
    /// # Errors
    /// [`FormatError`] when reading fails or the row is damaged.
    fn next_row(&mut self) -> Result<bool, FormatError>;

    /// The number in a column of this row.
    ///
    /// # Errors
    /// [`FormatError`] when it is not a number or outside the limits.
    fn number(&self, column: usize, limits: &Limits) -> Result<f64, FormatError>;

    /// The whole number in a column of this row.
    ///
    /// # Errors
    /// [`FormatError`] when it is none or does not fit 32 bits.
    fn count(&self, column: usize) -> Result<u32, FormatError>;

    /// A fault in a column of this row.
    fn fault(&self, kind: FaultKind, column: usize, found: String, expected: &str) -> FormatError;

    /// The error that this row's value in a column is not what was expected.
    fn bad_value(&self, column: usize, expected: &str) -> FormatError;

    /// The error that the table holds no row.
    fn no_rows(&self) -> FormatError;

    /// Takes every row with `take`, which leaves nothing behind of a row that it refuses; gives back what became of faulty rows, in words.
    /// `invalid` is `None` for files of which no row may be missing.
    ///
    /// # Errors
    /// [`FormatError`] when reading fails, no row is there, or faulty ones are not left out ([`Faults::end`]).
    fn each(
        &mut self,
        invalid: Option<Invalid>,
        mut take: impl FnMut(&Self) -> Result<(), FormatError>,
    ) -> Result<Option<String>, FormatError>
    where
        Self: Sized,
    {
        let mut faults = Faults::of(self.file());
        let mut any = false;
        loop {
            match self.next_row() {
                Ok(false) => break,
                Ok(true) => faults.row(take(self))?,
                // a line that is no row of the table; reading goes on behind it
                Err(fault) if matches!(fault.place, Place::Line { .. }) => {
                    faults.row(Err(fault))?;
                }
                Err(fault) => return Err(fault),
            }
            any = true;
        }
        if any {
            faults.end(invalid)
        } else {
            Err(self.no_rows())
        }
    }

    /// The time in a column, seconds, which follows the one before: strictly, or not descending; counted on at the end of a GPS week.
    ///
    /// # Errors
    /// [`FormatError`] when it is no number, or of kind `Order`.
    fn time(&self, column: usize, before: Option<f64>, strict: bool) -> Result<f64, FormatError> {
        let time_s = week::following(before, self.number(column, &Limits::FINITE)?);
        match before {
            Some(t) if time_s < t || (strict && time_s == t) => {
                let found = if time_s == t {
                    format!("{time_s} a second time")
                } else {
                    format!("{time_s} after {t}")
                };
                let expected = if strict {
                    "strictly ascending times"
                } else {
                    "ascending times"
                };
                Err(self.fault(FaultKind::Order, column, found, expected))
            }
            _ => Ok(time_s),
        }
    }
}
