//! What is printed, and where: results on standard output, progress and errors on standard error.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdout};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::args::Common;
use super::error::CliError;
use super::plain::{ascii, asks_for_ascii, fitted};
use crate::watch::Watch;

/// The program's voice.
#[derive(Debug)]
pub struct Talk {
    quiet: bool,
    verbose: bool,
    json: bool,
    /// Whether the locale has no letters beyond ASCII.
    ascii: bool,
    begun: Instant,
    spinner: Option<ProgressBar>,
    /// The step that was told last.
    doing: Mutex<String>,
}

impl Watch for Talk {
    fn step(&self, what: &str) {
        Talk::step(self, what);
    }

    /// Puts a bar behind the step.
    fn counted(&self, done: usize, of: usize) {
        if let Some(spinner) = &self.spinner {
            let doing = self.doing.lock().unwrap_or_else(PoisonError::into_inner);
            spinner.set_message(format!("{doing} {}", bar_of(done, of)));
        }
    }
}

impl Talk {
    /// A spinner on a terminal, none in a pipe.
    pub fn new(common: &Common) -> Self {
        let shown = !common.quiet && !common.verbose && stderr().is_terminal();
        Self {
            quiet: common.quiet,
            verbose: common.verbose,
            json: common.json,
            ascii: asks_for_ascii(),
            begun: Instant::now(),
            spinner: shown.then(spinner),
            doing: Mutex::default(),
        }
    }

    /// Says what is being done.
    pub fn step(&self, what: &str) {
        if let Some(spinner) = &self.spinner {
            what.clone_into(&mut self.doing.lock().unwrap_or_else(PoisonError::into_inner));
            spinner.set_message(what.to_owned());
        }
        if self.verbose {
            let _ = writeln!(
                stderr(),
                "{:8.3} s  {what}",
                self.begun.elapsed().as_secs_f64()
            );
        }
    }

    /// Shows how much of a counted job is done, on a terminal.
    pub fn bar(&self, what: &str, length: u64) -> ProgressBar {
        if self.spinner.is_none() {
            return ProgressBar::hidden();
        }
        let style = "{msg} [{bar:30}] {percent:>3} % {elapsed_precise}, {eta_precise} left";
        let bar = ProgressBar::new(length).with_message(what.to_owned());
        bar.with_style(
            ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()),
        )
    }

    /// Shows how many trials are done and how long the rest will take, on a terminal; `before` were done earlier.
    pub fn trials(&self, before: u64, length: u64) -> ProgressBar {
        self.finish();
        if self.spinner.is_none() {
            return ProgressBar::hidden();
        }
        let style = "[{bar:20}] {pos} of {len} trials, {elapsed_precise}, {eta_precise} left";
        let style = ProgressStyle::with_template(style);
        let bar = ProgressBar::new(length)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
            .with_position(before);
        bar.reset_eta();
        bar
    }

    /// What can be said when this voice is cut off.
    pub fn farewell(&self) -> Farewell {
        Farewell {
            quiet: self.quiet,
            spinner: self.spinner.clone(),
        }
    }

    /// Takes the spinner away.
    pub fn finish(&self) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }

    /// Prints a result: the text in 80 columns, or with `--json` the JSON; nothing with `--quiet` unless JSON was asked for.
    ///
    /// # Errors
    /// [`CliError`] when standard output cannot be written; a closed pipe is no error.
    pub fn result(&self, text: &str, json: &[u8]) -> Result<(), CliError> {
        if self.json {
            self.finish();
            return to_stdout(json);
        }
        if self.quiet {
            return Ok(());
        }
        self.print(&fitted(text))
    }

    /// Prints a text on standard output.
    ///
    /// # Errors
    /// As [`Self::result`].
    pub fn print(&self, text: &str) -> Result<(), CliError> {
        self.finish();
        match self.ascii {
            true => to_stdout(ascii(text).as_bytes()),
            false => to_stdout(text.as_bytes()),
        }
    }

    /// Prints a sentence on standard error, unless `--quiet`.
    pub fn remark(&self, text: &str) {
        if !self.quiet {
            self.complain("boresight:", text);
        }
    }

    /// Prints an error on standard error, on a terminal with the red word that a wrong option has too.
    pub fn error(&self, error: &dyn Display) {
        let coloured = stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        let name = if coloured {
            "\u{1b}[1m\u{1b}[31merror:\u{1b}[0m"
        } else {
            "boresight:"
        };
        for line in error.to_string().lines() {
            self.complain(name, line);
        }
    }

    fn complain(&self, name: &str, text: &str) {
        let text = if self.ascii {
            ascii(text)
        } else {
            text.to_owned()
        };
        let _ = writeln!(stderr(), "{name} {text}");
    }
}

/// `[====      ]  40 %`.
fn bar_of(done: usize, of: usize) -> String {
    let percent = (100 * done.min(of)).checked_div(of).unwrap_or(100);
    let full = percent / 10;
    format!("[{:10}] {percent:>3} %", "=".repeat(full))
}

/// The last sentence of a program that is interrupted.
#[derive(Debug)]
pub struct Farewell {
    quiet: bool,
    spinner: Option<ProgressBar>,
}

impl Farewell {
    /// Says it on a line of its own, unless `--quiet`.
    pub fn say(&self, text: &str) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
            let _ = write!(stderr(), "\r\u{1b}[K");
        }
        if !self.quiet {
            let _ = writeln!(stderr(), "boresight: {text}");
        }
    }
}

fn spinner() -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {elapsed_precise} {msg}");
    let bar = ProgressBar::new_spinner()
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

fn to_stdout(bytes: &[u8]) -> Result<(), CliError> {
    let mut out = stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Print {
            found: error.to_string(),
        }),
        _ => Ok(()),
    }
}
