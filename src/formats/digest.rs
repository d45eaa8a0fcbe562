//! SHA-256 of an input file, for the provenance of a result.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use sha2::{Digest, Sha256};

use super::error::{FaultKind, FormatError, Place, open};

/// Size and time of change of files, to know that they stayed the same while they were read: the digest of a file and what was made
/// of its content must be of one state of it.
#[derive(Clone, Debug)]
pub struct Stamps(Vec<(PathBuf, Option<Stamp>)>);

/// Size and time of change.
type Stamp = (u64, SystemTime);

impl Stamps {
    /// Begins with one file, before it is read.
    #[must_use]
    pub fn begin(path: &Path) -> Self {
        Self(vec![(path.to_owned(), stamp(path))])
    }

    /// Takes in more files, before they are read.
    pub fn add(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        let stamped = paths.into_iter().map(|path| {
            let stamp = stamp(&path);
            (path, stamp)
        });
        self.0.extend(stamped);
    }

    /// After the reading.
    ///
    /// # Errors
    /// [`FormatError`] with the first file that changed meanwhile.
    pub fn unchanged(&self) -> Result<(), FormatError> {
        match self.0.iter().find(|(path, before)| stamp(path) != *before) {
            None => Ok(()),
            Some((path, _)) => Err(FormatError::new(
                FaultKind::Unreadable,
                path,
                Place::File,
                "a file that changed while it was read",
                "a file that nothing writes to",
            )),
        }
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

/// SHA-256 of a file's bytes, lower-case hexadecimal.
///
/// # Errors
/// [`FormatError`] when the file cannot be read.
pub fn sha256(path: &Path) -> Result<String, FormatError> {
    let (mut file, _) = open(path)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 20];
    loop {
        match file.read(&mut buffer) {
            Ok(0) => break,
            Ok(n) => hash.update(&buffer[..n]),
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(FormatError::unreadable(path, &error)),
        }
    }
    Ok(hexadecimal(hash))
}

/// SHA-256 of bytes, lower-case hexadecimal.
#[must_use]
pub fn sha256_of(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_changes_while_it_is_read_is_named() {
        let folder = tempfile::tempdir().expect("folder");
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&a, b"one").expect("write");
        std::fs::write(&b, b"two").expect("write");
        let mut stamps = Stamps::begin(&a);
        stamps.add([b.clone()]);
        assert_eq!(stamps.unchanged(), Ok(()));
        std::fs::write(&b, b"three").expect("write");
        let error = stamps.unchanged().expect_err("changed");
        assert_eq!(*error.file, *b);
    }

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn bytes_have_the_digest_of_a_file() {
        assert!(sha256_of(b"abc").starts_with("ba7816bf8f01cfea"));
    }

    #[test]
    fn the_digest_of_abc_is_the_published_one() {
        let file = tempfile::NamedTempFile::new().expect("file");
        std::fs::write(file.path(), b"abc").expect("write");
        assert_eq!(
            sha256(file.path()).expect("digest"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
