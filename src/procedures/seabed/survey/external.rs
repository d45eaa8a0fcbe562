//! A trajectory from another file than the sounder's: its clock, its place, and whether the two agree.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::super::scene::DriftSigmas;
use super::file::SeabedSurveyFile;
use super::recorded::heights;
use crate::formats::TrajectoryRecords;
use crate::formats::recorder::TimeScale;
use crate::formats::smrmsg::{self, Accuracies};
use crate::recorders::Observed;
use crate::recorders::navigation::{Wanted, at_reference};
use crate::survey::problem::SurveyError;
use crate::survey::recorded::clock::{Named, agreeing, meeting};
use crate::survey::recorded::navigation::of_file;
use crate::units::degrees;

/// A trajectory beside the sounder's files.
pub(super) struct External {
    /// Poses of the reference point, times as the sounder's (UTC).
    pub(super) records: TrajectoryRecords,
    /// What was done, in words.
    pub(super) notes: Vec<String>,
}

/// Sigmas that accuracies of an SBET supply.
pub(super) const MEASURED: &[&str] = &[
    "position_drift_sigma_m",
    "height_drift_sigma_m",
    "roll_pitch_drift_sigma_deg",
    "heading_drift_sigma_deg",
];

/// How a recorder's navigation is wanted.
pub(super) fn wanted(file: &SeabedSurveyFile) -> Wanted {
    Wanted {
        heights: heights(file),
        max_gap_s: file.trajectory.max_gap_s,
        ellipsoid: file.site.ellipsoid,
        heave_serves: true,
    }
}

/// Reads `[trajectory] path`, if it is given.
pub(super) fn read(
    file: &SeabedSurveyFile,
    folder: &Path,
    observed: &Observed,
) -> Result<Option<External>, SurveyError> {
    let Some(name) = &file.trajectory.path else {
        return Ok(None);
    };
    let path = folder.join(name);
    let (mut records, scale, mut notes) = of_file(&path, &wanted(file), file.trajectory.invalid)?;
    notes.push(to_utc(file, &path, scale, &mut records.time_s, observed)?);
    agreeing(&path, (&records, 0.0), &observed.recorded)?;
    let arm_m = Vector3::from(file.trajectory.lever_arm_m);
    Ok(Some(External {
        records: at_reference(records, &arm_m, file.site.ellipsoid),
        notes,
    }))
}

/// Makes the times of a file UTC, and says how; a file that then never meets the soundings is refused.
fn to_utc(
    file: &SeabedSurveyFile,
    path: &Path,
    scale: Option<TimeScale>,
    times_s: &mut [f64],
    observed: &Observed,
) -> Result<String, SurveyError> {
    let t = &file.trajectory;
    let named = Named {
        section: "trajectory",
        keys: "time, week and leap_seconds",
        of: "trajectory",
        time: t.time.as_deref(),
        week: t.week,
        leap_seconds: t.leap_seconds,
    };
    let clock = meeting(&named, path, scale, times_s, observed)?;
    for time_s in &mut *times_s {
        *time_s += clock.shift_s;
    }
    Ok(clock.words)
}

/// Drift sigmas from the accuracies of an SBET, record by record, and as root mean squares in the survey file; what the survey file gives
/// itself stays.
pub(super) fn accuracies(
    file: &mut SeabedSurveyFile,
    folder: &Path,
    observed: &Observed,
    is_given: impl Fn(&str) -> bool,
) -> Result<Option<(DriftSigmas, String)>, SurveyError> {
    let Some(name) = file.trajectory.accuracies.clone() else {
        return Ok(None);
    };
    let path: PathBuf = folder.join(&name);
    let mut all = smrmsg::read(&path)?;
    let scale = Some(TimeScale::SecondsOfWeek);
    to_utc(file, &path, scale, &mut all.time_s, observed)?;
    let [horizontal_m, height_m, tilt_deg, heading_deg] = rms(&all);
    let t = &mut file.trajectory;
    let targets = [
        (&mut t.position_drift_sigma_m, horizontal_m),
        (&mut t.height_drift_sigma_m, height_m),
        (&mut t.roll_pitch_drift_sigma_deg, tilt_deg),
        (&mut t.heading_drift_sigma_deg, heading_deg),
    ];
    for ((target, value), key) in targets.into_iter().zip(MEASURED) {
        if !is_given(key) {
            *target = value;
        }
    }
    let words = format!(
        "accuracies of {name}: position {horizontal_m:.4} m, height {height_m:.4} m, roll and pitch {tilt_deg:.4} deg, heading {heading_deg:.4} deg as root mean squares, taken as drifts, each moment with its own"
    );
    Ok(Some((over_time(all, is_given), words)))
}

/// The accuracies of the components whose drift the survey file does not give.
fn over_time(all: Accuracies, is_given: impl Fn(&str) -> bool) -> DriftSigmas {
    let column = |key: usize, rows: &[[f64; 3]], k: usize| match is_given(MEASURED[key]) {
        true => vec![],
        false => rows.iter().map(|row| row[k]).collect(),
    };
    let (place, angles) = (&all.position_m, &all.attitude_rad);
    DriftSigmas {
        components: [
            column(0, place, 0),
            column(0, place, 1),
            column(1, place, 2),
            column(2, angles, 1),
            column(2, angles, 0),
            column(3, angles, 2),
        ],
        time_s: all.time_s,
    }
}

/// Root mean squares: horizontal per axis, height, roll and pitch, heading; metres and degrees.
fn rms(all: &Accuracies) -> [f64; 4] {
    let n = all.time_s.len().max(1) as f64;
    let root = |sum: f64| (sum / n).sqrt();
    let position = |k: usize| all.position_m.iter().map(|p| p[k] * p[k]).sum::<f64>();
    let angle = |k: usize| all.attitude_rad.iter().map(|a| a[k] * a[k]).sum::<f64>();
    [
        root(0.5 * (position(0) + position(1))),
        root(position(2)),
        degrees(root(0.5 * (angle(0) + angle(1)))),
        degrees(root(angle(2))),
    ]
}
