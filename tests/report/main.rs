//! Reports: schema of `result.json`, the terminal summary, the page.

#![allow(clippy::unwrap_used)]

mod browser;
mod fixture;

use boresight::report::{headline, html, json, text, write_all};
use boresight::results::PoolResult;
use serde_json::Value;

/// The documented example, with matrices where it only describes them.
fn example() -> Value {
    let mut example: Value = serde_json::from_str(include_str!("result-example.json")).unwrap();
    let identity: Vec<Vec<f64>> = (0..6)
        .map(|i| (0..6).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for name in ["covariance", "correlation"] {
        example["solutions"]["joint"][name] = serde_json::json!(identity);
    }
    example
}

/// Every member of `a` with its value is in `b`; numbers by value, so that 1 is 1.0.
fn contained(a: &Value, b: &Value, place: &str) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            for (key, value) in a {
                contained(
                    value,
                    b.get(key)
                        .unwrap_or_else(|| panic!("{place}.{key} is missing")),
                    &format!("{place}.{key}"),
                );
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter()
                .zip(b)
                .enumerate()
                .for_each(|(i, (a, b))| contained(a, b, &format!("{place}[{i}]")));
        }
        (Value::Number(a), Value::Number(b)) => assert_eq!(a.as_f64(), b.as_f64(), "{place}"),
        _ => assert_eq!(a, b, "{place}"),
    }
}

#[test]
fn the_documented_example_is_read_and_written_without_loss() {
    let result: PoolResult = serde_json::from_value(example()).unwrap();
    let mut written: Value = serde_json::from_slice(&json::to_bytes(&result).unwrap()).unwrap();
    contained(&example(), &written, "result");
    let members = written.as_object_mut().unwrap();
    assert_eq!(
        (members.remove("usable"), members.remove("reason")),
        (Some(Value::Bool(true)), Some(Value::Null))
    );
    contained(&written, &example(), "example");
}

#[test]
fn members_stand_in_the_documented_order() {
    let text = String::from_utf8(json::to_bytes(&fixture::result()).unwrap()).unwrap();
    let order = [
        "schema",
        "procedure",
        "software",
        "seed",
        "inputs",
        "configuration",
        "usable",
        "counts",
        "target_pose",
        "solutions",
        "comparison",
    ];
    let places: Vec<usize> = order
        .iter()
        .map(|name| text.find(&format!("\n  \"{name}\": ")).unwrap())
        .collect();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn every_float_comes_back_bit_for_bit() {
    let mut result = fixture::with_simple();
    result
        .solutions
        .joint
        .as_mut()
        .unwrap()
        .estimate
        .lever_arm_m = Some([0.1 + 0.2, 1.0 / 3.0, -5e-324]);
    let bytes = json::to_bytes(&result).unwrap();
    assert_eq!(json::from_slice(&bytes).unwrap(), result);
    assert_eq!(
        json::to_bytes(&json::from_slice(&bytes).unwrap()).unwrap(),
        bytes
    );
}

#[test]
fn a_value_that_is_not_finite_becomes_null() {
    let mut result = fixture::result();
    result.comparison.as_mut().unwrap().chi_square = f64::NAN;
    let value: Value = serde_json::from_slice(&json::to_bytes(&result).unwrap()).unwrap();
    assert!(value["comparison"]["chi_square"].is_null());
}

#[test]
fn a_refused_run_has_null_matrices_and_a_reason() {
    let value: Value =
        serde_json::from_slice(&json::to_bytes(&fixture::refused()).unwrap()).unwrap();
    assert_eq!(value["usable"], false);
    assert!(value["reason"].as_str().unwrap().contains("not determined"));
    for name in [
        "rotation_matrix",
        "covariance",
        "correlation",
        "mounting_deg",
        "lever_arm_m",
    ] {
        assert!(value["solutions"]["joint"][name].is_null(), "{name}");
    }
}

#[test]
fn the_headline_says_gain_and_significance_in_one_sentence() {
    let sentence = headline(&fixture::result());
    for part in [
        "from 13.1 mm",
        "to 9.8 mm",
        "5.1 standard deviations",
        "yaw, 0.3044 deg",
        "which is significant",
        "6 degrees of freedom, p = 7e-8",
    ] {
        assert!(sentence.contains(part), "{part} is not in: {sentence}");
    }
    let mut same = fixture::result();
    same.comparison.as_mut().unwrap().p_value = 0.4;
    assert!(headline(&same).contains("which is not significant"));
}

#[test]
fn the_summary_shows_both_paths_side_by_side() {
    let summary = text::summary(&fixture::result());
    let yaw = summary.lines().find(|line| line.contains("yaw (")).unwrap();
    assert!(
        yaw.contains("1.5042") && yaw.contains("1.200 ± 0.060") && yaw.contains("5.1"),
        "{yaw}"
    );
    let lever = summary.lines().find(|line| line.contains("ly (")).unwrap();
    assert!(
        lever.contains("-98.8") && lever.contains("-120.2 ± 5.1"),
        "{lever}"
    );
    for part in [
        "stalled: two-step cycle",
        "15 911 used of 114 763",
        "global test: passed",
        "another distance",
        "roll -45.9013",
    ] {
        assert!(summary.contains(part), "{part} is not in:\n{summary}");
    }
}

#[test]
fn a_refused_run_shows_its_reason_and_no_numbers() {
    let summary = text::summary(&fixture::refused());
    assert!(
        summary
            .starts_with("No usable result: yaw and the along-track lever arm are not determined")
    );
    assert!(
        !summary.contains("mounting (") && !summary.contains("±"),
        "{summary}"
    );
}

#[test]
fn names_from_files_cannot_become_markup() {
    let mut samples = fixture::samples(50);
    samples.title = "</title><script>alert(1)</script>".into();
    samples.faces[0].name = "</script><img src=x onerror=alert(2)>".into();
    let mut result = fixture::result();
    result.provenance.inputs[0].path = "<!--<script>".into();
    let page = html::render(&result, &samples).unwrap();
    assert_eq!(
        page.matches("<script").count(),
        2,
        "one for the data, one for the code"
    );
    assert!(
        !page.contains("<img src=x")
            && !page.contains("<script>alert")
            && !page.contains("<!--<script>")
    );
}

#[test]
fn the_page_refers_to_nothing_outside_itself() {
    let page = html::render(&fixture::result(), &fixture::samples(50)).unwrap();
    let namespace = "http://www.w3.org/2000/svg";
    for sign in [
        "http://",
        "https://",
        "src=",
        "href=",
        "url(",
        "@import",
        "fetch(",
        "XMLHttpRequest",
        "import(",
        "//cdn",
    ] {
        assert!(!page.replace(namespace, "").contains(sign), "{sign}");
    }
}

#[test]
fn the_page_has_no_mark_left_unfilled_and_is_the_same_twice() {
    let render = || html::render(&fixture::result(), &fixture::samples(500)).unwrap();
    let page = render();
    assert_eq!(page, render());
    for name in ["title", "style", "data", "scripts"] {
        assert!(!page.contains(&format!("<!--{name}-->")), "{name}");
    }
}

/// Leaves the pages in the target folder, where a person can look at them too.
#[test]
fn both_files_are_written_and_the_pages_open_in_a_browser_without_errors() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    let kinds = [
        ("both", fixture::result()),
        ("three", fixture::with_simple()),
        ("refused", fixture::refused()),
    ];
    for (kind, result) in kinds {
        let written = write_all(&folder.join(kind), &result, &fixture::samples(6000)).unwrap();
        assert_eq!(
            std::fs::read(&written.result).unwrap(),
            json::to_bytes(&result).unwrap()
        );
        match browser::installed() {
            Some(program) => opens(&program, &written.report, &headline(&result)),
            None => println!("skipped: no browser is installed"),
        }
    }
}

fn opens(program: &std::path::Path, page: &std::path::Path, headline: &str) {
    let (elements, messages) = browser::open(program, page);
    assert!(!messages.contains("CONSOLE"), "{messages}");
    assert!(
        elements.contains("data-ready=\"yes\""),
        "the scripts did not run to their end: {messages}"
    );
    assert!(elements.contains(headline), "{headline}");
    for drawn in ["<canvas", "<svg", "<table"] {
        assert!(elements.matches(drawn).count() > 3, "{drawn}");
    }
}

/// Only one path, no samples at all: fewer pictures, no error.
#[test]
fn a_bare_result_of_one_path_opens_in_a_browser_too() {
    let Some(program) = browser::installed() else {
        println!("skipped: no browser is installed");
        return;
    };
    let mut result = fixture::result();
    result.comparison = None;
    result.solutions.joint = None;
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report/bare");
    let written = write_all(
        &folder,
        &result,
        &boresight::results::ReportSamples::default(),
    )
    .unwrap();
    let (elements, messages) = browser::open(&program, &written.report);
    assert!(
        !messages.contains("CONSOLE") && elements.contains("data-ready=\"yes\""),
        "{messages}"
    );
}
