//! Times that recorders write, as seconds since 1970-01-01 00:00 UTC without leap seconds (Unix time).
//!
//! The calendar is the proleptic Gregorian one. GPS time runs ahead of UTC by whole leap seconds ([`leap_seconds`]).

/// Seconds of a day.
pub const DAY_S: f64 = 86_400.0;
/// Seconds of a week.
pub const WEEK_S: f64 = 7.0 * DAY_S;
/// Unix time at which GPS week 0 began, 1980-01-06.
pub const GPS_EPOCH_S: f64 = 315_964_800.0;

/// Days since 1970-01-01 of a date; `None` where there is no such date or it is outside the years 1970 to 2199.
#[must_use]
pub fn days(year: u32, month: u32, day: u32) -> Option<i64> {
    let lengths = [
        31,
        28 + u32::from(leap(year)),
        31,
        30,
        31,
        30,
        31,
        31,
        30,
        31,
        30,
        31,
    ];
    let length = *lengths.get(month.checked_sub(1)? as usize)?;
    if !(1970..2200).contains(&year) || day == 0 || day > length {
        return None;
    }
    let before: u32 = lengths[..month as usize - 1].iter().sum();
    Some(days_before(year) + i64::from(before + day - 1))
}

fn leap(year: u32) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

/// Days from 1970-01-01 to the first day of a year.
fn days_before(year: u32) -> i64 {
    let past = i64::from(year) - 1;
    365 * (i64::from(year) - 1970) + (past / 4 - past / 100 + past / 400) - 477
}

/// Unix time of a day of a year (1 is the first of January) and a time of that day, seconds.
#[must_use]
pub fn from_day_of_year(year: u32, day: u32, seconds: f64) -> Option<f64> {
    if day == 0 || day > 365 + u32::from(leap(year)) {
        return None;
    }
    Some((days(year, 1, 1)? + i64::from(day) - 1) as f64 * DAY_S + seconds)
}

/// Unix time of an ISO 8601 date and time of day such as `2026-06-12T08:30:15.25Z`: the parts of the date may stand apart by slashes, a
/// space may stand for the T, and instead of the Z a shift such as `+02:00`, or nothing, which means UTC. `None` where it is none.
#[must_use]
pub fn from_iso(text: &str) -> Option<f64> {
    let digits = |part: &str| -> Option<u32> {
        let all = !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        if all { part.parse().ok() } else { None }
    };
    let (date, rest) = (text.get(..10)?, text.get(11..)?);
    if !matches!(text.as_bytes()[10], b'T' | b't' | b' ') {
        return None;
    }
    let apart = if date.as_bytes()[4] == b'/' { '/' } else { '-' };
    let date: Vec<u32> = date.split(apart).map(digits).collect::<Option<_>>()?;
    let [year, month, day] = date.try_into().ok()?;
    let (clock, shift_s) = match rest.strip_suffix(['Z', 'z']) {
        Some(clock) => (clock, 0.0),
        None => match rest.rfind(['+', '-']) {
            Some(at) => (&rest[..at], shift(&rest[at..])?),
            None => (rest, 0.0),
        },
    };
    let mut clock = clock.split(':');
    let (hour, minute) = (digits(clock.next()?)?, digits(clock.next()?)?);
    let second = clock.next().unwrap_or("0");
    let number = second.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    if clock.next().is_some() || !number || second.starts_with('.') {
        return None;
    }
    let second: f64 = second.parse().ok()?;
    let midnight = hour == 24 && minute == 0 && second == 0.0;
    if (hour > 23 && !midnight) || minute > 59 || second >= 60.0 {
        return None;
    }
    let of_day_s = f64::from(3600 * hour + 60 * minute) - shift_s;
    // whole seconds are added up first: the fraction is rounded once
    Some(days(year, month, day)? as f64 * DAY_S + of_day_s + second)
}

/// Whether a text that [`from_iso`] does not take names a second 60 ("23:59:60"): a leap second, which Unix time does not count.
#[must_use]
pub fn in_leap_second(text: &str) -> bool {
    let second = text.splitn(3, ':').nth(2);
    second.is_some_and(|second| {
        let (whole, rest) = second.split_at_checked(2).unwrap_or((second, ""));
        whole == "60" && !rest.starts_with(|c: char| c.is_ascii_digit())
    })
}

/// The seconds of a shift such as `+02:00`, `+0200` or `-03`.
fn shift(text: &str) -> Option<f64> {
    let (sign, rest) = text.split_at_checked(1)?;
    let (hour, minute) = match (rest.split_once(':'), rest.len()) {
        (Some(parts), _) => parts,
        (None, 4) => rest.split_at_checked(2)?,
        (None, _) => (rest, "0"),
    };
    let (hour, minute): (u32, u32) = (hour.parse().ok()?, minute.parse().ok()?);
    let seconds = f64::from(3600 * hour + 60 * minute);
    let whole = hour <= 14 && minute < 60;
    whole.then_some(if sign == "-" { -seconds } else { seconds })
}

/// Unix time of a date written as the number yyyymmdd and a time of that day, seconds.
#[must_use]
pub fn from_digits(date: u32, seconds: f64) -> Option<f64> {
    let day = days(date / 10_000, date / 100 % 100, date % 100)?;
    Some(day as f64 * DAY_S + seconds)
}

/// Unix time on the GPS scale of a week and its seconds: leap seconds are *not* taken off.
#[must_use]
pub fn from_gps_week(week: u32, seconds: f64) -> f64 {
    GPS_EPOCH_S + f64::from(week) * WEEK_S + seconds
}

/// GPS minus UTC, seconds, at a Unix time from 1999 on; nothing was announced after 2017 when this was written.
#[must_use]
pub fn leap_seconds(unix_s: f64) -> f64 {
    let steps = [
        (1_136_073_600.0, 14.0),
        (1_230_768_000.0, 15.0),
        (1_341_100_800.0, 16.0),
        (1_435_708_800.0, 17.0),
        (1_483_228_800.0, 18.0),
    ];
    steps
        .iter()
        .rev()
        .find(|(begin, _)| unix_s >= *begin)
        .map_or(13.0, |(_, leap)| *leap)
}

/// A Unix time as `2014-02-13 05:27:36.123`; only the number where there is no such date.
#[must_use]
pub fn written(unix_s: f64) -> String {
    let milliseconds = (unix_s * 1e3).round();
    if !(0.0..7.2e12).contains(&milliseconds) {
        return format!("{unix_s:.3} s");
    }
    let ms = milliseconds as u64;
    let (day, of_day) = ((ms / 86_400_000) as i64, ms % 86_400_000);
    let (year, month, day) = date(day);
    let (hour, minute, second) = (of_day / 3_600_000, of_day / 60_000 % 60, of_day / 1000 % 60);
    format!(
        "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{:03}",
        of_day % 1000
    )
}

/// Year, month, day of a number of days since 1970-01-01.
#[must_use]
pub fn date(since: i64) -> (u32, u32, u32) {
    let mut year = 1970 + (since / 366) as u32;
    while days_before(year + 1) <= since {
        year += 1;
    }
    let mut month = 1;
    while month < 12 && days(year, month + 1, 1).is_some_and(|first| first <= since) {
        month += 1;
    }
    let first = days(year, month, 1).unwrap_or(since);
    (year, month, (since - first) as u32 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_dates() {
        assert_eq!(days(1970, 1, 1), Some(0));
        assert_eq!(days(2000, 3, 1), Some(11_017));
        assert_eq!(days(2014, 2, 13), Some(16_114));
        assert_eq!(days(2014, 2, 29), None);
        assert_eq!(days(2014, 0, 1), None);
        assert_eq!(
            from_day_of_year(2014, 44, 1.0),
            from_digits(20_140_213, 1.0)
        );
        assert_eq!(from_day_of_year(2013, 366, 0.0), None);
        assert_eq!(Some(from_gps_week(0, 0.0)), from_digits(19_800_106, 0.0));
    }

    #[test]
    fn every_day_returns() {
        for since in 0..80_000 {
            let (year, month, day) = date(since);
            assert_eq!(days(year, month, day), Some(since));
        }
    }

    #[test]
    fn leap_seconds_step_at_their_day() {
        let before = from_digits(20_161_231, 86_399.0).expect("a date");
        assert_eq!(
            (leap_seconds(before), leap_seconds(before + 1.0)),
            (17.0, 18.0)
        );
    }

    #[test]
    fn dates_of_iso_8601_are_unix_times() {
        // date -u -d "2026-06-12 08:30:15.25" +%s.%N
        let whole = 1_781_253_015.25;
        for text in [
            "2026-06-12T08:30:15.25Z",
            "2026-06-12 08:30:15.25",
            "2026/06/12 08:30:15.250z",
            "2026-06-12T10:30:15.25+02:00",
            "2026-06-12T05:00:15.25-0330",
            "2026-06-11T23:30:15.25-09",
        ] {
            assert_eq!(from_iso(text), Some(whole), "{text}");
        }
        assert_eq!(from_iso("2026-06-12T08:30"), Some(1_781_253_000.0));
        for text in ["2016-12-31T23:59:60Z", "2016-12-31 23:59:60.5"] {
            assert_eq!((from_iso(text), in_leap_second(text)), (None, true));
        }
        assert!(!in_leap_second("2016-12-31T23:59:600"));
        for text in [
            "2026-06-12",
            "2026-13-12T08:30:15",
            "2026-02-29T08:30:15",
            "2026-06-12T08:61:15",
            "2026-06-12T08:30:75",
            "2026-06-12T08:30:15+99:00",
            "2026-06-12T08:30:15:00",
            "2026-06-12T24:30:00Z",
            "2026-06-12T08:30:.5",
            "2026-06-12TT8:30:15",
            "2026-06-12T08:30:1e1",
            "",
            "2026-06-1\u{e9}T08:30:15",
        ] {
            assert_eq!(from_iso(text), None, "{text}");
        }
    }

    #[test]
    fn a_time_is_written_with_milliseconds() {
        assert_eq!(written(1_392_269_256.123_6), "2014-02-13 05:27:36.124");
        assert_eq!(written(-1.0), "-1.000 s");
    }
}
