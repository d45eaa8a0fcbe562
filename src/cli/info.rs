//! `boresight info`: what recorders' files hold, and what a calibration would still need.

use serde_json::{Value, json};

use super::Ending;
use super::args::Info;
use super::error::CliError;
use super::talk::Talk;
use crate::formats::recorder::table;
use crate::recorders::{Agreement, Choice, Recorded, against_own_solution, info::overview};

/// Runs the command.
pub fn run(args: &Info, talk: &Talk) -> Result<Ending, CliError> {
    let (mut text, mut files) = (String::new(), vec![]);
    for path in &args.files {
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
