//! SHA-256 of an input file, for the provenance of a result.

use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::error::{FormatError, open};

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
