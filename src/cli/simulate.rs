//! `boresight simulate`: a scenario file to a complete survey.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::Ending;
use super::args::Simulate;
use super::demo::demo_or;
use super::error::CliError;
use super::out::survey_into;
use super::talk::Talk;
use crate::calibrate::seam::Count;
use crate::formats::error::read_text;
use crate::procedures;
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// Runs the command.
pub fn run(args: &Simulate, talk: &Talk) -> Result<Ending, CliError> {
    let file = &written_for(args, talk)?;
    talk.step(&format!("reading {}", file.display()));
    let scenario = procedures::scenario(file)?;
    let seed = args.seed.unwrap_or(scenario.seed());
    let made = format!("boresight simulate, {}, seed {seed}", scenario.name());
    let text = read_text(file)?;
    let written = survey_into(&args.out, (&made, &text), args.force, |folder| {
        scenario.write(seed, folder, talk)
    })?;
    let (survey, truth) = (args.out.join(SURVEY_FILE), args.out.join(TRUTH_FILE));
    let name = scenario.name();
    let text = format!(
        "Simulated {name} with seed {seed}: {}.\nSurvey  {}\nTruth   {}\n",
        in_words(&written.counts),
        survey.display(),
        truth.display(),
    );
    let mut json = Map::new();
    json.insert("scenario".to_owned(), json!(name));
    json.insert("seed".to_owned(), json!(seed));
    json.insert("survey".to_owned(), json!(survey));
    json.insert("truth".to_owned(), json!(truth));
    let counts = written.counts.iter();
    json.extend(counts.map(|c| (c.key.to_owned(), json!(c.count))));
    talk.result(&text, format!("{:#}\n", Value::Object(json)).as_bytes())?;
    Ok(Ending::Usable)
}

/// The scenario file; the demo's is written beside the survey's folder, which holds only what the simulation wrote.
fn written_for(args: &Simulate, talk: &Talk) -> Result<PathBuf, CliError> {
    let beside = args.out.parent().filter(|p| !p.as_os_str().is_empty());
    let beside = beside.unwrap_or(Path::new("."));
    demo_or(&args.scenario, "simulate", Some(beside), talk)
}

fn in_words(counts: &[Count]) -> String {
    let each = counts.iter().map(|c| format!("{} {}", c.count, c.words));
    each.collect::<Vec<_>>().join(", ")
}
