//! The shape of the sources: how long functions are, and that procedures are named in their own folder only.

use std::path::{Path, PathBuf};

use crate::layers::{sources, without_comments};

/// Files outside `procedures/` that name a procedure: the examples in the program's help, and a kind of target, the pool's wall.
const NAMING: [&str; 2] = ["cli/args.rs", "target/model.rs"];
/// Longest body that a function may have, lines.
const LONGEST: usize = 80;
/// What 95 of 100 bodies stay under.
const MOST: usize = 38;
/// The body in the middle.
const MEDIAN: usize = 7;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The number of bytes that a comment, text or letter in quotes takes from the beginning of `rest`; 0 where none begins.
fn silent(rest: &str, in_word: bool) -> usize {
    let until = |from: usize, end: &str| {
        let found = rest[from..].find(end);
        found.map_or(rest.len(), |at| from + at + end.len())
    };
    if rest.starts_with("//") {
        return rest.find('\n').unwrap_or(rest.len());
    }
    if rest.starts_with("/*") {
        return until(2, "*/");
    }
    let raw = rest.trim_start_matches('b');
    if !in_word && (raw.starts_with("r\"") || raw.starts_with("r#")) {
        let fence: String = raw[1..].chars().take_while(|c| *c == '#').collect();
        let begin = rest.len() - raw.len() + 1 + fence.len();
        if rest[begin..].starts_with('"') {
            return until(begin + 1, &format!("\"{fence}"));
        }
    }
    match rest.as_bytes() {
        [b'"', ..] => text(rest),
        [b'\'', b'\\', _, ..] => until(3, "'"),
        [b'\'', ..] => letter(rest),
        _ => 0,
    }
}

/// Bytes of a text in quotes.
fn text(rest: &str) -> usize {
    let mut escaped = false;
    for (at, byte) in rest.bytes().enumerate().skip(1) {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = true,
            b'"' => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// Bytes of a letter in quotes; 0 for a lifetime.
fn letter(rest: &str) -> usize {
    let mut letters = rest.char_indices().skip(2);
    match letters.next() {
        Some((at, '\'')) => at + 1,
        _ => 0,
    }
}

/// Source with comments and texts blanked, line by line as long as it was.
fn bare(source: &str) -> String {
    let (mut bare, mut at, mut in_word) = (String::new(), 0, false);
    while let Some(next) = source[at..].chars().next() {
        let skipped = silent(&source[at..], in_word);
        let end = at
            + if skipped > 0 {
                skipped
            } else {
                next.len_utf8()
            };
        if skipped > 0 {
            let lines = source[at..end].matches('\n').count();
            bare.push_str(&"\n".repeat(lines));
            bare.push(' ');
        } else {
            bare.push(next);
        }
        in_word = skipped == 0 && (next.is_alphanumeric() || next == '_');
        at = end;
    }
    bare
}

/// Name and lines of the body of every function: the lines between its braces, one for a body on a single line.
fn bodies(source: &str) -> Vec<(String, usize)> {
    let bare = bare(source);
    let begins = bare.match_indices("fn ").filter(|(at, _)| {
        let before = bare[..*at].chars().next_back();
        before.is_none_or(|c| !c.is_alphanumeric() && c != '_')
    });
    begins
        .filter_map(|(at, _)| {
            let head = &bare[at + 3..];
            let name = head.split(['(', '<', ' ']).next()?;
            let body = &head[opening(head)?..];
            let lines = body[..closing(body)].matches('\n').count();
            (!name.is_empty()).then(|| (name.to_owned(), lines.saturating_sub(1).max(1)))
        })
        .collect()
}

/// Where the body's brace opens; `None` for a function without a body, and for the type of a function.
fn opening(head: &str) -> Option<usize> {
    let mut depth = 0;
    for (at, c) in head.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' if depth == 0 => return None,
            ')' | ']' => depth -= 1,
            ';' | '}' | ',' | '=' if depth == 0 && !in_angles(&head[..at]) => return None,
            '{' if depth == 0 => return Some(at),
            _ => {}
        }
    }
    None
}

/// Whether the parameters in angle brackets or a `where` are still being said.
fn in_angles(head: &str) -> bool {
    let arrows = head.matches("->").count();
    let open = head.matches('<').count() > head.matches('>').count() - arrows;
    open || head.contains("\nwhere") || head.contains(" where")
}

/// Where the brace that a text begins with closes.
fn closing(body: &str) -> usize {
    let mut depth = 0;
    for (at, c) in body.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return at,
            '}' => depth -= 1,
            _ => {}
        }
    }
    body.len()
}

#[test]
fn bodies_are_counted_as_they_stand() {
    let source = "fn one() { 1 }\ntrait T {\n    fn none(&self);\n    fn given(&self) -> [u8; 2] {\n        // fn not() {\n        let a = \"}\";\n        [b'}', 2]\n    }\n}\n\
        fn long<F>(f: F, g: fn(u8) -> u8) -> u8\nwhere\n    F: Fn(&str) -> u8,\n{\n    let c = '{';\n    f(r#\"\"}\"#)\n}\n";
    let found = bodies(source);
    let found: Vec<_> = found.iter().map(|(n, l)| (n.as_str(), *l)).collect();
    assert_eq!(found, [("one", 1), ("given", 3), ("long", 2)]);
}

#[test]
fn functions_are_short() {
    let mut all = vec![];
    for path in sources(&root()) {
        let source = std::fs::read_to_string(&path).expect("a readable file");
        let of = |(name, lines): (String, usize)| (lines, path.clone(), name);
        all.extend(bodies(&source).into_iter().map(of));
    }
    all.sort();
    let count = all.len();
    assert!(count > 4000, "only {count} functions found");
    let lines = |place: usize| all[place].0;
    let (median, most, longest) = (lines(count / 2), lines(95 * count / 100), &all[count - 1]);
    println!("{count} functions: median {median}, 95 % {most}, longest {longest:?}");
    assert!(median <= MEDIAN, "median {median}");
    assert!(most < MOST, "95 % have {most} lines or fewer");
    let long: Vec<_> = all.iter().filter(|f| f.0 > LONGEST).collect();
    assert!(long.is_empty(), "{long:?}");
}

/// Lines that name a procedure by the word, in code, text or tests; comments apart.
fn naming(source: &str, names: &[&str]) -> Vec<String> {
    let code = without_comments(source);
    let named = |line: &&str| {
        let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
        words.any(|word| names.contains(&word))
    };
    code.lines().filter(named).map(str::to_owned).collect()
}

#[test]
fn a_procedure_is_named_in_its_own_folder_only() {
    let names = boresight::procedures::names();
    let source = "let a = \"pool-wall\";\n// \"pool\"\nuse crate::procedures::pool::X; // a\nlet pool_m = 1;\n";
    assert_eq!(naming(source, &["pool"]).len(), 2);
    let (root, mut found) = (root(), vec![]);
    for path in sources(&root) {
        let relative = path.strip_prefix(&root).expect("below src");
        let source = std::fs::read_to_string(&path).expect("a readable file");
        let lines = naming(&source, &names);
        if !relative.starts_with("procedures") && !lines.is_empty() {
            found.push((relative.display().to_string(), lines));
        }
    }
    let files: Vec<_> = found.iter().map(|(file, _)| file.as_str()).collect();
    assert_eq!(files, NAMING, "{found:#?}");
}
