//! Seconds of the GPS week fall to zero at midnight between Saturday and Sunday; they are counted on from there.

/// Seconds of a GPS week.
pub const WEEK_S: f64 = 604_800.0;
/// A fall of more than this is a week's end, not another order of rows.
const FALL_S: f64 = 0.5 * WEEK_S;

/// A week ends within so much after the last time before it and before the first behind it; a fall elsewhere is a stray time.
const NIGHT_S: f64 = 43_200.0;

/// The time that follows `before`: as it is, or counted on where the seconds of the week fell to zero in between.
///
/// Only seconds of one week are taken for such (`before` below two weeks, `time_s` within one): a fall of any other clock stays a fall.
#[must_use]
pub fn following(before: Option<f64>, time_s: f64) -> f64 {
    match before {
        Some(b) if b < 2.0 * WEEK_S && (0.0..WEEK_S).contains(&time_s) && b - time_s > FALL_S => {
            let counted_on = b >= WEEK_S;
            let at_the_end = b > WEEK_S - NIGHT_S && time_s < NIGHT_S;
            match counted_on || at_the_end {
                true => time_s + ((b - time_s) / WEEK_S).round() * WEEK_S,
                false => time_s,
            }
        }
        _ => time_s,
    }
}

/// For times in any order that begin before the end of a week and go on after it: the time below which they belong to the next week.
///
/// `None` unless all are seconds of the week, with more than half a week between the two parts.
#[must_use]
pub fn next_week(time_s: &[f64]) -> Option<f64> {
    let first = *time_s.first()?;
    let (mut latest_of_next, mut earliest) = (f64::NEG_INFINITY, first);
    for &t in time_s {
        if !(0.0..=WEEK_S).contains(&t) {
            return None;
        }
        if t < first - FALL_S {
            latest_of_next = latest_of_next.max(t);
        } else {
            earliest = earliest.min(t);
        }
    }
    (latest_of_next >= 0.0 && earliest - latest_of_next > FALL_S).then_some(earliest)
}

/// The sentence for a report when ascending times go past the end of the week; `what` they are the times of.
#[must_use]
pub fn passed(what: &str, time_s: &[f64]) -> Option<String> {
    let (first, last) = (time_s.first()?, time_s.last()?);
    ((0.0..WEEK_S).contains(first) && (WEEK_S..2.0 * WEEK_S).contains(last)).then(|| {
        format!("the times of the {what} pass the end of a GPS week ({WEEK_S} s) and are counted on from there")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stray_time_is_no_week_s_end() {
        assert_eq!(following(Some(400_000.0), 1006.0), 1006.0);
        assert_eq!(following(Some(604_799.0), 50_000.0), 50_000.0);
    }

    #[test]
    fn seconds_of_the_week_are_counted_on() {
        assert_eq!(following(Some(604_799.5), 0.5), 604_800.5);
        assert_eq!(following(Some(604_800.5), 1.5), 604_801.5);
        assert_eq!(
            following(Some(604_800.5), 0.0),
            604_800.0,
            "a fall of half a second stays one"
        );
        assert_eq!(following(None, 3.0), 3.0);
    }

    #[test]
    fn other_clocks_and_other_orders_stay_as_they_are() {
        assert_eq!(following(Some(1.7e9), 3.0), 3.0);
        assert_eq!(following(Some(604_799.5), -1.0), -1.0);
        assert_eq!(following(Some(100.0), 99.0), 99.0);
    }

    #[test]
    fn the_note_stands_where_a_week_ends() {
        assert!(passed("soundings", &[604_799.0, 604_801.0]).is_some());
        assert_eq!(passed("soundings", &[10.0, 20.0]), None);
        assert_eq!(passed("soundings", &[1.3e9, 1.3e9]), None);
        assert_eq!(passed("soundings", &[]), None);
    }
}
