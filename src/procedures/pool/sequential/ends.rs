//! How the angle iteration ends: converged, in a cycle or without progress, out of passes.

use nalgebra::Vector3;

use super::super::config::SequentialConfig;
use super::{End, UPDATE_TOLERANCE_RAD};
use crate::observe::Mounting;

/// Longest cycle that is looked for.
const LONGEST_CYCLE: usize = 6;
/// A pass comes back to an earlier one when it is closer to it than this share of its last step.
const SAME: f64 = 0.02;
/// Passes without a smaller largest angle that count as no progress.
const PATIENCE: usize = 12;

/// The states of one angle iteration.
#[derive(Default)]
pub(super) struct History {
    states: Vec<State>,
}

struct State {
    mounting: Mounting,
    largest_rad: f64,
    pass: u32,
}

impl History {
    /// Adds a mounting with the angles found under it.
    pub(super) fn push(&mut self, mounting: Mounting, angle_rad: [f64; 4], pass: u32) {
        self.states.push(State {
            mounting,
            largest_rad: angle_rad.into_iter().fold(0.0, f64::max),
            pass,
        });
    }

    /// Whether the iteration ends here, given the next update (target frame, radians).
    pub(super) fn end(&self, update_rad: &Vector3<f64>, config: &SequentialConfig) -> Option<End> {
        let last = self.states.last()?;
        let best = self.best()?;
        let (kept_pass, largest_rad) = (best.pass, best.largest_rad);
        if last.largest_rad < config.threshold_deg.to_radians()
            || update_rad.amax() < UPDATE_TOLERANCE_RAD
        {
            return Some(End::Converged {
                largest_rad: last.largest_rad,
            });
        }
        if let Some(period) = self.cycle() {
            return Some(End::Cycle {
                period,
                kept_pass,
                largest_rad,
            });
        }
        if last.pass - kept_pass >= PATIENCE as u32 {
            return Some(End::NoProgress {
                kept_pass,
                largest_rad,
            });
        }
        (self.states.len() > config.max_passes as usize).then_some(End::OutOfPasses {
            kept_pass,
            largest_rad,
        })
    }

    /// The mounting to go on with: the last one when converged, else the best.
    pub(super) fn kept(&self, end: &End) -> Option<Mounting> {
        let state = match end {
            End::Converged { .. } => self.states.last(),
            _ => self.best(),
        };
        state.map(|s| s.mounting)
    }

    /// The state with the smallest largest angle, the first of equals.
    fn best(&self) -> Option<&State> {
        self.states.iter().reduce(|best, s| {
            if s.largest_rad < best.largest_rad {
                s
            } else {
                best
            }
        })
    }

    /// Period of the cycle that the last two passes repeat, if they do.
    fn cycle(&self) -> Option<usize> {
        let last = self.states.len().checked_sub(1)?;
        let apart = |i: usize, j: usize| {
            let (a, b) = (&self.states[i].mounting, &self.states[j].mounting);
            a.correction_from(b).norm()
        };
        (2..=LONGEST_CYCLE).filter(|p| last > *p).find(|p| {
            let near = SAME * apart(last, last - 1);
            apart(last, last - p) < near && apart(last - 1, last - 1 - p) < near
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walked(yaws: &[f64], largest: impl Fn(usize) -> f64) -> History {
        let mut history = History::default();
        for (k, yaw) in yaws.iter().enumerate() {
            let mounting = Mounting::from_angles(0.0, 0.0, *yaw, Vector3::zeros());
            history.push(mounting, [largest(k); 4], k as u32);
        }
        history
    }

    fn end(history: &History) -> Option<End> {
        history.end(&Vector3::repeat(0.01), &SequentialConfig::default())
    }

    #[test]
    fn cycles_of_two_and_three_are_seen_and_the_best_pass_kept() {
        let two = walked(
            &[0.0, 0.2, 0.1, 0.2, 0.1],
            |k| if k == 2 { 0.02 } else { 0.03 },
        );
        assert_eq!(
            end(&two),
            Some(End::Cycle {
                period: 2,
                kept_pass: 2,
                largest_rad: 0.02
            })
        );
        assert!((two.kept(&end(&two).expect("end")).expect("kept").angles().2 - 0.1).abs() < 1e-12);
        let three = walked(&[0.0, 0.2, 0.1, 0.15, 0.2, 0.1], |_| 0.03);
        assert_eq!(
            end(&three),
            Some(End::Cycle {
                period: 3,
                kept_pass: 0,
                largest_rad: 0.03
            })
        );
    }

    #[test]
    fn an_approach_is_no_cycle() {
        let halving: Vec<f64> = (0..9).map(|k| 0.1 * (-0.5_f64).powi(k)).collect();
        assert_eq!(end(&walked(&halving, |k| 0.1 / (k + 1) as f64)), None);
    }

    #[test]
    fn patience_and_passes_run_out() {
        let wander: Vec<f64> = (0..14).map(|k| f64::from(k * k) * 0.01).collect();
        let lost = walked(&wander, |k| if k == 1 { 0.02 } else { 0.03 });
        assert_eq!(
            end(&lost),
            Some(End::NoProgress {
                kept_pass: 1,
                largest_rad: 0.02
            })
        );
        let long: Vec<f64> = (0..31).map(|k| f64::from(k * k) * 0.01).collect();
        let falling = walked(&long, |k| 1.0 - 0.01 * k as f64);
        assert!(matches!(
            end(&falling),
            Some(End::OutOfPasses { kept_pass: 30, .. })
        ));
        assert_eq!(end(&walked(&long[..30], |k| 1.0 - 0.01 * k as f64)), None);
    }

    #[test]
    fn small_angles_or_small_updates_converge() {
        let small = walked(&[0.0, 0.1], |_| 0.0008);
        assert_eq!(
            end(&small),
            Some(End::Converged {
                largest_rad: 0.0008
            })
        );
        let stuck = walked(&[0.0, 0.1], |_| 0.01);
        let config = SequentialConfig::default();
        assert_eq!(
            stuck.end(&Vector3::repeat(1e-6), &config),
            Some(End::Converged { largest_rad: 0.01 })
        );
    }
}
