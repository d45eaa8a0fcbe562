//! Iterated Gauss-Helmert adjustment with Levenberg-Marquardt globalisation.

use nalgebra::DMatrix;

use super::block::ChainFactor;
use super::chain::{ChainModel, ChainState};
use super::curvature::{LARGEST_BEND, REACH, curvature};
use super::error::AdjustError;
use super::kernel::Kernel;
use super::linearise::{Keep, Linearisation, factor_here, linearise};
use super::mestimate::with_robust_covariance;
use super::options::{Bending, IterationRecord, Options, Status};
use super::partition::check_intervals;
use super::pass::{Pass, Weighting};
use super::problem::{Estimate, Problem};

/// Damping above which a step is smaller than rounding.
const LARGEST_DAMPING: f64 = 1e32;
/// Promised fall of the cost, relative to the cost, that its own rounding can hide.
const ROUNDING: f64 = 1e-14;

/// Part of the damping's scale that is kept from step to step.
const METRIC_MEMORY: f64 = 0.5;

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
    /// Weighted sum of squares of conditions (kernel weights), priors and states.
    pub omega: f64,
    /// Cofactors over all columns (covariance a priori, variance factor one); zero rows for held columns. An undetermined
    /// direction has a huge variance. Under a kernel they are those of the M-estimator.
    pub cofactor: DMatrix<f64>,
    /// The linearisation at the end, for the quality figures.
    pub(super) linearisation: Linearisation,
    /// Weighting of that linearisation.
    pub(super) weighting: Weighting,
    /// Kernel that the conditions were solved with.
    pub kernel: Kernel,
}

impl Solution {
    /// Information (inverse cofactors) of all columns with the states eliminated, priors included; zero rows for held columns.
    #[must_use]
    pub fn information(&self) -> DMatrix<f64> {
        let parameters = &self.estimate.parameters;
        let inner = self.linearisation.reduced.information();
        spread(&inner, parameters.columns(), &parameters.free_columns())
    }
}

/// Solves a problem from a start.
///
/// # Errors
/// See [`AdjustError`]; a problem that does not converge is not an error but a [`Status`].
pub fn solve(
    problem: &Problem,
    start: Estimate,
    options: &Options,
) -> Result<Solution, AdjustError> {
    let mut iteration = Iteration::start(problem, start, options)?;
    while iteration.status.is_none() {
        iteration.advance()?;
    }
    iteration.finish()
}

/// The adjustment between two iterations.
pub(super) struct Iteration<'a> {
    problem: &'a Problem<'a>,
    options: &'a Options,
    here: Estimate,
    linearisation: Linearisation,
    /// Scale of the damping: the largest length each column has had (Moré 1978, eq. 6.3), halved at each step so that lengths
    /// of a far start are forgotten.
    metric: Vec<f64>,
    damping: f64,
    growth: f64,
    /// The linear model has been wrong lately, so steps are bent along their second order.
    rough: bool,
    pub(super) records: Vec<IterationRecord>,
    pub(super) status: Option<Status>,
}

/// A proposed step.
struct Step {
    parameters: Vec<f64>,
    states: Vec<f64>,
    promise: f64,
    sigmas: f64,
}

impl<'a> Iteration<'a> {
    /// Checks the problem and linearises it at the start.
    pub(super) fn start(
        problem: &'a Problem<'a>,
        start: Estimate,
        options: &'a Options,
    ) -> Result<Self, AdjustError> {
        check_intervals(problem)?;
        check_size(problem, &start)?;
        let chain = problem
            .chain
            .map(|model| start.chain.unwrap_or_else(|| ChainState::zero(model)));
        let here = Estimate {
            parameters: start.parameters,
            chain,
        };
        let weighting = Weighting::Kernel(options.kernel);
        let linearisation = linearise(problem, &here, weighting, Keep::Factor(None))?;
        let metric = linearisation.reduced.lengths();
        let (damping, growth, records) = (options.initial_damping, 2.0, Vec::new());
        Ok(Iteration {
            problem,
            options,
            here,
            linearisation,
            metric,
            damping,
            growth,
            rough: false,
            records,
            status: None,
        })
    }

    /// One iteration: propose, judge, accept or damp.
    pub(super) fn advance(&mut self) -> Result<(), AdjustError> {
        let mut step = self.propose()?;
        self.status = self.ending(&step);
        if self.status.is_some() {
            return Ok(());
        }
        if self.is_rough() && !self.bend(&mut step)? {
            return self.reject(&step, f64::INFINITY, None);
        }
        let trial = self.moved(&step);
        let recycled = self.linearisation.factor.take();
        match linearise(
            self.problem,
            &trial,
            Weighting::Kernel(self.options.kernel),
            Keep::Factor(recycled),
        ) {
            Ok(there) if self.improves(&step, there.cost) => self.accept(&step, trial, there),
            Ok(there) => self.reject(&step, there.cost, there.factor),
            Err(AdjustError::NotFinite { .. }) => self.reject(&step, f64::INFINITY, None),
            Err(error) => Err(error),
        }
    }

    /// Damped step of the parameters, and of the states that follow.
    fn propose(&self) -> Result<Step, AdjustError> {
        let spectrum = self.linearisation.reduced.spectrum(&self.metric)?;
        let free = spectrum.step(self.damping);
        let states = match (self.problem.chain, &self.linearisation.factor) {
            (Some(model), Some(factor)) => self.state_steps(model, factor, &free)?,
            _ => Vec::new(),
        };
        let promise = spectrum.promise(self.damping) + self.linearisation.state_promise;
        let sigmas = self.parameter_sigmas().max(self.state_sigmas(&states));
        Ok(Step {
            parameters: self.spread(&free),
            states,
            promise,
            sigmas,
        })
    }

    /// Step of all states; what other processes cannot give is made here.
    fn state_steps(
        &self,
        model: &ChainModel,
        factor: &ChainFactor,
        free: &[f64],
    ) -> Result<Vec<f64>, AdjustError> {
        let elsewhere = self.problem.elsewhere;
        if let Some(steps) = factor.back_substitute((model, elsewhere), free)? {
            return Ok(steps);
        }
        let weighting = Weighting::Kernel(self.options.kernel);
        let factor = factor_here(self.problem, &self.here, weighting)?;
        let steps = factor.map(|factor| factor.back_substitute((model, None), free));
        Ok(steps.transpose()?.flatten().unwrap_or_default())
    }

    /// Adds the geodesic acceleration to a step; false where the step bends too much to be taken. Problems with a chain, whose
    /// states are small, do without.
    fn bend(&self, step: &mut Step) -> Result<bool, AdjustError> {
        if self.problem.chain.is_some() || self.hides(step) {
            return Ok(true);
        }
        let reached: Vec<f64> = step.parameters.iter().map(|step| step * REACH).collect();
        let ahead = Estimate {
            parameters: self.here.parameters.retracted(&reached),
            chain: None,
        };
        let weighting = Weighting::Kernel(self.options.kernel);
        let pass = Pass {
            problem: self.problem,
            at: &self.here,
            weighting,
        };
        let second = curvature(&pass, &ahead, &step.parameters)?;
        if second.iter().any(|value| !value.is_finite()) {
            return Ok(false);
        }
        let spectrum = self.linearisation.reduced.spectrum(&self.metric)?;
        let bend = spectrum.respond(&self.gathered(&second), self.damping);
        let bent = spectrum.length(&bend) / spectrum.length(&self.gathered(&step.parameters));
        let bend = self.spread(&bend);
        step.parameters
            .iter_mut()
            .zip(bend)
            .for_each(|(step, bend)| *step += 0.5 * bend);
        Ok(bent <= LARGEST_BEND)
    }

    fn is_rough(&self) -> bool {
        self.rough || self.options.bending == Bending::Always
    }

    fn gathered(&self, all: &[f64]) -> Vec<f64> {
        self.here
            .parameters
            .free_columns()
            .iter()
            .map(|column| all[*column])
            .collect()
    }

    /// Largest undamped parameter step in its own standard deviation.
    fn parameter_sigmas(&self) -> f64 {
        let spectrum = &self.linearisation.spectrum;
        let (step, cofactor) = (spectrum.step(0.0), spectrum.cofactor());
        let ratios = step
            .iter()
            .enumerate()
            .map(|(j, step)| step.abs() / cofactor[(j, j)].sqrt());
        ratios.fold(0.0, f64::max) / self.noise()
    }

    /// Largest state step in the standard deviation of its process.
    fn state_sigmas(&self, states: &[f64]) -> f64 {
        let Some(model) = self.problem.chain else {
            return 0.0;
        };
        let sigmas = model
            .processes()
            .iter()
            .cycle()
            .map(|process| process.sigma);
        states
            .iter()
            .zip(sigmas)
            .map(|(step, sigma)| step.abs() / sigma)
            .fold(0.0, f64::max)
    }

    /// Standard deviation of unit weight that steps are measured with.
    fn noise(&self) -> f64 {
        if !self.options.unknown_noise {
            return 1.0;
        }
        let excess = redundancy(self.problem, &self.here).max(1.0);
        (2.0 * self.linearisation.cost / excess)
            .sqrt()
            .max(f64::MIN_POSITIVE)
    }

    fn spread(&self, free: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.here.parameters.columns()];
        self.here
            .parameters
            .free_columns()
            .iter()
            .zip(free)
            .for_each(|(column, step)| all[*column] = *step);
        all
    }

    fn ending(&self, step: &Step) -> Option<Status> {
        if step.sigmas <= self.options.step_tolerance_sigmas {
            return Some(self.settled());
        }
        if self.damping > LARGEST_DAMPING || self.is_at_the_floor(step) {
            return Some(Status::Stalled);
        }
        (self.records.len() >= self.options.max_iterations).then_some(Status::OutOfIterations)
    }

    /// Whether steps that the cost can no longer judge have stopped shrinking.
    fn is_at_the_floor(&self, step: &Step) -> bool {
        let before = self
            .records
            .len()
            .checked_sub(3)
            .map(|i| self.records[i].step_sigmas);
        self.hides(step) && before.is_some_and(|before| step.sigmas > 0.5 * before)
    }

    /// Whether the cost is too coarse to judge a step.
    fn hides(&self, step: &Step) -> bool {
        step.promise <= ROUNDING * self.linearisation.cost
    }

    fn settled(&self) -> Status {
        let undetermined = self.linearisation.spectrum.undetermined();
        if undetermined.is_empty() {
            return Status::Converged;
        }
        Status::RankDeficient {
            directions: undetermined.iter().map(|axis| self.spread(axis)).collect(),
        }
    }

    fn moved(&self, step: &Step) -> Estimate {
        let chain = match (self.problem.chain, &self.here.chain) {
            (Some(model), Some(state)) => Some(state.moved(model, &step.states)),
            _ => None,
        };
        Estimate {
            parameters: self.here.parameters.retracted(&step.parameters),
            chain,
        }
    }

    /// A fall of the cost, or a change below its rounding.
    fn improves(&self, step: &Step, cost: f64) -> bool {
        let fall = self.linearisation.cost - cost;
        let noise = ROUNDING * self.linearisation.cost;
        fall > 1e-4 * step.promise || (self.hides(step) && fall.abs() <= noise)
    }

    /// Takes the step; the damping falls with the quality of the linear model (Nielsen 1999, eq. 2.5).
    fn accept(
        &mut self,
        step: &Step,
        trial: Estimate,
        there: Linearisation,
    ) -> Result<(), AdjustError> {
        let gain = match self.hides(step) {
            true => 1.0,
            false => (self.linearisation.cost - there.cost) / step.promise,
        };
        self.record(step, there.cost, true);
        self.damping *= (1.0 - (2.0 * gain.clamp(0.0, 1.0) - 1.0).powi(3)).max(0.1);
        self.growth = 2.0;
        self.rough = !(0.5..1.5).contains(&gain);
        self.here = trial;
        self.linearisation = there;
        let lengths = self.linearisation.reduced.lengths();
        let slow =
            |(metric, length): (&mut f64, f64)| *metric = (METRIC_MEMORY * *metric).max(length);
        self.metric.iter_mut().zip(lengths).for_each(slow);
        Ok(())
    }

    /// Stays and damps more.
    fn reject(
        &mut self,
        step: &Step,
        cost: f64,
        recycled: Option<ChainFactor>,
    ) -> Result<(), AdjustError> {
        self.record(step, cost, false);
        self.damping *= self.growth;
        self.growth *= 2.0;
        self.rough = true;
        if self.problem.chain.is_some() {
            self.linearisation = linearise(
                self.problem,
                &self.here,
                Weighting::Kernel(self.options.kernel),
                Keep::Factor(recycled),
            )?;
        }
        Ok(())
    }

    fn record(&mut self, step: &Step, cost: f64, accepted: bool) {
        self.records.push(IterationRecord {
            cost,
            damping: self.damping,
            step_sigmas: step.sigmas,
            accepted,
        });
    }

    /// The estimate reached, with its cofactors.
    pub(super) fn finish(self) -> Result<Solution, AdjustError> {
        let kernel = self.options.kernel;
        let solution = Solution {
            cofactor: spread_cofactor(&self.here, &self.linearisation),
            estimate: self.here,
            status: self.status.unwrap_or(Status::OutOfIterations),
            iterations: self.records,
            cost: self.linearisation.cost,
            omega: self.linearisation.tally.omega + 2.0 * self.linearisation.prior_cost,
            linearisation: self.linearisation,
            weighting: Weighting::Kernel(kernel),
            kernel,
        };
        if kernel.is_least_squares() || !self.options.robust_covariance {
            return Ok(solution);
        }
        with_robust_covariance(self.problem, solution)
    }
}

/// Cofactors over all columns, zero for held ones.
pub(super) fn spread_cofactor(at: &Estimate, linearisation: &Linearisation) -> DMatrix<f64> {
    let (all, free) = (at.parameters.columns(), at.parameters.free_columns());
    spread(&linearisation.spectrum.cofactor(), all, &free)
}

/// A matrix over the free columns as one over all columns.
fn spread(inner: &DMatrix<f64>, all: usize, free: &[usize]) -> DMatrix<f64> {
    let mut whole = DMatrix::zeros(all, all);
    for (i, &row) in free.iter().enumerate() {
        for (j, &column) in free.iter().enumerate() {
            whole[(row, column)] = inner[(i, j)];
        }
    }
    whole
}

/// Conditions and priors less unknowns; states and their priors cancel.
pub(super) fn redundancy(problem: &Problem, at: &Estimate) -> f64 {
    let observations = problem.condition_count() + at.parameters.prior_count();
    observations as f64 - at.parameters.free_columns().len() as f64
}

fn check_size(problem: &Problem, start: &Estimate) -> Result<(), AdjustError> {
    let conditions = problem.condition_count() + start.parameters.prior_count();
    let unknowns = start.parameters.free_columns().len();
    if conditions == 0 || conditions < unknowns {
        return Err(AdjustError::TooFew {
            conditions,
            unknowns,
        });
    }
    Ok(())
}
