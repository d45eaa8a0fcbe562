//! `boresight budget` for procedures whose parameters are named: Monte Carlo by both paths.

use std::path::Path;
use std::sync::atomic::Ordering::SeqCst;

use super::Ending;
use super::args::Budget;
use super::budget::catch_ctrl_c;
use super::calibrate::folder_of;
use super::error::CliError;
use super::talk::Talk;
use crate::budget::named::{self, Tried, Wanted};
use crate::report::{named_budget as pages, write_named_budget};
use crate::results::NamedBudget;

/// Trials of all sources together when the user says nothing.
const TRIALS: u64 = 200;
/// Trials of each source alone when the user says nothing.
const SINGLE: u64 = 50;

/// Runs the trials, writes and prints the budget.
pub fn run(tried: &dyn Tried, args: &Budget, talk: &Talk) -> Result<Ending, CliError> {
    refuse(args, tried.procedure())?;
    let wanted = Wanted {
        first_seed: args.seed,
        trials: args.trials.unwrap_or(TRIALS),
        single: args
            .single
            .unwrap_or(if args.trials.is_none() { SINGLE } else { 0 }),
    };
    let all = wanted.trials + wanted.single * tried.sources().len() as u64 + 1;
    talk.step(&format!("{all} trials"));
    let stop = catch_ctrl_c()?;
    let bar = talk.trials(0, all);
    let mut result = named::run(tried, &wanted, stop, &|done, _| bar.set_position(done));
    bar.finish_and_clear();
    let stopped = stop.load(SeqCst);
    if stopped {
        result.notes.push(format!(
            "stopped by Ctrl-C: {} of {} trials together, {} of {} of each source alone; these procedures keep no ledger to go on with",
            result.trials, wanted.trials, result.single_trials, wanted.single
        ));
    }
    result.command = command(args, &wanted);
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| folder_of(&format!("{}-budget", tried.scenario())));
    written(&result, &folder, stopped, talk)
}

/// What only a pool's budget has.
fn refuse(args: &Budget, procedure: &'static str) -> Result<(), CliError> {
    let option = if !args.vary.is_empty() {
        "--vary"
    } else if args.resume {
        "--resume"
    } else {
        return Ok(());
    };
    Err(CliError::NotForProcedure { option, procedure })
}

fn command(args: &Budget, wanted: &Wanted) -> String {
    let mut text = format!(
        "boresight budget {} --trials {}",
        args.scenario.display(),
        wanted.trials
    );
    if wanted.single > 0 {
        text.push_str(&format!(" --single {}", wanted.single));
    }
    if wanted.first_seed != 1 {
        text.push_str(&format!(" --seed {}", wanted.first_seed));
    }
    text
}

fn written(
    result: &NamedBudget,
    folder: &Path,
    stopped: bool,
    talk: &Talk,
) -> Result<Ending, CliError> {
    talk.step(&format!("writing {}", folder.display()));
    let files = write_named_budget(folder, result)?;
    let text = format!(
        "{}\nReport  {}\nResult  {}\nTable   {}\n",
        pages::summary(result),
        files.page.display(),
        files.json.display(),
        files.table.display()
    );
    talk.result(&text, &pages::to_bytes(result)?)?;
    let joint = result.paths.first().and_then(|p| p.together.as_ref());
    Ok(match (stopped, joint) {
        (true, _) => Ending::Interrupted,
        (false, Some(joint)) if joint.usable > 0 => Ending::Usable,
        _ => Ending::Unusable,
    })
}
