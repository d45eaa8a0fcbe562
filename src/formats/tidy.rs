//! Laser returns as other programs leave them: a week's end in the middle, tiles in any order, the same return more than once.

use super::records::LaserRecords;
use super::week::{WEEK_S, next_week};

impl LaserRecords {
    /// Counts on past a week's end, sorts by time, keeps returns of the same time and place once; a note says each.
    pub fn tidy(&mut self) {
        self.count_on();
        self.sort();
        self.keep_once();
    }

    fn count_on(&mut self) {
        let Some(before_s) = next_week(&self.time_s) else {
            return;
        };
        for time_s in self.time_s.iter_mut().filter(|t| **t < before_s) {
            *time_s += WEEK_S;
        }
        self.notes.push(format!(
            "the returns' times fall by a week ({WEEK_S} s) at the end of a GPS week; they are counted on from there"
        ));
    }

    fn sort(&mut self) {
        if self.time_s.is_sorted() {
            return;
        }
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by(|&a, &b| self.time_s[a].total_cmp(&self.time_s[b]));
        self.take(&order);
        self.notes
            .push("the returns were not in order of time; they were sorted".to_owned());
    }

    fn keep_once(&mut self) {
        let mut kept = Vec::new();
        let mut begin = 0;
        while begin < self.len() {
            let time_s = self.time_s[begin];
            let same = self.time_s[begin..].iter().take_while(|t| **t == time_s);
            let end = begin + same.count();
            self.distinct(begin..end, &mut kept);
            begin = end;
        }
        let repeated = self.len() - kept.len();
        if repeated > 0 {
            self.notes.push(format!(
                "{repeated} of {} returns are duplicates (same time and place); each was used once",
                self.len()
            ));
            self.take(&kept);
        }
    }

    /// The first of each place among returns of one time, in the order of the file.
    fn distinct(&self, group: std::ops::Range<usize>, kept: &mut Vec<usize>) {
        let place = |k: usize| [&self.x_m, &self.y_m, &self.z_m].map(|c| c[k].to_bits());
        if group.len() == 1 {
            kept.extend(group);
            return;
        }
        let mut order: Vec<usize> = group.collect();
        order.sort_by_key(|&k| (place(k), k));
        order.dedup_by_key(|k| place(*k));
        order.sort_unstable();
        kept.extend(order);
    }

    fn take(&mut self, rows: &[usize]) {
        let columns = [
            &mut self.time_s,
            &mut self.x_m,
            &mut self.y_m,
            &mut self.z_m,
        ];
        for column in columns {
            *column = rows.iter().map(|&k| column[k]).collect();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(rows: &[(f64, f64)]) -> LaserRecords {
        LaserRecords {
            time_s: rows.iter().map(|r| r.0).collect(),
            x_m: rows.iter().map(|r| r.1).collect(),
            y_m: vec![0.0; rows.len()],
            z_m: vec![0.0; rows.len()],
            notes: vec![],
        }
    }

    #[test]
    fn returns_in_any_order_are_sorted_and_repeated_ones_kept_once() {
        let mut found = records(&[(2.0, 1.0), (1.0, 5.0), (2.0, 3.0), (2.0, 1.0), (1.0, 5.0)]);
        found.tidy();
        assert_eq!(found.time_s, [1.0, 2.0, 2.0]);
        assert_eq!(found.x_m, [5.0, 1.0, 3.0]);
        assert_eq!(found.notes.len(), 2, "{:?}", found.notes);
        assert!(found.notes[1].starts_with("2 of 5 returns"));
    }

    #[test]
    fn a_week_s_end_is_unwrapped() {
        let mut found = records(&[(604_799.5, 1.0), (0.5, 2.0), (1.5, 3.0)]);
        found.tidy();
        assert_eq!(found.time_s, [604_799.5, 604_800.5, 604_801.5]);
        assert!(found.notes[0].contains("week"));
    }

    #[test]
    fn times_in_any_order_are_not_taken_for_weeks() {
        let mut found = records(&[(500_000.0, 1.0), (0.5, 2.0), (300_000.0, 3.0)]);
        found.tidy();
        assert_eq!(found.time_s, [0.5, 300_000.0, 500_000.0]);
        let mut tiles = records(&[(604_799.0, 1.0), (0.5, 2.0), (604_798.0, 3.0)]);
        tiles.tidy();
        assert_eq!(tiles.time_s, [604_798.0, 604_799.0, 604_800.5]);
    }

    #[test]
    fn good_returns_stay_as_they_are() {
        let good = records(&[(1.0, 1.0), (1.0, 2.0), (2.0, 1.0)]);
        let mut found = good.clone();
        found.tidy();
        assert_eq!(found, good);
    }
}
