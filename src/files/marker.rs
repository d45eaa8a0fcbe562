//! What the program itself wrote into a folder, by name and SHA-256, in a small file beside it.
//!
//! A folder may hold the only copy of a survey. Files are made together in it only where nothing of the user's is in the way: a file
//! that the program did not write, or that was changed since, is never replaced; what the program wrote is replaced without a
//! question when the same thing is made again, and with `--force` when it is something else.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::gate::Naming;
use super::temporary::TemporaryFolder;
use super::whole::{Made, WriteError, write_bytes};

/// Name of the marker in its folder.
pub const MARKER: &str = ".boresight.json";

/// What the program wrote into a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ours {
    /// What was made, in words: the command, its input, the seed.
    pub made: String,
    /// SHA-256 of every file, two while an old one is being replaced.
    pub files: BTreeMap<String, Vec<String>>,
}

/// Why files cannot be made in a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file is in the way that the program did not write.
    #[error("{}: whole file: found {}, expected another folder for --out: boresight replaces only files that it wrote", file.display(), if *changed { "a file that was changed after boresight wrote it" } else { "a file that boresight did not write" })]
    NotOurs {
        /// The file.
        file: PathBuf,
        /// Whether the program wrote an earlier state of it.
        changed: bool,
    },
    /// The folder holds something else that the program made.
    #[error("{}: whole folder: found what \"{found}\" wrote, expected an empty folder (--force replaces it)", folder.display())]
    OtherMade {
        /// The folder.
        folder: PathBuf,
        /// What was made in it.
        found: String,
    },
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl Ours {
    /// The marker of a folder; nothing where there is none or it is damaged.
    #[must_use]
    pub fn of(folder: &Path) -> Self {
        let path = folder.join(MARKER);
        let ordinary =
            std::fs::symlink_metadata(&path).is_ok_and(|m| m.is_file() && m.len() < 1 << 20);
        let text = if ordinary {
            std::fs::read(&path).ok()
        } else {
            None
        };
        text.and_then(|text| serde_json::from_slice(&text).ok())
            .unwrap_or_default()
    }

    /// Whether files of these names may be made in the folder, being `made`.
    ///
    /// # Errors
    /// [`FolderError`] with the first file in the way.
    pub fn may_replace<'n>(
        &self,
        folder: &Path,
        made: &str,
        force: bool,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Result<(), FolderError> {
        let mut there = false;
        for name in names {
            let file = folder.join(name);
            if std::fs::symlink_metadata(&file).is_err() {
                continue;
            }
            there = true;
            let known = self.files.get(name);
            let same = known.is_some_and(|known| sha256(&file).is_ok_and(|s| known.contains(&s)));
            if !same {
                let changed = known.is_some();
                return Err(FolderError::NotOurs { file, changed });
            }
        }
        if there && !force && self.made != made {
            let (folder, found) = (folder.to_owned(), self.made.clone());
            return Err(FolderError::OtherMade { folder, found });
        }
        Ok(())
    }

    fn write(&self, folder: &Path) -> Result<(), WriteError> {
        let text = serde_json::to_string_pretty(self).map_err(|e| WriteError {
            file: folder.join(MARKER),
            source: e.into(),
        })?;
        write_bytes(&folder.join(MARKER), format!("{text}\n").as_bytes())
    }
}

/// Makes files together in a folder: `write` fills a temporary folder, then every file gets its place, or none does.
///
/// `names` are the files that are expected; they are looked at before `write` works, whatever else it makes after it. `made` says in
/// words what is made. The folder is made when missing.
///
/// # Errors
/// [`FolderError`], or what `write` says; the folder is as it was then.
pub fn made_together<T, E: From<FolderError>>(
    folder: &Path,
    made: &str,
    force: bool,
    names: &[&str],
    write: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<T, E> {
    let ours = Ours::of(folder);
    ours.may_replace(folder, made, force, names.iter().copied())?;
    let error = |source| {
        FolderError::Write(WriteError {
            file: folder.to_owned(),
            source,
        })
    };
    let kept = Made::folder(folder).map_err(error)?;
    let temporary = TemporaryFolder::new_in(folder).map_err(error)?;
    let value = write(temporary.path())?;
    let files = digests(temporary.path()).map_err(error)?;
    ours.may_replace(folder, made, force, files.keys().map(String::as_str))?;
    let _naming = Naming::begin();
    moved(&ours, made, temporary.path(), folder, &files)?;
    kept.keep();
    Ok(value)
}

/// The marker names both states before the first file is moved, and only the new one after the last.
fn moved(
    ours: &Ours,
    made: &str,
    from: &Path,
    folder: &Path,
    files: &BTreeMap<String, String>,
) -> Result<(), FolderError> {
    let mut marker = ours.clone();
    marker.made = made.to_owned();
    for (name, digest) in files {
        let known = marker.files.entry(name.clone()).or_default();
        known.push(digest.clone());
    }
    marker.write(folder)?;
    for name in files.keys() {
        let file = folder.join(name);
        std::fs::rename(from.join(name), &file).map_err(|source| WriteError { file, source })?;
    }
    for (name, digest) in files {
        marker.files.insert(name.clone(), vec![digest.clone()]);
    }
    Ok(marker.write(folder)?)
}

/// Name and digest of every file in a folder.
fn digests(folder: &Path) -> io::Result<BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        found.insert(name, sha256(&entry.path())?);
    }
    Ok(found)
}

/// SHA-256 of a file, lower-case hexadecimal.
fn sha256(path: &Path) -> io::Result<String> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    let (mut file, mut hash) = (std::fs::File::open(path)?, Sha256::new());
    let mut buffer = vec![0; 1 << 18];
    loop {
        match file.read(&mut buffer)? {
            0 => break,
            n => hash.update(&buffer[..n]),
        }
    }
    let mut text = String::new();
    for byte in hash.finalize() {
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn make(folder: &Path, made: &str, force: bool, text: &str) -> Result<(), FolderError> {
        made_together(folder, made, force, &["survey.toml"], |place| {
            let write = |name: &str| write_bytes(&place.join(name), text.as_bytes());
            write("survey.toml")?;
            Ok(write("lidar.laz")?)
        })
    }

    fn read(folder: &Path, name: &str) -> String {
        std::fs::read_to_string(folder.join(name)).expect("read")
    }

    #[test]
    fn nothing_of_the_user_s_is_replaced_even_with_force() {
        let place = tempfile::tempdir().expect("folder");
        for name in ["survey.toml", "lidar.laz"] {
            let folder = place.path().join(name);
            std::fs::create_dir(&folder).expect("folder");
            std::fs::write(folder.join(name), b"raw").expect("written");
            for force in [false, true] {
                let error = make(&folder, "a", force, "new").expect_err("refused");
                assert!(error.to_string().contains("did not write"), "{error}");
                assert_eq!(read(&folder, name), "raw");
                assert_eq!(std::fs::read_dir(&folder).expect("list").count(), 1);
            }
        }
    }

    #[test]
    fn the_same_again_is_allowed_and_something_else_wants_force() {
        let place = tempfile::tempdir().expect("folder");
        let folder = place.path().join("out");
        make(&folder, "a", false, "one").expect("made");
        make(&folder, "a", false, "one").expect("the same again");
        let error = make(&folder, "b", false, "two").expect_err("something else");
        assert!(error.to_string().contains("--force"), "{error}");
        assert_eq!(read(&folder, "lidar.laz"), "one");
        make(&folder, "b", true, "two").expect("forced");
        assert_eq!(read(&folder, "lidar.laz"), "two");
        std::fs::write(folder.join("survey.toml"), b"edited").expect("written");
        let error = make(&folder, "b", true, "three").expect_err("changed");
        assert!(error.to_string().contains("was changed"), "{error}");
        assert_eq!(read(&folder, "survey.toml"), "edited");
    }

    #[test]
    fn a_failed_job_leaves_the_folder_as_it_was() {
        let place = tempfile::tempdir().expect("folder");
        let folder = place.path().join("out");
        let failed: Result<(), FolderError> =
            made_together(&folder, "a", false, &[], |temporary| {
                write_bytes(&temporary.join("half"), b"x")?;
                let (file, source) = (folder.clone(), io::Error::other("no"));
                Err(WriteError { file, source }.into())
            });
        assert!(failed.is_err());
        assert!(!folder.exists());
    }
}
