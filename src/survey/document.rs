//! A TOML text with the line of every key.

use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::Problem;

/// A parsed TOML file, for checks that need to name lines.
#[derive(Debug)]
pub struct Document<'t> {
    file: PathBuf,
    text: &'t str,
    root: DeTable<'t>,
}

impl<'t> Document<'t> {
    /// Parses a text; `file` names it in messages.
    ///
    /// # Errors
    /// One [`Problem`] for every place that is no TOML.
    pub fn parse(file: &Path, text: &'t str) -> Result<Self, Vec<Problem>> {
        let (root, errors) = DeTable::parse_recoverable(text);
        if errors.is_empty() {
            return Ok(Self {
                file: file.to_owned(),
                text,
                root: root.into_inner(),
            });
        }
        Err(not_toml(file, text, &errors))
    }

    /// The file's name in messages.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The outermost table.
    #[must_use]
    pub fn root(&self) -> &DeTable<'t> {
        &self.root
    }

    /// The line of a key or value, counted from 1.
    #[must_use]
    pub fn line_of<T>(&self, item: &Spanned<T>) -> usize {
        line(self.text, item.span().start)
    }

    /// The text of a value as it stands in the file, cut to a message's length.
    #[must_use]
    pub fn text_of(&self, value: &Spanned<DeValue<'_>>) -> String {
        let piece = self.text.get(value.span()).unwrap_or_default().trim();
        let single: Vec<_> = piece.split_whitespace().collect();
        let shown = crate::formats::error::quoted(single.join(" ").as_bytes());
        shown[1..shown.len() - 1].to_owned()
    }

    /// The value at a path of keys, such as `["lidar", "coordinates"]`.
    #[must_use]
    pub fn get(&self, path: &[&str]) -> Option<&Spanned<DeValue<'t>>> {
        let (first, rest) = path.split_first()?;
        let mut value = self.root.get(*first)?;
        for key in rest {
            value = value.get_ref().as_table()?.get(*key)?;
        }
        Some(value)
    }

    /// The text at a path of keys, if it is one.
    #[must_use]
    pub fn string(&self, path: &[&str]) -> Option<&str> {
        self.get(path)?.get_ref().as_str()
    }

    /// The line of a key in words, such as `pass[1].speed_m_s` or `[joint] gate_sigma`, or of as much of it as is there; nothing where
    /// not even its section is.
    #[must_use]
    pub fn line_of_key(&self, words: &str) -> Option<usize> {
        let parts = words
            .split(|c| ".[] ".contains(c))
            .filter(|p| !p.is_empty());
        let (mut line, mut table, mut array) = (None, Some(&self.root), None);
        for part in parts {
            let value = match (table, array, part.parse::<usize>()) {
                (Some(table), _, _) => table.get(part),
                (None, Some(values), Ok(k)) => <[_]>::get(values, k),
                _ => None,
            };
            let Some(value) = value else { break };
            line = Some(self.line_of(value));
            table = value.get_ref().as_table();
            array = value.get_ref().as_array().map(|a| &a[..]);
        }
        line
    }

    /// A fault that begins with its key, with the line of that key before it.
    #[must_use]
    pub fn placed(&self, fault: &str) -> String {
        let key = fault.split([':', '=', '(']).next().unwrap_or_default();
        match self.line_of_key(key) {
            Some(line) if !fault.starts_with("line ") => format!("line {line}: {fault}"),
            _ => fault.to_owned(),
        }
    }

    /// The line at which a key at this path stands, or else its section.
    #[must_use]
    pub fn line_at(&self, path: &[&str]) -> usize {
        (1..=path.len())
            .rev()
            .find_map(|n| self.get(&path[..n]))
            .map_or(1, |value| self.line_of(value))
    }

    /// A problem with the key at a path.
    #[must_use]
    pub fn problem(
        &self,
        path: &[&str],
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Problem {
        let place = format!("line {}, {}", self.line_at(path), dotted(path));
        Problem::new(&self.file, place, found, expected)
    }
}

/// `[section] key` for a path of two keys and more, the key alone at the top.
#[must_use]
pub fn dotted(path: &[&str]) -> String {
    match path {
        [] => "whole file".to_owned(),
        [key] => (*key).to_owned(),
        [section, keys @ ..] => format!("[{section}] {}", keys.join(".")),
    }
}

fn line(text: &str, byte: usize) -> usize {
    let before = text.as_bytes().get(..byte).unwrap_or(text.as_bytes());
    1 + before.iter().filter(|&&b| b == b'\n').count()
}

/// Lines that are shown of a text that is not TOML.
const SHOWN: usize = 3;

/// The first lines that are not TOML, in their order, and how many there are.
fn not_toml(file: &Path, text: &str, errors: &[toml::de::Error]) -> Vec<Problem> {
    let place = |error: &toml::de::Error| error.span().unwrap_or(0..0);
    let mut lines: Vec<_> = errors
        .iter()
        .map(|error| {
            (
                line(text, place(error).start),
                place(error),
                error.message(),
            )
        })
        .collect();
    lines.sort_by_key(|(line, span, _)| (*line, span.start));
    lines.dedup_by_key(|(line, _, _)| *line);
    let more = lines.len().saturating_sub(SHOWN);
    let shown = lines.iter().take(SHOWN).map(|(line, span, message)| {
        let piece = text.get(span.clone()).unwrap_or_default();
        let found = match piece.is_empty() {
            true => "something else".to_owned(),
            false => crate::formats::error::quoted(piece.as_bytes()),
        };
        Problem::new(
            file,
            format!("line {line}"),
            found,
            format!("TOML ({message})"),
        )
    });
    let mut problems: Vec<Problem> = shown.collect();
    if more > 0 {
        let found = format!("{more} more lines that are not TOML");
        problems.push(Problem::new(file, "whole file", found, "a TOML file"));
    }
    problems
}
