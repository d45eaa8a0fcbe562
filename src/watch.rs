//! What a long job tells while it runs, and what it asks: whether it should stop.

use std::sync::Arc;

/// Somebody who watches a job. A closure `|step: &str| ...` is one that is told the steps and never stops the job.
///
/// It is called from whatever thread works on the job, so it should return at once. A job looks at [`Self::stopped`] before each of its
/// steps and, in its long passes over the observations, at every some thousand of them; it then ends with an error and leaves nothing
/// behind.
pub trait Watch: Sync {
    /// A step begins: what is being done, in words.
    fn step(&self, what: &str);

    /// How far the step is that was told last: `done` of `of` equal parts. A step may count anew as often as it passes over its
    /// observations.
    fn counted(&self, done: usize, of: usize) {
        let _ = (done, of);
    }

    /// Whether the job should stop.
    fn stopped(&self) -> bool {
        false
    }

    /// Other processes that work for the job, where there are any.
    fn workers(&self) -> Option<&dyn Workers> {
        None
    }

    /// An error once the job should stop.
    ///
    /// # Errors
    /// [`Stopped`].
    fn go_on(&self) -> Result<(), Stopped> {
        match self.stopped() {
            true => Err(Stopped),
            false => Ok(()),
        }
    }

    /// Tells a step, unless the job should stop.
    ///
    /// # Errors
    /// [`Stopped`].
    fn begin(&self, what: &str) -> Result<(), Stopped> {
        self.go_on()?;
        self.step(what);
        Ok(())
    }
}

/// Other processes that work on the parts of a job.
pub trait Workers: Sync {
    /// Asks one question about each part and gives the answers in the same order. `packets` holds, part by part, what a question needs
    /// besides; they are the same as long as `number` is.
    ///
    /// # Errors
    /// [`Stopped`].
    fn ask(
        &self,
        number: u64,
        packets: &Arc<Vec<Vec<u8>>>,
        questions: Vec<Vec<u8>>,
    ) -> Result<Vec<Vec<u8>>, Stopped>;
}

impl<F: Fn(&str) + Sync> Watch for F {
    fn step(&self, what: &str) {
        self(what);
    }
}

/// A job was stopped by whoever watches it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before it was done; nothing was written")]
pub struct Stopped;

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn step(&self, _: &str) {}
}

/// Passes on whether the job should stop, and tells nothing of it.
#[derive(Clone, Copy)]
pub struct Silently<'a>(pub &'a dyn Watch);

impl Watch for Silently<'_> {
    fn step(&self, _: &str) {}

    fn stopped(&self) -> bool {
        self.0.stopped()
    }
}
