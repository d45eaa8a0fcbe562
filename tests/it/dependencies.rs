//! Licences, sources and bans of everything that is built in, held to `deny.toml`: what `cargo deny` checks too where it is installed.

use std::collections::BTreeSet;
use std::process::Command;

use serde_json::Value;
use spdx::{Expression, ParseMode};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Where packages may come from.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

fn list(text: &str, table: &str, key: &str) -> Vec<toml::Value> {
    let rules: toml::Table = text.parse().expect("deny.toml is TOML");
    let list = rules[table][key].as_array().expect("a list");
    assert!(!list.is_empty());
    list.clone()
}

/// Every package of the build, the project's own apart.
fn packages() -> Vec<Value> {
    let mut host = Command::new("rustc");
    let host = host.arg("-vV").output().expect("rustc says its host");
    let host = String::from_utf8(host.stdout).expect("text");
    let host = host.lines().find_map(|line| line.strip_prefix("host: "));
    let mut metadata = Command::new(env!("CARGO"));
    metadata.args([
        "metadata",
        "--format-version",
        "1",
        "--locked",
        "--all-features",
    ]);
    metadata.args(["--filter-platform", host.expect("a host")]);
    let output = metadata.current_dir(ROOT).output().expect("cargo metadata");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let resolved: BTreeSet<&str> = all["resolve"]["nodes"]
        .as_array()
        .expect("nodes")
        .iter()
        .filter_map(|node| node["id"].as_str())
        .collect();
    let packages = all["packages"].as_array().expect("packages").iter();
    let built = packages.filter(|p| resolved.contains(p["id"].as_str().unwrap_or_default()));
    let foreign: Vec<Value> = built.filter(|p| !p["source"].is_null()).cloned().collect();
    assert!(foreign.len() > 100, "{} packages", foreign.len());
    foreign
}

/// What is wrong with a package.
fn fault(package: &Value, allowed: &BTreeSet<String>, banned: &[String]) -> Option<String> {
    let name = package["name"].as_str().unwrap_or_default();
    if package["source"] != REGISTRY {
        return Some(format!("{name}: from {}", package["source"]));
    }
    if banned.iter().any(|other| other == name) {
        return Some(format!("{name}: is banned"));
    }
    let Some(licence) = package["license"].as_str() else {
        return Some(format!("{name}: states no licence"));
    };
    match Expression::parse_mode(licence, ParseMode::LAX) {
        Ok(terms) if terms.evaluate(|term| allowed.contains(&term.to_string())) => None,
        Ok(_) => Some(format!("{name}: {licence} is not allowed")),
        Err(error) => Some(format!("{name}: {licence}: {error}")),
    }
}

#[test]
fn every_package_has_a_licence_and_a_source_that_deny_toml_allows() {
    let rules = std::fs::read_to_string(format!("{ROOT}/deny.toml")).expect("deny.toml");
    let text = |value: &toml::Value| value.as_str().expect("a text").to_owned();
    let allowed: BTreeSet<String> = list(&rules, "licenses", "allow").iter().map(text).collect();
    let banned = list(&rules, "bans", "deny");
    let banned: Vec<String> = banned.iter().map(|ban| text(&ban["name"])).collect();
    let packages = packages();
    let faults: Vec<String> = packages
        .iter()
        .filter_map(|p| fault(p, &allowed, &banned))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // with a licence less, or a package banned, it says so
    let without: BTreeSet<String> = allowed.into_iter().filter(|l| l != "MIT").collect();
    assert!(
        packages
            .iter()
            .any(|p| fault(p, &without, &banned).is_some())
    );
    let ban = ["serde".to_owned()];
    assert!(
        packages
            .iter()
            .any(|p| fault(p, &without, &ban).is_some_and(|f| f == "serde: is banned"))
    );
}
