//! What a pool survey holds and what its geometry can and cannot determine, before anything is solved.

use std::borrow::Cow;
use std::fmt::Write;

use serde_json::{Value, json};

use super::preview::{PassSpan, Predicted, Preview};
use super::survey::LoadedSurvey;
use super::survey::file::MultibeamSection;
use crate::calibrate::seam::{Checked, looks_like};
use crate::ruled::Ruled;
use crate::survey::clock::Span;

/// The preview in words and for programs.
pub(super) fn checked(survey: &LoadedSurvey, preview: &Preview) -> Checked {
    let undetermined = preview
        .predicted
        .as_ref()
        .is_some_and(|p| !p.undetermined.is_empty());
    Checked {
        text: format!(
            "{}\n{}{}",
            data(survey),
            geometry(preview),
            notes(&survey.notes)
        ),
        json: as_json(survey, preview),
        determined: preview.refusal.is_none() && preview.mistake.is_none() && !undetermined,
    }
}

/// The notes as a paragraph, empty without any.
fn notes(notes: &[String]) -> String {
    let lines: String = notes
        .iter()
        .map(|note| format!("Note: {note}.\n"))
        .collect();
    if lines.is_empty() {
        lines
    } else {
        format!("\n{lines}")
    }
}

/// What was read: rows that are used, those dropped as the trajectory does not cover them, times.
fn data(survey: &LoadedSurvey) -> String {
    let mut table =
        Ruled::new(["data", "file", "records", "no position", "from, s", "to, s"]).texts(2);
    for row in rows(survey) {
        let (first, last) = row.span.map_or((String::new(), String::new()), |s| {
            (format!("{:.3}", s.first_s), format!("{:.3}", s.last_s))
        });
        table.row([
            row.name,
            &row.path,
            &row.count.to_string(),
            &row.dropped.to_string(),
            &first,
            &last,
        ]);
    }
    format!(
        "Survey \"{}\" is readable and consistent.\n\n{}\n",
        survey.file.name, table
    )
}

struct Row<'s> {
    name: &'static str,
    path: Cow<'s, str>,
    count: usize,
    dropped: usize,
    span: Option<Span>,
}

fn rows(survey: &LoadedSurvey) -> [Row<'_>; 3] {
    let (file, campaign, counts) = (&survey.file, &survey.campaign, &survey.counts);
    let own = "its own, of the recorder";
    let of_trajectory = file.trajectory.path.as_deref().unwrap_or(own);
    let sounded_s = campaign.soundings.span_s();
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
            of_trajectory.into(),
            counts.trajectory,
            0,
            &campaign.trajectory.time_s,
        ),
        row(
            "laser returns",
            file.lidar.path.as_str().into(),
            counts.laser,
            counts.laser_dropped,
            &campaign.laser.time_s,
        ),
        row(
            "soundings",
            soundings_named(&file.multibeam),
            counts.soundings,
            counts.soundings_dropped,
            sounded_s.as_ref().map_or(&[], |span| &span[..]),
        ),
    ]
}

/// The soundings' file, or the first of several.
fn soundings_named(section: &MultibeamSection) -> Cow<'_, str> {
    let others = section.paths.len().saturating_sub(1);
    let first = section.path.as_ref().or(section.paths.first());
    let first = first.map(String::as_str).unwrap_or_default();
    match others {
        0 => first.into(),
        _ => format!("{first} and {others} more").into(),
    }
}

fn geometry(preview: &Preview) -> String {
    let mut table = Ruled::new(["on the target", "laser returns", "soundings"]);
    for (name, seen) in &preview.seen {
        table.row([
            *name,
            &seen.returns.to_string(),
            &seen.soundings.to_string(),
        ]);
    }
    let mut text = format!("{table}\n\n");
    for (k, pass) in preview.passes.iter().enumerate() {
        text.push_str(&pass_line(k, pass));
    }
    if let Some(predicted) = &preview.predicted {
        text.push_str(&expected(predicted));
    }
    if let Some(refusal) = &preview.refusal {
        let _ = writeln!(text, "A calibration would be refused: {refusal}.");
    } else if preview.advice.is_empty() && preview.mistake.is_none() {
        text.push_str("The geometry is good enough for every parameter; no advice.\n");
    }
    if let Some(mistake) = &preview.mistake {
        let _ = writeln!(text, "{}", looks_like(mistake));
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
        "Pass {}: {:.1} s, {} soundings on the target, {mean:.1} m ({low:.1} to {high:.1}) from the wall\n",
        k + 1,
        end - begin,
        pass.soundings
    )
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
        "procedure": "pool",
        "data": data,
        "on_target": seen.collect::<Vec<_>>(),
        "passes": passes.collect::<Vec<_>>(),
        "expected_standard_deviation": preview.predicted.as_ref().filter(|p| p.undetermined.is_empty()).map(|p| p.sigmas),
        "undetermined": preview.predicted.as_ref().map(|p| &p.undetermined),
        "mistake": preview.mistake,
        "refused": preview.refusal.as_ref().map(ToString::to_string),
        "advice": preview.advice,
        "notes": survey.notes,
    })
}
