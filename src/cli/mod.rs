//! The command line: arguments, files, printing, exit codes.
//!
//! | file | what |
//! |---|---|
//! | [`args`] | what the user types |
//! | `demo`, `calibrate`, `simulate`, `apply`, `check`, `info`, `budget`, `plan`, `template` | one command each |
//! | `interrupt` | what Ctrl-C does |
//! | `out` | where a command may write |
//! | `plain` | what a terminal can show: 80 columns, ASCII where the locale asks for it |
//! | `talk` | what is printed: results on standard output, progress on standard error |
//! | [`error`] | what ends a command before it solves (exit code 2) |

mod apply;
pub mod args;
mod budget;
mod calibrate;
mod check;
mod compare;
mod demo;
pub mod error;
mod info;
mod interrupt;
mod out;
mod plain;
mod plan;
mod result_file;
mod simulate;
mod talk;
mod template;

use std::ffi::OsString;

use clap::{CommandFactory, Parser};
use clap_complete::Shell;

use args::{Cli, Command};
use error::CliError;
use talk::Talk;

/// How a command ended when it was not stopped by an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    /// Exit code 0.
    Usable,
    /// Solved without a usable result: exit code 1.
    Unusable,
    /// Stopped by Ctrl-C, to be continued with `--resume`: exit code 130, as shells have it.
    Interrupted,
}

/// Runs the program on some arguments, the first being its name.
///
/// Exit codes: 0 usable result, 1 none was found by solving, 2 bad usage or bad input,
/// 130 stopped by Ctrl-C.
#[must_use]
pub fn run_code(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(usage) => {
            // help and version end with 0, everything else with 2; a closed pipe is no reason to complain
            let _ = usage.print();
            return usage.exit_code() as u8;
        }
    };
    let talk = Talk::new(&cli.common);
    let ready = interrupt::caught(talk.farewell()).and_then(|()| threads(cli.common.threads));
    let ended = ready.and_then(|()| match cli.command {
        Command::Demo(args) => demo::run(&args, &talk),
        Command::Calibrate(args) => calibrate::run(&args, &talk),
        Command::Simulate(args) => simulate::run(&args, &talk),
        Command::Check(args) => check::run(&args, &talk),
        Command::Apply(args) => apply::run(&args, &talk),
        Command::Compare(args) => compare::run(&args, &talk),
        Command::Info(args) => info::run(&args, &talk),
        Command::Budget(args) => budget::run(&args, &talk),
        Command::Plan(args) => plan::run(&args, &talk),
        Command::Template(args) => template::run(&args, &talk),
        Command::Completions { shell } => completions(shell, &talk),
    });
    interrupt::let_end();
    talk.finish();
    exit_code(ended, &talk)
}

/// The exit code of a command that ended so; an error is said.
fn exit_code(ended: Result<Ending, CliError>, talk: &Talk) -> u8 {
    match ended {
        Ok(Ending::Usable) => 0,
        Ok(Ending::Unusable) => 1,
        Ok(Ending::Interrupted) => 130,
        Err(error) => {
            talk.error(&error);
            2
        }
    }
}

/// Prints a shell's completion script.
fn completions(shell: Shell, talk: &Talk) -> Result<Ending, CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "boresight", &mut script);
    talk.print(&String::from_utf8_lossy(&script))?;
    Ok(Ending::Usable)
}

/// Sets the size of the thread pool.
fn threads(count: Option<u16>) -> Result<(), CliError> {
    let Some(count) = count else { return Ok(()) };
    let workers = rayon::ThreadPoolBuilder::new().num_threads(count.into());
    workers.build_global().map_err(|e| CliError::Threads {
        found: e.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
