//! Files written whole or not at all: a temporary file beside the target, then a rename.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::error::FormatError;

/// Lets `write` fill a temporary file in the folder of `path`, and gives it that name when all went well.
///
/// # Errors
/// [`FormatError`] of kind `Unwritable`; the old file, if any, is untouched then.
pub fn write_whole<E: std::fmt::Display>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Result<(), FormatError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let unwritable = |error: &dyn std::fmt::Display| FormatError::unwritable(path, error);
    let mut temporary = tempfile::Builder::new()
        .prefix(".boresight-")
        .tempfile_in(folder)
        .map_err(|e| unwritable(&e))?;
    let mut buffer = BufWriter::with_capacity(1 << 20, temporary.as_file_mut());
    write(&mut buffer).map_err(|e| unwritable(&e))?;
    buffer.flush().map_err(|e| unwritable(&e))?;
    drop(buffer);
    readable_by_all(temporary.as_file()).map_err(|e| unwritable(&e))?;
    temporary.persist(path).map_err(|e| unwritable(&e.error))?;
    Ok(())
}

/// Temporary files are private; results are ordinary files.
#[cfg(unix)]
pub(super) fn readable_by_all(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
pub(super) fn readable_by_all(_file: &File) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("a.txt");
        write_whole(&path, |w| w.write_all(b"old")).expect("written");
        let failed = write_whole(&path, |w| {
            w.write_all(b"half")?;
            Err(std::io::Error::other("disk on fire"))
        });
        assert!(
            failed
                .expect_err("fails")
                .to_string()
                .contains("disk on fire")
        );
        assert_eq!(std::fs::read(&path).expect("read"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("list").count(), 1);
    }
}
