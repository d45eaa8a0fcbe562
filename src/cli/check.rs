//! `boresight check`: reads and validates everything, says what the geometry can and cannot determine, solves nothing.

use std::fmt::Write;

use comfy_table::{CellAlignment, Table};
use serde_json::{Value, json};

use super::Ending;
use super::args::Check;
use super::calibrate::{input, notes};
use super::error::CliError;
use super::talk::Talk;
use crate::calibrate::choices::Method;
use crate::procedures::pool::preview::{PassSpan, Predicted, Preview, preview};
use crate::procedures::pool::survey::{self as survey, LoadedSurvey};
use crate::report::text::ruled_table;
use crate::survey::clock::Span;

/// Runs the command.
pub fn run(args: &Check, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let survey = survey::load(&args.survey)?;
    talk.step("looking at the geometry");
    let preview = preview(&input(&survey, Method::Both, args.seed))?;
    let text = format!(
        "{}\n{}{}",
        data(&survey),
        geometry(&preview),
        notes(&survey.notes)
    );
    talk.result(
        &text,
        format!("{:#}\n", as_json(&survey, &preview)).as_bytes(),
    )?;
    let undetermined = preview
        .predicted
        .as_ref()
        .is_some_and(|p| !p.undetermined.is_empty());
    Ok(if preview.refusal.is_some() || undetermined {
        Ending::Unusable
    } else {
        Ending::Usable
    })
}

/// What was read: rows, times, dropped.
fn data(survey: &LoadedSurvey) -> String {
    let mut table = table(["data", "file", "records", "dropped", "from, s", "to, s"]);
    for row in rows(survey) {
        let (first, last) = row.span.map_or((String::new(), String::new()), |s| {
            (format!("{:.3}", s.first_s), format!("{:.3}", s.last_s))
        });
        table.add_row([
            row.name,
            row.path,
            &row.count.to_string(),
            &row.dropped.to_string(),
            &first,
            &last,
        ]);
    }
    align(&mut table, 2);
    format!(
        "Survey \"{}\" is readable and consistent.\n\n{}\n",
        survey.file.name,
        table.trim_fmt()
    )
}

struct Row<'s> {
    name: &'static str,
    path: &'s str,
    count: usize,
    dropped: usize,
    span: Option<Span>,
}

fn rows(survey: &LoadedSurvey) -> [Row<'_>; 3] {
    let (file, campaign, counts) = (&survey.file, &survey.campaign, &survey.counts);
    let row = |name, path, count, dropped, time_s: &[f64]| Row {
        name,
        path,
        count,
        dropped,
        span: Span::of(time_s),
    };
    [
        row(
            "trajectory",
            &file.trajectory.path,
            counts.trajectory,
            0,
            &campaign.trajectory.time_s,
        ),
        row(
            "laser returns",
            &file.lidar.path,
            counts.laser,
            counts.laser_dropped,
            &campaign.laser.time_s,
        ),
        row(
            "soundings",
            &file.multibeam.path,
            counts.soundings,
            counts.soundings_dropped,
            &campaign.soundings.time_s,
        ),
    ]
}

fn geometry(preview: &Preview) -> String {
    let mut table = table(["on the target", "laser returns", "soundings"]);
    for (name, seen) in &preview.seen {
        table.add_row([
            *name,
            &seen.returns.to_string(),
            &seen.soundings.to_string(),
        ]);
    }
    align(&mut table, 1);
    let mut text = format!("{}\n\n", table.trim_fmt());
    for (k, pass) in preview.passes.iter().enumerate() {
        text.push_str(&pass_line(k, pass));
    }
    if let Some(predicted) = &preview.predicted {
        text.push_str(&expected(predicted));
    }
    if let Some(refusal) = &preview.refusal {
        let _ = writeln!(text, "A calibration would be refused: {refusal}.");
    } else if preview.advice.is_empty() {
        text.push_str("Every parameter has the geometry it needs; nothing to advise.\n");
    }
    for sentence in &preview.advice {
        let _ = writeln!(text, "Advice: {sentence}.");
    }
    text
}

/// The standard deviations to expect, and what would be refused.
fn expected(predicted: &Predicted) -> String {
    let s = &predicted.sigmas;
    let mut text = format!(
        "Expected standard deviations of the joint path: pitch {:.4}, roll {:.4}, yaw {:.4} deg; lever arm right {:.2}, forward {:.2}, up {:.2} mm\n",
        s.pitch_deg,
        s.roll_deg,
        s.yaw_deg,
        1e3 * s.lx_m,
        1e3 * s.ly_m,
        1e3 * s.lz_m
    );
    for (a, b, correlation) in &predicted.inseparable {
        let _ = writeln!(
            text,
            "Nearly inseparable: {a} and {b} (correlation {correlation:.3})"
        );
    }
    if !predicted.undetermined.is_empty() {
        let _ = writeln!(
            text,
            "Not determined: {}; a calibration would be refused.",
            predicted.undetermined.join(", ")
        );
    }
    text
}

fn pass_line(k: usize, pass: &PassSpan) -> String {
    let ((begin, end), (low, mean, high)) = (pass.time_s, pass.distance_m);
    format!(
        "Pass {}: {:.1} s, {} soundings on the target, {mean:.1} m from the wall ({low:.1} to {high:.1} m)\n",
        k + 1,
        end - begin,
        pass.soundings
    )
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = ruled_table();
    table.set_header(header);
    table
}

fn align(table: &mut Table, from: usize) {
    table
        .column_iter_mut()
        .skip(from)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
}

fn as_json(survey: &LoadedSurvey, preview: &Preview) -> Value {
    let data = rows(survey).map(|r| {
        let span = r.span.map(|s| [s.first_s, s.last_s]);
        json!({ "name": r.name, "path": r.path, "records": r.count, "dropped": r.dropped, "time_s": span })
    });
    let seen = preview
        .seen
        .iter()
        .map(|(name, s)| json!({ "role": name, "returns": s.returns, "soundings": s.soundings }));
    let passes = preview.passes.iter().map(|p| {
        let (low, mean, high) = p.distance_m;
        json!({ "time_s": [p.time_s.0, p.time_s.1], "soundings": p.soundings, "distance_m": { "smallest": low, "mean": mean, "largest": high } })
    });
    json!({
        "name": survey.file.name,
        "data": data,
        "on_target": seen.collect::<Vec<_>>(),
        "passes": passes.collect::<Vec<_>>(),
        "expected_standard_deviation": preview.predicted.as_ref().filter(|p| p.undetermined.is_empty()).map(|p| p.sigmas),
        "undetermined": preview.predicted.as_ref().map(|p| &p.undetermined),
        "refused": preview.refusal.as_ref().map(ToString::to_string),
        "advice": preview.advice,
        "notes": survey.notes,
    })
}
