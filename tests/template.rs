//! `boresight template` and the page of keys: made from the reader's lists, accepted by the reader.

use std::path::Path;

use boresight::procedures;
use boresight::survey::document::Document;
use boresight::survey::schema::{Key, check};
use boresight::survey::template::{markdown, template};

fn problems(text: &str, keys: &[Key]) -> Vec<String> {
    let document = Document::parse(Path::new("t.toml"), text).expect("TOML");
    check(&document, keys)
        .iter()
        .map(ToString::to_string)
        .collect()
}

/// With every optional key written out: `#key = value` and `#[section]` without the mark.
fn complete(text: &str) -> String {
    let line = |line: &str| match line.strip_prefix('#') {
        Some(rest) if !rest.starts_with(' ') => format!("{rest}\n"),
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// Every file that is described by a list of keys, with its title.
fn described() -> Vec<(String, &'static [Key])> {
    let of = |procedure: &&dyn boresight::calibrate::seam::Procedure| {
        let name = procedure.name();
        let survey = (
            format!("Survey file, procedure = \"{name}\""),
            procedure.survey_keys(),
        );
        let targets = procedure.targets().iter();
        let targets =
            targets.map(move |(title, keys)| (format!("Target file ({name}): {title}"), *keys));
        std::iter::once(survey).chain(targets).collect::<Vec<_>>()
    };
    procedures::ALL.iter().flat_map(of).collect()
}

#[test]
fn the_reader_accepts_every_template_with_and_without_its_optional_keys() {
    for (title, keys) in described() {
        let text = template(&title, keys);
        assert_eq!(problems(&text, keys), Vec::<String>::new(), "{text}");
        let text = complete(&text);
        assert_eq!(problems(&text, keys), Vec::<String>::new(), "{text}");
    }
}

#[test]
fn every_key_of_a_survey_file_says_what_it_means() {
    fn silent(keys: &[Key]) -> Vec<&'static str> {
        use boresight::survey::schema::Kind;
        let below = |key: &Key| match key.kind {
            Kind::Table(keys) | Kind::Tables(keys) => silent(keys),
            _ => vec![],
        };
        let own = keys.iter().filter(|key| key.about.trim().is_empty());
        own.map(|key| key.name)
            .chain(keys.iter().flat_map(below))
            .collect()
    }
    for procedure in procedures::ALL {
        assert_eq!(silent(procedure.survey_keys()), Vec::<&str>::new());
    }
}

#[test]
fn the_page_of_keys_is_the_lists() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/keys.md");
    let page = std::fs::read_to_string(path).expect("the page");
    let part = |(title, keys): (String, &[Key])| format!("## {title}\n\n{}", markdown(keys));
    let lists: String = described().into_iter().map(part).collect();
    assert!(
        page.ends_with(lists.trim_end()),
        "docs/keys.md should end with\n{lists}"
    );
}
