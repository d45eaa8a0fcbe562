//! What a terminal can show: 80 columns, and ASCII where the locale asks for it.

use crate::ruled::{WIDTH, unbroken};

/// Whether the locale asks for ASCII: the first of `LC_ALL`, `LC_CTYPE` and `LANG` that is set names `C`, `POSIX` or another set of
/// letters than UTF-8.
pub fn asks_for_ascii() -> bool {
    let set = |name: &&str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].iter().find_map(set);
    locale.is_some_and(|locale| without_utf8(&locale))
}

fn without_utf8(locale: &str) -> bool {
    let locale = locale.to_ascii_lowercase();
    !locale.contains("utf-8") && !locale.contains("utf8")
}

/// The text in ASCII; signs are replaced by ones of the same width where there are such, so that tables stay in shape.
pub fn ascii(text: &str) -> String {
    text.replace(" ± ", "+/-")
        .chars()
        .map(|letter| match letter {
            letter if letter.is_ascii() => letter,
            '─' | '–' | '—' | '−' => '-',
            '═' => '=',
            '·' => '.',
            '×' => 'x',
            'µ' | 'μ' => 'u',
            '±' => '~',
            '²' => '2',
            '³' => '3',
            '‘' | '’' => '\'',
            '“' | '”' => '"',
            _ => '?',
        })
        .collect()
}

/// The text with its sentences broken between words at 80 columns; tables, lists of files and what has no blanks stay as they are.
pub fn fitted(text: &str) -> String {
    let lines = text.lines().map(|line| {
        if line.chars().count() <= WIDTH || !is_sentence(line) {
            line.to_owned()
        } else {
            broken(line)
        }
    });
    let end = if text.ends_with('\n') { "\n" } else { "" };
    lines.collect::<Vec<_>>().join("\n") + end
}

/// Neither a ruler nor a row nor "Report  path".
fn is_sentence(line: &str) -> bool {
    !line.starts_with(['─', '═']) && !line.trim_start().contains("  ")
}

/// Lines after the first are indented by two more than the first.
fn broken(line: &str) -> String {
    let indent = line.chars().take_while(|c| *c == ' ').count();
    let mut lines = vec![" ".repeat(indent)];
    let mut empty = true;
    for word in unbroken(line.split_whitespace()) {
        let last = lines.last().map_or(0, |l| l.chars().count());
        if !empty && last + 1 + word.chars().count() > WIDTH {
            lines.push(" ".repeat(indent + 2));
            empty = true;
        }
        if let Some(last) = lines.last_mut() {
            if !empty {
                last.push(' ');
            }
            last.push_str(&word);
            empty = false;
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locales_without_utf8_ask_for_ascii() {
        assert!(without_utf8("C") && without_utf8("POSIX") && without_utf8("de_DE.ISO-8859-1"));
        assert!(!without_utf8("C.UTF-8") && !without_utf8("de_DE.utf8"));
    }

    #[test]
    fn ascii_keeps_the_width_of_tables() {
        let line = " pitch   -1.4134 ± 0.0083  ─═ 12 µm";
        let plain = ascii(line);
        assert!(plain.is_ascii(), "{plain}");
        assert_eq!(plain.chars().count(), line.chars().count());
    }

    #[test]
    fn sentences_are_broken_and_tables_are_not() {
        let sentence = "word ".repeat(40);
        let path = format!("Report  {}", "x".repeat(90));
        let text = fitted(&format!("{}\n{path}\n", sentence.trim_end()));
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len() > 2 && lines[1].starts_with("  word"), "{text}");
        assert!(lines[..lines.len() - 1].iter().all(|l| l.len() <= WIDTH));
        assert_eq!(lines[lines.len() - 1], path);
    }
}
