//! The seam: all that command line, budget and report need to know of a procedure.
//!
//! | trait | what it stands for |
//! |---|---|
//! | [`Procedure`] | one way to calibrate: its name, its built-in scenario, its two readers |
//! | [`Loaded`] | a survey of that procedure in memory |
//! | [`ScenarioRun`] | a scenario of that procedure, ready to be simulated |
//!
//! All three are object safe, so that whoever works with procedures names none of them. A procedure implements them in its own folder
//! and stands in one table, `procedures::ALL`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::choices::Method;
use super::cloud::{Calibrated, Cloud};
use super::planning::{PlanAsk, Planner};
use super::tried::Tried;
use crate::formats::{Format, FormatError};
use crate::observe::Extra;
use crate::results::{Calibration, Finding, InputFile, Page, Provenance, Software};
use crate::survey::schema::Key;
use crate::survey::{ScenarioError, SurveyError};
use crate::watch::{Stopped, Watch};

/// Seed of a calibration when the user gives none.
pub const SEED: u64 = 1;

/// Is told what is being done, and asked whether it should go on.
pub type Progress<'a> = &'a dyn Watch;

/// One way to calibrate.
pub trait Procedure: Sync {
    /// Its name in the key `procedure` of a file and on the command line.
    fn name(&self) -> &'static str;

    /// What it calibrates against what, in half a sentence.
    fn about(&self) -> &'static str;

    /// The text of its built-in scenario.
    fn demo(&self) -> String;

    /// The keys of its survey file.
    fn survey_keys(&self) -> &'static [Key];

    /// The kinds of target files, each with its title and keys, the usual one first; none where a survey needs no such file.
    fn targets(&self) -> &'static [(&'static str, &'static [Key])] {
        &[]
    }

    /// Formats that no other procedure reads: those of its own folder. The documentation and the suites for bad input take them in.
    fn formats(&self) -> &'static [Format] {
        &[]
    }

    /// A survey file made from recorder files; `None` where it reads none. What is wrong with them stands in it.
    fn template_from(&self, _files: &[PathBuf]) -> Option<String> {
        None
    }

    /// What to sail next, of the text of a scenario or survey file; `None` where the procedure plans nothing.
    ///
    /// # Errors
    /// [`InputError`] with everything that is wrong with the file or the question.
    fn planner(
        &self,
        _file: &Path,
        _text: &str,
        _ask: &PlanAsk,
    ) -> Result<Option<Box<dyn Planner>>, InputError> {
        Ok(None)
    }

    /// Which settings it has a use for.
    fn uses(&self) -> Uses;

    /// Reads a survey file and every file that it names.
    ///
    /// # Errors
    /// [`InputError`] with everything that is wrong with them.
    fn read(&self, survey: &Path) -> Result<Box<dyn Loaded>, InputError>;

    /// Reads the text of a scenario; `file` names it in messages, and files that it names are looked for beside it.
    ///
    /// # Errors
    /// [`InputError`] with everything that is wrong with it.
    fn scenario(&self, file: &Path, text: &str) -> Result<Box<dyn ScenarioRun>, InputError>;
}

/// A survey in memory.
pub trait Loaded: Send + Sync {
    /// The survey's name.
    fn name(&self) -> &str;

    /// Every file that was read, the survey file first, paths as they stand in the survey file.
    fn inputs(&self) -> &[InputFile];

    /// What is to be said of reading it: rows left out, observations without a position.
    fn notes(&self) -> &[String] {
        &[]
    }

    /// The survey file with every default filled in, as it stands in a result's provenance.
    ///
    /// # Errors
    /// [`InputError::Json`] for a value that has no JSON form, which none has.
    fn configuration(&self) -> Result<Value, InputError>;

    /// Calibrates it; `truth` is the content of a simulated survey's `truth.json`.
    ///
    /// # Errors
    /// [`InputError`] for input that no calibration can work with, or [`InputError::Stopped`]; one without a usable result is no error.
    fn calibrate(
        &self,
        settings: &Settings,
        truth: Option<&Value>,
        progress: Progress<'_>,
    ) -> Result<Finished, InputError>;

    /// Says what was read and what the geometry can and cannot determine; solves nothing.
    ///
    /// # Errors
    /// As [`Self::calibrate`].
    fn check(&self, settings: &Settings, progress: Progress<'_>) -> Result<Checked, InputError>;

    /// The survey for the error budget: what the errors that it claims do to its own calibration ([`Uses::survey_budget`]). `None`
    /// where it does not say how its instruments err.
    ///
    /// # Errors
    /// [`InputError`] for input that no budget can be made of.
    fn observed(&self, _settings: &Settings) -> Result<Option<Box<dyn Tried + '_>>, InputError> {
        Ok(None)
    }

    /// All points that the survey's sensors observed, georeferenced under a calibration; `None` where the procedure's sensors give no
    /// points to map.
    ///
    /// # Errors
    /// [`InputError`] for observations that cannot be placed at all.
    fn cloud(&self, _calibrated: &Calibrated) -> Result<Option<Cloud<'_>>, InputError> {
        Ok(None)
    }
}

/// A scenario.
pub trait ScenarioRun: Send + Sync {
    /// Its name.
    fn name(&self) -> &str;

    /// The seed that it names.
    fn seed(&self) -> u64;

    /// Simulates under a seed and writes a complete survey into a folder, which exists.
    ///
    /// # Errors
    /// [`InputError`] for a scenario that cannot be simulated or a file that cannot be written.
    fn write(
        &self,
        seed: u64,
        folder: &Path,
        progress: Progress<'_>,
    ) -> Result<Simulated, InputError>;

    /// The same scenario on trial, for the error budget.
    ///
    /// # Errors
    /// [`InputError`] when its sections about the calibration cannot be read.
    fn tried(&self) -> Result<Box<dyn Tried + '_>, InputError>;
}

/// Which settings a procedure has a use for; those it has not are refused, never ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uses {
    /// A seed of the calibration: it draws random samples.
    pub seed: bool,
    /// A simple joint model as a third column.
    pub simple: bool,
    /// An error budget of a survey as it was observed, without a truth.
    pub survey_budget: bool,
    /// Unknowns of the caller's own.
    pub extras: bool,
}

/// What the user may say of a calibration besides its survey file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Which paths run.
    pub method: Method,
    /// Seed of the random samples; [`SEED`] when it is not given.
    pub seed: Option<u64>,
    /// The simple joint model too, as a third column.
    pub simple: bool,
    /// Unknowns of the caller's own, one number a sounding each.
    pub extras: Arc<[Extra]>,
}

impl Settings {
    /// The seed in effect.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(SEED)
    }

    /// Refuses what the procedure has no use for.
    ///
    /// # Errors
    /// [`InputError::Unused`] with the option and the reason.
    pub fn fit(&self, procedure: &dyn Procedure) -> Result<(), InputError> {
        let unused = |option, reason| InputError::Unused {
            option,
            procedure: procedure.name(),
            reason,
        };
        let uses = procedure.uses();
        if self.seed.is_some() && !uses.seed {
            return Err(unused("--seed", "it draws no random samples"));
        }
        if self.simple && !uses.simple {
            return Err(unused("--simple", "it has one joint model only"));
        }
        if !self.extras.is_empty() && !uses.extras {
            return Err(unused(
                "extra",
                "no soundings are there for an unknown of the caller's own to act on",
            ));
        }
        Ok(())
    }
}

/// A calibration that came to its end, with or without a usable result.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The content of `result.json`.
    pub result: Calibration,
    /// What the report shows beside it.
    pub page: Page,
}

/// What is known of a survey before anything is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// In words, with a final newline.
    pub text: String,
    /// The same for programs.
    pub json: Value,
    /// Whether the geometry determines everything that is sought.
    pub determined: bool,
}

/// A mistake that a check suspects, as a line of its text.
#[must_use]
pub fn looks_like(mistake: &Finding) -> String {
    format!("It looks like a mistake: {}.", mistake.in_words())
}

/// What a simulated survey holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// How much of what was written, in words and as a key.
    pub counts: Vec<Count>,
    /// The content of `truth.json`.
    pub truth: Value,
}

/// How many observations of a kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Count {
    /// The key for programs.
    pub key: &'static str,
    /// In words, behind the number.
    pub words: &'static str,
    /// How many.
    pub count: usize,
}

impl Count {
    /// From its parts.
    #[must_use]
    pub fn new(key: &'static str, words: &'static str, count: usize) -> Self {
        Self { key, words, count }
    }
}

/// Why a command cannot begin: bad usage or bad input, found before solving.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// A survey file or one of its files; every problem on a line of its own.
    #[error(transparent)]
    Survey(#[from] SurveyError),
    /// A scenario file; every problem on a line of its own.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A file could not be read or written.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A folder could not be made.
    #[error("{}: whole folder: found \"{found}\", expected a folder to write into", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the operating system said.
        found: String,
    },
    /// An option that the procedure has no use for.
    #[error(
        "{option}: found with a {procedure} calibration, which has no use for it: {reason}; leave it out"
    )]
    Unused {
        /// The option.
        option: &'static str,
        /// The procedure.
        procedure: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// A value has no JSON form; a fault of this program.
    #[error("cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Stopped by whoever watches.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// Observations or a scenario that the procedure cannot work with.
    #[error(transparent)]
    Unworkable(Box<dyn Error + Send + Sync>),
}

impl InputError {
    /// A procedure's own error.
    #[must_use]
    pub fn unworkable(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Unworkable(Box::new(error))
    }
}

/// What a result says of where it comes from: the configuration as it took effect and the files it was read from.
///
/// # Errors
/// None for configurations made by this program; `serde_json` does not promise it.
pub fn provenance(
    configuration: &impl Serialize,
    inputs: &[InputFile],
    settings: &Settings,
) -> serde_json::Result<Provenance> {
    let mut configuration = serde_json::to_value(configuration)?;
    if let Some(table) = configuration.as_object_mut() {
        table.insert("method".to_owned(), settings.method.name().into());
    }
    Ok(Provenance {
        software: Software::this(),
        seed: settings.seed(),
        inputs: inputs.to_vec(),
        configuration,
    })
}

/// Makes a folder when it is missing.
///
/// # Errors
/// [`InputError::Folder`].
pub fn make_folder(folder: &Path) -> Result<(), InputError> {
    std::fs::create_dir_all(folder).map_err(|error| InputError::Folder {
        folder: folder.to_owned(),
        found: error.to_string(),
    })
}

/// The truth that a procedure's own simulator wrote.
///
/// # Errors
/// [`InputError::Json`] for another procedure's truth.
pub fn read_truth<T: DeserializeOwned>(truth: &Value) -> Result<T, InputError> {
    Ok(T::deserialize(truth)?)
}
