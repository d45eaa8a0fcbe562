//! Tables of keys, and the check of a document against them that finds every fault at once.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::document::{Document, dotted};
use super::problem::Problem;
pub use crate::formats::table::Limits;

/// What a key may hold.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A text that is not empty.
    Text,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// A list of some of these words.
    Words(&'static [&'static str]),
    /// A list of texts, none of them empty.
    Texts,
    /// `true` or `false`.
    Flag,
    /// A number within limits.
    Number(Limits),
    /// A whole number within limits.
    Count(Limits),
    /// Two numbers within limits.
    Pair(Limits),
    /// Three numbers within limits.
    Triple(Limits),
    /// A list of at least three triples of numbers within limits.
    Triples(Limits),
    /// A UTM zone: 1 to 60, negative in the south, or a text such as "50N".
    UtmZone,
    /// A table with these keys.
    Table(&'static [Key]),
    /// A list of tables with these keys.
    Tables(&'static [Key]),
}

/// A key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it may hold.
    pub kind: Kind,
    /// Whether it must be there.
    pub required: bool,
    /// What it means, for the documentation.
    pub about: &'static str,
    /// The value that it has where it is left out, if it has one then.
    pub default: Option<fn() -> Option<toml::Value>>,
}

impl Key {
    /// With what it means.
    #[must_use]
    pub const fn about(mut self, about: &'static str) -> Self {
        self.about = about;
        self
    }
}

/// A key that must be there.
#[must_use]
pub const fn required(name: &'static str, kind: Kind) -> Key {
    let required = true;
    Key {
        name,
        kind,
        required,
        about: "",
        default: None,
    }
}

/// A key that may be there.
#[must_use]
pub const fn optional(name: &'static str, kind: Kind) -> Key {
    let required = false;
    Key {
        name,
        kind,
        required,
        about: "",
        default: None,
    }
}

/// Every fault of a document measured by a table of keys, in the order of lines.
#[must_use]
pub fn check(document: &Document<'_>, keys: &[Key]) -> Vec<Problem> {
    check_but(document, keys, &[])
}

/// As [`check`], but the keys at these paths may be missing: something else supplies them.
#[must_use]
pub fn check_but(document: &Document<'_>, keys: &[Key], supplied: &[&[&str]]) -> Vec<Problem> {
    let mut check = Check {
        document,
        supplied,
        found: vec![],
    };
    check.table(document.root(), keys, &[], 1);
    check.found.sort_by_key(|(line, _)| *line);
    check
        .found
        .into_iter()
        .map(|(_, problem)| problem)
        .collect()
}

struct Check<'d, 't> {
    document: &'d Document<'t>,
    supplied: &'d [&'d [&'d str]],
    found: Vec<(usize, Problem)>,
}

impl Check<'_, '_> {
    fn report(&mut self, line: usize, path: &[&str], found: String, expected: String) {
        let place = format!("line {line}, {}", dotted(path));
        let problem = Problem::new(self.document.file(), place, found, expected);
        self.found.push((line, problem));
    }

    /// `line` is where the table begins.
    fn table(&mut self, table: &DeTable<'_>, keys: &[Key], path: &[&str], line: usize) {
        for (name, value) in table {
            let inner: Vec<&str> = path.iter().copied().chain([&**name.get_ref()]).collect();
            match keys.iter().find(|k| k.name == name.get_ref()) {
                Some(key) => self.value(value, &key.kind, &inner),
                None => {
                    let line = self.document.line_of(name);
                    let expected = known_keys(name.get_ref(), keys);
                    self.report(line, &inner, "an unknown key".to_owned(), expected);
                }
            }
        }
        for key in keys
            .iter()
            .filter(|k| k.required && !table.contains_key(k.name))
        {
            let inner: Vec<&str> = path.iter().copied().chain([key.name]).collect();
            if !self.supplied.contains(&inner.as_slice()) {
                self.report(line, &inner, "nothing".to_owned(), describe(&key.kind));
            }
        }
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, kind: &Kind, path: &[&str]) {
        let line = self.document.line_of(value);
        match (kind, value.get_ref()) {
            (Kind::Table(keys), DeValue::Table(table)) => self.table(table, keys, path, line),
            (Kind::Tables(keys), DeValue::Array(list)) if !list.is_empty() => {
                for item in list {
                    let line = self.document.line_of(item);
                    match item.get_ref() {
                        DeValue::Table(table) => self.table(table, keys, path, line),
                        _ => self.wrong(item, kind, path),
                    }
                }
            }
            (kind, inner) if holds(kind, inner) => {}
            _ => self.wrong(value, kind, path),
        }
    }

    fn wrong(&mut self, value: &Spanned<DeValue<'_>>, kind: &Kind, path: &[&str]) {
        let line = self.document.line_of(value);
        let mut expected = describe(kind);
        if let (Kind::OneOf(words), Some(word)) = (kind, value.get_ref().as_str())
            && let Some(nearest) = nearest(word, words.iter().copied())
        {
            expected.push_str(&format!(" (nearest: \"{nearest}\")"));
        }
        self.report(line, path, self.document.text_of(value), expected);
    }
}

/// Whether a value that is no table is what the kind allows.
fn holds(kind: &Kind, value: &DeValue<'_>) -> bool {
    match kind {
        Kind::Text => value.as_str().is_some_and(|s| !s.trim().is_empty()),
        Kind::OneOf(words) => value.as_str().is_some_and(|s| words.contains(&s)),
        Kind::Words(words) => value.as_array().is_some_and(|list| {
            list.iter()
                .all(|item| item.get_ref().as_str().is_some_and(|s| words.contains(&s)))
        }),
        Kind::Texts => value.as_array().is_some_and(|list| {
            let text = |item: &Spanned<DeValue<'_>>| {
                item.get_ref()
                    .as_str()
                    .is_some_and(|s| !s.trim().is_empty())
            };
            list.iter().all(text)
        }),
        Kind::Flag => value.is_bool(),
        Kind::Number(limits) => number(value).is_some_and(|v| limits.contain(v)),
        Kind::Count(limits) => {
            value.is_integer() && number(value).is_some_and(|v| limits.contain(v))
        }
        Kind::Pair(limits) => is_tuple(value, limits, 2),
        Kind::Triple(limits) => is_triple(value, limits),
        Kind::Triples(limits) => value.as_array().is_some_and(|list| {
            list.len() >= 3 && list.iter().all(|item| is_triple(item.get_ref(), limits))
        }),
        Kind::UtmZone => utm_zone(value).is_some(),
        Kind::Table(_) | Kind::Tables(_) => false,
    }
}

fn is_triple(value: &DeValue<'_>, limits: &Limits) -> bool {
    is_tuple(value, limits, 3)
}

fn is_tuple(value: &DeValue<'_>, limits: &Limits, length: usize) -> bool {
    value.as_array().is_some_and(|list| {
        list.len() == length
            && list
                .iter()
                .all(|item| number(item.get_ref()).is_some_and(|v| limits.contain(v)))
    })
}

/// The number that a TOML integer or float stands for.
#[must_use]
pub fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .map(|v| v as f64),
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}

/// The zone, negative in the south, that a whole number or a text such as "50N" or "33S" stands for.
#[must_use]
pub fn utm_zone(value: &DeValue<'_>) -> Option<i8> {
    let zone = match value {
        DeValue::String(text) => return super::sections::UtmZone::parse(text),
        _ if value.is_integer() => number(value)?,
        _ => return None,
    };
    (zone != 0.0 && zone.abs() <= 60.0).then_some(zone as i8)
}

/// What a kind allows, in words.
pub(super) fn describe(kind: &Kind) -> String {
    let listed = |words: &[&str]| {
        let quoted: Vec<_> = words.iter().map(|w| format!("\"{w}\"")).collect();
        quoted.join(", ")
    };
    match kind {
        Kind::Text => "a text in quotes".to_owned(),
        Kind::OneOf(words) => format!("one of {}", listed(words)),
        Kind::Words(words) => format!("a list of {}", listed(words)),
        Kind::Texts => "a list of texts in quotes".to_owned(),
        Kind::Flag => "true or false".to_owned(),
        Kind::Number(limits) => limits.expected.to_owned(),
        Kind::Count(limits) => format!("a whole number, {}", limits.expected),
        Kind::Pair(limits) => format!("two numbers, each {}", limits.expected),
        Kind::Triple(limits) => format!("three numbers, each {}", limits.expected),
        Kind::Triples(limits) => format!("at least three [x, y, z], each {}", limits.expected),
        Kind::UtmZone => "a UTM zone: 1 to 60, negative in the south, or as \"50N\"".to_owned(),
        Kind::Table(keys) => format!("a section with {}", names(keys)),
        Kind::Tables(keys) => format!("one or more sections with {}", names(keys)),
    }
}

fn names(keys: &[Key]) -> String {
    let names: Vec<_> = keys.iter().filter(|k| k.required).map(|k| k.name).collect();
    if names.is_empty() {
        "its keys".to_owned()
    } else {
        names.join(", ")
    }
}

fn known_keys(name: &str, keys: &[Key]) -> String {
    let known: Vec<_> = keys.iter().map(|k| k.name).collect();
    match nearest(name, known.iter().copied()) {
        Some(nearest) => format!("one of {} (nearest: {nearest})", known.join(", ")),
        None => format!("one of {}", known.join(", ")),
    }
}

/// The candidate that is most like `word`.
pub fn nearest<'w>(word: &str, candidates: impl Iterator<Item = &'w str>) -> Option<&'w str> {
    candidates.max_by(|a, b| likeness(word, a).total_cmp(&likeness(word, b)))
}

/// Two measures of likeness, and a bonus for the same first letter and for a part of the whole word.
fn likeness(word: &str, candidate: &str) -> f64 {
    let first = word.chars().next() == candidate.chars().next();
    let part = candidate.contains(word) || word.contains(candidate);
    strsim::jaro_winkler(word, candidate)
        + strsim::normalized_damerau_levenshtein(word, candidate)
        + 0.2 * f64::from(u8::from(first))
        + 0.4 * f64::from(u8::from(part))
}
