//! The summary for the terminal; no line is wider than 80 columns.

use super::card::{Card, card};
use super::format::{grouped, shown, status};
use super::headline::{difference, headline};
use crate::results::{
    AgainstTruth, Calibration, Finding, Page, Parameter, Quality, SensorCounts, Severity, Solution,
    TextTable,
};
use crate::ruled::{Ruled, WIDTH, unbroken};
use crate::units::with_sigma;

/// The summary: verdict and values to enter first, then both paths side by side, how they ended, what the procedure adds, tests, counts
/// and notes. Ends with a newline.
#[must_use]
pub fn summary(result: &Calibration, page: &Page) -> String {
    let joint = result.solutions.joint.as_ref();
    let quality = joint.and_then(|joint| joint.quality.as_ref());
    let mut parts = vec![
        wrapped(&headline(result)),
        further(&result.verdict.findings),
        card(result).map_or_else(String::new, |card| values(&card)),
        corrections(result),
        result
            .comparison
            .as_ref()
            .map_or_else(String::new, |c| wrapped(&difference(c))),
        ends(result),
    ];
    parts.extend(page.tables.iter().map(own));
    parts.push(quality.map_or_else(String::new, tests));
    parts.push(counts(result));
    parts.push(notes(&result.notes));
    parts.extend(page.against_truth.as_ref().map(against_truth));
    let filled = parts.iter().map(|p| p.trim_end()).filter(|p| !p.is_empty());
    filled.collect::<Vec<_>>().join("\n\n") + "\n"
}

/// Findings that are listed after the one in the headline, at the most.
const FURTHER: usize = 5;

/// What was found beside the first finding, which stands in the headline, and how to accept what the surveyor knows.
fn further(findings: &[Finding]) -> String {
    let one = |finding: &Finding| {
        let state = match (finding.accepted, finding.withdraws()) {
            (true, _) => " (accepted)",
            (false, true) => "",
            (false, false) => " (worth a look)",
        };
        let text = format!("- {}{state}: {}", finding.code, finding.seen);
        wrapped(&match finding.advice.as_str() {
            "" => text,
            advice => format!("{text}; {advice}"),
        })
    };
    let rest = findings.iter().skip(1);
    let mut lines: Vec<String> = rest.take(FURTHER).map(one).collect();
    if !lines.is_empty() {
        lines.insert(0, "Also found".to_owned());
    }
    let more = findings.len().saturating_sub(FURTHER + 1);
    if more > 0 {
        lines.push(format!("- and {more} more, in the report"));
    }
    let takes = |finding: &&Finding| finding.severity == Severity::Withdraws && !finding.accepted;
    let refused = findings
        .iter()
        .any(|finding| finding.severity == Severity::Refuses);
    if let Some(first) = findings.iter().find(takes).filter(|_| !refused) {
        let code = &first.code;
        let how = format!(
            "To accept a finding that you know: [verdict] accept = [\"{code}\"] in the survey file."
        );
        lines.push(wrapped(&how));
    }
    lines.join("\n")
}

/// Broken between words; lines after the first are indented.
pub(super) fn wrapped(sentence: &str) -> String {
    let mut lines = vec![String::new()];
    for word in unbroken(sentence.split(' ')) {
        let last = lines.last().map_or(0, |l| l.chars().count());
        if last > 0 && last + 1 + word.chars().count() > WIDTH {
            lines.push(format!("  {word}"));
        } else if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(&word);
        }
    }
    lines.join("\n")
}

fn values(card: &Card) -> String {
    let mut table = Ruled::new(["", "before", "after", "sigma", "positive"]).numbers(1..4);
    for row in &card.rows {
        table.row([
            titled(&row.name, &row.unit),
            row.before.clone(),
            row.after.clone(),
            row.sigma.clone(),
            row.positive.clone(),
        ]);
    }
    let from = words(card.solution);
    format!("Enter these values ({from} solution)\n{table}")
}

fn titled(name: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" {
        name.to_owned()
    } else {
        format!("{name}, {unit}")
    }
}

/// A solution's name as people say it.
fn words(solution: &str) -> &str {
    match solution {
        SIMPLE => "simple joint",
        other => other,
    }
}

/// Every solution's corrections side by side.
fn corrections(result: &Calibration) -> String {
    let usable = |(_, s): &(&str, &Solution)| s.usable && !s.parameters.is_empty();
    let shown: Vec<_> = result.solutions.named().filter(usable).collect();
    let Some((_, widest)) = shown.iter().max_by_key(|(_, s)| s.parameters.len()) else {
        return String::new();
    };
    let mut header = vec!["correction".to_owned()];
    header.extend(shown.iter().map(|(name, s)| column(name, s)));
    if result.comparison.is_some() {
        header.push("diff., sigmas".to_owned());
    }
    let mut table = Ruled::new(header);
    for parameter in &widest.parameters {
        let mut row = vec![titled(&parameter.name, &parameter.unit)];
        row.extend(
            shown
                .iter()
                .map(|(name, s)| cell(s.parameter(&parameter.name), *name != SIMPLE)),
        );
        row.extend(result.comparison.as_ref().map(|c| {
            let own = c.differences.iter().find(|d| d.name == parameter.name);
            own.map_or_else(String::new, |d| format!("{:.1}", d.in_joint_sigmas))
        }));
        table.row(row);
    }
    table.to_string()
}

/// The solution that is for research: its sigmas are too small, and three columns with sigmas do not fit.
const SIMPLE: &str = "joint_simple";

fn column(name: &str, solution: &Solution) -> String {
    let sigmas = solution.covariance.is_some() && name != SIMPLE;
    format!("{}{}", words(name), if sigmas { " ± 1 sigma" } else { "" })
}

fn cell(parameter: Option<&Parameter>, with_sigmas: bool) -> String {
    let Some(p) = parameter else {
        return String::new();
    };
    match (p.correction, p.sigma.filter(|_| with_sigmas)) {
        (Some(value), Some(sigma)) => with_sigma(value, sigma),
        (Some(value), None) if p.note.is_empty() => shown(value, &p.unit),
        (Some(value), None) => {
            let short = p.note.split(':').next().unwrap_or_default(); // the rest stands in the report
            format!("{} ({short})", shown(value, &p.unit))
        }
        _ => "-".to_owned(),
    }
}

fn ends(result: &Calibration) -> String {
    let line = |(name, s): (&str, &Solution)| {
        let usable = if s.usable { "" } else { ", not usable" };
        let said = result.reason.as_deref() == Some(s.message.as_str());
        let message = if s.message.is_empty() || said {
            String::new()
        } else {
            format!(": {}", s.message)
        };
        wrapped(&format!(
            "{} solution: {}{usable}{message}",
            words(name),
            status(s.status)
        ))
    };
    let all: Vec<String> = result.solutions.named().map(line).collect();
    all.join("\n")
}

/// A table of the procedure's own.
fn own(of: &TextTable) -> String {
    let mut parts = vec![];
    if !of.rows.is_empty() {
        let mut table = Ruled::new(&of.header);
        for row in &of.rows {
            table.row(row);
        }
        parts.push(table.to_string());
    }
    parts.extend(of.lines.iter().map(|line| wrapped(line)));
    parts.join("\n")
}

fn tests(quality: &Quality) -> String {
    let t = &quality.global_test;
    let verdict = match (t.void_because.as_str(), t.passed) {
        ("", true) => "passed".into(),
        ("", false) => "failed".into(),
        (why, _) => format!("not valid: {why}"),
    };
    let mut lines = vec![wrapped(&format!(
        "global test: {verdict}; variance factor {:.4}, {:.0} % interval {:.4} to {:.4}, {} degrees of freedom",
        t.statistic,
        100.0 * (1.0 - t.significance),
        t.lower,
        t.upper,
        grouped(quality.degrees_of_freedom)
    ))];
    let weak = &quality.observability.weak;
    lines.extend(
        weak.iter()
            .map(|w| wrapped(&format!("weakly determined: {}", w.text))),
    );
    lines.join("\n")
}

fn counts(result: &Calibration) -> String {
    let all: Vec<String> = result
        .counts
        .iter()
        .map(|(name, c)| counted(name, c))
        .collect();
    all.join("\n")
}

fn counted(sensor: &str, counts: &SensorCounts) -> String {
    let reasons: Vec<String> = counts
        .rejected
        .iter()
        .map(|(reason, count)| format!("{} {reason}", grouped(*count)))
        .collect();
    let rejected = if reasons.is_empty() {
        String::new()
    } else {
        format!("; not used: {}", reasons.join(", "))
    };
    wrapped(&format!(
        "{sensor}: {} used of {}{rejected}",
        grouped(counts.used),
        grouped(counts.read)
    ))
}

fn notes(notes: &[String]) -> String {
    let lines: Vec<String> = notes
        .iter()
        .map(|note| wrapped(&format!("Note: {note}.")))
        .collect();
    lines.join("\n")
}

/// Each path's errors, the joint one's also in its own standard deviations; empty when nothing was found.
#[must_use]
pub fn against_truth(found: &AgainstTruth) -> String {
    let any = |of: fn(&crate::results::TruthRow) -> Option<f64>| {
        found.rows.iter().any(|r| of(r).is_some())
    };
    let simple = any(|r| r.joint_simple);
    if !any(|r| r.reference) && !any(|r| r.joint) {
        return String::new();
    }
    let mut header = vec!["error against the truth", "reference", "joint", "in sigmas"];
    header.extend(simple.then_some("simple joint"));
    let mut table = Ruled::new(header);
    for row in &found.rows {
        let number = |v: Option<f64>| v.map_or_else(String::new, |v| signed(v, &row.unit));
        let sigmas = row
            .joint_in_sigmas
            .map_or_else(String::new, |s| format!("{s:+.1}"));
        let mut cells = vec![
            titled(&row.name, &row.unit),
            number(row.reference),
            number(row.joint),
            sigmas,
        ];
        cells.extend(simple.then(|| number(row.joint_simple)));
        table.row(cells);
    }
    table.to_string()
}

fn signed(value: f64, unit: &str) -> String {
    if unit == "1" {
        format!("{value:+.7}")
    } else {
        format!("{value:+.5}")
    }
}

#[cfg(test)]
mod tests_of_lines {
    use super::*;

    #[test]
    fn every_finding_stands_with_its_advice_and_how_to_accept_it() {
        let finding = |code, severity| Finding::new(code, severity, "seen", "limit", "try this");
        let two = [
            finding("latency", Severity::Withdraws),
            finding("face", Severity::Finding),
        ];
        let text = further(&two);
        assert!(
            text.contains("- face (worth a look): seen; try this"),
            "{text}"
        );
        assert!(text.contains("accept = [\"latency\"]"), "{text}");
        let refused = [
            finding("sign_of_roll", Severity::Refuses),
            finding("latency", Severity::Withdraws),
        ];
        let text = further(&refused);
        assert!(
            text.contains("- latency: seen") && !text.contains("accept"),
            "{text}"
        );
        assert_eq!(further(&[]), "");
    }

    #[test]
    fn a_long_sentence_is_broken_between_words() {
        let text = wrapped(&"word ".repeat(40));
        assert!(text.lines().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert_eq!(text.matches("word").count(), 40);
    }
}
