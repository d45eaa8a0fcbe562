//! The summary for the terminal.

use super::format::{ROWS, grouped, in_order, plain, shown, shown_sigmas, status};
use super::headline;
use crate::results::{
    Estimate, JointSolution, PoolResult, Quality, SensorCounts, SequentialSolution, SixSigmas,
};
use crate::units::with_sigma;
use comfy_table::{CellAlignment, LineStyle, Table, presets};
use std::fmt::Write;

/// A summary of some thirty lines: verdict, both paths side by side, the mounting to enter, ends, tests, weak directions, counts.
/// Ends with a newline.
#[must_use]
pub fn summary(result: &PoolResult) -> String {
    let mut text = format!("{}\n", headline(result));
    paragraph(&mut text, &corrections(result));
    paragraph(&mut text, &mounting(result));
    paragraph(&mut text, &ends(result));
    if let Some(quality) = result
        .solutions
        .joint
        .as_ref()
        .and_then(|joint| joint.quality.as_ref())
    {
        paragraph(&mut text, &tests(quality));
    }
    paragraph(&mut text, &counts(result));
    text
}

/// An empty table for the terminal with lines above, below and under its header only.
#[must_use]
pub fn ruled_table() -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none()));
    table
}

fn paragraph(text: &mut String, lines: &str) {
    if !lines.is_empty() {
        text.push('\n');
        text.push_str(lines.trim_end());
        text.push('\n');
    }
}

/// One column of the table: a path's name and its six values.
struct Column {
    title: &'static str,
    values: [String; 6],
}

fn corrections(result: &PoolResult) -> String {
    let columns: Vec<Column> = columns(result);
    if columns.is_empty() {
        return String::new();
    }
    let mut table = ruled_table();
    table.set_header(
        ["correction".to_string()]
            .into_iter()
            .chain(columns.iter().map(|column| column.title.into())),
    );
    for (place, row) in ROWS.iter().enumerate() {
        let label = format!("{} ({}), {}", row.name, row.sense, row.unit);
        table.add_row(
            [label]
                .into_iter()
                .chain(columns.iter().map(|column| column.values[place].clone())),
        );
    }
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table.trim_fmt()
}

fn columns(result: &PoolResult) -> Vec<Column> {
    let s = &result.solutions;
    let sequential = s
        .sequential
        .as_ref()
        .filter(|s| s.usable)
        .and_then(|s| column("sequential", &s.estimate, None));
    let joint = s
        .joint
        .as_ref()
        .and_then(|j| joint_column("joint ± 1 sigma", j));
    let simple = s
        .joint_simple
        .as_ref()
        .and_then(|j| joint_column("simple joint ± 1 sigma", j));
    let difference = result.comparison.as_ref().map(|comparison| Column {
        title: "sequential - joint, in sigmas of joint",
        values: in_order(&comparison.in_joint_sigmas).map(|sigmas| format!("{sigmas:.1}")),
    });
    [sequential, joint, simple, difference]
        .into_iter()
        .flatten()
        .collect()
}

fn joint_column(title: &'static str, joint: &JointSolution) -> Option<Column> {
    let joint = Some(joint).filter(|joint| joint.usable)?;
    column(title, &joint.estimate, joint.standard_deviation.as_ref())
}

fn column(title: &'static str, estimate: &Estimate, sigmas: Option<&SixSigmas>) -> Option<Column> {
    let values = shown(estimate.correction_deg?, estimate.lever_arm_correction_m?);
    let sigmas = sigmas.map(shown_sigmas);
    let text = |place: usize| match &sigmas {
        Some(sigmas) => with_sigma(values[place], sigmas[place]),
        None => plain(values[place], ROWS[place].unit),
    };
    Some(Column {
        title,
        values: std::array::from_fn(text),
    })
}

fn mounting(result: &PoolResult) -> String {
    let s = &result.solutions;
    let joint = s.joint.as_ref().map(|joint| ("joint", &joint.estimate));
    let sequential = s
        .sequential
        .as_ref()
        .map(|sequential| ("sequential", &sequential.estimate));
    let Some((path, estimate)) = joint.or(sequential).filter(|_| result.usable) else {
        return String::new();
    };
    let (Some(m), Some([x, y, z])) = (estimate.mounting_deg, estimate.lever_arm_m) else {
        return String::new();
    };
    format!(
        "mounting ({path}): roll {:.4}, pitch {:.4}, heading {:.4} deg; lever arm {x:.4}, {y:.4}, {z:.4} m (right, forward, up)",
        m.roll, m.pitch, m.heading
    )
}

fn ends(result: &PoolResult) -> String {
    let s = &result.solutions;
    let mut lines = String::new();
    let sequential = s.sequential.as_ref().map(sequential_end);
    let joint = s
        .joint
        .as_ref()
        .map(|joint| end("joint", status(joint.status), joint.usable, &joint.message));
    let simple = s.joint_simple.as_ref().map(|joint| {
        end(
            "simple joint",
            status(joint.status),
            joint.usable,
            &joint.message,
        )
    });
    for line in [sequential, joint, simple].into_iter().flatten() {
        lines.push_str(&line);
    }
    lines
}

fn sequential_end(s: &SequentialSolution) -> String {
    end(
        &format!("sequential ({})", s.variant),
        status(s.status),
        s.usable,
        &s.message,
    )
}

fn end(path: &str, status: &str, usable: bool, message: &str) -> String {
    let usable = if usable { "" } else { ", not usable" };
    let colon = if message.is_empty() { "" } else { ": " };
    format!("{path}: {status}{usable}{colon}{message}\n")
}

fn tests(quality: &Quality) -> String {
    let t = &quality.global_test;
    let verdict = match (t.void_because.as_str(), t.passed) {
        ("", true) => "passed".into(),
        ("", false) => "failed".into(),
        (why, _) => format!("void: {why}"),
    };
    let mut lines = format!(
        "global test: {verdict}; variance factor {:.4}, {:.0} % interval {:.4} to {:.4}, {} degrees of freedom\n",
        t.statistic,
        100.0 * (1.0 - t.significance),
        t.lower,
        t.upper,
        grouped(quality.degrees_of_freedom)
    );
    for weak in &quality.observability.weak {
        let _ = writeln!(lines, "weakly determined: {}", weak.text);
    }
    lines
}

fn counts(result: &PoolResult) -> String {
    let soundings = counted("soundings", &result.counts.soundings);
    format!(
        "{soundings}{}",
        counted("laser returns", &result.counts.returns)
    )
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
        format!("; rejected: {}", reasons.join(", "))
    };
    format!(
        "{sensor}: {} used of {}{rejected}\n",
        grouped(counts.used),
        grouped(counts.read)
    )
}
