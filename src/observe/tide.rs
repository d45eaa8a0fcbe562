//! A tide over time, as a gauge or a table gives it.

use crate::math;

/// Heights of the water over time, linear between its rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TideCurve {
    /// Time of each row, seconds, strictly ascending.
    pub time_s: Vec<f64>,
    /// Height of the water over the datum of the curve, metres.
    pub height_m: Vec<f64>,
}

impl TideCurve {
    /// Height at a time, metres: linear between two rows, held at the ends; 0 of an empty curve.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        let after = self.time_s.partition_point(|t| *t <= time_s);
        let (Some(last), Some(before)) = (self.height_m.last(), after.checked_sub(1)) else {
            return self.height_m.first().copied().unwrap_or(0.0);
        };
        if after == self.time_s.len() {
            return *last;
        }
        let part = (time_s - self.time_s[before]) / (self.time_s[after] - self.time_s[before]);
        self.height_m[before] + part * (self.height_m[after] - self.height_m[before])
    }

    /// Whether a span of time lies within it.
    #[must_use]
    pub fn covers(&self, [from_s, to_s]: [f64; 2]) -> bool {
        let ends = self.time_s.first().zip(self.time_s.last());
        ends.is_some_and(|(first_s, last_s)| *first_s <= from_s && to_s <= *last_s)
    }

    /// The rows that a span of time is interpolated from, as places of the first and the last one.
    fn rows(&self, [from_s, to_s]: [f64; 2]) -> [usize; 2] {
        let last = self.time_s.len().saturating_sub(1);
        let begin = self.time_s.partition_point(|t| *t <= from_s);
        let end = self.time_s.partition_point(|t| *t < to_s);
        [begin.saturating_sub(1), end.min(last)]
    }

    /// The widest step between two rows that a span of time is interpolated from: the place of its second row, and seconds.
    #[must_use]
    pub fn widest_step(&self, span_s: [f64; 2]) -> Option<(usize, f64)> {
        let [first, last] = self.rows(span_s);
        let step = |k: usize| (k, self.time_s[k] - self.time_s[k - 1]);
        let steps = (first + 1..=last).map(step);
        steps.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// How far a straight line between two rows may lie off the tide within a span of time, metres: an eighth of the step's square times
    /// the curvature of the rows about it. Nothing of fewer than three rows.
    #[must_use]
    pub fn straightness_m(&self, span_s: [f64; 2]) -> Option<f64> {
        let [first, last] = self.rows(span_s);
        let inner = 1..self.time_s.len().saturating_sub(1);
        let curved = |k: usize| {
            let slope = |a: usize, b: usize| {
                (self.height_m[b] - self.height_m[a]) / (self.time_s[b] - self.time_s[a])
            };
            let (before_s, after_s) = (
                self.time_s[k] - self.time_s[k - 1],
                self.time_s[k + 1] - self.time_s[k],
            );
            let bend = (slope(k, k + 1) - slope(k - 1, k)) / (0.5 * (before_s + after_s));
            bend.abs() * before_s.max(after_s).powi(2) / 8.0
        };
        let about = first.max(1)..(last + 1).min(inner.end);
        about.map(curved).max_by(f64::total_cmp)
    }

    /// Fastest rise or fall between two rows: the place of the second one, and metres per second.
    #[must_use]
    pub fn steepest(&self) -> Option<(usize, f64)> {
        let rate = |k: usize| {
            let rise = self.height_m[k] - self.height_m[k - 1];
            (k, (rise / (self.time_s[k] - self.time_s[k - 1])).abs())
        };
        let rates = (1..self.time_s.len()).map(rate);
        rates.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// A tide of one period: `range_m` from low to high water, high at `high_s`, one row every `step_s` from `from_s` to beyond `to_s`.
    #[must_use]
    pub fn of_one_period(
        (range_m, period_s, high_s): (f64, f64, f64),
        step_s: f64,
        [from_s, to_s]: [f64; 2],
    ) -> Self {
        let rows = ((to_s - from_s) / step_s).ceil().max(1.0) as usize;
        let time_s: Vec<f64> = (0..=rows).map(|k| from_s + step_s * k as f64).collect();
        let height = |t: &f64| one_period_m((range_m, period_s, high_s), *t);
        Self {
            height_m: time_s.iter().map(height).collect(),
            time_s,
        }
    }
}

/// Height of a tide of one period at a time, metres.
#[must_use]
pub fn one_period_m((range_m, period_s, high_s): (f64, f64, f64), time_s: f64) -> f64 {
    0.5 * range_m * math::cos(std::f64::consts::TAU * (time_s - high_s) / period_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> TideCurve {
        TideCurve {
            time_s: vec![100.0, 200.0, 400.0],
            height_m: vec![1.0, 2.0, 0.0],
        }
    }

    #[test]
    fn it_is_linear_between_rows_and_held_at_the_ends() {
        let due = [
            (0.0, 1.0),
            (100.0, 1.0),
            (125.0, 1.25),
            (200.0, 2.0),
            (350.0, 0.5),
            (400.0, 0.0),
            (900.0, 0.0),
        ];
        for (time_s, height_m) in due {
            assert_eq!(curve().at(time_s), height_m, "{time_s}");
        }
        assert_eq!(TideCurve::default().at(5.0), 0.0);
    }

    #[test]
    fn what_it_covers_and_how_wide_its_steps_are() {
        let curve = curve();
        assert!(curve.covers([100.0, 400.0]));
        assert!(!curve.covers([99.0, 300.0]) && !curve.covers([300.0, 401.0]));
        assert_eq!(curve.widest_step([110.0, 190.0]), Some((1, 100.0)));
        assert_eq!(curve.widest_step([110.0, 210.0]), Some((2, 200.0)));
        assert_eq!(curve.steepest().map(|(_, rate)| rate), Some(0.01));
    }

    /// An hour of a tide of 12.42 h is curved by `a (1 - cos(w 1800))` at the most: 0.032 a.
    #[test]
    fn straight_lines_between_rows_are_off_by_what_is_said() {
        let tide = (4.0, 44_714.0, 30_000.0);
        let curve = TideCurve::of_one_period(tide, 3600.0, [0.0, 80_000.0]);
        let off = |t: f64| (curve.at(t) - one_period_m(tide, t)).abs();
        let worst = (0..8000)
            .map(|k| off(10.0 * f64::from(k)))
            .fold(0.0, f64::max);
        let said = curve.straightness_m([0.0, 80_000.0]).expect("rows");
        assert!((worst - 0.0637).abs() < 0.002, "{worst}");
        assert!(said > 0.95 * worst && said < 1.1 * worst, "{said} {worst}");
    }
}
