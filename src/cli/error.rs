//! What ends a command before it solves: exit code 2, and nothing is written.

use std::path::PathBuf;

use crate::budget::join::JoinError;
use crate::budget::ledger::LedgerError;
use crate::calibrate::seam::InputError;
use crate::calibrate::vary::VaryError;
use crate::files::{FolderError, Overwrites};
use crate::formats::FormatError;
use crate::geometry::utm::UtmError;
use crate::report::ReportError;
use crate::simulate::SimulateError;
use crate::survey::{ScenarioError, SurveyError};

/// Everything that can stop a command.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// What a procedure cannot begin with.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The survey file or one of its files; every problem on a line of its own.
    #[error(transparent)]
    Survey(#[from] SurveyError),
    /// The scenario file; every problem on a line of its own.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A scenario that cannot be simulated.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// A file could not be read or written.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A report could not be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// Points outside the zone.
    #[error(transparent)]
    Utm(#[from] UtmError),
    /// A folder could not be made.
    #[error("{}: whole folder: found \"{found}\", expected a folder to write into", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the operating system said.
        found: String,
    },
    /// A demo into a folder that holds other files than its own.
    #[error("{}: whole folder: found files that the {procedure} demo did not write, expected a new or empty folder, or one of an earlier {procedure} demo: name another with --out", folder.display())]
    Occupied {
        /// The folder.
        folder: PathBuf,
        /// The procedure.
        procedure: &'static str,
    },
    /// A folder that may not be written into, or a file that may not be replaced.
    #[error(transparent)]
    Place(#[from] FolderError),
    /// A file to write that is an input.
    #[error(transparent)]
    Overwrites(#[from] Overwrites),
    /// A point cloud of another command.
    #[error("{}: whole file: found a point cloud that another boresight command wrote, expected another name (--force replaces it)", file.display())]
    Cloud {
        /// The file.
        file: PathBuf,
    },
    /// Not a result of this program.
    #[error("{}: {found}", file.display())]
    NoResult {
        /// The file.
        file: PathBuf,
        /// What was found: the line, the column and the fault.
        found: String,
    },
    /// The solution that was asked for is not there or not usable.
    #[error("{}: solutions.{name}: found {found}, expected a usable solution", file.display())]
    NoSolution {
        /// The file.
        file: PathBuf,
        /// Which solution.
        name: &'static str,
        /// What stands there.
        found: String,
    },
    /// A survey whose sensors give no points to map.
    #[error("{}: whole file: found a {procedure} survey, expected one of a procedure whose sensors map points", file.display())]
    NoPoints {
        /// The file.
        file: PathBuf,
        /// Its procedure.
        procedure: &'static str,
    },
    /// A surface of geocentric coordinates.
    #[error(
        "--surface: found --coordinates geocentric, expected coordinates in a plane: --coordinates utm"
    )]
    NoPlane,
    /// A surface without a cell, or with too many.
    #[error("{}: whole surface: found {found}, expected {expected}", file.display())]
    Surface {
        /// The file.
        file: PathBuf,
        /// What there is.
        found: String,
        /// What would do.
        expected: String,
    },
    /// Two results that cannot be compared.
    #[error("{}, {}: found {found}", before.display(), after.display())]
    NotComparable {
        /// The earlier one.
        before: PathBuf,
        /// The later one.
        after: PathBuf,
        /// What stands against it.
        found: String,
    },
    /// The thread pool could not be made.
    #[error("--threads: {found}")]
    Threads {
        /// What went wrong.
        found: String,
    },
    /// Standard output could not be written.
    #[error("standard output: {found}")]
    Print {
        /// What the operating system said.
        found: String,
    },
    /// Parts that cannot be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// Parts with another number of trials than the user says.
    #[error(
        "{option} {said}: found {found} trials in the parts from seed {first_seed} on, expected {said}; finish or add the part that lacks them, or leave {option} out"
    )]
    OtherCount {
        /// The option.
        option: &'static str,
        /// What it says.
        said: u64,
        /// What the parts hold.
        found: u64,
        /// Their first seed.
        first_seed: u64,
    },
    /// The trials' files cannot be used.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// A sweep that cannot be run.
    #[error(transparent)]
    Sweep(#[from] VaryError),
    /// More keys than a picture has axes.
    #[error("--vary: found {found} keys, expected one or two")]
    TooManyKeys {
        /// How many.
        found: usize,
    },
    /// One key with two lists of values.
    #[error(
        "--vary {key}: found twice, expected all values of a key in one list, such as {key}=1,2,3"
    )]
    KeyTwice {
        /// The key.
        key: String,
    },
    /// A second word where one is enough.
    #[error(
        "template {first}: found a second word \"{second}\", expected one after \"scenario\" or \"target\" only"
    )]
    SecondWord {
        /// What was asked for.
        first: String,
        /// What came behind it.
        second: String,
    },
    /// A wanted accuracy of something that the procedure does not estimate.
    #[error("--wanted: {found}")]
    Wanted {
        /// What was found and expected.
        found: String,
    },
    /// A scenario of which no trial can be run.
    #[error("{fault}")]
    Untriable {
        /// What stands against it.
        fault: String,
    },
    /// A survey of a procedure whose budget needs a truth.
    #[error("{}: whole file: found a {procedure} survey, expected a {procedure} scenario: this budget simulates, and a survey has no truth", file.display())]
    NeedsScenario {
        /// The file.
        file: PathBuf,
        /// The procedure.
        procedure: &'static str,
    },
    /// `--vary` with a survey.
    #[error("{}: whole file: found a survey, expected a scenario (or demo) with --vary; to see what another claimed error does to this survey, change it in the survey file and run boresight budget again", file.display())]
    VaryOfSurvey {
        /// The file.
        file: PathBuf,
    },
    /// A plan of a procedure that has none.
    #[error("{}: procedure: found \"{procedure}\", expected a procedure that plans passes; boresight budget says what a {procedure} survey would determine", file.display())]
    NoPlan {
        /// The file.
        file: PathBuf,
        /// The procedure.
        procedure: &'static str,
    },
    /// The demo's scenario has another one in its place, or the user has changed it.
    #[error("{}: whole file: found another scenario, or one that you changed, expected the demo's as it was written: name this file instead of {demo}, or another folder with --out", file.display())]
    ChangedDemo {
        /// The file.
        file: PathBuf,
        /// What was typed.
        demo: String,
    },
    /// Trials of a survey.
    #[error("{}: whole file: found a survey with --trials, expected a scenario: trials need a truth (without --trials the survey's own errors are propagated)", file.display())]
    NoTrials {
        /// The survey file.
        file: PathBuf,
    },
    /// A survey that does not say how its scanner measures.
    #[error("{}: [lidar] coordinates: found georeferenced points, expected \"sensor\": only then the scanner's errors can be propagated", file.display())]
    NoScanner {
        /// The survey file.
        file: PathBuf,
    },
    /// Ctrl-C cannot be caught.
    #[error("Ctrl-C cannot be caught: {found}")]
    Signal {
        /// What the operating system said.
        found: String,
    },
    /// A value has no JSON form; a fault of this program.
    #[error("cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}
