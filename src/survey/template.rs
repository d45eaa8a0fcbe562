//! Complete commented files, and the tables of keys in the documentation, from the same lists that the reader checks by.

use super::schema::{Key, Kind, Limits, describe};

/// A file with every key: what must be given with a value to replace, everything else commented out (`#key = value`) at its default.
#[must_use]
pub fn template(title: &str, keys: &[Key]) -> String {
    let mut text = format!(
        "# {title}\n# Replace the values below; a line that begins with \"#\" and a key is optional and shows what holds without it.\n"
    );
    Writer {
        text: &mut text,
        optional: false,
    }
    .table(keys, "");
    text
}

/// The same with every line commented out, for a file's other kind.
#[must_use]
pub fn alternative(title: &str, keys: &[Key]) -> String {
    let mut text = format!("\n# {title}\n");
    Writer {
        text: &mut text,
        optional: true,
    }
    .table(keys, "");
    text
}

struct Writer<'t> {
    text: &'t mut String,
    /// Whether the table as a whole may be left out.
    optional: bool,
}

impl Writer<'_> {
    /// Values first, then the sections below: TOML wants it so.
    fn table(&mut self, keys: &[Key], path: &str) {
        let section = |key: &&Key| matches!(key.kind, Kind::Table(_) | Kind::Tables(_));
        for key in keys.iter().filter(|key| !section(key)) {
            self.value(key);
        }
        for key in keys.iter().filter(section) {
            self.section(key, path);
        }
    }

    fn value(&mut self, key: &Key) {
        let mark = if key.required && !self.optional {
            ""
        } else {
            "#"
        };
        self.text.push('\n');
        self.comment(key.about);
        let need = if key.required { "needed; " } else { "" };
        self.comment(&format!("{need}{}", describe(&key.kind)));
        let value = allowed_default(key).unwrap_or_else(|| example(&key.kind));
        self.text
            .push_str(&format!("{mark}{} = {value}\n", key.name));
    }

    fn section(&mut self, key: &Key, path: &str) {
        let (keys, open, close) = match key.kind {
            Kind::Tables(keys) => (keys, "[[", "]]"),
            Kind::Table(keys) => (keys, "[", "]"),
            _ => return,
        };
        let path = match path {
            "" => key.name.to_owned(),
            path => format!("{path}.{}", key.name),
        };
        let optional = self.optional || !key.required;
        self.text.push('\n');
        self.comment(key.about);
        let mark = if optional { "#" } else { "" };
        self.text.push_str(&format!("{mark}{open}{path}{close}\n"));
        Writer {
            text: self.text,
            optional,
        }
        .table(keys, &path);
    }

    fn comment(&mut self, words: &str) {
        for line in words.lines().map(str::trim).filter(|line| !line.is_empty()) {
            self.text.push_str(&format!("# {line}\n"));
        }
    }
}

/// The default as it would stand in the file.
fn shown_default(key: &Key) -> Option<String> {
    Some((key.default?)()?.to_string())
}

/// The default where it may be written too: some keys stand at a value outside their limits as long as they are not used.
fn allowed_default(key: &Key) -> Option<String> {
    let value = (key.default?)()?;
    let inside = match key.kind {
        Kind::Number(limits) => value.as_float().is_none_or(|number| limits.contain(number)),
        _ => true,
    };
    inside.then(|| value.to_string())
}

/// A value that the kind allows, to be replaced.
fn example(kind: &Kind) -> String {
    let number = |limits: &Limits| format!("{:?}", within(limits));
    match kind {
        Kind::Text => "\"...\"".to_owned(),
        Kind::OneOf(words) => format!("{:?}", words.first().copied().unwrap_or_default()),
        Kind::Words(_) | Kind::Texts => "[]".to_owned(),
        Kind::Flag => "false".to_owned(),
        Kind::Number(limits) => number(limits),
        Kind::Count(limits) => format!("{:.0}", within(limits)),
        Kind::Pair(limits) => format!("[{}, {}]", number(limits), number(limits)),
        Kind::Triple(limits) => format!("[{0}, {0}, {0}]", number(limits)),
        Kind::Triples(limits) => format!(
            "[[{0}, {0}, {0}], [{0}, {0}, {0}], [{0}, {0}, {0}]]",
            number(limits)
        ),
        Kind::UtmZone => "\"50N\"".to_owned(),
        Kind::Table(_) | Kind::Tables(_) => "{}".to_owned(),
    }
}

/// A handy number within the limits.
fn within(limits: &Limits) -> f64 {
    let handy = [0.01, 1.0, 1500.0, 0.0];
    let found = handy.into_iter().find(|number| limits.contain(*number));
    found.unwrap_or(limits.max)
}

// DOCUMENTATION

/// The keys of a file as Markdown: a table for every section, the sections below after it.
#[must_use]
pub fn markdown(keys: &[Key]) -> String {
    let mut text = String::new();
    tables(&mut text, keys, "");
    text
}

fn tables(text: &mut String, keys: &[Key], path: &str) {
    let header = match path {
        "" => "Before the first section:".to_owned(),
        path => format!("`[{path}]`:"),
    };
    text.push_str(&format!(
        "{header}\n\n| key | what | allowed | without it |\n|---|---|---|---|\n"
    ));
    for key in keys {
        text.push_str(&row(key));
    }
    text.push('\n');
    for key in keys {
        let below = match path {
            "" => key.name.to_owned(),
            path => format!("{path}.{}", key.name),
        };
        match key.kind {
            Kind::Table(inner) => tables(text, inner, &below),
            Kind::Tables(inner) => tables(text, inner, &format!("[{below}]")),
            _ => {}
        }
    }
}

fn row(key: &Key) -> String {
    let about: Vec<_> = key.about.lines().map(str::trim).collect();
    let allowed = match key.kind {
        Kind::Table(_) => "a section".to_owned(),
        Kind::Tables(_) => "one or more sections".to_owned(),
        kind => describe(&kind),
    };
    let section = matches!(key.kind, Kind::Table(_) | Kind::Tables(_));
    let without = match (key.required, shown_default(key)) {
        (true, _) => "needed".to_owned(),
        (false, Some(value)) if !section => format!("`{value}`"),
        (false, _) => "none".to_owned(),
    };
    let cell = |words: &str| words.replace('|', "\\|");
    format!(
        "| `{}` | {} | {} | {} |\n",
        key.name,
        cell(about.join(" ").trim()),
        cell(&allowed),
        cell(&without)
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::survey::document::Document;
    use crate::survey::schema::{check, optional, required};

    const LIMITS: Limits = Limits {
        min: 2.0,
        max: 3.0,
        expected: "metres from 2 to 3",
    };
    const INNER: &[Key] = &[
        required("height_m", Kind::Number(LIMITS)).about("Height, metres."),
        optional("count", Kind::Count(LIMITS)),
    ];
    const KEYS: &[Key] = &[
        required("place", Kind::Table(INNER)),
        optional("other", Kind::Tables(INNER)),
        required("name", Kind::Text),
    ];

    fn problems(text: &str) -> Vec<String> {
        let document = Document::parse(Path::new("t.toml"), text).expect("TOML");
        let found = check(&document, KEYS);
        found.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_template_is_a_file_that_its_reader_accepts() {
        let text = template("A file.", KEYS);
        assert_eq!(problems(&text), Vec::<String>::new(), "{text}");
        assert!(
            text.contains("\nheight_m = 3.0\n") && text.contains("\n#count = 3\n"),
            "{text}"
        );
        assert!(
            text.contains("# Height, metres.\n# needed; metres from 2 to 3\n"),
            "{text}"
        );
        let all = text.replace("\n#[", "\n[").replace("\n#count", "\ncount");
        assert_eq!(problems(&all).len(), 1, "{all}");
    }

    #[test]
    fn the_page_has_a_table_for_every_section() {
        let page = markdown(KEYS);
        for part in [
            "| `height_m` | Height, metres. | metres from 2 to 3 | needed |",
            "`[place]`:",
            "`[[other]]`:",
        ] {
            assert!(page.contains(part), "{part} in {page}");
        }
    }
}
