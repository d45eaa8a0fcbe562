//! Iterated Gauss-Helmert adjustment with Levenberg-Marquardt globalisation.

use nalgebra::DMatrix;

use super::error::AdjustError;
use super::kernel::Kernel;
use super::problem::{Estimate, Problem};

/// How to solve.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Iterations (accepted or not) before giving up.
    pub max_iterations: usize,
    /// Robust kernel of the conditions; priors and states are never robustified.
    pub kernel: Kernel,
    /// Converged when no parameter and no state moves by more than this many of its own standard deviations.
    pub step_tolerance_sigmas: f64,
    /// Measure steps in a posteriori standard deviations (scaled by the variance factor): for data of unknown noise.
    pub unknown_noise: bool,
    /// First damping, relative to the diagonal of the normal matrix of the parameters.
    pub initial_damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            max_iterations: 50,
            kernel: Kernel::LeastSquares,
            step_tolerance_sigmas: 1e-3,
            unknown_noise: false,
            initial_damping: 1e-4,
        }
    }
}

/// How a solve ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    /// Parameters and states stand still within tolerance.
    Converged,
    /// No step lowers the cost any more, yet the proposed steps exceed the tolerance.
    Stalled,
    /// The data leave directions of the parameter space undetermined; the estimate is not unique.
    RankDeficient {
        /// Unit tangent vectors over all columns, in scaled parameters.
        directions: Vec<Vec<f64>>,
    },
    /// The iterations were used up.
    OutOfIterations,
}

impl Status {
    /// Whether the estimate may be used.
    pub fn was_successful(&self) -> bool {
        *self == Status::Converged
    }
}

/// One iteration, for the convergence log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IterationRecord {
    /// Cost at the trial point: half the weighted (or robust) sum of squares, priors and states included.
    pub cost: f64,
    /// Damping used.
    pub damping: f64,
    /// Largest step of a parameter or state in its own standard deviation.
    pub step_sigmas: f64,
    /// Whether the step was taken.
    pub accepted: bool,
}

/// A solved problem.
#[derive(Debug)]
pub struct Solution {
    /// Parameters and states.
    pub estimate: Estimate,
    /// How it ended.
    pub status: Status,
    /// Every iteration.
    pub iterations: Vec<IterationRecord>,
    /// Final cost.
    pub cost: f64,
    /// Cofactors over all columns (a-priori covariance, variance factor one); zero rows for held columns.
    pub cofactor: DMatrix<f64>,
}

/// Solves a problem from a start.
///
/// # Errors
/// See [`AdjustError`].
pub fn solve(
    _problem: &Problem,
    _start: Estimate,
    _options: &Options,
) -> Result<Solution, AdjustError> {
    todo!()
}
