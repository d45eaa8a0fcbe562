//! `boresight template`: complete commented files to fill in.

use std::path::PathBuf;

use super::Ending;
use super::args::Template;
use super::error::CliError;
use super::talk::Talk;
use crate::calibrate::seam::{InputError, Procedure};
use crate::procedures;
use crate::survey::template::{alternative, template};

/// Runs the command.
pub fn run(args: &Template, talk: &Talk) -> Result<Ending, CliError> {
    if let Some(second) = &args.procedure
        && !["scenario", "target"].contains(&args.what.as_str())
    {
        return Err(CliError::SecondWord {
            first: args.what.clone(),
            second: second.clone(),
        });
    }
    let of = args.procedure.as_deref().and_then(procedures::find);
    let procedure = of.unwrap_or(procedures::ALL[0]);
    let text = match args.what.as_str() {
        name if !args.from.is_empty() => from(name, &args.from)?,
        "scenario" => procedure.demo(),
        "target" => target(procedure),
        name => procedures::find(name).map_or(String::new(), survey),
    };
    talk.print(&text)?;
    Ok(Ending::Usable)
}

/// A survey file from what recorders wrote.
fn from(name: &str, files: &[PathBuf]) -> Result<String, CliError> {
    let procedure = procedures::find(name);
    let files = super::info::files_of(files)?;
    let made = procedure.and_then(|procedure| procedure.template_from(&files));
    let unused = || InputError::Unused {
        option: "--from",
        procedure: procedure.map_or("scenario or target, not a", |p| p.name()),
        reason: "it reads no recorder files",
    };
    Ok(made.ok_or_else(unused)?)
}

/// A survey file.
fn survey(procedure: &dyn Procedure) -> String {
    let title = format!(
        "Survey of the procedure \"{}\": {}.",
        procedure.name(),
        procedure.about()
    );
    template(&title, procedure.survey_keys())
}

/// A target file of the usual kind, the other kinds below it commented out.
fn target(procedure: &dyn Procedure) -> String {
    let Some(((title, keys), others)) = procedure.targets().split_first() else {
        return format!(
            "# A survey of the procedure \"{}\" names no target file.\n",
            procedure.name()
        );
    };
    let other = |(title, keys): &(&str, &[_])| alternative(&format!("Or: {title}"), keys);
    template(title, keys) + &others.iter().map(other).collect::<String>()
}
