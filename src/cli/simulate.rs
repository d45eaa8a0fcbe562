//! `boresight simulate`: a scenario file to a complete survey.

use serde_json::{Map, Value, json};

use super::Ending;
use super::args::Simulate;
use super::error::CliError;
use super::talk::Talk;
use crate::calibrate::seam::Count;
use crate::procedures;
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// Runs the command.
pub fn run(args: &Simulate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.scenario.display()));
    let scenario = procedures::scenario(&args.scenario)?;
    let seed = args.seed.unwrap_or(scenario.seed());
    let written = scenario.write(seed, &args.out, &|what| talk.step(what))?;
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

fn in_words(counts: &[Count]) -> String {
    let each = counts.iter().map(|c| format!("{} {}", c.count, c.words));
    each.collect::<Vec<_>>().join(", ")
}
