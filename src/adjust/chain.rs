//! Chain of states: what a trajectory errs by at each epoch, as a sum of stochastic processes with proper priors.
//!
//! A *visible* quantity (component of position or attitude error) is the sum of its processes: white noise, independent from
//! epoch to epoch, and Gauss-Markov drift, `s_(k+1) = phi s_k + q`, `phi = exp(-dt / tau)`, `var q = sigma^2 (1 - phi^2)`,
//! started stationary (Gelb, *Applied Optimal Estimation*, 1974, sec. 2.2). The processes' residuals count as observations.

use std::ops::Range;

use super::error::AdjustError;
use crate::math;

/// Number of visible quantities of an epoch: three of position, three of attitude, by convention of the caller.
pub const VISIBLE: usize = 6;

/// How a process correlates in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProcessKind {
    /// Independent at each epoch.
    White,
    /// First-order Gauss-Markov.
    GaussMarkov {
        /// Correlation time (s).
        tau_s: f64,
    },
}

/// One stochastic process, adding to one visible quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Process {
    /// The visible quantity it adds to, below [`VISIBLE`].
    pub component: usize,
    /// Stationary standard deviation, in the unit of the visible quantity.
    pub sigma: f64,
    /// Correlation.
    pub kind: ProcessKind,
}

/// Epochs and processes of a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainModel {
    times_s: Vec<f64>,
    processes: Vec<Process>,
}

impl ChainModel {
    /// A chain over strictly increasing times.
    ///
    /// # Errors
    /// [`AdjustError::BadChain`] on fewer than two epochs, unsorted or non-finite times, no process, a component outside the
    /// visible ones, and standard deviations or correlation times that are not positive.
    pub fn new(times_s: Vec<f64>, processes: Vec<Process>) -> Result<Self, AdjustError> {
        check_times(&times_s)?;
        check_processes(&processes)?;
        Ok(ChainModel { times_s, processes })
    }

    /// Times of the epochs (s).
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Processes in the order of the state vector.
    pub fn processes(&self) -> &[Process] {
        &self.processes
    }

    /// Number of epochs.
    pub fn epochs(&self) -> usize {
        self.times_s.len()
    }

    /// Number of intervals between epochs.
    pub fn intervals(&self) -> usize {
        self.times_s.len() - 1
    }

    /// Size of an epoch's state vector.
    pub fn state_size(&self) -> usize {
        self.processes.len()
    }

    /// `phi` of a process over the interval that starts at `epoch`; zero for white noise.
    pub(super) fn transition(&self, process: &Process, epoch: usize) -> f64 {
        match process.kind {
            ProcessKind::White => 0.0,
            ProcessKind::GaussMarkov { tau_s } => {
                math::exp(-(self.times_s[epoch + 1] - self.times_s[epoch]) / tau_s)
            }
        }
    }

    /// Variance of the innovation over that interval.
    pub(super) fn innovation(&self, process: &Process, epoch: usize) -> f64 {
        match process.kind {
            ProcessKind::White => process.sigma * process.sigma,
            ProcessKind::GaussMarkov { tau_s } => {
                let dt = self.times_s[epoch + 1] - self.times_s[epoch];
                -process.sigma * process.sigma * math::exp_m1(-2.0 * dt / tau_s)
            }
        }
    }
}

fn check_times(times_s: &[f64]) -> Result<(), AdjustError> {
    if times_s.len() < 2 {
        return Err(AdjustError::BadChain {
            what: "number of epochs",
            place: 0,
            found: times_s.len() as f64,
        });
    }
    let bad =
        (1..times_s.len()).find(|&k| !(times_s[k] > times_s[k - 1] && times_s[k].is_finite()));
    match bad {
        Some(place) => Err(AdjustError::BadChain {
            what: "time of epoch",
            place,
            found: times_s[place],
        }),
        None => Ok(()),
    }
}

fn check_processes(processes: &[Process]) -> Result<(), AdjustError> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if processes.is_empty() {
        return Err(AdjustError::BadChain {
            what: "number of processes",
            place: 0,
            found: 0.0,
        });
    }
    for (place, process) in processes.iter().enumerate() {
        if process.component >= VISIBLE {
            return Err(AdjustError::BadChain {
                what: "component of process",
                place,
                found: process.component as f64,
            });
        }
        if !positive(process.sigma) {
            return Err(AdjustError::BadChain {
                what: "sigma of process",
                place,
                found: process.sigma,
            });
        }
        if let ProcessKind::GaussMarkov { tau_s } = process.kind
            && !positive(tau_s)
        {
            return Err(AdjustError::BadChain {
                what: "correlation time of process",
                place,
                found: tau_s,
            });
        }
    }
    Ok(())
}

/// Current states of a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainState {
    /// The first epoch that is here; before it there is nothing.
    first: usize,
    size: usize,
    states: Vec<f64>,
    visible: Vec<[f64; VISIBLE]>,
}

impl ChainState {
    /// All states zero.
    pub fn zero(model: &ChainModel) -> Self {
        let (size, epochs) = (model.state_size(), model.epochs());
        ChainState {
            first: 0,
            size,
            states: vec![0.0; size * epochs],
            visible: vec![[0.0; VISIBLE]; epochs],
        }
    }

    /// The states of a stretch of epochs that begins at `first`, as [`Self::stretch`] gives them.
    pub(super) fn of_stretch(model: &ChainModel, first: usize, states: Vec<f64>) -> Self {
        let size = model.state_size();
        let mut made = ChainState {
            first,
            size,
            visible: vec![[0.0; VISIBLE]; states.len() / size],
            states,
        };
        made.see(model);
        made
    }

    /// The states of some epochs, epoch after epoch.
    pub(super) fn stretch(&self, epochs: Range<usize>) -> &[f64] {
        &self.states[(epochs.start - self.first) * self.size..(epochs.end - self.first) * self.size]
    }

    /// State vector of an epoch, in the order of the processes.
    pub fn state(&self, epoch: usize) -> &[f64] {
        self.stretch(epoch..epoch + 1)
    }

    /// Visible quantities of an epoch.
    pub fn visible(&self, epoch: usize) -> &[f64; VISIBLE] {
        &self.visible[epoch - self.first]
    }

    /// Visible quantities between two epochs.
    #[inline]
    pub fn between(&self, interval: u32, weight0: f64, weight1: f64) -> [f64; VISIBLE] {
        let local = interval as usize - self.first;
        let (a, b) = (&self.visible[local], &self.visible[local + 1]);
        std::array::from_fn(|i| weight0 * a[i] + weight1 * b[i])
    }

    /// The states moved by `step`, epoch after epoch.
    #[must_use]
    pub(super) fn moved(&self, model: &ChainModel, step: &[f64]) -> Self {
        let mut moved = self.clone();
        moved.states.iter_mut().zip(step).for_each(|(s, d)| *s += d);
        moved.see(model);
        moved
    }

    /// Sums the states to the visible quantities.
    fn see(&mut self, model: &ChainModel) {
        let states = self.states.chunks_exact(self.size);
        for (visible, states) in self.visible.iter_mut().zip(states) {
            *visible = [0.0; VISIBLE];
            for (process, state) in model.processes().iter().zip(states) {
                visible[process.component] += state;
            }
        }
    }
}
