//! Faulty rows of a file of observations: all are counted, the first are shown; on demand few of them are left out.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::{FaultKind, FormatError, Place};

/// What to do with a row whose values cannot be: no number, or an impossible one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Invalid {
    /// It is an error.
    #[default]
    Error,
    /// It is left out and counted, up to [`MAX_DROPPED`] of the file.
    Drop,
}

impl Invalid {
    /// Whether it is what holds where a survey says nothing.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// Largest share of a file's rows that is left out: a file with more of them is damaged or of another kind.
pub const MAX_DROPPED: f64 = 0.05;

/// So many faulty rows are shown.
const SHOWN: usize = 3;

/// The faulty rows met so far.
#[derive(Debug)]
pub struct Faults {
    file: PathBuf,
    first: Vec<FormatError>,
    rows: usize,
    faulty: usize,
    only_values: bool,
}

impl Faults {
    /// None yet.
    #[must_use]
    pub fn of(file: &Path) -> Self {
        Self {
            file: file.to_owned(),
            first: vec![],
            rows: 0,
            faulty: 0,
            only_values: true,
        }
    }

    /// Counts a row. A row that was taken must have left nothing behind when it is faulty.
    ///
    /// # Errors
    /// The fault, when reading cannot go on past it.
    pub fn row(&mut self, taken: Result<(), FormatError>) -> Result<(), FormatError> {
        self.rows += 1;
        let Err(fault) = taken else {
            return Ok(());
        };
        let of_row = !matches!(fault.place, Place::File | Place::Header | Place::Byte(_));
        let value = fault.kind == FaultKind::BadValue;
        if !of_row || !(value || fault.kind == FaultKind::Order) {
            return Err(fault);
        }
        self.faulty += 1;
        self.only_values &= value;
        if self.first.len() < SHOWN {
            self.first.push(fault);
        }
        Ok(())
    }

    /// What became of faulty rows, in words; nothing where there are none. `invalid` is `None` for files of which no row may be missing.
    ///
    /// # Errors
    /// The first faults, and how many there are, unless all of them are left out.
    pub fn end(self, invalid: Option<Invalid>) -> Result<Option<String>, FormatError> {
        let mut faults = self.first.into_iter();
        let Some(first) = faults.next() else {
            return Ok(None);
        };
        let (faulty, rows) = (self.faulty, self.rows);
        let droppable = self.only_values && faulty as f64 <= MAX_DROPPED * rows as f64;
        if droppable && invalid == Some(Invalid::Drop) {
            let name = self.file.file_name().unwrap_or_default().to_string_lossy();
            let (place, found) = (&first.place, &first.found);
            let were = if faulty == 1 { "was" } else { "were" };
            return Ok(Some(format!(
                "{name}: {faulty} of {rows} rows {were} invalid and left out; the first: {place}: found {found}"
            )));
        }
        let mut others: Vec<FormatError> = faults.collect();
        let shown = 1 + others.len();
        let noun = if faulty == 1 { "row" } else { "rows" };
        let mut found = format!("{faulty} faulty {noun} of {rows}");
        if shown < faulty {
            found.push_str(&format!("; these are the first {shown}"));
        }
        let share = 100.0 * MAX_DROPPED;
        let expected = match (droppable, invalid) {
            (true, Some(_)) => {
                "none, or invalid = \"drop\" in the file's section, which leaves such rows out"
                    .to_owned()
            }
            (false, Some(Invalid::Drop)) if self.only_values => {
                format!("at most {share} %, which invalid = \"drop\" leaves out")
            }
            _ => "none".to_owned(),
        };
        if faulty > 1 || (droppable && invalid.is_some()) {
            let all = FormatError::new(first.kind, &self.file, Place::File, found, expected);
            others.push(all);
        }
        Err(first.with(others))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAME: &str = "some.csv";

    fn fault(line: u64, kind: FaultKind) -> Result<(), FormatError> {
        let place = Place::Line {
            line,
            column: "x_m".to_owned(),
        };
        Err(FormatError::new(
            kind,
            Path::new(NAME),
            place,
            "\"NaN\"",
            "a coordinate",
        ))
    }

    /// So many rows, of which every tenth line of the first `faulty` tens cannot be read.
    fn met(rows: u64, faulty: u64) -> Faults {
        let mut faults = Faults::of(Path::new(NAME));
        for line in 1..=rows {
            let bad = line % 10 == 0 && line <= 10 * faulty;
            let taken = if bad {
                fault(line, FaultKind::BadValue)
            } else {
                Ok(())
            };
            faults.row(taken).expect("reading goes on");
        }
        faults
    }

    #[test]
    fn all_are_counted_and_three_are_shown() {
        let said = met(1000, 7).end(Some(Invalid::Error)).expect_err("faulty");
        let said = said.to_string();
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines.len(), 4, "{said}");
        assert!(lines[2].starts_with("some.csv: line 30, column x_m: found \"NaN\""));
        assert!(lines[3].contains("7 faulty rows of 1000; these are the first 3"));
        assert!(lines[3].contains("invalid = \"drop\""), "{said}");
        let whole = met(1000, 7).end(None).expect_err("faulty").to_string();
        assert!(!whole.contains("drop"), "{whole}");
    }

    #[test]
    fn a_few_are_left_out_on_demand() {
        let note = met(1000, 50).end(Some(Invalid::Drop)).expect("5 %");
        let note = note.expect("a note");
        assert!(
            note.starts_with("some.csv: 50 of 1000 rows were invalid"),
            "{note}"
        );
        let said = met(1000, 51).end(Some(Invalid::Drop)).expect_err("more");
        assert!(said.to_string().contains("at most 5 %"), "{said}");
        assert_eq!(met(1000, 0).end(Some(Invalid::Drop)), Ok(None));
    }

    #[test]
    fn times_out_of_order_are_not_left_out() {
        let mut faults = met(1000, 1);
        faults.row(fault(1001, FaultKind::Order)).expect("goes on");
        let said = faults.end(Some(Invalid::Drop)).expect_err("an order");
        assert!(said.to_string().ends_with("expected none"), "{said}");
    }

    #[test]
    fn a_file_that_ends_early_ends_reading() {
        let mut faults = met(10, 0);
        let end = FormatError::new(FaultKind::Truncated, Path::new(NAME), Place::File, "x", "y");
        assert_eq!(faults.row(Err(end.clone())), Err(end));
    }
}
