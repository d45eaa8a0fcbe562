//! `boresight info`: what recorders' files hold, and what a calibration would still need.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::Ending;
use super::args::Info;
use super::error::CliError;
use super::talk::Talk;
use crate::formats::error::{FaultKind, FormatError, Place};
use crate::formats::recorder::table;
use crate::recorders::{Agreement, Choice, Recorded, against_own_solution, info::overview};

/// Runs the command.
pub fn run(args: &Info, talk: &Talk) -> Result<Ending, CliError> {
    let (mut text, mut files) = (String::new(), vec![]);
    for path in &files_of(&args.files)? {
        talk.step(&format!("reading {}", path.display()));
        let overview = overview(path)?;
        let mut json = overview.json(path);
        text.push_str(&overview.text(path));
        if args.own_solution {
            talk.step("comparing with the sounder's own solution");
            let mut recorded = Recorded::default();
            table::read(path, &mut recorded)?;
            let found = against_own_solution(&recorded, Choice::default());
            text.push_str(&words(found.as_ref()));
            json["own_solution"] = found.as_ref().map_or(Value::Null, as_json);
        }
        text.push('\n');
        files.push(json);
    }
    let text = format!("{}\n", text.trim_end());
    talk.result(&text, format!("{:#}\n", json!(files)).as_bytes())?;
    Ok(Ending::Usable)
}

/// The files, and of a folder those of its files that a reader knows, by name.
pub(super) fn files_of(named: &[PathBuf]) -> Result<Vec<PathBuf>, FormatError> {
    let mut files = vec![];
    for path in named {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let unreadable = |error: std::io::Error| FormatError::unreadable(path, &error);
        let mut inside = vec![];
        for entry in std::fs::read_dir(path).map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            if file.is_file() && (table::is_recorder(&file) || table::is_named_sbet(&file)) {
                inside.push(file);
            }
        }
        inside.sort();
        if inside.is_empty() {
            let (found, expected) = ("a folder without a recorder's file", "recorder files in it");
            let kind = FaultKind::UnknownFormat;
            return Err(FormatError::new(kind, path, Place::File, found, expected));
        }
        files.extend(inside);
    }
    Ok(files)
}

fn words(found: Option<&Agreement>) -> String {
    let Some(found) = found else {
        return "  own solution: not comparable (needs installation, attitude, profile, pings and\n  solutions in one file)\n".to_owned();
    };
    let (mean, rms) = (found.mean_m * 100.0, found.rms_m * 100.0);
    format!(
        "  ours minus the sounder's own points, {} beams of {} pings ({} left out), cm:\n    right, forward, up: mean {:.1}, {:.1}, {:.1}; rms {:.1}, {:.1}, {:.1}\n",
        found.beams, found.pings, found.left_out, mean.x, mean.y, mean.z, rms.x, rms.y, rms.z
    )
}

fn as_json(found: &Agreement) -> Value {
    json!({
        "pings": found.pings,
        "beams": found.beams,
        "left_out": found.left_out,
        "mean_m": [found.mean_m.x, found.mean_m.y, found.mean_m.z],
        "rms_m": [found.rms_m.x, found.rms_m.y, found.rms_m.z],
    })
}
