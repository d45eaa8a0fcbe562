//! Reports: schema of `result.json`, the terminal summary, the page.

#![allow(clippy::unwrap_used)]

mod fixture;

use boresight::report::{Export, csv, headline, html, json, text, write_all};
use boresight::results::{Calibration, Page, SCHEMA, Verdict};
use serde_json::Value;

/// The documented example, with matrices where it only describes them.
fn example() -> Value {
    let mut example: Value = serde_json::from_str(include_str!("result-example.json")).unwrap();
    let identity: Vec<Vec<f64>> = (0..7)
        .map(|i| (0..7).map(|j| f64::from(u8::from(i == j))).collect())
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
    let result: Calibration = serde_json::from_value(example()).unwrap();
    let written: Value = serde_json::from_slice(&json::to_bytes(&result).unwrap()).unwrap();
    contained(&example(), &written, "result");
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
        "reason",
        "verdict",
        "counts",
        "solutions",
        "comparison",
        "residual_rms_m",
        "notes",
        "details",
        "conventions",
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
    let joint = result.solutions.joint.as_mut().unwrap();
    joint.mountings[0].lever_arm_m = Some([0.1 + 0.2, 1.0 / 3.0, -5e-324]);
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
fn a_result_of_another_schema_is_refused_by_its_number() {
    let mut value: Value =
        serde_json::from_slice(&json::to_bytes(&fixture::result()).unwrap()).unwrap();
    value["schema"] = serde_json::json!(1);
    let refused = json::from_slice(value.to_string().as_bytes()).unwrap_err();
    let said = refused.to_string();
    assert!(
        said.contains("schema 1") && said.contains("boresight calibrate"),
        "{said}"
    );
    value["schema"] = serde_json::json!(SCHEMA);
    assert!(json::from_slice(value.to_string().as_bytes()).is_ok());
}

#[test]
fn a_result_that_does_not_say_whether_it_is_usable_is_refused() {
    let mut value: Value =
        serde_json::from_slice(&json::to_bytes(&fixture::result()).unwrap()).unwrap();
    value.as_object_mut().unwrap().remove("usable").unwrap();
    let refused = json::from_slice(value.to_string().as_bytes()).unwrap_err();
    assert!(refused.to_string().contains("usable"), "{refused}");
}

#[test]
fn a_refused_run_has_no_matrices_and_a_reason() {
    let value: Value =
        serde_json::from_slice(&json::to_bytes(&fixture::refused()).unwrap()).unwrap();
    assert_eq!(value["usable"], false);
    assert!(value["reason"].as_str().unwrap().contains("not determined"));
    let joint = &value["solutions"]["joint"];
    assert!(joint["covariance"].is_null() && joint["correlation"].is_null());
    for name in ["mountings", "parameters"] {
        assert_eq!(joint[name], serde_json::json!([]), "{name}");
    }
}

/// The twin of `the_headline_says_gain_and_significance_in_one_sentence`: the gain in RMS is gone, it ranks the wrong model best.
#[test]
fn the_difference_of_the_paths_is_said_with_its_significance() {
    let page = fixture::page(&fixture::samples(50));
    let said = |result: &Calibration| text::summary(result, &page).replace("\n  ", " ");
    let summary = said(&fixture::result());
    for part in [
        "differ most in yaw: 0.3044 deg, 5.1 standard deviations",
        "are significant: chi-square 44.0 on 6 degrees of freedom, p = 7e-8",
    ] {
        assert!(summary.contains(part), "{part} is not in: {summary}");
    }
    let mut same = fixture::result();
    same.comparison.as_mut().unwrap().p_value = 0.4;
    assert!(said(&same).contains("are not significant"));
}

#[test]
fn the_summary_begins_with_the_verdict_and_the_values_to_enter() {
    let summary = text::summary(&fixture::result(), &Page::default());
    let lines: Vec<&str> = summary.lines().collect();
    assert_eq!(
        (lines[0], lines[2]),
        ("Usable.", "Enter these values (joint solution)")
    );
    let row = |name: &str| {
        lines
            .iter()
            .find(|l| l.trim_start().starts_with(name))
            .unwrap()
    };
    let roll: Vec<&str> = row("roll, deg").split_whitespace().collect();
    assert_eq!(roll[2..5], ["-45.0000", "-45.9013", "0.0058"]);
    let forward: Vec<&str> = row("y, m").split_whitespace().collect();
    assert_eq!(forward[2..5], ["-0.2000", "-0.3202", "0.0051"]);
    assert!(row("range_scale").contains("0.00011"), "{summary}");
}

#[test]
fn no_line_of_the_summary_is_wider_than_a_terminal() {
    let page = fixture::page(&fixture::samples(50));
    for result in [
        fixture::result(),
        fixture::with_simple(),
        fixture::refused(),
    ] {
        let summary = text::summary(&result, &page);
        let wide = summary.lines().find(|l| l.chars().count() > 80);
        assert_eq!(wide, None);
    }
}

#[test]
fn the_summary_shows_both_paths_side_by_side() {
    let summary = text::summary(&fixture::result(), &Page::default());
    let row = |name: &str| {
        let corrections = summary.split("correction").nth(1).unwrap();
        corrections
            .lines()
            .find(|line| line.contains(name))
            .unwrap()
            .to_owned()
    };
    let yaw = row("yaw, deg");
    assert!(
        yaw.contains("1.5042") && yaw.contains("1.200 ± 0.060") && yaw.contains("5.1"),
        "{yaw}"
    );
    let lever = row("ly, m");
    assert!(
        lever.contains("-0.0988") && lever.contains("-0.1202 ± 0.0051"),
        "{lever}"
    );
    for part in [
        "stalled: two-step cycle",
        "15 911 used of 114 763",
        "global test: passed",
        "another distance",
    ] {
        assert!(
            summary.replace("\n  ", " ").contains(part),
            "{part} is not in:\n{summary}"
        );
    }
}

#[test]
fn a_finding_is_named_in_the_first_line() {
    let mut result = fixture::result();
    let finding = boresight::results::Finding::new(
        "latency",
        boresight::results::Severity::Finding,
        "the soundings look 2 ms late",
        "",
        "",
    );
    result.verdict = Verdict::of(vec![finding]);
    assert!(headline(&result).contains("2 ms late"));
}

#[test]
fn a_refused_run_shows_its_reason_and_no_numbers() {
    let summary = text::summary(&fixture::refused(), &Page::default());
    assert!(
        summary
            .starts_with("No usable result: yaw and the along-track lever arm are not determined")
    );
    assert!(
        !summary.contains("Enter these values") && !summary.contains("±"),
        "{summary}"
    );
}

#[test]
fn the_table_of_parameters_has_every_solution_before_and_after() {
    let table = csv::parameters(&fixture::result());
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 1 + 7 + 6 + 7);
    assert_eq!(
        lines[0],
        "solution,parameter,unit,before,after,correction,sigma,determined,usable,verdict"
    );
    assert!(lines[1].starts_with("enter,roll,deg,"), "{}", lines[1]);
    assert!(lines[10].starts_with("reference,yaw,deg,0,1.5042,1.5042,,true,true,"));
    assert!(lines[20].starts_with("joint,range_scale,1,0,0.000021,0.000021,0.00011,true"));
}

#[test]
fn every_export_has_the_values_of_the_card_and_fits_a_terminal() {
    let result = fixture::result();
    for form in Export::ALL {
        let said = form.text(&result, "fixture");
        assert!(said.contains("roll") || said.contains("Roll"), "{said}");
        if form != Export::Csv && form != Export::Latex {
            assert!(said.lines().all(|l| l.chars().count() <= 80), "{said}");
        }
    }
    let mut refused = result;
    refused.usable = false;
    let said = Export::Sis.text(&refused, "fixture");
    assert!(said.contains("nothing to enter"), "{said}");
}

#[test]
fn names_from_files_cannot_become_markup() {
    let mut samples = fixture::samples(50);
    samples.faces[0].name = "</script><img src=x onerror=alert(2)>".into();
    let mut result = fixture::result();
    result.provenance.inputs[0].path = "<!--<script>".into();
    let mut page = fixture::page(&samples);
    page.title = "</title><script>alert(1)</script>".into();
    let page = html::render(&result, &page).unwrap();
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
    let page = html::render(&fixture::result(), &fixture::page(&fixture::samples(50))).unwrap();
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
    let render =
        || html::render(&fixture::result(), &fixture::page(&fixture::samples(500))).unwrap();
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
        let written = write_all(
            &folder.join(kind),
            &result,
            &fixture::page(&fixture::samples(6000)),
            &[],
        )
        .unwrap();
        assert_eq!(
            std::fs::read(&written.result).unwrap(),
            json::to_bytes(&result).unwrap()
        );
        assert_eq!(
            std::fs::read_to_string(&written.parameters).unwrap(),
            csv::parameters(&result)
        );
        match crate::browser::installed() {
            Some(program) => opens(&program, &written.report, &headline(&result)),
            None => println!("skipped: no browser is installed"),
        }
    }
}

fn opens(program: &std::path::Path, page: &std::path::Path, headline: &str) {
    let (elements, messages) = crate::browser::open(program, page);
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
    let Some(program) = crate::browser::installed() else {
        println!("skipped: no browser is installed");
        return;
    };
    let mut result = fixture::result();
    result.comparison = None;
    result.solutions.joint = None;
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report/bare");
    let bare = boresight::procedures::pool::summary::ReportSamples::default();
    let page = boresight::procedures::pool::summary::packed_page(&bare, "bare").unwrap();
    let written = write_all(&folder, &result, &page, &[]).unwrap();
    let (elements, messages) = crate::browser::open(&program, &written.report);
    assert!(
        !messages.contains("CONSOLE") && elements.contains("data-ready=\"yes\""),
        "{messages}"
    );
}
