//! Where a command may write: never over the user's files.

use std::io::Read;
use std::path::Path;

use super::error::CliError;
use crate::calibrate::seam::InputError;
use crate::files::{self, FolderError};
use crate::formats::digest::sha256_of;
use crate::formats::geotiff;
use crate::formats::las::stream::WRITTEN_BY;
use crate::results::InputFile;
use crate::survey::{SURVEY_FILE, TRUTH_FILE};

/// Files of a calibration.
pub const RESULT_FILES: [&str; 3] = ["result.json", "report.html", "parameters.csv"];

/// Lets `write` make a survey from a scenario's text, all of its files together or none; only over what this program wrote, and over
/// another survey of its own only with `force`.
pub fn survey_into<T>(
    folder: &Path,
    (command, scenario): (&str, &str),
    force: bool,
    write: impl FnOnce(&Path) -> Result<T, InputError>,
) -> Result<T, CliError> {
    let digest = sha256_of(scenario.as_bytes());
    let made = format!("{command} (scenario {})", &digest[..12]);
    files::made_together(folder, &made, force, &[SURVEY_FILE, TRUTH_FILE], |place| {
        Ok(write(place)?)
    })
}

/// Tries before the work whether these files can be written into a folder.
pub fn tried(folder: &Path, names: &[&str]) -> Result<(), CliError> {
    Ok(files::tried(folder, names).map_err(FolderError::Write)?)
}

/// Whether nothing stands at a name that is none of the survey's inputs and none of the `others`, in a folder that can be written into.
fn is_free(
    out: &Path,
    survey: &Path,
    inputs: &[InputFile],
    others: &[&Path],
) -> Result<bool, CliError> {
    let folder = survey.parent().unwrap_or(Path::new(""));
    let named: Vec<_> = inputs.iter().map(|i| folder.join(&i.path)).collect();
    let all = named.iter().map(std::path::PathBuf::as_path);
    files::none_is(out, all.chain(others.iter().copied()))?;
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    tried(files::whole::folder_of(out), &[&name])?;
    Ok(std::fs::symlink_metadata(out).is_err())
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
    if is_free(out, survey, inputs, &[survey, calibration])? {
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

/// Refuses a surface's name where an input of the survey or the cloud stands, or a file that `apply` did not write.
pub fn free_for_surface(
    out: &Path,
    cloud: &Path,
    survey: &Path,
    inputs: &[InputFile],
    calibration: &Path,
) -> Result<(), CliError> {
    if is_free(out, survey, inputs, &[survey, calibration, cloud])? || geotiff::is_ours(out) {
        return Ok(());
    }
    let file = out.to_owned();
    Err(FolderError::NotOurs {
        file,
        changed: false,
    }
    .into())
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
