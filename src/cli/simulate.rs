//! `boresight simulate`: a scenario file to a complete survey.

use std::path::Path;

use super::Ending;
use super::args::Simulate;
use super::error::CliError;
use super::talk::Talk;
use crate::procedures::pool::survey::write_survey;
use crate::procedures::pool::survey::{ScenarioFile, scenario};
use crate::simulate::{Simulated, simulate};
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// Runs the command.
pub fn run(args: &Simulate, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.scenario.display()));
    let file = scenario::read(&args.scenario)?;
    let seed = args.seed.unwrap_or(file.scenario.seed);
    let survey = written(&file, seed, &args.out, talk)?;
    let json = serde_json::json!({
        "scenario": file.scenario.name,
        "seed": seed,
        "survey": args.out.join(SURVEY_FILE),
        "truth": args.out.join(TRUTH_FILE),
        "trajectory_records": survey.campaign.trajectory.time_s.len(),
        "returns": survey.campaign.laser.len(),
        "soundings": survey.campaign.soundings.len(),
    });
    let text = format!(
        "Simulated {} with seed {seed}: {} trajectory records, {} laser returns, {} soundings.\nSurvey  {}\nTruth   {}\n",
        file.scenario.name,
        survey.campaign.trajectory.time_s.len(),
        survey.campaign.laser.len(),
        survey.campaign.soundings.len(),
        args.out.join(SURVEY_FILE).display(),
        args.out.join(TRUTH_FILE).display(),
    );
    talk.result(&text, format!("{json:#}\n").as_bytes())?;
    Ok(Ending::Usable)
}

/// Simulates and writes the survey's files into a folder, which is made when missing.
pub fn written(
    file: &ScenarioFile,
    seed: u64,
    folder: &Path,
    talk: &Talk,
) -> Result<Simulated, CliError> {
    talk.step(&format!(
        "simulating {} with seed {seed}",
        file.scenario.name
    ));
    let survey = simulate(&file.scenario, seed)?;
    talk.step(&format!("writing {}", folder.display()));
    std::fs::create_dir_all(folder).map_err(|e| CliError::Folder {
        folder: folder.to_owned(),
        found: e.to_string(),
    })?;
    write_survey(folder, file, &survey)?;
    Ok(survey)
}
