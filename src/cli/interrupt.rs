//! Ctrl-C ends the program at once, with nothing half written. While trials run it asks them to end; a second one ends the program.

use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use super::error::CliError;
use super::talk::Farewell;
use crate::files;

/// Whether the work looks at [`STOP`] itself.
static GENTLE: AtomicBool = AtomicBool::new(false);
/// Asks the work to end.
static STOP: AtomicBool = AtomicBool::new(false);
/// Whether the program is ending.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Catches Ctrl-C from now on.
///
/// # Errors
/// [`CliError::Signal`].
pub fn caught(farewell: Farewell) -> Result<(), CliError> {
    let caught = ctrlc::set_handler(move || {
        if GENTLE.load(SeqCst) && !STOP.swap(true, SeqCst) {
            return;
        }
        ENDING.store(true, SeqCst);
        files::abandon();
        farewell.say("stopped by Ctrl-C; nothing was left half written");
        std::process::exit(130);
    });
    match caught {
        // caught already: this is not the process's first command
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        Err(error) => Err(CliError::Signal {
            found: error.to_string(),
        }),
    }
}

/// While it lives, the first Ctrl-C only sets the flag that it lends.
pub struct Gentle;

impl Gentle {
    pub fn begin() -> Self {
        STOP.store(false, SeqCst);
        GENTLE.store(true, SeqCst);
        Self
    }

    pub fn stop(&self) -> &'static AtomicBool {
        &STOP
    }
}

impl Drop for Gentle {
    fn drop(&mut self) {
        GENTLE.store(false, SeqCst);
    }
}

/// Waits for the end where Ctrl-C has begun it, so that nothing else is said of the work that it cut off.
pub fn let_end() {
    while ENDING.load(SeqCst) {
        std::thread::park();
    }
}
