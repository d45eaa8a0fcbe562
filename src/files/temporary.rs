//! Temporary files beside their target, each locked as long as its writer lives.
//!
//! A run that was killed leaves its temporary files behind, without the lock. The next run that writes into the same folder finds
//! them by their name, takes the lock and removes them; those of a run that still lives cannot be locked and stay.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::gate;

/// How the names of temporary files begin and end.
const NAME: (&str, &str) = (".boresight-", ".tmp");
/// Added to the name of a temporary file for a folder of files that belong to it.
const FOLDER: &str = ".d";

/// A new temporary file in a folder, locked until it is dropped or has got its final name.
///
/// # Errors
/// What the operating system says.
pub fn new_in(folder: &Path) -> io::Result<NamedTempFile> {
    loop {
        let mut builder = tempfile::Builder::new();
        builder.prefix(NAME.0).suffix(NAME.1);
        let file = gate::making(
            || builder.tempfile_in(folder),
            |file| file.path().to_owned(),
        );
        let file = file.map_err(bare)?;
        // where locks do not exist, nobody sweeps either
        let _ = file.as_file().lock();
        if file.path().exists() {
            return Ok(file);
        }
        gate::done_with(file.path());
    }
}

/// An error without the temporary name, which means nothing to a reader: what kind of error it is.
fn bare(error: io::Error) -> io::Error {
    match error.raw_os_error() {
        Some(_) => error,
        None => error.kind().into(),
    }
}

/// A temporary folder, removed with everything in it when dropped.
#[derive(Debug)]
pub struct TemporaryFolder {
    path: PathBuf,
    _lock: NamedTempFile,
}

impl TemporaryFolder {
    /// A new one in a folder that exists.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn new_in(folder: &Path) -> io::Result<Self> {
        let lock = new_in(folder)?;
        let path = folder_of(lock.path());
        gate::making(|| std::fs::create_dir(&path), |()| path.clone())?;
        Ok(Self { path, _lock: lock })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.path);
        gate::done_with(&self.path);
        gate::done_with(self._lock.path());
    }
}

fn folder_of(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(FOLDER);
    name.into()
}

/// Removes what killed runs left in a folder; a folder that cannot be read is left alone.
pub fn sweep(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(NAME.0) && name.ends_with(NAME.1) {
            remove_if_left(&entry.path());
        }
    }
}

fn remove_if_left(path: &Path) {
    if !std::fs::symlink_metadata(path).is_ok_and(|m| m.is_file()) {
        return;
    }
    let Ok(file) = File::options().read(true).write(true).open(path) else {
        return;
    };
    if file.try_lock().is_ok() {
        let _ = std::fs::remove_dir_all(folder_of(path));
        let _ = std::fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("list").flatten();
        let mut names: Vec<_> = entries
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn an_error_says_nothing_of_the_temporary_name() {
        let place = tempfile::tempdir().expect("folder");
        let error = new_in(&place.path().join("missing")).expect_err("no folder");
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(!error.to_string().contains(NAME.0), "{error}");
    }

    #[test]
    fn what_a_killed_run_left_goes_and_what_a_living_one_needs_stays() {
        let place = tempfile::tempdir().expect("folder");
        let living = new_in(place.path()).expect("file");
        let folder = TemporaryFolder::new_in(place.path()).expect("folder");
        std::fs::write(folder.path().join("a"), b"a").expect("written");
        // a killed run: the same names, and no lock
        std::fs::write(place.path().join(".boresight-x.tmp"), b"half").expect("written");
        std::fs::create_dir(place.path().join(".boresight-x.tmp.d")).expect("folder");
        std::fs::write(place.path().join(".boresight-x.tmp.d/b"), b"b").expect("written");
        std::fs::write(place.path().join("of-the-user.tmp"), b"mine").expect("written");
        sweep(place.path());
        let left = names(place.path());
        assert!(!left.iter().any(|n| n.contains("-x.tmp")), "{left:?}");
        assert_eq!(left.len(), 4, "{left:?}");
        assert!(folder.path().join("a").exists() && living.path().exists());
        drop((living, folder));
        assert_eq!(names(place.path()), ["of-the-user.tmp"]);
    }
}
