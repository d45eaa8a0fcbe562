//! Poses of the body at the moments of the observations, kept while there are few: every pass over the data asks for them again.

use std::cell::RefCell;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::observe::{Campaign, PoseSample, Trajectory};

/// Up to so many returns, and so many moments of soundings, poses are kept (some 120 bytes each); of more each is interpolated anew,
/// since memory must not grow with what can be computed.
const KEPT: usize = 300_000;
/// Of up to so many soundings it is kept whose moment is whose (four bytes each).
const LISTED: usize = 1_000_000;
/// Rows per parallel task.
const CHUNK: usize = 16_384;

/// Poses by row.
#[derive(Debug, Default)]
pub(super) struct Poses {
    /// Of the laser returns; empty where they are not kept.
    returns: Vec<Option<PoseSample>>,
    /// At the distinct moments of the soundings.
    moments: Vec<Option<PoseSample>>,
    /// Moment of each sounding; empty where they are not kept.
    moment_of: Vec<u32>,
    /// Tells the poses of this trajectory from those of others; zero while it may still change.
    number: u64,
}

/// A pose that a thread has interpolated: of which trajectory, at which moment (its bits).
type Again = ((u64, u64), Option<PoseSample>);

thread_local! {
    /// The last two: consecutive beams are of one ping, looked at with a latency and without.
    static LAST: RefCell<[Again; 2]> = const { RefCell::new([((0, 0), None); 2]) };
}

impl Poses {
    /// Interpolates what is to be kept. Returns that came already georeferenced need none.
    pub(super) fn kept(
        campaign: &Campaign,
        trajectory: &Trajectory,
        laser_uses_trajectory: bool,
    ) -> Self {
        static TRAJECTORIES: AtomicU64 = AtomicU64::new(1);
        let mut kept = Self {
            number: TRAJECTORIES.fetch_add(1, Ordering::Relaxed),
            ..Self::default()
        };
        let times_s = &campaign.laser.time_s;
        if laser_uses_trajectory && times_s.len() <= KEPT {
            kept.returns = interpolated(trajectory, times_s);
        }
        // of soundings in a file the column is empty
        let times_s = &campaign.soundings.time_s;
        let few = (1..=LISTED).contains(&times_s.len());
        if let Some((distinct_s, moment_of)) = few.then(|| distinct(times_s, KEPT)).flatten() {
            kept.moments = interpolated(trajectory, &distinct_s);
            kept.moment_of = moment_of;
        }
        kept
    }

    /// Of return `j`; the outer `None` where it is not kept, the inner one outside the trajectory.
    #[inline]
    pub(super) fn of_return(&self, j: usize) -> Option<Option<PoseSample>> {
        self.returns.get(j).copied()
    }

    /// At a moment at which the next sounding probably was too; the pose is that of [`Trajectory::pose_at`].
    #[inline]
    pub(super) fn again(&self, trajectory: &Trajectory, moment_s: f64) -> Option<PoseSample> {
        if self.number == 0 {
            return trajectory.pose_at(moment_s).ok();
        }
        let of = (self.number, moment_s.to_bits());
        LAST.with_borrow_mut(|last| {
            if last[0].0 != of {
                last.swap(0, 1);
                if last[0].0 != of {
                    last[0] = (of, trajectory.pose_at(moment_s).ok());
                }
            }
            last[0].1
        })
    }

    /// Of sounding `k`; as [`Self::of_return`].
    #[inline]
    pub(super) fn of_sounding(&self, k: usize) -> Option<Option<PoseSample>> {
        let moment = *self.moment_of.get(k)?;
        self.moments.get(moment as usize).copied()
    }
}

fn interpolated(trajectory: &Trajectory, times_s: &[f64]) -> Vec<Option<PoseSample>> {
    let of = |time_s: &f64| trajectory.pose_at(*time_s).ok();
    times_s.par_iter().with_min_len(CHUNK).map(of).collect()
}

/// Runs of equal times, and the run of each; nothing where there are more than `most`.
fn distinct(times_s: &[f64], most: usize) -> Option<(Vec<f64>, Vec<u32>)> {
    let runs = times_s.windows(2).filter(|pair| pair[0] != pair[1]).count();
    if runs >= most {
        return None;
    }
    let mut runs: Vec<f64> = Vec::with_capacity(runs + 1);
    let of = times_s
        .iter()
        .map(|time_s| {
            if runs.last() != Some(time_s) {
                runs.push(*time_s);
            }
            runs.len() as u32 - 1
        })
        .collect();
    Some((runs, of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soundings_of_one_moment_share_a_pose() {
        let times_s = [1.0, 1.0, 2.0, 1.0];
        let (runs, of) = distinct(&times_s, 3).expect("three runs");
        assert_eq!((runs, of), (vec![1.0, 2.0, 1.0], vec![0, 0, 1, 2]));
        assert_eq!(distinct(&times_s, 2), None);
    }
}
