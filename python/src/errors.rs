//! What ends a call, as the package's exceptions.

use boresight::InputError;
use boresight::budget::ledger::LedgerError;
use boresight::calibrate::vary::VaryError;
use boresight::report::ReportError;
use boresight::survey::Problem;
use pyo3::call::PyCallArgs;
use pyo3::prelude::*;

/// Why a call gave nothing.
#[derive(Debug)]
pub enum Failure {
    /// What the user gave cannot be worked with.
    Input(InputError),
    /// The same, said by a part that has no error type of its own.
    Refused(String),
    /// Files of trials.
    Ledger(LedgerError),
    /// Something that cannot be written.
    Report(ReportError),
    /// What a callable of the caller's raised.
    Python(PyErr),
    /// A fault of the program.
    Panic(String),
    /// The call was told to stop.
    Stopped,
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<boresight::survey::SurveyError> for Failure {
    fn from(error: boresight::survey::SurveyError) -> Self {
        Self::Input(error.into())
    }
}

impl From<boresight::survey::ScenarioError> for Failure {
    fn from(error: boresight::survey::ScenarioError) -> Self {
        Self::Input(error.into())
    }
}

impl From<LedgerError> for Failure {
    fn from(error: LedgerError) -> Self {
        Self::Ledger(error)
    }
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        Self::Report(error)
    }
}

impl From<VaryError> for Failure {
    fn from(error: VaryError) -> Self {
        // the command's option is the package's argument
        Self::Refused(error.to_string().replacen("--vary", "vary:", 1))
    }
}

impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        Self::Input(error.into())
    }
}

/// File, place, found, expected.
pub type Fault = (String, String, String, String);

impl Failure {
    /// As an exception of the package.
    pub fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Input(error) => input(py, error.to_string(), faults(&error)),
            Self::Refused(text) => input(py, text, vec![]),
            Self::Ledger(error) => {
                // what the command calls --resume and --out
                let text = error.to_string();
                let text = text.replace("with --resume", "with resume=True");
                raised(
                    py,
                    "LedgerError",
                    (text.replace("another --out", "another folder"),),
                )
            }
            Self::Report(error) => raised(py, "BoresightError", (error.to_string(),)),
            Self::Python(error) => error,
            Self::Panic(text) => raised(py, "InternalError", (text,)),
            Self::Stopped => raised(py, "BoresightError", ("stopped",)),
        }
    }
}

/// `InputError` with its faults.
pub fn input(py: Python<'_>, message: String, faults: Vec<Fault>) -> PyErr {
    raised(py, "InputError", (message, faults))
}

/// An exception of the package by its name.
fn raised<'py>(py: Python<'py>, name: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let class = py.import("boresight._errors").and_then(|m| m.getattr(name));
    let made = class.and_then(|class| class.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

fn faults(error: &InputError) -> Vec<Fault> {
    let of = |p: &Problem| {
        let file = p.file.display().to_string();
        (file, p.place.clone(), p.found.clone(), p.expected.clone())
    };
    match error {
        InputError::Survey(error) => error.problems.iter().map(of).collect(),
        InputError::Scenario(error) => {
            let file = error.file.display().to_string();
            let one = |fault: &String| (file.clone(), String::new(), fault.clone(), String::new());
            error.faults.iter().map(one).collect()
        }
        InputError::Format(error) => vec![of(&error.clone().into())],
        _ => vec![],
    }
}
