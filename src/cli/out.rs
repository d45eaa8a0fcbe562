//! Where a command may write: never over the user's files.

use std::io::Read;
use std::path::Path;

use super::error::CliError;
use crate::files::{self, FolderError, Ours};
use crate::formats::digest::sha256_of;
use crate::formats::las::stream::WRITTEN_BY;
use crate::results::InputFile;
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// Files of a calibration.
pub const RESULT_FILES: [&str; 2] = ["result.json", "report.html"];

/// A folder that a command fills with files that belong together.
#[derive(Clone, Debug)]
pub struct Place<'a> {
    folder: &'a Path,
    made: String,
    force: bool,
}

impl<'a> Place<'a> {
    /// A folder, and what is made in it: the command in words, and the scenario it is made from.
    pub fn new(
        folder: &'a Path,
        command: &str,
        scenario: &impl std::fmt::Debug,
        force: bool,
    ) -> Self {
        let digest = sha256_of(format!("{scenario:?}").as_bytes());
        let made = format!("{command} (scenario {})", &digest[..12]);
        Self {
            folder,
            made,
            force,
        }
    }

    /// The same job in another folder.
    pub fn within<'b>(&self, folder: &'b Path) -> Place<'b> {
        let (made, force) = (self.made.clone(), self.force);
        Place {
            folder,
            made,
            force,
        }
    }

    /// Makes a survey's files.
    pub fn survey<T>(
        &self,
        write: impl FnOnce(&Path) -> Result<T, CliError>,
    ) -> Result<T, CliError> {
        files::made_together(
            self.folder,
            &self.made,
            self.force,
            &[SURVEY_FILE, TRUTH_FILE],
            write,
        )
    }

    /// Refuses a folder where a survey or a result stands that this job may not replace.
    pub fn free_for_results(&self) -> Result<(), CliError> {
        let names = RESULT_FILES.into_iter().chain([SURVEY_FILE]);
        let ours = Ours::of(self.folder);
        Ok(ours.may_replace(self.folder, &self.made, self.force, names)?)
    }

    /// Makes the files of a calibration.
    pub fn results<T>(
        &self,
        write: impl FnOnce(&Path) -> Result<T, CliError>,
    ) -> Result<T, CliError> {
        self.free_for_results()?;
        files::made_together(self.folder, &self.made, self.force, &RESULT_FILES, write)
    }
}

/// Tries before the work whether these files can be written into a folder.
pub fn tried(folder: &Path, names: &[&str]) -> Result<(), CliError> {
    Ok(files::tried(folder, names).map_err(FolderError::Write)?)
}

/// Refuses a point cloud's name where an input of the survey stands, or a file that `apply` did not write; `--force` replaces what
/// another command of this program wrote.
pub fn free_for_cloud(
    out: &Path,
    survey: &Path,
    inputs: &[InputFile],
    calibration: &Path,
    force: bool,
) -> Result<(), CliError> {
    let folder = survey.parent().unwrap_or(Path::new(""));
    let named: Vec<_> = inputs.iter().map(|i| folder.join(&i.path)).collect();
    let all = named.iter().map(|p| p.as_path());
    files::none_is(out, all.chain([survey, calibration]))?;
    let folder = files::whole::folder_of(out);
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    tried(folder, &[&name])?;
    if std::fs::symlink_metadata(out).is_err() {
        return Ok(());
    }
    let (system, software) = authors(out);
    let file = out.to_owned();
    match (system == WRITTEN_BY, software == "boresight") {
        (true, true) => Ok(()),
        (false, true) if force => Ok(()),
        (false, true) => Err(CliError::Cloud { file }),
        _ => Err(FolderError::NotOurs {
            file,
            changed: false,
        }
        .into()),
    }
}

/// System identifier and generating software of a LAS or LAZ file; empty for any other.
fn authors(path: &Path) -> (String, String) {
    let mut header = [0; 90];
    let read = crate::formats::error::open(path)
        .ok()
        .and_then(|(mut file, _)| file.read_exact(&mut header).ok());
    if read.is_none() || !header.starts_with(b"LASF") {
        return Default::default();
    }
    let text = |bytes: &[u8]| {
        String::from_utf8_lossy(bytes)
            .trim_end_matches('\0')
            .to_owned()
    };
    (text(&header[26..58]), text(&header[58..90]))
}
