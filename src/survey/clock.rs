//! Do the sensors' clocks agree with the trajectory's, and does every observation have a position?

use crate::formats::week::WEEK_S;
use std::ops::Range;

use crate::observe::{Outside, SoundingFile};

/// First and last time of a sensor, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// First time.
    pub first_s: f64,
    /// Last time.
    pub last_s: f64,
}

impl Span {
    /// Of times that ascend; `None` when there are none.
    #[must_use]
    pub fn of(time_s: &[f64]) -> Option<Self> {
        let (first_s, last_s) = (*time_s.first()?, *time_s.last()?);
        Some(Self { first_s, last_s })
    }

    /// Whether the two have a moment in common.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.first_s <= other.last_s && other.first_s <= self.last_s
    }

    /// Whether `other`, with `shift_s` added to its times, lies within.
    fn contains_shifted(&self, other: &Self, shift_s: f64) -> bool {
        self.first_s <= other.first_s + shift_s && other.last_s + shift_s <= self.last_s
    }
}

impl std::fmt::Display for Span {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.3} s to {:.3} s", self.first_s, self.last_s)
    }
}

/// GPS minus UTC since 2017, seconds.
const LEAP_S: f64 = 18.0;
const DAY_S: f64 = 86_400.0;
/// LAS subtracts this from GPS seconds ("adjusted standard time").
const ADJUSTED_S: f64 = 1e9;

/// A sentence naming the confusion of clocks that would explain why `sensor` is not within `trajectory`, if one would.
#[must_use]
pub fn explain_shift(trajectory: &Span, sensor: &Span) -> Option<String> {
    let thousandth = Span {
        first_s: sensor.first_s / 1e3,
        last_s: sensor.last_s / 1e3,
    };
    if trajectory.overlaps(&thousandth) && !trajectory.overlaps(sensor) {
        return Some("taken as milliseconds they would lie inside: give seconds".to_owned());
    }
    let (total_s, what) = shift_of(trajectory, sensor)?;
    Some(format!(
        "time_offset_s = {total_s} would bring it inside, which is {what}"
    ))
}

/// The seconds that bring `sensor` within `trajectory`, and the confusion of clocks that they are, if one is.
#[must_use]
pub fn shift_of(trajectory: &Span, sensor: &Span) -> Option<(f64, String)> {
    let middle = |s: &Span| 0.5 * (s.first_s + s.last_s);
    let apart_s = middle(trajectory) - middle(sensor);
    let whole = |unit_s: f64, base_s: f64| ((apart_s - base_s) / unit_s).round() * unit_s + base_s;
    let candidates = [
        (
            whole(WEEK_S, 0.0),
            "whole GPS weeks: seconds of the week against continuous GPS seconds",
        ),
        (
            whole(WEEK_S, ADJUSTED_S),
            "1e9 s and whole weeks: adjusted standard GPS time (LAS) against seconds of the week",
        ),
        (
            whole(WEEK_S, -ADJUSTED_S),
            "1e9 s and whole weeks: adjusted standard GPS time (LAS) against seconds of the week",
        ),
        (
            whole(DAY_S, 0.0),
            "whole days: seconds of the week, of the day, or of another epoch (UTC, GPS)",
        ),
    ];
    for (shift_s, what) in candidates {
        for leap_s in [0.0, LEAP_S, -LEAP_S] {
            let total_s = shift_s + leap_s;
            if total_s == 0.0 || !trajectory.contains_shifted(sensor, total_s) {
                continue;
            }
            let leap = match (shift_s, leap_s) {
                (_, 0.0) => what.to_owned(),
                (0.0, _) => "the leap seconds between GPS and UTC".to_owned(),
                _ => format!("{what}, and the 18 leap seconds between GPS and UTC"),
            };
            return Some((total_s, leap));
        }
    }
    None
}

/// Why an observation has no position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lost {
    /// Before the first or after the last record.
    Outside,
    /// In a gap of the trajectory.
    Gap {
        /// Last record before it, seconds.
        begin_s: f64,
        /// First record after it, seconds.
        end_s: f64,
    },
}

/// Times of a sensor, ascending, wherever they are kept.
pub trait Times {
    /// How many.
    fn count(&self) -> usize;

    /// The `k`-th, seconds.
    fn at_s(&self, k: usize) -> f64;
}

impl Times for [f64] {
    fn count(&self) -> usize {
        self.len()
    }

    fn at_s(&self, k: usize) -> f64 {
        self[k]
    }
}

impl Times for SoundingFile {
    fn count(&self) -> usize {
        self.len()
    }

    fn at_s(&self, k: usize) -> f64 {
        self.time_s(k)
    }
}

/// Runs of observations without a position for one reason each.
type LostRuns = Vec<(Range<usize>, Lost)>;

/// The observations (ascending times) without a position, in their order; one pass over both columns.
#[must_use]
pub fn without_position<T: Times + ?Sized>(
    trajectory_s: &[f64],
    max_gap_s: f64,
    times: &T,
) -> Vec<(Range<usize>, Lost)> {
    let mut lost: LostRuns = vec![];
    let Some(span) = Span::of(trajectory_s).filter(|_| trajectory_s.len() >= 2) else {
        return vec![(0..times.count(), Lost::Outside)];
    };
    let mut add = |k: usize, why: Lost| match lost.last_mut() {
        Some((run, last)) if run.end == k && *last == why => run.end += 1,
        _ => lost.push((k..k + 1, why)),
    };
    let mut record = 0;
    for k in 0..times.count() {
        let t = times.at_s(k);
        if !(t >= span.first_s && t <= span.last_s) {
            add(k, Lost::Outside);
            continue;
        }
        while record + 2 < trajectory_s.len() && trajectory_s[record + 1] <= t {
            record += 1;
        }
        let (begin_s, end_s) = (trajectory_s[record], trajectory_s[record + 1]);
        if end_s - begin_s > max_gap_s && t > begin_s && t < end_s {
            add(k, Lost::Gap { begin_s, end_s });
        }
    }
    lost
}

/// A clock beside the trajectory's puts at most this much of a recording off its end, seconds.
const OFF_S: f64 = 2.0;

/// The clock that would explain observations without position: all of them lie shortly after a stretch of the trajectory, or all
/// shortly before one.
fn shifted<T: Times + ?Sized>(
    trajectory_s: &[f64],
    times: &T,
    lost: &[(Range<usize>, Lost)],
) -> Option<String> {
    let most = |by: &dyn Fn(usize) -> f64| {
        let all = lost.iter().flat_map(|(run, _)| run.clone()).map(by);
        all.fold(0.0, f64::max)
    };
    let next = |k: usize| trajectory_s.partition_point(|record| *record <= times.at_s(k));
    let after = |k: usize| match next(k) {
        0 => f64::INFINITY,
        n => times.at_s(k) - trajectory_s[n - 1],
    };
    let before = |k: usize| {
        let record = trajectory_s.get(next(k));
        record.map_or(f64::INFINITY, |record| record - times.at_s(k))
    };
    let (late_s, early_s) = (most(&after), most(&before));
    let (off_s, word, end) = match (late_s < OFF_S, early_s < OFF_S) {
        (true, false) => (late_s, "late", "after the end"),
        (false, true) => (early_s, "early", "before the start"),
        _ => return None,
    };
    Some(format!(
        "all {} lie up to {off_s:.3} s {end} of a stretch of the trajectory: the sensor's time stamps look {word} by {off_s:.3} s or more (time_offset_s, latency); dropping them would hide it",
        rows(lost)
    ))
}

/// How many observations are in runs.
fn rows(lost: &[(Range<usize>, Lost)]) -> usize {
    lost.iter().map(|(run, _)| run.len()).sum()
}

/// What becomes of observations without position.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// All have one.
    Keep,
    /// These rows (ascending) are dropped.
    Drop(Vec<Range<usize>>),
    /// This is an error.
    Refuse {
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
}

/// Judges a sensor's times (ascending, offsets added) by the trajectory's.
#[must_use]
pub fn judge<T: Times + ?Sized>(
    trajectory_s: &[f64],
    max_gap_s: f64,
    outside: Outside,
    times: &T,
) -> Verdict {
    let last = times.count().checked_sub(1);
    let sensor = last.map(|last| Span {
        first_s: times.at_s(0),
        last_s: times.at_s(last),
    });
    let (Some(trajectory), Some(sensor)) = (Span::of(trajectory_s), sensor) else {
        return Verdict::Keep;
    };
    let hint = || explain_shift(&trajectory, &sensor).map_or(String::new(), |h| format!(" ({h})"));
    if !trajectory.overlaps(&sensor) {
        return Verdict::Refuse {
            found: format!("times from {sensor}{}", hint()),
            expected: format!("an overlap with the trajectory, {trajectory}"),
        };
    }
    let lost = without_position(trajectory_s, max_gap_s, times);
    match (lost.first(), outside) {
        (None, _) => Verdict::Keep,
        (Some(_), Outside::Drop) if rows(&lost) < times.count() => {
            Verdict::Drop(lost.into_iter().map(|(run, _)| run).collect())
        }
        (Some((run, why)), _) => {
            let place = match why {
                Lost::Outside => format!("outside the trajectory, {trajectory}{}", hint()),
                Lost::Gap { begin_s, end_s } => {
                    format!(
                        "in the gap from {begin_s:.3} s to {end_s:.3} s (max_gap_s is {max_gap_s})"
                    )
                }
            };
            let clock =
                shifted(trajectory_s, times, &lost).map_or(String::new(), |w| format!("; {w}"));
            let others = match rows(&lost) {
                1 => String::new(),
                n => format!(", and {} more without a position", n - 1),
            };
            Verdict::Refuse {
                found: format!(
                    "an observation at {:.6} s {place}{others}{clock}",
                    times.at_s(run.start)
                ),
                expected:
                    "a position for every observation, or outside = \"drop\" under [trajectory]"
                        .to_owned(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two stretches of a trajectory, 0 to 10 s and 20 to 30 s.
    fn stretches() -> Vec<f64> {
        let records = (0..=100).map(|k| 0.1 * f64::from(k));
        let second = records.clone().map(|t| t + 20.0);
        records.chain(second).collect()
    }

    fn refusal(time_s: &[f64]) -> String {
        match judge(&stretches(), 1.0, Outside::Error, time_s) {
            Verdict::Refuse { found, .. } => found,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_clock_that_runs_off_every_stretch_is_named_with_its_size() {
        let late = refusal(&[9.9, 10.05, 10.1, 29.9, 30.1]);
        assert!(late.contains("all 3 lie up to 0.100 s after"), "{late}");
        assert!(late.contains("stamps look late by 0.100 s"), "{late}");
        let early = refusal(&[-0.2, 5.0, 19.9, 25.0]);
        assert!(early.contains("stamps look early by 0.200 s"), "{early}");
        let neither = refusal(&[-0.1, 5.0, 10.1]);
        assert!(!neither.contains("stamps look"), "{neither}");
    }
}
