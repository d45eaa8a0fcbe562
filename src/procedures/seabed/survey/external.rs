//! A trajectory from another file than the sounder's: its clock, its place, and whether the two agree.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::super::scene::DriftSigmas;
use super::file::SeabedSurveyFile;
use super::recorded::heights;
use crate::formats::recorder::{TimeScale, utc};
use crate::formats::smrmsg::{self, Accuracies};
use crate::formats::{TrajectoryRecords, read_trajectory};
use crate::recorders::navigation::{Lacking, Wanted, at_reference, navigation};
use crate::recorders::{Observed, Recorded};
use crate::survey::clock::{Span, explain_shift};
use crate::survey::problem::{Problem, SurveyError};
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
    let (mut records, scale, mut notes) = of_file(file, &path)?;
    notes.push(to_utc(file, &path, scale, &mut records.time_s, observed)?);
    agreeing(&path, &records, &observed.recorded)?;
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
    let clock = Clock::new(file, path, scale, times_s, observed)?;
    for time_s in &mut *times_s {
        *time_s += clock.shift_s;
    }
    overlapping(path, times_s, observed)?;
    Ok(clock.words)
}

type Read = (TrajectoryRecords, Option<TimeScale>, Vec<String>);

/// The records with what the file says of their times: nothing in a CSV.
fn of_file(file: &SeabedSurveyFile, path: &Path) -> Result<Read, SurveyError> {
    let ends = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let ends = ends.unwrap_or_default();
    if ends == "csv" {
        return Ok((
            read_trajectory(path, file.trajectory.invalid)?,
            None,
            vec![],
        ));
    }
    if ends == "sbet" || ends == "out" {
        let records = read_trajectory(path, file.trajectory.invalid)?;
        return Ok((records, Some(TimeScale::SecondsOfWeek), vec![]));
    }
    let mut all = Observed::default();
    all.read(path)?;
    let scale = all.files.first().map(|f| f.summary.time);
    let made = navigation(&all.recorded, &wanted(file)).map_err(|missing| {
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

/// What is added to the times of a file to make them UTC.
struct Clock {
    shift_s: f64,
    words: String,
}

impl Clock {
    fn new(
        file: &SeabedSurveyFile,
        path: &Path,
        scale: Option<TimeScale>,
        times_s: &[f64],
        observed: &Observed,
    ) -> Result<Self, SurveyError> {
        let t = &file.trajectory;
        let first_s = observed.first_s().unwrap_or(0.0);
        let leap_s = t.leap_seconds.unwrap_or_else(|| utc::leap_seconds(first_s));
        let named = t.time.as_deref().or(match scale {
            None | Some(TimeScale::Utc) => Some("utc"),
            Some(TimeScale::Gps) => Some("gps"),
            Some(TimeScale::SecondsOfWeek) => None,
        });
        let Some(named) = named else {
            let found = "seconds of the week, and no word whether GPS or UTC";
            let expected = "time = \"gps-week\" (what POSPac exports unless told otherwise) or \"utc-week\" under [trajectory]";
            return Err(Problem::new(path, "[trajectory] time", found, expected).into());
        };
        let behind_s = if named.starts_with("gps") {
            leap_s
        } else {
            0.0
        };
        let (unit_s, epoch_s) = match named {
            "gps-week" | "utc-week" => (utc::WEEK_S, utc::GPS_EPOCH_S),
            "gps-day" | "utc-day" => (utc::DAY_S, 0.0),
            _ => (0.0, 0.0),
        };
        let begin_s = match t.week {
            _ if unit_s == 0.0 => 0.0,
            Some(week) if unit_s == utc::WEEK_S => utc::from_gps_week(week, 0.0),
            _ => begin_s(times_s, observed, (unit_s, epoch_s), behind_s),
        };
        let words = if unit_s == 0.0 {
            format!("times of the trajectory: {named}, {behind_s} s taken off")
        } else {
            let day = utc::written(begin_s);
            format!("times of the trajectory: {named} from {day}, {behind_s} s taken off")
        };
        Ok(Self {
            shift_s: begin_s - behind_s,
            words,
        })
    }
}

/// Begin of the week or day in which the file meets the soundings: that of the first sounding, or the one before.
fn begin_s(
    times_s: &[f64],
    observed: &Observed,
    (unit_s, epoch_s): (f64, f64),
    behind_s: f64,
) -> f64 {
    let first_s = observed.first_s().unwrap_or(0.0) + behind_s;
    let own = epoch_s + ((first_s - epoch_s) / unit_s).floor() * unit_s;
    let soundings = soundings_span(observed);
    let meets = |begin_s: &f64| {
        let span = Span::of(times_s).zip(soundings);
        span.is_some_and(|(trajectory, soundings)| {
            let moved = Span {
                first_s: trajectory.first_s + begin_s - behind_s,
                last_s: trajectory.last_s + begin_s - behind_s,
            };
            moved.overlaps(&soundings)
        })
    };
    [own, own - unit_s].into_iter().find(meets).unwrap_or(own)
}

fn soundings_span(observed: &Observed) -> Option<Span> {
    let spans = observed.files.iter().filter_map(|file| file.span_s);
    let joined = spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    Some(Span {
        first_s: joined.0,
        last_s: joined.1,
    })
}

/// Refuses a file whose times never meet the soundings, with the confusion of clocks that would explain it.
fn overlapping(path: &Path, times_s: &[f64], observed: &Observed) -> Result<(), SurveyError> {
    let (Some(own), Some(soundings)) = (Span::of(times_s), soundings_span(observed)) else {
        return Ok(());
    };
    if own.overlaps(&soundings) {
        return Ok(());
    }
    let during = |span: &Span| {
        format!(
            "{} to {}",
            utc::written(span.first_s),
            utc::written(span.last_s)
        )
    };
    let hint = explain_shift(&own, &soundings).map_or(String::new(), |words| format!("; {words}"));
    let expected = format!(
        "times that meet those of the soundings, {}{hint}: look at time, week and leap_seconds under [trajectory]",
        during(&soundings)
    );
    Err(Problem::new(path, "times", during(&own), expected).into())
}

/// Shifts at which a wrong time scale would show, seconds.
const LEAPS_S: [f64; 12] = [
    -18.0, -17.0, -16.0, -15.0, -14.0, -13.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0,
];
/// Roll that differs less than this says nothing about the clocks, degrees.
const CALM_DEG: f64 = 0.1;

/// Refuses a trajectory whose roll is the recorder's own some leap seconds earlier or later.
fn agreeing(
    path: &Path,
    records: &TrajectoryRecords,
    recorded: &Recorded,
) -> Result<(), SurveyError> {
    let step = recorded.attitude.len().div_ceil(2000).max(1);
    let off_deg = |shift_s: f64| {
        let own = recorded.attitude.iter().step_by(step);
        let off = own.filter_map(|a| Some(a.roll_rad - roll_rad(records, a.time_s + shift_s)?));
        let (count, squares) = off.fold((0, 0.0), |(n, sum), x| (n + 1, sum + x * x));
        (count >= 100).then(|| degrees((squares / f64::from(count)).sqrt()))
    };
    let Some(here) = off_deg(0.0).filter(|off| *off > CALM_DEG) else {
        return Ok(());
    };
    let apart = LEAPS_S.iter().filter_map(|s| Some((*s, off_deg(*s)?)));
    let best = apart.min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((shift_s, there)) = best.filter(|best| best.1 < 0.4 * here) else {
        return Ok(());
    };
    let found = format!(
        "a roll that is the recorder's own {:.0} s {} (within {there:.2} deg; as the times stand {here:.2} deg)",
        shift_s.abs(),
        if shift_s > 0.0 { "later" } else { "earlier" },
    );
    let expected = "the same motion at the same time: look at time and leap_seconds under [trajectory] (GPS or UTC)";
    Err(Problem::new(path, "times", found, expected).into())
}

fn roll_rad(records: &TrajectoryRecords, time_s: f64) -> Option<f64> {
    let after = records.time_s.partition_point(|t| *t < time_s);
    let before = after.checked_sub(1)?;
    let (begin_s, end_s) = (records.time_s[before], *records.time_s.get(after)?);
    let share = (time_s - begin_s) / (end_s - begin_s);
    let (a, b) = (records.roll_rad[before], records.roll_rad[after]);
    (end_s - begin_s < 1.0).then_some(a + share * (b - a))
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
