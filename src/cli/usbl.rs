//! The commands for a USBL calibration.

use std::path::Path;

use super::Ending;
use super::args::{Budget, Calibrate, Check, Demo, Simulate};
use super::error::CliError;
use super::talk::Talk;

/// `boresight calibrate`.
pub fn calibrate(args: &Calibrate, _talk: &Talk) -> Result<Ending, CliError> {
    not_built(&args.survey)
}

/// `boresight simulate`.
pub fn simulate(args: &Simulate, _talk: &Talk) -> Result<Ending, CliError> {
    not_built(&args.scenario)
}

/// `boresight check`.
pub fn check(args: &Check, _talk: &Talk) -> Result<Ending, CliError> {
    not_built(&args.survey)
}

/// `boresight budget`.
pub fn budget(args: &Budget, _talk: &Talk) -> Result<Ending, CliError> {
    not_built(&args.scenario)
}

/// `boresight demo usbl`.
pub fn demo(_args: &Demo, _talk: &Talk) -> Result<Ending, CliError> {
    not_built(Path::new("demo usbl"))
}

fn not_built(file: &Path) -> Result<Ending, CliError> {
    Err(CliError::NotBuilt {
        file: file.to_owned(),
        found: "usbl",
    })
}
