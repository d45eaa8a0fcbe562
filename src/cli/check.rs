//! `boresight check`: reads and validates everything, says what the geometry can and cannot determine, solves nothing.

use super::Ending;
use super::args::Check;
use super::error::CliError;
use super::talk::Talk;
use crate::calibrate::seam::Settings;
use crate::procedures;

/// Runs the command.
pub fn run(args: &Check, talk: &Talk) -> Result<Ending, CliError> {
    talk.step(&format!("reading {}", args.survey.display()));
    let settings = Settings {
        seed: args.seed,
        ..Settings::default()
    };
    let procedure = procedures::of_file(&args.survey)?;
    settings.fit(procedure)?;
    let survey = procedure.read(&args.survey)?;
    let checked = survey.check(&settings, talk)?;
    talk.result(&checked.text, format!("{:#}\n", checked.json).as_bytes())?;
    Ok(if checked.determined {
        Ending::Usable
    } else {
        Ending::Unusable
    })
}
