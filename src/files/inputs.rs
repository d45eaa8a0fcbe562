//! Whether a path names a file that was read.

use std::path::{Path, PathBuf};

/// A file to write that is one of those that were read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}: whole file: found {}, which this run reads, expected another name to write to",
    file.display(),
    if file == input { "a file".to_owned() } else { input.display().to_string() }
)]
pub struct Overwrites {
    /// The file to write.
    pub file: PathBuf,
    /// The input that it is.
    pub input: PathBuf,
}

/// Refuses to write over a file that is read: by another path, a link, or a second name of the same file too.
///
/// # Errors
/// [`Overwrites`] with the first input that `file` is.
pub fn none_is<'p>(
    file: &Path,
    inputs: impl IntoIterator<Item = &'p Path>,
) -> Result<(), Overwrites> {
    match inputs.into_iter().find(|input| same(file, input)) {
        None => Ok(()),
        Some(input) => Err(Overwrites {
            file: file.to_owned(),
            input: input.to_owned(),
        }),
    }
}

/// Whether two paths lead to one file.
fn same(a: &Path, b: &Path) -> bool {
    let place = |p: &Path| std::fs::canonicalize(p).ok();
    match (place(a), place(b)) {
        (Some(x), Some(y)) => x == y || one_file(&x, &y),
        _ => false,
    }
}

#[cfg(unix)]
fn one_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |p: &Path| std::fs::metadata(p).ok().map(|m| (m.dev(), m.ino()));
    number(a).is_some() && number(a) == number(b)
}

#[cfg(not(unix))]
fn one_file(_: &Path, _: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_is_known_by_any_of_its_names() {
        let folder = tempfile::tempdir().expect("folder");
        let input = folder.path().join("lidar.laz");
        std::fs::write(&input, b"points").expect("written");
        std::fs::create_dir(folder.path().join("sub")).expect("folder");
        let by_detour = folder.path().join("sub/../lidar.laz");
        let linked = folder.path().join("second-name.laz");
        std::fs::hard_link(&input, &linked).expect("linked");
        for file in [&input, &by_detour, &linked] {
            let error = none_is(file, [input.as_path()]).expect_err("an input");
            assert!(
                error.to_string().contains("which this run reads"),
                "{error}"
            );
        }
        let other = folder.path().join("other.laz");
        assert_eq!(none_is(&other, [input.as_path()]), Ok(()));
    }
}
