//! `boresight demo`: the whole job with no input.

use std::path::{Path, PathBuf};

use super::Ending;
use super::args::Demo;
use super::calibrate::{ending, finish};
use super::error::CliError;
use super::talk::Talk;
use crate::calibrate::choices::Method;
use crate::calibrate::seam::{Procedure, Settings, make_folder};
use crate::procedures;
use crate::survey::SURVEY_FILE;

/// Says in a folder whose demo wrote it, so that the next one knows what it may overwrite.
const MARKER: &str = ".boresight-demo";

/// Runs the command: simulate, write the survey, read it again, calibrate, report, compare with the truth.
pub fn run(args: &Demo, talk: &Talk) -> Result<Ending, CliError> {
    let (procedure, folder) = chosen(args);
    let step = |what: &str| talk.step(what);
    claim(&folder, procedure)?;
    let name = PathBuf::from(format!("{}.toml", procedure.name()));
    let scenario = procedure.scenario(&name, &procedure.demo())?;
    let survey = folder.join("survey");
    let simulated = scenario.write(args.seed, &survey, &step)?;
    talk.step("reading the survey");
    let survey = survey.join(SURVEY_FILE);
    let settings = Settings {
        method: Method::Both,
        seed: procedure.uses().seed.then_some(args.seed),
        simple: false,
    };
    let loaded = procedure.read(&survey)?;
    let finished = loaded.calibrate(&settings, Some(&simulated.truth), &step)?;
    finish(&folder, &finished, Some(&survey), talk)?;
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
    let own = std::fs::read_to_string(&marker).is_ok_and(|name| name.trim() == procedure.name());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_procedure_s_demo_is_written_over() {
        let base = tempfile::tempdir().expect("a folder");
        let folder = base.path().join("demo");
        let [first, second, ..] = procedures::ALL;
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
