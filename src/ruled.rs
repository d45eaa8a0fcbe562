//! Text tables for the terminal: a line above, below and under the header, none between rows.
//!
//! ```
//! let mut table = boresight::ruled::Ruled::new(["parameter", "value"]);
//! table.row(["pitch, deg", "0.12"]);
//! assert_eq!(table.to_string().lines().nth(3), Some(" pitch, deg    0.12"));
//! ```

use std::fmt;

/// A table whose first columns are text, aligned left, and whose others are numbers, aligned right.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ruled {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    texts: usize,
}

impl Ruled {
    /// A table without rows; its first column is text.
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self {
            header: header.into_iter().map(Into::into).collect(),
            rows: vec![],
            texts: 1,
        }
    }

    /// The same with so many columns of text.
    #[must_use]
    pub fn texts(self, columns: usize) -> Self {
        Self {
            texts: columns,
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

    /// One row as a line, without blanks at its end.
    fn line(&self, row: &[String], widths: &[usize]) -> String {
        let cells = widths.iter().enumerate().map(|(k, &width)| {
            let cell = row.get(k).map_or("", String::as_str);
            let blank = " ".repeat(width - length(cell));
            if k < self.texts {
                format!(" {cell}{blank} ")
            } else {
                format!(" {blank}{cell} ")
            }
        });
        let line = cells.collect::<Vec<_>>().join(" ");
        line.trim_end().to_owned()
    }
}

fn length(cell: &str) -> usize {
    cell.chars().count()
}

/// A ruler through all columns.
fn ruler(widths: &[usize], mark: &str) -> String {
    let total: usize = widths.iter().map(|width| width + 3).sum();
    mark.repeat(total.saturating_sub(1))
}

impl fmt::Display for Ruled {
    /// Without a newline at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths = self.widths();
        let thin = ruler(&widths, "─");
        writeln!(f, "{thin}\n{}", self.line(&self.header, &widths))?;
        writeln!(f, "{}", ruler(&widths, "═"))?;
        for row in &self.rows {
            writeln!(f, "{}", self.line(row, &widths))?;
        }
        write!(f, "{thin}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }
}
