//! How to solve, and how a solve went.

use super::kernel::Kernel;

/// When steps are bent along the second order of the conditions (geodesic acceleration), at the cost of one more evaluation.
/// Problems with a chain do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bending {
    /// After a step that the linear model foresaw badly.
    #[default]
    WhenRough,
    /// Always: for starts far away and strongly curved models.
    Always,
}

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
    /// When steps are bent.
    pub bending: Bending,
    /// Correct the cofactors of a robust estimate for its kernel, which costs one more pass and a selected inverse; off for a
    /// solve whose cofactors only measure steps.
    pub robust_covariance: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            max_iterations: 50,
            kernel: Kernel::LeastSquares,
            step_tolerance_sigmas: 1e-3,
            unknown_noise: false,
            initial_damping: 1e-4,
            bending: Bending::WhenRough,
            robust_covariance: true,
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
        /// Unit vectors over all columns, each column scaled to unit information.
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
    /// Cost at the trial point: half the weighted (or robust) sum of squares, priors and states included. Infinite where the
    /// conditions could not be evaluated.
    pub cost: f64,
    /// Damping used.
    pub damping: f64,
    /// Largest undamped step of a parameter, or step of a state, in its own standard deviation.
    pub step_sigmas: f64,
    /// Whether the step was taken.
    pub accepted: bool,
}
