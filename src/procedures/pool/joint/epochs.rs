//! Which records of the trajectory carry states, and the processes that err there (`docs/joint-path.md`).

use super::super::scene::Scene;
use super::super::ties::TieSet;
use crate::adjust::{AdjustError, ChainModel, Process, ProcessKind};

/// Records that observations hang on, numbered as epochs of the chain.
#[derive(Clone, Debug)]
pub struct Epochs {
    /// Epoch of each record; `u32::MAX` where no observation needs it.
    pub(in super::super) of_record: Vec<u32>,
    pub(in super::super) chain: Option<ChainModel>,
}

impl Epochs {
    /// Numbers the records around the tied returns and the candidate soundings; `reach_s` widens for a latency.
    ///
    /// # Errors
    /// [`AdjustError`] when the noise of the trajectory makes no chain.
    pub fn number(
        scene: &Scene,
        returns: &TieSet,
        soundings: impl Iterator<Item = u32>,
        reach_s: f64,
    ) -> Result<Self, AdjustError> {
        let trajectory = &scene.trajectory;
        let mut needed = vec![false; trajectory.len()];
        let times_s = trajectory.times_s();
        let mut mark = |time_s: f64| {
            if let Ok(record) = trajectory.record_before(time_s) {
                needed[record..record + 2].fill(true);
            }
            if reach_s > 0.0 {
                let first = times_s.partition_point(|t| *t <= time_s - reach_s);
                let last = times_s.partition_point(|t| *t <= time_s + reach_s);
                let end = (last + 1).min(times_s.len());
                needed[first.saturating_sub(1)..end].fill(true);
            }
        };
        if scene.laser_uses_trajectory() {
            returns
                .iter()
                .for_each(|t| mark(scene.campaign.laser.time_s[t.row as usize]));
        }
        soundings.for_each(|k| mark(scene.campaign.soundings.at_s(k as usize)));
        let mut of_record = vec![u32::MAX; needed.len()];
        let mut times_s = vec![];
        for (record, _) in needed.iter().enumerate().filter(|(_, n)| **n) {
            of_record[record] = times_s.len() as u32;
            times_s.push(trajectory.times_s()[record]);
        }
        let processes = processes(scene);
        let chain = if processes.is_empty() || times_s.len() < 2 {
            None
        } else {
            Some(ChainModel::new(times_s, processes)?)
        };
        Ok(Self { of_record, chain })
    }
}

/// The stochastic processes of a trajectory's errors: white per record, and drift ([`crate::adjust::ChainModel`]).
fn processes(scene: &Scene) -> Vec<Process> {
    let noise = &scene.campaign.trajectory.noise;
    let white = |component, sigma| Process {
        component,
        sigma,
        kind: ProcessKind::White,
    };
    let tau_s = noise.drift_correlation_time_s;
    let slow = |component, sigma| Process {
        component,
        sigma,
        kind: ProcessKind::GaussMarkov { tau_s },
    };
    let mut all: Vec<Process> = (0..3).map(|i| white(i, noise.position_m)).collect();
    all.extend([
        white(3, noise.roll_pitch_rad),
        white(4, noise.roll_pitch_rad),
        white(5, noise.heading_rad),
    ]);
    all.extend((0..3).map(|i| slow(i, noise.position_drift_m)));
    all.push(slow(5, noise.heading_drift_rad));
    all.retain(|p| p.sigma > 0.0);
    all
}
