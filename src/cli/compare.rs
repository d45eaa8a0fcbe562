//! `boresight compare`: has the mounting changed between two calibrations?

use super::Ending;
use super::args::Compare;
use super::error::CliError;
use super::result_file::read_result;
use super::talk::Talk;
use crate::calibrate::compare::compare;
use crate::report;

/// Runs the command.
pub fn run(args: &Compare, talk: &Talk) -> Result<Ending, CliError> {
    let [before, after] = [&args.before, &args.after].map(|path| read_result(path));
    let change = compare(&before?, &after?, args.significance);
    let change = change.map_err(|found| CliError::NotComparable {
        before: args.before.clone(),
        after: args.after.clone(),
        found,
    })?;
    talk.result(
        &report::change::summary(&change),
        &report::change::to_bytes(&change)?,
    )?;
    Ok(if change.changed {
        Ending::Unusable
    } else {
        Ending::Usable
    })
}
