//! Files written whole or not at all: a temporary file beside the target, then a rename.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::gate::{self, Naming};
use super::temporary::{new_in, sweep};

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: cannot write: {source}", file = file.display())]
pub struct WriteError {
    /// The file that should have been written.
    pub file: PathBuf,
    /// What the operating system said.
    pub source: io::Error,
}

impl WriteError {
    fn of(file: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self {
            file: file.to_owned(),
            source,
        }
    }
}

/// Lets `write` fill a temporary file in the folder of `path`, and gives it that name when all went well. The folder is made when
/// missing; what killed runs left in it is removed.
///
/// # Errors
/// [`WriteError`] with the file's name; the old file, if any, stays as it was.
pub fn write_whole<E: Into<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let error = WriteError::of(path);
    let folder = folder_of(path);
    let made = Made::folder(folder).map_err(&error)?;
    let staged = staged(folder, write).map_err(&error)?;
    let _naming = Naming::begin();
    persisted(staged, path).map_err(&error)?;
    made.keep();
    Ok(())
}

/// Writes bytes as [`write_whole`] does.
///
/// # Errors
/// As [`write_whole`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_whole(path, |w| w.write_all(bytes))
}

/// Writes several files into a folder: all of them are written before the first gets its name, so that a full disk leaves none.
/// The folder is made when missing. Returns their paths in the same order.
///
/// # Errors
/// [`WriteError`] of the first file that cannot be written; nothing new is left then, not even the folder.
pub fn land(folder: &Path, files: &[(&str, &[u8])]) -> Result<Vec<PathBuf>, WriteError> {
    let made = Made::folder(folder).map_err(WriteError::of(folder))?;
    let mut all = Vec::new();
    for (name, bytes) in files {
        let path = folder.join(name);
        no_folder(&path).map_err(WriteError::of(&path))?;
        let file = staged(folder, |w| w.write_all(bytes)).map_err(WriteError::of(&path))?;
        all.push((path, file));
    }
    let named = named(all)?;
    made.keep();
    Ok(named)
}

/// Tries whether these files could be written into a folder, and leaves nothing behind: to be asked before the work, not after it.
///
/// # Errors
/// [`WriteError`]: no folder, no permission, a folder where a file should be.
pub fn tried(folder: &Path, names: &[&str]) -> Result<(), WriteError> {
    for name in names {
        let path = folder.join(name);
        no_folder(&path).map_err(WriteError::of(&path))?;
    }
    let _made = Made::folder(folder).map_err(WriteError::of(folder))?;
    let file = new_in(folder).map_err(WriteError::of(folder))?;
    gate::done_with(file.path());
    Ok(())
}

/// Gives every staged file its name; when one fails, takes away those that were not there before.
fn named(all: Vec<(PathBuf, NamedTempFile)>) -> Result<Vec<PathBuf>, WriteError> {
    let _naming = Naming::begin();
    let mut done: Vec<(PathBuf, bool)> = Vec::new();
    for (path, file) in all {
        let new = !path.exists();
        if let Err(failed) = persisted(file, &path) {
            for (path, _) in done.iter().filter(|(_, new)| *new) {
                let _ = std::fs::remove_file(path);
            }
            return Err(WriteError::of(&path)(failed));
        }
        done.push((path, new));
    }
    Ok(done.into_iter().map(|(path, _)| path).collect())
}

/// Gives a temporary file its name.
fn persisted(file: NamedTempFile, path: &Path) -> io::Result<()> {
    let temporary = file.path().to_owned();
    let named = file.persist(path).map(drop);
    gate::done_with(&temporary);
    named.map_err(|failed| failed.error)
}

/// A filled temporary file, on the disk.
fn staged<E: Into<io::Error>>(
    folder: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> io::Result<NamedTempFile> {
    let mut file = new_in(folder)?;
    let mut buffer = BufWriter::with_capacity(1 << 18, file.as_file_mut());
    write(&mut buffer).map_err(Into::into)?;
    buffer.flush()?;
    drop(buffer);
    readable_by_all(file.as_file())?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// The folder of a file, `.` when its path names none.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

fn no_folder(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    Ok(())
}

/// Temporary files are private; results are ordinary files.
///
/// # Errors
/// What the operating system says.
#[cfg(unix)]
pub fn readable_by_all(file: &File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

/// Temporary files are private; results are ordinary files.
///
/// # Errors
/// None here.
#[cfg(not(unix))]
pub fn readable_by_all(_file: &File) -> io::Result<()> {
    Ok(())
}

/// Folders that were made for what is to be written, outermost first; removed again unless kept.
#[derive(Debug)]
pub(super) struct Made(Vec<PathBuf>);

impl Made {
    /// Makes a folder and those around it, and removes from it what killed runs left.
    pub(super) fn folder(folder: &Path) -> io::Result<Self> {
        let missing = folder
            .ancestors()
            .take_while(|f| !f.as_os_str().is_empty() && matches!(f.try_exists(), Ok(false)));
        let mut missing: Vec<PathBuf> = missing.map(Path::to_owned).collect();
        missing.reverse();
        let mut made = Self(vec![]);
        for folder in missing {
            std::fs::create_dir_all(&folder)?;
            gate::made(&folder);
            made.0.push(folder);
        }
        std::fs::create_dir_all(folder)?;
        sweep(folder);
        Ok(made)
    }

    /// Leaves them.
    pub(super) fn keep(mut self) {
        gate::keeps(&self.0);
        self.0.clear();
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        gate::keeps(&self.0);
        for folder in self.0.iter().rev() {
            // only when it is empty
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(folder: &Path) -> usize {
        std::fs::read_dir(folder).expect("list").count()
    }

    #[test]
    fn a_file_is_replaced_whole_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("new/result.json");
        write_bytes(&path, b"long first text").expect("written");
        write_bytes(&path, b"second").expect("written");
        assert_eq!(std::fs::read(&path).expect("read"), b"second");
        assert_eq!(count(&folder.path().join("new")), 1);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.txt");
        write_bytes(&path, b"old").expect("written");
        let failed = write_whole(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("disk on fire"))
        });
        let message = failed.expect_err("fails").to_string();
        assert!(message.contains("a.txt") && message.contains("disk on fire"));
        assert_eq!(std::fs::read(&path).expect("read"), b"old");
        assert_eq!(count(folder.path()), 1);
    }

    #[test]
    fn several_files_land_together_or_not_at_all() {
        let place = tempfile::tempdir().expect("folder");
        let folder = place.path().join("a/b");
        std::fs::create_dir_all(folder.join("report.html/inside")).expect("folder");
        let files: [(&str, &[u8]); 2] = [("result.json", b"1"), ("report.html", b"2")];
        let message = land(&folder, &files)
            .expect_err("a folder is in the way")
            .to_string();
        assert!(message.contains("report.html"), "{message}");
        assert_eq!(count(&folder), 1);
        assert!(tried(&folder, &["result.json", "report.html"]).is_err());
        std::fs::remove_dir_all(&folder).expect("removed");
        let named = land(&folder, &files).expect("written");
        assert_eq!(
            named,
            [folder.join("result.json"), folder.join("report.html")]
        );
        assert_eq!(count(&folder), 2);
    }

    #[test]
    fn trying_leaves_nothing() {
        let place = tempfile::tempdir().expect("folder");
        tried(&place.path().join("new/deep"), &["result.json"]).expect("it can be written");
        assert_eq!(count(place.path()), 0);
        std::fs::write(place.path().join("file"), b"x").expect("written");
        assert!(tried(&place.path().join("file/deep"), &[]).is_err());
        assert!(tried(&place.path().join("file"), &[]).is_err());
    }
}
