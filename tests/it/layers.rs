//! The floor plan: a file may import only from floors below its own (or from files of its own module).
//!
//! Every path that begins with `crate::` (in `src/main.rs` also `boresight::`), imported or written out, in code and in tests within
//! the sources, must name a module of a lower floor. Comments are not looked at.

use std::path::{Path, PathBuf};

/// Floor of every top-level module; the table of the architecture page.
const FLOORS: [(&str, u8); 25] = [
    ("math", 0),
    ("ruled", 0),
    ("units", 0),
    ("watch", 0),
    ("stats", 0),
    ("files", 0),
    ("geometry", 1),
    ("adjust", 2),
    ("observe", 3),
    ("formats", 4),
    ("georef", 4),
    ("target", 5),
    ("recorders", 5),
    ("matching", 5),
    ("simulate", 5),
    ("results", 6),
    ("calibrate", 7),
    ("survey", 7),
    ("casting", 8),
    ("procedures", 8),
    ("budget", 9),
    ("report", 9),
    ("doors", 10),
    ("cli", 11),
    ("main", 12),
];

/// Neighbours on one floor of which the first builds on the second; never the other way round.
/// The floor plan's prose does not name them: matching ties points to a target's faces, the simulator casts rays at them, and a
/// procedure's own simulator knows its scene.
const NEIGHBOURS: [(&str, &str); 6] = [
    // distributions and rounding are made of functions of numbers
    ("stats", "math"),
    ("units", "math"),
    // its errors name files, lines and keys
    ("calibrate", "survey"),
    ("matching", "target"),
    ("simulate", "target"),
    ("casting", "procedures"),
];

/// What holds besides the floors: a module that may know only these.
/// The simulator casts rays and does not call `georef`, so that the two check each other.
const NARROWER: [(&str, &[&str]); 4] = [
    (
        "simulate",
        &[
            "units", "math", "stats", "geometry", "observe", "formats", "target", "watch",
        ],
    ),
    (
        "casting",
        &[
            "units", "math", "stats", "geometry", "observe", "formats", "target", "simulate",
            "watch",
        ],
    ),
    (
        "results",
        &["units", "stats", "files", "geometry", "adjust"],
    ),
    (
        "report",
        &[
            "ruled", "units", "math", "stats", "files", "geometry", "adjust", "results",
        ],
    ),
];

fn floor(module: &str) -> Option<u8> {
    FLOORS
        .iter()
        .find(|entry| entry.0 == module)
        .map(|entry| entry.1)
}

/// Source without line comments, strings left alone (none of them begins a path).
pub(crate) fn without_comments(source: &str) -> String {
    let lines = source
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Names directly behind each `root::`, also inside `root::{a::b, c}`.
fn modules_named(source: &str, root: &str) -> Vec<String> {
    let code = without_comments(source);
    let marker = format!("{root}::");
    let mut found = Vec::new();
    for (at, _) in code.match_indices(&marker) {
        let before = code[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = code[at + marker.len()..].trim_start();
        if let Some(group) = rest.strip_prefix('{') {
            found.extend(first_names(group));
        } else {
            found.push(leading_name(rest));
        }
    }
    found
}

fn leading_name(text: &str) -> String {
    let name = text
        .trim_start()
        .chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_');
    name.collect()
}

/// First names of the members of a braced group whose opening brace is already read.
fn first_names(group: &str) -> Vec<String> {
    let (mut depth, mut begin, mut names) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            '}' | ',' if depth == 0 => {
                names.push(leading_name(&group[begin..at]));
                begin = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// What is wrong with the paths that a file of `module` names.
fn faults(module: &str, source: &str) -> Vec<String> {
    let root = if module == "main" {
        "boresight"
    } else {
        "crate"
    };
    let Some(own) = floor(module) else {
        return vec![format!("module `{module}` has no floor")];
    };
    let narrow = NARROWER.iter().find(|entry| entry.0 == module);
    let mut faults = Vec::new();
    for name in modules_named(source, root) {
        let allowed = narrow.is_none_or(|entry| entry.1.contains(&name.as_str()));
        match floor(&name) {
            _ if name == module || NEIGHBOURS.contains(&(module, &name)) => {}
            None => faults.push(format!("`{root}::{name}` has no floor")),
            Some(other) if other >= own => {
                faults.push(format!(
                    "{module} (floor {own}) imports {name} (floor {other})"
                ));
            }
            Some(_) if !allowed => faults.push(format!("{module} may not know {name}")),
            Some(_) => {}
        }
    }
    faults
}

pub(crate) fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Top-level module of a file below `src`; `casting` for the simulator in a procedure's folder, which is as narrow as `simulate`.
fn module_of(relative: &Path) -> String {
    let mut parts = relative.iter();
    if parts.next().is_some_and(|p| p == "procedures")
        && parts
            .nth(1)
            .is_some_and(|p| p == "simulate" || p == "simulate.rs")
    {
        return "casting".to_owned();
    }
    let first = relative.iter().next().expect("a file").to_string_lossy();
    first.trim_end_matches(".rs").to_owned()
}

#[test]
fn no_import_climbs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = sources(&root);
    assert!(files.len() > 30, "only {} files found", files.len());
    let mut wrong = Vec::new();
    for path in files {
        let relative = path.strip_prefix(&root).expect("below src");
        let module = module_of(relative);
        if module == "lib" {
            continue;
        }
        let source = std::fs::read_to_string(&path).expect("a readable file");
        let named = faults(&module, &source).into_iter();
        wrong.extend(named.map(|fault| format!("src/{}: {fault}", relative.display())));
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// `lib.rs` only declares modules (and may re-export): every module has a floor, every floor that stands has its module.
#[test]
fn every_module_of_the_library_has_a_floor() {
    let library = without_comments(include_str!("../../src/lib.rs"));
    let declared: Vec<&str> = library
        .lines()
        .filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    assert!(declared.len() >= 15, "{declared:?}");
    for module in declared {
        assert!(floor(module).is_some(), "module `{module}` has no floor");
    }
}

#[test]
fn a_climbing_import_is_seen() {
    for (module, source) in [
        ("geometry", "use crate::georef::Beam;"),
        (
            "georef",
            "use crate::{geometry::{Ellipsoid, frames}, target::Model};",
        ),
        ("georef", "use crate::{\n    units,\n    formats::sbet,\n};"),
        (
            "adjust",
            "fn f() { let _ = crate::observe::Soundings::default(); }",
        ),
        ("formats", "pub(crate) use crate::georef::Beam;"),
        ("report", "use crate::georef::georeference;"),
        ("cli", "use crate::unheard_of::Thing;"),
        ("simulate", "use crate::georef::georeference;"),
        ("target", "use crate::matching::Ties;"),
        ("matching", "use crate::simulate::Scene;"),
    ] {
        assert_eq!(faults(module, source).len(), 1, "{module}: {source}");
    }
}

#[test]
fn a_descending_import_is_not() {
    for (module, source) in [
        (
            "georef",
            "use crate::geometry::{Ellipsoid, frames::{Body, Ecef}};\nuse crate::georef::beam::Beam;",
        ),
        (
            "georef",
            "//! See `crate::target`.\n/// crate::target\nuse mycrate::target::T;",
        ),
        ("main", "fn main() { boresight::cli::run_code() }"),
        ("simulate", "use crate::target::Face;"),
        ("survey", "use crate::{results, formats, units::degrees};"),
    ] {
        assert_eq!(faults(module, source), Vec::<String>::new(), "{source}");
    }
}
