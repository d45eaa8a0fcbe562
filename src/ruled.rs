//! Text tables for the terminal: a line above, below and under the header, none between rows. A table that is too wide for 80 columns
//! is first set closer, then cut into several below one another that repeat the columns of text.
//!
//! ```
//! let mut table = boresight::ruled::Ruled::new(["parameter", "value"]);
//! table.row(["pitch, deg", "0.12"]);
//! assert_eq!(table.to_string().lines().nth(3), Some(" pitch, deg    0.12"));
//! ```

use std::fmt;
use std::ops::Range;

/// Widest line, columns.
pub const WIDTH: usize = 80;

/// A table of columns with text, aligned left, and columns with numbers, aligned right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ruled {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    numbers: Range<usize>,
}

impl Ruled {
    /// A table without rows; its first column is text.
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self {
            header: header.into_iter().map(Into::into).collect(),
            rows: vec![],
            numbers: 1..usize::MAX,
        }
    }

    /// The same with so many columns of text before the numbers.
    #[must_use]
    pub fn texts(self, columns: usize) -> Self {
        self.numbers(columns..usize::MAX)
    }

    /// The same with numbers in these columns and text in the others.
    #[must_use]
    pub fn numbers(self, columns: Range<usize>) -> Self {
        Self {
            numbers: columns,
            ..self
        }
    }

    /// Adds a row; what is missing at its end stays empty.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) -> &mut Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// Characters of the widest cell of every column, in any row.
    fn widths(&self) -> Vec<usize> {
        let all = || self.rows.iter().chain([&self.header]);
        let columns = all().map(Vec::len).max().unwrap_or(0);
        let width = |row: &Vec<String>, k| row.get(k).map_or(0, |cell: &String| length(cell));
        let widest = |k| all().map(|row| width(row, k)).max().unwrap_or(0);
        (0..columns).map(widest).collect()
    }

    /// Some columns of one row as a line, without blanks at its end.
    fn line(&self, row: &[String], set: &Setting<'_>) -> String {
        let cells = set.columns.iter().map(|&k| {
            let cell = row.get(k).map_or("", String::as_str);
            let blank = " ".repeat(set.widths[k] - length(cell));
            if self.numbers.contains(&k) {
                format!(" {blank}{cell}{}", set.gap)
            } else {
                format!(" {cell}{blank}{}", set.gap)
            }
        });
        let line = cells.collect::<String>();
        line.trim_end().to_owned()
    }

    /// The columns of each part: all in one where they fit, else as many as fit beside the leading columns of text.
    fn parts(&self, widths: &[usize], gap: &str) -> Vec<Vec<usize>> {
        let all: Vec<usize> = (0..widths.len()).collect();
        if total(widths, &all, gap) <= WIDTH {
            return vec![all];
        }
        let leading = self.numbers.start.min(widths.len());
        let first: Vec<usize> = (0..leading).collect();
        let mut parts = vec![first.clone()];
        for column in leading..widths.len() {
            let last = parts.last_mut().expect("there is a part");
            last.push(column);
            if last.len() > leading + 1 && total(widths, last, gap) > WIDTH {
                last.pop();
                parts.push(first.iter().copied().chain([column]).collect());
            }
        }
        parts
    }

    /// One part as a table.
    fn part(&self, set: &Setting<'_>) -> String {
        let wide = total(set.widths, set.columns, set.gap);
        let thin = "─".repeat(wide);
        let mut lines = vec![thin.clone(), self.line(&self.header, set), "═".repeat(wide)];
        lines.extend(self.rows.iter().map(|row| self.line(row, set)));
        lines.push(thin);
        lines.join("\n")
    }
}

/// How a part of a table is set.
struct Setting<'a> {
    widths: &'a [usize],
    columns: &'a [usize],
    gap: &'a str,
}

fn length(cell: &str) -> usize {
    cell.chars().count()
}

/// Characters of a line through these columns.
fn total(widths: &[usize], columns: &[usize], gap: &str) -> usize {
    let all = columns.iter().map(|&k| widths[k] + 1 + gap.len());
    (all.sum::<usize>() + 1).saturating_sub(gap.len())
}

impl fmt::Display for Ruled {
    /// Without a newline at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths = self.widths();
        let all: Vec<usize> = (0..widths.len()).collect();
        let fits = |gap: &str| total(&widths, &all, gap) <= WIDTH;
        let gap = if fits("  ") { "  " } else { " " };
        let parts = self.parts(&widths, gap);
        let set = |columns: &Vec<usize>| {
            let (widths, columns) = (&widths[..], &columns[..]);
            self.part(&Setting {
                widths,
                columns,
                gap,
            })
        };
        let texts: Vec<String> = parts.iter().map(set).collect();
        write!(f, "{}", texts.join("\n"))
    }
}

/// Words that a line may end after: a number with blanks between its thousands is one of them.
pub fn unbroken<'w>(parts: impl Iterator<Item = &'w str>) -> Vec<String> {
    let mut words: Vec<String> = vec![];
    for word in parts {
        let digits = word.bytes().take_while(u8::is_ascii_digit).count();
        let rest = &word[digits..];
        let thousands = digits == 3 && rest.chars().all(|c| ",.;:)".contains(c));
        match words.last_mut() {
            Some(last) if thousands && begins_number(last) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_owned()),
        }
    }
    words
}

/// Whether thousands may follow: the word ends in one to three digits, and in groups of three before them.
fn begins_number(word: &str) -> bool {
    let mut groups = word.trim_start_matches('(').split(' ');
    let first = groups.next().unwrap_or_default();
    let digits = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
    (1..=3).contains(&first.len()) && digits(first) && groups.all(digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_with_thousands_is_one_word() {
        let words = |text: &str| unbroken(text.split(' ')).join("|");
        assert_eq!(words("with 7 954 degrees"), "with|7 954|degrees");
        assert_eq!(words("(12 345 678), of"), "(12 345 678),|of");
        for apart in ["0.9 954", "1000 123", "pass 12 34", "x7 954", "7 954a"] {
            assert_eq!(words(apart), apart.replace(' ', "|"));
        }
    }

    #[test]
    fn texts_stand_left_and_numbers_right() {
        let mut table = Ruled::new(["µ", "n", "sigma"]);
        table.row(["long name", "1", "22"]).row(["b", "333"]);
        let lines: Vec<String> = table.to_string().lines().map(str::to_owned).collect();
        assert_eq!(lines[0], "─".repeat(25));
        assert_eq!(lines[1], " µ             n   sigma");
        assert_eq!(lines[3], " long name     1      22");
        assert_eq!(lines[4], " b           333");
        assert_eq!(lines.len(), 6);
        let mut ends = Ruled::new(["a", "b", "c"]).numbers(1..2);
        ends.row(["x", "1", "words"]);
        assert!(ends.to_string().contains(" x   1   words"));
    }

    #[test]
    fn a_table_too_wide_is_cut_and_its_names_repeated() {
        let heads = ["name"].into_iter().chain(["a long head of a column"; 5]);
        let mut table = Ruled::new(heads);
        table.row(["roll", "1", "2", "3", "4", "5"]);
        let text = table.to_string();
        assert!(text.lines().all(|l| length(l) <= WIDTH), "{text}");
        assert_eq!(text.matches(" roll").count(), 3, "{text}");
        assert_eq!(text.matches("a long head").count(), 5, "{text}");
    }
}
