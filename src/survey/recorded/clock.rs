//! Clocks beside the sounder's: what a file's times are, and whether they meet the soundings.

use std::path::Path;

use crate::formats::TrajectoryRecords;
use crate::formats::recorder::{TimeScale, utc};
use crate::recorders::{Observed, Recorded};
use crate::survey::clock::{Span, explain_shift};
use crate::survey::problem::{Problem, SurveyError};
use crate::units::degrees;

/// What is added to the times of a file to make them UTC.
pub(crate) struct Clock {
    /// Seconds.
    pub(crate) shift_s: f64,
    /// What was done, in words.
    pub(crate) words: String,
}

/// What LAS takes off GPS seconds, seconds.
const ADJUSTED_S: f64 = 1e9;

/// What a section of the survey file says of a file's times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Named<'s> {
    /// The section, for messages.
    pub(crate) section: &'static str,
    /// Its keys, for messages.
    pub(crate) keys: &'static str,
    /// Whose times, in words.
    pub(crate) of: &'static str,
    /// `time`.
    pub(crate) time: Option<&'s str>,
    /// `week`.
    pub(crate) week: Option<u32>,
    /// `leap_seconds`.
    pub(crate) leap_seconds: Option<f64>,
}

impl Clock {
    /// Of a file's times by what the survey file names them, else by what the file's format says; a file whose format says nothing has
    /// the sounder's (UTC).
    ///
    /// # Errors
    /// [`SurveyError`] where neither says whether seconds of the week are of GPS or of UTC.
    pub(crate) fn new(
        t: &Named<'_>,
        path: &Path,
        scale: Option<TimeScale>,
        times_s: &[f64],
        observed: &Observed,
    ) -> Result<Self, SurveyError> {
        let first_s = observed.first_s().unwrap_or(0.0);
        let leap_s = t.leap_seconds.unwrap_or_else(|| utc::leap_seconds(first_s));
        let named = t.time.or(match scale {
            None | Some(TimeScale::Utc) => Some("utc"),
            Some(TimeScale::Gps) => Some("gps"),
            Some(TimeScale::SecondsOfWeek) => None,
        });
        let Some(named) = named else {
            let found = "seconds of the week, and no word whether GPS or UTC";
            let expected = format!(
                "time = \"gps-week\" (what POSPac exports unless told otherwise) or \"utc-week\" under [{}]",
                t.section
            );
            let place = format!("[{}] time", t.section);
            return Err(Problem::new(path, place, found, expected).into());
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
        let begin_s = if named == "gps-adjusted" {
            utc::GPS_EPOCH_S + ADJUSTED_S
        } else {
            begin_s
        };
        let words = if unit_s == 0.0 {
            format!("times of the {}: {named}, {behind_s} s taken off", t.of)
        } else {
            let day = utc::written(begin_s);
            format!(
                "times of the {}: {named} from {day}, {behind_s} s taken off",
                t.of
            )
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

/// The clock of a file's times, as [`Clock::new`].
///
/// # Errors
/// As [`Clock::new`]; also where the times, made UTC, never meet the soundings, with the confusion of clocks that would explain it.
pub(crate) fn meeting(
    named: &Named<'_>,
    path: &Path,
    scale: Option<TimeScale>,
    times_s: &[f64],
    observed: &Observed,
) -> Result<Clock, SurveyError> {
    let clock = Clock::new(named, path, scale, times_s, observed)?;
    let moved = Span::of(times_s).map(|span| Span {
        first_s: span.first_s + clock.shift_s,
        last_s: span.last_s + clock.shift_s,
    });
    overlapping(named, path, moved, observed)?;
    Ok(clock)
}

/// Refuses times (UTC) that never meet the soundings.
fn overlapping(
    named: &Named<'_>,
    path: &Path,
    times: Option<Span>,
    observed: &Observed,
) -> Result<(), SurveyError> {
    let (Some(own), Some(soundings)) = (times, soundings_span(observed)) else {
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
        "times that meet those of the soundings, {}{hint}: look at {} under [{}]",
        during(&soundings),
        named.keys,
        named.section
    );
    Err(Problem::new(path, "times", during(&own), expected).into())
}

/// Shifts at which a wrong time scale would show, seconds.
const LEAPS_S: [f64; 12] = [
    -18.0, -17.0, -16.0, -15.0, -14.0, -13.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0,
];
/// Roll that differs less than this says nothing about the clocks, degrees.
const CALM_DEG: f64 = 0.1;

/// Refuses a trajectory whose roll, `behind_s` added to its times to make them UTC, is the recorder's own some leap seconds earlier or
/// later.
///
/// # Errors
/// [`SurveyError`] naming the shift.
pub(crate) fn agreeing(
    path: &Path,
    (records, behind_s): (&TrajectoryRecords, f64),
    recorded: &Recorded,
) -> Result<(), SurveyError> {
    let step = recorded.attitude.len().div_ceil(2000).max(1);
    let off_deg = |shift_s: f64| {
        let own = recorded.attitude.iter().step_by(step);
        let off = own
            .filter_map(|a| Some(a.roll_rad - roll_rad(records, a.time_s + shift_s - behind_s)?));
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
