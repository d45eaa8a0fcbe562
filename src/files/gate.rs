//! What an interrupted program does about its files: those that are getting their names get them all, those that are not yet done are
//! taken away.

use std::cell::Cell;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What would be left behind now.
#[derive(Default)]
struct Open {
    /// Temporary files and folders.
    temporary: Vec<PathBuf>,
    /// Folders that were made for files to come.
    made: Vec<PathBuf>,
    /// Threads that are giving files their names.
    naming: usize,
    /// Whether the program ends.
    ending: bool,
}

static OPEN: Mutex<Open> = Mutex::new(Open {
    temporary: vec![],
    made: vec![],
    naming: 0,
    ending: false,
});
static NAMED: Condvar = Condvar::new();

thread_local! {
    /// How deep this thread is in giving names.
    static DEPTH: Cell<usize> = const { Cell::new(0) };
}

fn open() -> MutexGuard<'static, Open> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a temporary file or folder and notes its path, to be taken away by [`abandon`]; while the program ends only a thread that is
/// giving names makes another.
///
/// # Errors
/// Those of `make`.
pub(super) fn making<T>(
    make: impl FnOnce() -> io::Result<T>,
    path: impl FnOnce(&T) -> PathBuf,
) -> io::Result<T> {
    let mut open = open();
    while open.ending && DEPTH.get() == 0 {
        open = NAMED.wait(open).unwrap_or_else(PoisonError::into_inner);
    }
    let made = make()?;
    open.temporary.push(path(&made));
    Ok(made)
}

/// Forgets a temporary file or folder.
pub(super) fn done_with(path: &Path) {
    open().temporary.retain(|other| other != path);
}

/// Notes a folder that was made.
pub(super) fn made(path: &Path) {
    open().made.push(path.to_owned());
}

/// Forgets folders that were made.
pub(super) fn keeps(paths: &[PathBuf]) {
    open().made.retain(|other| !paths.contains(other));
}

/// While it lives, files get their names and the program does not end; one that ends already lets nobody begin.
pub(super) struct Naming;

impl Naming {
    pub(super) fn begin() -> Self {
        let outermost = DEPTH.replace(DEPTH.get() + 1) == 0;
        let mut open = open();
        while open.ending && outermost {
            open = NAMED.wait(open).unwrap_or_else(PoisonError::into_inner);
        }
        open.naming += 1;
        Self
    }
}

impl Drop for Naming {
    fn drop(&mut self) {
        DEPTH.set(DEPTH.get().saturating_sub(1));
        open().naming -= 1;
        NAMED.notify_all();
    }
}

/// To be called before the program ends in the middle of its work: waits until files that are getting their names have them, takes away
/// what is not done, and lets no further file get its name.
pub fn abandon() {
    let mut open = open();
    open.ending = true;
    while open.naming > 0 {
        open = NAMED.wait(open).unwrap_or_else(PoisonError::into_inner);
    }
    open.temporary.iter().for_each(|path| take_away(path));
    for folder in open.made.iter().rev() {
        // only when it is empty
        let _ = std::fs::remove_dir(folder);
    }
}

/// Tries to take a folder away while other threads are still filling it: each of them has but a few files to make.
const TRIES: usize = 1000;

/// Takes away a temporary file, or a folder with everything that comes into it meanwhile.
fn take_away(path: &Path) {
    let _ = std::fs::remove_file(path);
    for _ in 0..TRIES {
        // another thread may be taking the same folder away: it is gone only when it cannot be found
        match std::fs::remove_dir_all(path) {
            Ok(()) => return,
            Err(_) if std::fs::symlink_metadata(path).is_err() => return,
            Err(_) => std::thread::yield_now(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_being_filled_goes() {
        let place = tempfile::tempdir().expect("folder");
        for round in 0..50 {
            let folder = place.path().join(format!("{round}.tmp.d"));
            std::fs::create_dir(&folder).expect("folder");
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    let made = |k: usize| std::fs::write(folder.join(k.to_string()), b"x");
                    (0..200).take_while(|k| made(*k).is_ok()).count()
                });
                take_away(&folder);
            });
            assert!(!folder.exists(), "round {round}");
        }
    }
}
