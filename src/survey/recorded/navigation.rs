//! Trajectories of recorder surveys: from a file beside the sounder's, or the recorder's own navigation.

use std::path::Path;

use crate::formats::recorder::TimeScale;
use crate::formats::{Invalid, TrajectoryRecords, read_trajectory};
use crate::recorders::navigation::{Lacking, Wanted, navigation};
use crate::recorders::{Navigation, Observed, Recorded};
use crate::survey::problem::{Problem, SurveyError};

/// Records, the scale of their times where the format says it, and what was done.
pub(crate) type Read = (TrajectoryRecords, Option<TimeScale>, Vec<String>);

/// The trajectory in a file with what the file says of its times: nothing in a CSV.
///
/// # Errors
/// [`SurveyError`] where it cannot be read or has no trajectory in it.
pub(crate) fn of_file(path: &Path, wanted: &Wanted, invalid: Invalid) -> Result<Read, SurveyError> {
    let ends = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let ends = ends.unwrap_or_default();
    if ends == "csv" {
        return Ok((read_trajectory(path, invalid)?, None, vec![]));
    }
    if ends == "sbet" || ends == "out" {
        let records = read_trajectory(path, invalid)?;
        return Ok((records, Some(TimeScale::SecondsOfWeek), vec![]));
    }
    let mut all = Observed::default();
    all.read(path)?;
    let scale = all.files.first().map(|f| f.summary.time);
    let made = navigation(&all.recorded, wanted).map_err(|missing| {
        let problem = |lacking: Lacking| {
            let found = format!("no {}", lacking.what);
            Problem::new(path, "navigation", found, "attitude, positions and heights")
        };
        SurveyError {
            problems: missing.into_iter().map(problem).collect(),
        }
    })?;
    Ok((made.records, scale, made.notes))
}

/// The recorder's own navigation; `path` names the files in messages.
///
/// # Errors
/// [`SurveyError`] with everything that is missing and what would supply it.
pub(crate) fn own(
    path: &Path,
    recorded: &Recorded,
    wanted: &Wanted,
) -> Result<Navigation, SurveyError> {
    navigation(recorded, wanted).map_err(|missing| {
        let problem = |lacking: Lacking| {
            let found = format!("no {}", lacking.what);
            Problem::new(path, "navigation", found, lacking.supplied_by)
        };
        SurveyError {
            problems: missing.into_iter().map(problem).collect(),
        }
    })
}
