//! Pages of the error budget and the plan: nothing outside themselves, names stay names, and a browser opens them whatever is missing.

#![allow(clippy::unwrap_used)]

use boresight::report::{budget_headline, html};
use boresight::results::{BudgetResult, PlanResult};
use serde_json::{Value, json};

fn six(values: [f64; 6]) -> Value {
    json!(values)
}

fn parts(values: [f64; 6]) -> Value {
    json!(values)
}

fn parameters() -> Value {
    let parameter = |(name, unit): (&str, &str)| json!({"name": name, "unit": unit});
    let (angles, arm) = (["pitch", "roll", "yaw"], ["lx", "ly", "lz"]);
    let all = angles
        .map(|n| (n, "deg"))
        .into_iter()
        .chain(arm.map(|n| (n, "m")));
    all.map(parameter).collect()
}

const SIGMA: [f64; 6] = [0.03, 0.01, 0.06, 0.0004, 0.006, 0.002];

fn statistics(path: &str, factor: f64) -> Value {
    let reported = json!({
        "standard_deviation": six(SIGMA), "pull_mean": parts([0.1, -0.05, 0.0, 0.02, 0.0, -0.1]),
        "pull_rms": parts([1.0, 1.05, 0.98, 1.3, 1.0, 0.96]), "pull_rms_interval": {"lower": 0.9, "upper": 1.1},
        "nees": {"mean": 6.1, "interval": {"lower": 5.5, "upper": 6.5}, "trials": 200, "parameters": 6}, "variance_factor": 1.001,
    });
    json!({
        "path": path, "trials": 200, "usable": 198, "bias": six([0.001; 6]), "bias_standard_error": six([0.002; 6]),
        "standard_deviation": six(SIGMA.map(|s| s * factor)), "standard_deviation_interval": {"lower": 0.92, "upper": 1.1},
        "rms": six(SIGMA.map(|s| 1.1 * s * factor)), "reported": if path == "joint" { reported } else { Value::Null },
    })
}

fn share(source: &str, origin: &str, part: f64) -> Value {
    json!({
        "source": source, "origin": origin, "usable": 50, "trials": 50, "bias": six([0.0, 0.0, 0.02, 0.0, 0.001, 0.0]),
        "standard_deviation": six(SIGMA.map(|s| s * part.sqrt())), "share": parts([part, 0.9 * part, part, part, part, 0.5 * part]),
    })
}

fn path(name: &str, factor: f64) -> Value {
    let shares = ["analytic", "monte_carlo"].iter().flat_map(|origin| {
        [
            ("position_drift", 0.7),
            ("sonar_range", 0.2),
            ("sonar_angle", 0.09),
            ("heading", 0.004),
        ]
        .map(|(source, part)| share(source, origin, part))
    });
    json!({
        "path": name, "variant": if name == "joint" { "" } else { "literal" }, "together": statistics(name, factor),
        "shares": shares.collect::<Vec<_>>(),
        "agreement": [{"source": "position_drift", "variance_ratio": {"pitch": 1.02, "ly": 1.6}, "interval": {"lower": 0.7, "upper": 1.4},
            "comparisons": 48, "outside": ["ly"], "note": "association"}],
        "bound": six(SIGMA.map(|s| 0.9 * s)), "efficiency": parts([0.9 / factor; 6]),
    })
}

fn source(name: &str) -> Value {
    json!({"source": name, "title": format!("{name} in words"), "description": "normal, per record",
        "size": {"trajectory.position_drift_sigma_m": "0.005"}, "default": {"position_drift_sigma_m": 0.005}, "reference": "a data sheet"})
}

fn sweep(keys: &[&str]) -> Value {
    let values: Vec<Vec<f64>> = match keys.len() {
        1 => vec![vec![0.001], vec![0.005], vec![0.02]],
        _ => vec![
            vec![1.0, 5.0],
            vec![1.0, 7.0],
            vec![2.0, 5.0],
            vec![2.0, 7.0],
        ],
    };
    let point = |v: &Vec<f64>| json!({"values": v, "paths": [statistics("joint", 1.0 + v[0]), statistics("reference", 5.0)], "refusals": []});
    json!({"keys": keys, "trials": 40, "points": values.iter().map(point).collect::<Vec<_>>()})
}

fn swath() -> Value {
    let both = |v: f64| json!({"horizontal_m": v, "vertical_m": 0.5 * v});
    let beam = |a: f64| {
        json!({"angle_deg": a, "calibration": both(0.02 + 1e-4 * a * a), "sensors": both(0.05), "total": both(0.06 + 1e-4 * a * a),
            "order": if a.abs() > 60.0 { Value::Null } else { json!("Special") }})
    };
    let beams: Vec<Value> = (-7..=7).map(|k| beam(f64::from(k) * 10.0)).collect();
    let zeros = [[0.0; 6]; 6];
    let path = |name: &str| json!({"path": name, "origin": "reported", "covariance": zeros, "depths": [{"depth_m": 10.0, "beams": beams}, {"depth_m": 50.0, "beams": beams}]});
    let limits = |d: f64| {
        json!({"depth_m": d, "orders": [{"order": "Exclusive", "horizontal_m": 1.0, "vertical_m": 0.15}, {"order": "1a", "horizontal_m": 5.5, "vertical_m": 0.52},
            {"order": "1b", "horizontal_m": 5.5, "vertical_m": 0.52}]})
    };
    json!({"standard": "S-44", "assumptions": "level boat", "limits": [limits(10.0), limits(50.0)], "paths": [path("joint"), path("reference")]})
}

fn whole() -> Value {
    let sources = ["position_drift", "sonar_range", "sonar_angle", "heading"].map(source);
    json!({
        "format_version": 2, "procedure": "pool", "parameters": parameters(), "scenario": "a scenario", "scenario_sha256": "00", "software": {"name": "boresight", "version": "0.0.0"},
        "first_seed": 1, "trials": 200, "single_trials": 50, "confidence": 0.95, "configuration": {"joint": {}},
        "sources": sources,
        "paths": [path("joint", 1.0), path("reference", 6.0), path("reference_projected", 5.0)],
        "refusals": [{"path": "reference", "code": "out", "count": 2, "seeds": [3, 9], "example": "out of passes"}],
        "sweep": sweep(&["trajectory.position_drift_sigma_m"]), "swath": swath(), "command": "boresight budget a.toml --trials 200",
        "notes": ["a note"],
    })
}

fn budget(value: Value) -> BudgetResult {
    serde_json::from_value(value).unwrap()
}

fn plan_value() -> Value {
    let pass = |d: f64, crab: f64| json!({"name": format!("{d} m"), "distance_m": d, "from_m": -9.0, "to_m": 9.0, "speed_m_s": 0.5, "crab_deg": crab});
    let candidate = |d: f64| json!({"pass": pass(d, 5.0), "soundings": 500, "returns": 600, "standard_deviation_if_next": six(SIGMA.map(|s| s * 0.7))});
    json!({
        "format_version": 2, "parameters": parameters(), "scenario": "a scenario", "scenario_sha256": "00", "software": {"name": "boresight", "version": "0.0.0"}, "command": "boresight plan a.toml",
        "criterion": "d", "wanted": six([0.015, 0.015, 0.015, 0.0012, 0.0012, 0.0012]), "sailed": [pass(6.0, 0.0)],
        "sailed_standard_deviation": six(SIGMA),
        "candidates": [candidate(4.0), candidate(9.0), {"pass": pass(80.0, 0.0), "soundings": 0, "returns": 0, "standard_deviation_if_next": null, "refusal": "out of range"}],
        "chosen": [{"candidate": 0, "name": "4 m", "standard_deviation": six(SIGMA.map(|s| s * 0.7))}, {"candidate": 1, "name": "9 m", "standard_deviation": six(SIGMA.map(|s| s * 0.5))}],
        "most": 2, "passes_needed": null, "floor": six(SIGMA.map(|s| s * 0.3)), "unreachable": ["yaw"],
        "faces_from_above_m": [[[-4.0, 0.0], [4.0, 0.0]], [[-5.5, 0.0], [-4.0, 0.0], [-5.5, -1.5]]],
        "variations": {"keys": ["multibeam.tilt_deg"], "points": [{"values": [30.0], "standard_deviation": six(SIGMA)}, {"values": [80.0], "standard_deviation": null, "refusal": "unseen"}]},
        "notes": ["a note"],
    })
}

fn plan(value: Value) -> PlanResult {
    serde_json::from_value(value).unwrap()
}

#[test]
fn the_pages_refer_to_nothing_outside_themselves_and_have_no_mark_left() {
    let pages = [
        html::budget(&budget(whole())),
        html::plan(&plan(plan_value())),
    ];
    for page in pages.map(Result::unwrap) {
        let bare = page.replace("http://www.w3.org/2000/svg", "");
        for sign in [
            "http://", "https://", "src=", "href=", "url(", "@import", "fetch(", "import(",
        ] {
            assert!(!bare.contains(sign), "{sign}");
        }
        for name in ["title", "kind", "style", "data", "scripts"] {
            assert!(!page.contains(&format!("<!--{name}-->")), "{name}");
        }
    }
}

#[test]
fn names_from_files_cannot_become_markup() {
    let evil = "</script><script>alert(1)</script><!--";
    let (mut b, mut p) = (whole(), plan_value());
    b["scenario"] = json!(evil);
    b["sources"][0]["title"] = json!(evil);
    b["refusals"][0]["example"] = json!(evil);
    p["scenario"] = json!(evil);
    p["candidates"][0]["pass"]["name"] = json!(evil);
    for page in [
        html::budget(&budget(b)).unwrap(),
        html::plan(&plan(p)).unwrap(),
    ] {
        assert_eq!(
            page.matches("<script").count(),
            2,
            "one for the data, one for the code"
        );
        assert!(!page.contains("<script>alert"));
    }
}

#[test]
fn the_headline_names_the_gain_the_largest_source_and_the_truth() {
    let sentence = budget_headline(&budget(whole()));
    for part in [
        "0.0660 deg against 0.396 deg in yaw",
        "position_drift in words, 70 % of the variance",
        "right within chance (NEES 6.10, 5.50 to 6.50",
    ] {
        assert!(sentence.contains(part), "{part} is not in: {sentence}");
    }
    let mut small = whole();
    small["paths"][0]["together"]["reported"]["nees"]["mean"] = json!(9.0);
    assert!(budget_headline(&budget(small)).contains("are too small (NEES 9.00"));
}

/// The whole, and with parts missing: nothing simulated, no single sources, nothing analytic, two keys, nothing but a name.
fn kinds() -> Vec<(&'static str, Value)> {
    let without = |change: &dyn Fn(&mut Value)| {
        let mut value = whole();
        change(&mut value);
        value
    };
    let shares = |value: &mut Value, keep: &dyn Fn(&Value) -> bool| {
        for k in 0..3 {
            value["paths"][k]["shares"]
                .as_array_mut()
                .unwrap()
                .retain(keep);
            value["paths"][k]["agreement"] = json!([]);
        }
    };
    vec![
        ("whole", whole()),
        (
            "no-trials",
            without(&|v| {
                shares(v, &|s| s["origin"] == "analytic");
                (0..3).for_each(|k| v["paths"][k]["together"] = Value::Null);
                v["sweep"] = Value::Null;
                v["refusals"] = json!([]);
            }),
        ),
        ("no-singles", without(&|v| shares(v, &|_| false))),
        (
            "no-analytic",
            without(&|v| {
                shares(v, &|s| s["origin"] == "monte_carlo");
                for k in 0..3 {
                    v["paths"][k]["bound"] = Value::Null;
                    v["paths"][k]["efficiency"] = Value::Null;
                }
            }),
        ),
        (
            "two-keys",
            without(&|v| v["sweep"] = sweep(&["a.b", "pass.*.distance_m"])),
        ),
        (
            "bare",
            without(&|v| {
                shares(v, &|_| false);
                for k in 0..3 {
                    for part in ["together", "bound", "efficiency"] {
                        v["paths"][k][part] = Value::Null;
                    }
                }
                (v["sweep"], v["swath"], v["refusals"], v["sources"]) =
                    (Value::Null, Value::Null, json!([]), json!([]));
            }),
        ),
    ]
}

/// Leaves the pages in the target folder, where a person can look at them too.
#[test]
fn the_pages_open_in_a_browser_without_errors_whatever_is_missing() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("budget-pages");
    std::fs::create_dir_all(&folder).unwrap();
    let mut bare_plan = plan_value();
    (
        bare_plan["sailed"],
        bare_plan["chosen"],
        bare_plan["variations"],
    ) = (json!([]), json!([]), Value::Null);
    bare_plan["sailed_standard_deviation"] = Value::Null;
    let mut pages: Vec<(String, String, usize)> = vec![
        ("plan".into(), html::plan(&plan(plan_value())).unwrap(), 9),
        ("bare-plan".into(), html::plan(&plan(bare_plan)).unwrap(), 6),
    ];
    for (kind, value) in kinds() {
        let drawn = match kind {
            "whole" => 20,
            "bare" => 0,
            _ => 6,
        };
        pages.push((kind.into(), html::budget(&budget(value)).unwrap(), drawn));
    }
    for (kind, page, drawn) in pages {
        let file = folder.join(format!("{kind}.html"));
        std::fs::write(&file, page).unwrap();
        let Some(program) = crate::browser::installed() else {
            println!("skipped: no browser is installed");
            return;
        };
        let (elements, messages) = crate::browser::open(&program, &file);
        assert!(!messages.contains("CONSOLE"), "{kind}: {messages}");
        assert!(
            elements.contains("data-ready=\"yes\""),
            "{kind}: {messages}"
        );
        assert!(elements.matches("<svg").count() >= drawn, "{kind}");
        let (drawn_part, _) = elements
            .split_once("<script type=\"application/json\"")
            .unwrap();
        for word in ["NaN", "undefined", "Infinity", "[object"] {
            assert!(!drawn_part.contains(word), "{kind}: {word}");
        }
    }
}
