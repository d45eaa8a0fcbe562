//! `boresight demo`: the whole job with no input.

use std::path::{Path, PathBuf};

use super::Ending;
use super::args::Demo;
use super::calibrate::{ending, finish};
use super::error::CliError;
use super::out::{survey_into, tried};
use super::talk::Talk;
use crate::calibrate::choices::Method;
use crate::calibrate::seam::{Procedure, Settings, make_folder};
use crate::formats::error::read_text;
use crate::procedures;
use crate::survey::SURVEY_FILE;

/// Says in a folder whose demo wrote it, so that the next one knows what it may overwrite.
const MARKER: &str = ".boresight-demo";

/// Runs the command: simulate, write the survey, read it again, calibrate, report, compare with the truth.
pub fn run(args: &Demo, talk: &Talk) -> Result<Ending, CliError> {
    let (procedure, folder) = chosen(args);
    claim(&folder, procedure)?;
    let name = PathBuf::from(format!("{}.toml", procedure.name()));
    let scenario = procedure.scenario(&name, &procedure.demo())?;
    let survey = folder.join("survey");
    let made = format!("boresight demo {}, seed {}", procedure.name(), args.seed);
    // the folder is the demo's own: another seed replaces what it wrote there
    let simulated = survey_into(&survey, (&made, &procedure.demo()), true, |folder| {
        scenario.write(args.seed, folder, talk)
    })?;
    talk.step("reading the survey");
    let survey = survey.join(SURVEY_FILE);
    let settings = Settings {
        method: Method::Both,
        seed: procedure.uses().seed.then_some(args.seed),
        ..Settings::default()
    };
    let loaded = procedure.read(&survey)?;
    let finished = loaded.calibrate(&settings, Some(&simulated.truth), talk)?;
    finish(&folder, &finished, Some(&survey), &[], talk)?;
    Ok(ending(&finished))
}

/// The procedure, the first of all when none is named, and the folder to write into.
fn chosen(args: &Demo) -> (&'static dyn Procedure, PathBuf) {
    let named = args.procedure.as_deref().and_then(procedures::find);
    let folder = match named {
        Some(procedure) => format!("boresight-demo-{}", procedure.name()),
        None => "boresight-demo".to_owned(),
    };
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from(folder));
    (named.unwrap_or(procedures::ALL[0]), folder)
}

/// Takes a folder for a procedure's demo; one that holds anything else is left alone.
fn claim(folder: &Path, procedure: &dyn Procedure) -> Result<(), CliError> {
    let marker = folder.join(MARKER);
    let own = read_text(&marker).is_ok_and(|name| name.trim() == procedure.name());
    let empty = std::fs::read_dir(folder).map_or(!folder.exists(), |mut all| all.next().is_none());
    if !own && !empty {
        return Err(CliError::Occupied {
            folder: folder.to_owned(),
            procedure: procedure.name(),
        });
    }
    make_folder(folder)?;
    let written = std::fs::write(&marker, format!("{}\n", procedure.name()));
    written.map_err(|error| CliError::Folder {
        folder: folder.to_owned(),
        found: error.to_string(),
    })
}

/// A scenario file that the user names, or for `demo`, `demo-usbl` and the like (where there is no such file) the built-in scenario: it is
/// written into the folder of the command, to be looked at and changed, unless it stands there already.
pub fn demo_or(
    named: &Path,
    command: &str,
    out: Option<&Path>,
    talk: &Talk,
) -> Result<PathBuf, CliError> {
    let Some(procedure) = built_in(named) else {
        return Ok(named.to_owned());
    };
    let default = || PathBuf::from(format!("{}-demo-{command}", procedure.name()));
    let folder = out.map_or_else(default, Path::to_owned);
    let file = folder.join(SCENARIO_FILE);
    let text = procedure.demo();
    if file.exists() {
        if read_text(&file)? != text {
            let demo = named.display().to_string();
            return Err(CliError::ChangedDemo { file, demo });
        }
        return Ok(file);
    }
    tried(&folder, &[SCENARIO_FILE])?;
    make_folder(&folder)?;
    crate::files::land(&folder, &[(SCENARIO_FILE, text.as_bytes())])
        .map_err(crate::report::ReportError::from)?;
    talk.remark(&format!("the demo's scenario is {}", file.display()));
    Ok(file)
}

/// Name of the scenario that a demo writes.
const SCENARIO_FILE: &str = "scenario.toml";

/// The procedure whose built-in scenario is meant, if one is.
fn built_in(named: &Path) -> Option<&'static dyn Procedure> {
    // a folder of the demo's name is no scenario
    if named.is_file() {
        return None;
    }
    match named.to_str()? {
        "demo" => Some(procedures::ALL[0]),
        name => procedures::find(name.strip_prefix("demo-")?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_procedure_s_demo_is_written_over() {
        let base = tempfile::tempdir().expect("a folder");
        let folder = base.path().join("demo");
        let [first, second] = [0, 1].map(|place| procedures::ALL[place]);
        claim(&folder, first).expect("a new folder");
        claim(&folder, first).expect("its own folder");
        assert!(claim(&folder, second).is_err(), "another demo's folder");
        let foreign = base.path().join("foreign");
        std::fs::create_dir(&foreign).expect("a folder");
        std::fs::write(foreign.join("result.json"), "mine").expect("a file");
        assert!(claim(&foreign, first).is_err());
        assert!(!foreign.join(MARKER).exists(), "nothing is left behind");
    }
}
