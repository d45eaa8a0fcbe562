//! Reading a CSV table of numbers column by column: names in the first line, in any order, extra columns ignored. Columns stand apart by
//! commas, semicolons or tabs, whichever the first line has; beside semicolons or tabs a number may have a decimal comma.

use std::io::{Chain, Cursor, Read};
use std::path::{Path, PathBuf};

use csv::{ByteRecord, ReaderBuilder};

use super::error::{FaultKind, FormatError, Place, quoted};
use super::recorder::utc;
use super::rows::Rows;

/// What a column may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// In words, for the message.
    pub expected: &'static str,
}

impl Limits {
    /// Any finite number.
    pub const FINITE: Self = Self {
        min: f64::MIN,
        max: f64::MAX,
        expected: "a finite number",
    };

    /// Whether the value lies within; never for NaN.
    #[must_use]
    pub fn contain(&self, value: f64) -> bool {
        value >= self.min && value <= self.max
    }
}

/// Columns that may hold dates.
const TIMES: [&str; 3] = ["time_s", "from_s", "to_s"];

/// A file whose begin has been looked at.
type Begun<R> = Chain<Cursor<Vec<u8>>, R>;

/// Bytes that are looked at to tell the separator.
const LOOKED_AT: u64 = 1 << 16;

/// The separator of the columns, of a file that is text in UTF-8.
fn begun<R: Read>(file: &Path, mut source: R) -> Result<(u8, Begun<R>), FormatError> {
    let mut begin = vec![];
    (&mut source)
        .take(LOOKED_AT)
        .read_to_end(&mut begin)
        .map_err(|e| FormatError::unreadable(file, &e))?;
    if begin.starts_with(b"\xff\xfe") || begin.starts_with(b"\xfe\xff") {
        let (found, expected) = ("text in UTF-16", "text in UTF-8 (save it as \"CSV UTF-8\")");
        return Err(FormatError::new(
            FaultKind::BadValue,
            file,
            Place::File,
            found,
            expected,
        ));
    }
    let first = begin.split(|b| *b == b'\n').next().unwrap_or_default();
    let has = |separator: &u8| first.contains(separator);
    let separator = *b",;\t".iter().find(|s| has(s)).unwrap_or(&b',');
    Ok((separator, Cursor::new(begin).chain(source)))
}

/// A table being read row by row.
#[derive(Debug)]
pub struct Table<R> {
    file: PathBuf,
    reader: csv::Reader<Begun<R>>,
    separator: u8,
    header: ByteRecord,
    row: ByteRecord,
    names: Vec<&'static str>,
    fields: Vec<Option<usize>>,
    size: u64,
    expected_rows: usize,
}

impl<R: Read> Table<R> {
    /// Reads the header line; `file` and `size` (bytes) are for messages and for estimating the number of rows.
    ///
    /// # Errors
    /// [`FormatError`]: empty file, a required column missing or a known one there twice.
    pub fn open(
        file: &Path,
        source: R,
        size: u64,
        required: &[&'static str],
        optional: &[&'static str],
    ) -> Result<Self, FormatError> {
        let (separator, source) = begun(file, source)?;
        let mut reader = ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .buffer_capacity(1 << 18)
            .from_reader(source);
        let mut header = ByteRecord::new();
        if !reader
            .read_byte_record(&mut header)
            .map_err(|e| translate(file, &e, &header, separator))?
        {
            let expected = format!("a header line with {}", required.join(","));
            return Err(FormatError::new(
                FaultKind::Empty,
                file,
                Place::File,
                "an empty file",
                expected,
            ));
        }
        let names: Vec<_> = required.iter().chain(optional).copied().collect();
        let fields = names
            .iter()
            .enumerate()
            .map(|(k, name)| find(file, &header, name, k < required.len()))
            .collect::<Result<_, _>>()
            .map_err(|fault| with_the_others(fault, required))?;
        Ok(Self {
            file: file.to_owned(),
            reader,
            separator,
            header,
            row: ByteRecord::new(),
            names,
            fields,
            size,
            expected_rows: 0,
        })
    }

    /// Whether the optional column, counted on from the required ones, is there.
    #[must_use]
    pub fn has(&self, column: usize) -> bool {
        self.fields[column].is_some()
    }

    /// The error that none of these columns is there.
    #[must_use]
    pub fn missing(&self, names: &[&str]) -> FormatError {
        missing_column(&self.file, &self.header, names)
    }

    /// Reads the next row; `false` at the end.
    ///
    /// # Errors
    /// [`FormatError`] when the row has another number of fields than the header, or reading fails.
    pub fn next_row(&mut self) -> Result<bool, FormatError> {
        let read = self.reader.read_byte_record(&mut self.row);
        // whether or not the fields happen to be as many as the header's
        if self.row.as_slice().contains(&b'\n') {
            return Err(self.left_open());
        }
        let more = read.map_err(|e| translate(&self.file, &e, &self.row, self.separator))?;
        if more && self.expected_rows == 0 {
            let length = self.row.as_slice().len() + self.row.len();
            self.expected_rows = (self.size / length.max(2) as u64) as usize + 1;
        }
        Ok(more)
    }

    /// The error that a quotation mark swallows lines: of the file, not of a row, since nobody knows how many rows it hides.
    fn left_open(&self) -> FormatError {
        let place = Place::Line {
            line: self.row.position().map_or(0, csv::Position::line),
            column: String::new(),
        };
        let found = "a quotation mark that opens here and runs on over the next lines";
        let expected = "it closed on its line";
        FormatError::new(FaultKind::Truncated, &self.file, place, found, expected)
    }

    /// Estimated number of rows, known from the first row on.
    #[must_use]
    pub fn expected_rows(&self) -> usize {
        self.expected_rows
    }

    /// The number in a column of this row; `None` when the column is not there.
    ///
    /// # Errors
    /// [`FormatError`] when it is not a number or outside the limits.
    pub fn optional_number(
        &self,
        column: usize,
        limits: &Limits,
    ) -> Result<Option<f64>, FormatError> {
        let Some(field) = self.fields[column].and_then(|f| self.row.get(f)) else {
            return Ok(None);
        };
        match parse(field).or_else(|| self.with_decimal_comma(field)) {
            Some(value) if limits.contain(value) => Ok(Some(value)),
            None if is_date(field) && TIMES.contains(&self.names[column]) => {
                self.date(field, column)
            }
            _ => Err(self.bad_value(column, limits.expected)),
        }
    }

    /// Seconds since 1970 of a date with its time of day.
    fn date(&self, field: &[u8], column: usize) -> Result<Option<f64>, FormatError> {
        let text = std::str::from_utf8(field).unwrap_or_default();
        let unix_s = utc::from_iso(text.trim());
        let expected = match utc::in_leap_second(text.trim()) {
            true => {
                "a time outside a leap second, which the seconds of no other file count: leave the row out"
            }
            false => "seconds, or a time such as 2026-06-12T08:30:15.25Z",
        };
        unix_s
            .map(Some)
            .ok_or_else(|| self.bad_value(column, expected))
    }

    /// "1,5" as 1.5 where commas do not part columns.
    fn with_decimal_comma(&self, field: &[u8]) -> Option<f64> {
        if self.separator == b',' || field.contains(&b'.') {
            return None;
        }
        let dotted: Vec<u8> = field
            .iter()
            .map(|b| if *b == b',' { b'.' } else { *b })
            .collect();
        parse(&dotted)
    }

    /// The number in a required column of this row.
    ///
    /// # Errors
    /// [`FormatError`] when it is not a number or outside the limits.
    pub fn number(&self, column: usize, limits: &Limits) -> Result<f64, FormatError> {
        self.optional_number(column, limits)?
            .ok_or_else(|| self.bad_value(column, limits.expected))
    }

    /// The text in a column of this row, trimmed; empty when the column is not there.
    ///
    /// # Errors
    /// [`FormatError`] when it is no UTF-8.
    pub fn text(&self, column: usize) -> Result<&str, FormatError> {
        let field = self.fields[column].and_then(|f| self.row.get(f));
        std::str::from_utf8(field.unwrap_or_default().trim_ascii())
            .map_err(|_| self.bad_value(column, "UTF-8 text"))
    }

    /// The whole number in a required column of this row.
    ///
    /// # Errors
    /// [`FormatError`] when it is none or does not fit 32 bits.
    pub fn count(&self, column: usize) -> Result<u32, FormatError> {
        let field = self.fields[column].and_then(|f| self.row.get(f));
        field
            .and_then(whole)
            .ok_or_else(|| self.bad_value(column, "a whole number from 0 to 4294967295"))
    }

    /// The error that this row's value in a column is not what was expected.
    #[must_use]
    pub fn bad_value(&self, column: usize, expected: &str) -> FormatError {
        let field = self.fields[column]
            .and_then(|f| self.row.get(f))
            .unwrap_or_default();
        self.fault(FaultKind::BadValue, column, quoted(field), expected)
    }

    /// Line of this row in its file, counted from 1.
    #[must_use]
    pub fn line(&self) -> u64 {
        self.row.position().map_or(0, csv::Position::line)
    }

    /// A fault in a column of this row.
    #[must_use]
    pub fn fault(
        &self,
        kind: FaultKind,
        column: usize,
        found: String,
        expected: &str,
    ) -> FormatError {
        let place = Place::Line {
            line: self.line(),
            column: self.names[column].to_owned(),
        };
        FormatError::new(kind, &self.file, place, found, expected)
    }

    /// The error that a table holds no row.
    #[must_use]
    pub fn no_rows(&self) -> FormatError {
        FormatError::new(
            FaultKind::Empty,
            &self.file,
            Place::File,
            "a header line and nothing else",
            "at least one row",
        )
    }

    /// The time in a column, which follows the one before ([`Rows::time`]).
    ///
    /// # Errors
    /// [`FormatError`] when it is no number, or of kind `Order`.
    pub fn time(
        &self,
        column: usize,
        before: Option<f64>,
        strict: bool,
    ) -> Result<f64, FormatError> {
        Rows::time(self, column, before, strict)
    }
}

impl<R: Read> Rows for Table<R> {
    fn file(&self) -> &Path {
        &self.file
    }

    fn next_row(&mut self) -> Result<bool, FormatError> {
        Self::next_row(self)
    }

    fn number(&self, column: usize, limits: &Limits) -> Result<f64, FormatError> {
        Self::number(self, column, limits)
    }

    fn count(&self, column: usize) -> Result<u32, FormatError> {
        Self::count(self, column)
    }

    fn fault(&self, kind: FaultKind, column: usize, found: String, expected: &str) -> FormatError {
        Self::fault(self, kind, column, found, expected)
    }

    fn bad_value(&self, column: usize, expected: &str) -> FormatError {
        Self::bad_value(self, column, expected)
    }

    fn no_rows(&self) -> FormatError {
        Self::no_rows(self)
    }
}

/// A whole number, also where it is written "12.0".
fn whole(field: &[u8]) -> Option<u32> {
    let text = std::str::from_utf8(field.trim_ascii()).ok()?;
    let number = match text.split_once('.') {
        Some((number, zeros)) if zeros.bytes().all(|b| b == b'0') => number,
        _ => text,
    };
    number.parse().ok()
}

/// Whether a field begins like "2024-05-01" or "2024/05/01".
fn is_date(field: &[u8]) -> bool {
    let field = field.trim_ascii();
    field.len() >= 10
        && field[..4].iter().all(u8::is_ascii_digit)
        && matches!(field[4], b'-' | b'/')
        && field[4] == field[7]
}

fn parse(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field.trim_ascii()).ok()?.parse().ok()
}

/// The field with this name, trimmed, letters of either case.
fn find(
    file: &Path,
    header: &ByteRecord,
    name: &str,
    required: bool,
) -> Result<Option<usize>, FormatError> {
    let same = |f: &[u8]| f.trim_ascii().eq_ignore_ascii_case(name.as_bytes());
    let mut hits = header.iter().enumerate().filter(|(_, f)| same(f));
    match (hits.next(), hits.next()) {
        (Some((k, _)), None) => Ok(Some(k)),
        (None, _) if required => Err(missing_column(file, header, &[name])),
        (None, _) => Ok(None),
        (Some(_), Some(_)) => Err(FormatError::new(
            FaultKind::BadValue,
            file,
            Place::Line {
                line: 1,
                column: name.to_owned(),
            },
            "this column twice",
            "it once",
        )),
    }
}

/// The same, and where a column is missing all that are needed: so that a header is mended at once.
fn with_the_others(mut fault: FormatError, required: &[&str]) -> FormatError {
    if fault.kind == FaultKind::MissingColumn && required.len() > 1 {
        let all = required.join(", ");
        fault.expected.push_str(&format!("; needed are {all}"));
    }
    fault
}

/// The error that none of the columns `names` is in the header; the nearest one there is suggested.
fn missing_column(file: &Path, header: &ByteRecord, names: &[&str]) -> FormatError {
    let wanted = names.join(" or ");
    let columns: Vec<String> = header
        .iter()
        .map(|f| quoted(f.trim_ascii()).trim_matches('"').to_owned())
        .collect();
    let mut found = quoted(columns.join(",").as_bytes());
    if header.iter().all(|f| parse(f).is_some()) {
        found.push_str(" (numbers instead of column names)");
    } else if let Some(nearest) = nearest(&columns, names) {
        found.push_str(&format!(" (nearest column: {nearest})"));
    } else if columns.len() == 1 && (columns[0].contains(';') || columns[0].contains('?')) {
        found.push_str(" (no comma between columns)");
    }
    let place = Place::Line {
        line: 1,
        column: wanted.clone(),
    };
    FormatError::new(
        FaultKind::MissingColumn,
        file,
        place,
        found,
        format!("a column {wanted}"),
    )
}

/// The column whose name is most like one of these, if any is.
pub(super) fn nearest<'c>(columns: &'c [String], names: &[&str]) -> Option<&'c String> {
    let similar = |column: &String| {
        let each = names.iter().map(|name| strsim::jaro_winkler(name, column));
        each.fold(0.0, f64::max)
    };
    columns
        .iter()
        .filter(|c| similar(c) > 0.75)
        .max_by(|a, b| similar(a).total_cmp(&similar(b)))
}

/// A row with its separators.
fn as_written(row: &ByteRecord, separator: u8) -> Vec<u8> {
    let fields: Vec<&[u8]> = row.iter().collect();
    let shown = if separator == b'\t' { b' ' } else { separator };
    fields.join(&shown)
}

fn translate(file: &Path, error: &csv::Error, row: &ByteRecord, separator: u8) -> FormatError {
    match error.kind() {
        csv::ErrorKind::Io(io) => FormatError::unreadable(file, io),
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => FormatError::new(
            FaultKind::BadValue,
            file,
            Place::Line {
                line: pos.as_ref().map_or(0, csv::Position::line),
                column: String::new(),
            },
            format!("{len} fields ({})", quoted(&as_written(row, separator))),
            format!("{expected_len} as in the header"),
        ),
        _ => FormatError::new(
            FaultKind::BadValue,
            file,
            Place::File,
            quoted(error.to_string().as_bytes()),
            "comma-separated values",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(text: &str) -> Result<(f64, u32), FormatError> {
        let (file, size) = (Path::new("x.csv"), text.len() as u64);
        let mut table = Table::open(file, text.as_bytes(), size, &["time_s", "ping"], &[])?;
        table.next_row()?;
        Ok((table.number(0, &Limits::FINITE)?, table.count(1)?))
    }

    #[test]
    fn commas_semicolons_and_tabs_part_columns() {
        for text in [
            "time_s,ping\n1.5,12\n",
            "time_s;ping\n1.5;12\n",
            "time_s;ping\n1,5;12\n",
            "ping\ttime_s\n12.0\t1.5\n",
        ] {
            assert_eq!(first(text), Ok((1.5, 12)), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_named() {
        let said = |text: &str| first(text).expect_err(text).to_string();
        assert!(said("time_s,ping\n2024-05-01 10:00:99,1\n").contains("a time such as"));
        assert!(said("Epoch,ping\n1,1\n").contains("a column time_s; needed are time_s, ping"));
        assert!(said("time_s,ping\n2016-12-31T23:59:60Z,1\n").contains("leap second"));
        assert!(said("time_s,ping\n1,1.5\n").contains("a whole number"));
        assert!(said("time_s,ping\n7\n").contains("1 fields (\"7\")"));
        assert!(said("time_s,ping\n7,8,9\n").contains("(\"7,8,9\")"));
        assert!(said("time_s,ping\n1,2,3\n").contains("expected 2"));
        assert!(said("time_s;ping\n1;x\n").contains("found \"x\""));
    }

    #[test]
    fn dates_are_times() {
        let read = first("time_s,ping\n2026-06-12T08:30:15.25Z,1\n");
        assert_eq!(read, Ok((1_781_253_015.25, 1)));
    }

    #[test]
    fn a_quotation_mark_left_open_swallows_no_rows() {
        let rows = "1,2\n".repeat(400);
        let text = format!("time_s,ping\n{rows}\"3,4\n{rows}");
        let (file, size) = (Path::new("x.csv"), text.len() as u64);
        let mut table =
            Table::open(file, text.as_bytes(), size, &["time_s", "ping"], &[]).expect("a table");
        let read = table.each(Some(super::super::Invalid::Drop), |row| {
            row.number(0, &Limits::FINITE).map(drop)
        });
        let said = read.expect_err("refused").to_string();
        assert!(said.contains("line 402: found a quotation mark"), "{said}");
        let closed = first("\"time_s\",\"ping\"\n\"1.5\",\"12\"\n");
        assert_eq!(closed, Ok((1.5, 12)));
    }

    #[test]
    fn utf16_is_named() {
        let bytes: &[u8] = b"\xff\xfet\0i\0";
        let opened = Table::open(Path::new("x.csv"), bytes, 6, &["time_s"], &[]);
        assert!(opened.is_err_and(|e| e.to_string().contains("UTF-16")));
    }
}
