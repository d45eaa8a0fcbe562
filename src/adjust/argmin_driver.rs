//! The iteration as an argmin `Solver`, so that observers (progress, convergence log) and time limits can be attached.
//!
//! Results are those of [`super::solve`] to the last bit: argmin only turns the crank.

use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{
    Error, Executor, KV, Problem as Wrapped, Solver, State, TerminationReason, TerminationStatus,
};
use argmin::kv;

use super::error::AdjustError;
use super::options::{IterationRecord, Options};
use super::problem::{Estimate, Problem};
use super::solve::{Iteration, Solution};

/// What an observer sees: the log of the iterations so far.
#[derive(Debug, Clone, Default)]
pub struct Progress {
    /// Every iteration so far.
    pub records: Vec<IterationRecord>,
    iteration: u64,
    limit: u64,
    counts: std::collections::HashMap<String, u64>,
    time: Option<std::time::Duration>,
    status: TerminationStatus,
}

impl Progress {
    fn cost(&self) -> f64 {
        self.records
            .iter()
            .rev()
            .find(|record| record.accepted)
            .map_or(f64::INFINITY, |record| record.cost)
    }
}

impl State for Progress {
    type Param = ();
    type Float = f64;

    fn new() -> Self {
        Progress {
            limit: u64::MAX,
            ..Progress::default()
        }
    }

    fn update(&mut self) {}

    fn get_param(&self) -> Option<&()> {
        None
    }

    fn get_best_param(&self) -> Option<&()> {
        None
    }

    fn terminate_with(mut self, reason: TerminationReason) -> Self {
        self.status = TerminationStatus::Terminated(reason);
        self
    }

    fn get_cost(&self) -> f64 {
        self.cost()
    }

    fn get_best_cost(&self) -> f64 {
        self.cost()
    }

    fn get_target_cost(&self) -> f64 {
        f64::NEG_INFINITY
    }

    fn func_counts<O>(&mut self, problem: &Wrapped<O>) {
        self.counts = problem
            .counts
            .iter()
            .map(|(name, count)| ((*name).to_string(), *count))
            .collect();
    }

    fn get_func_counts(&self) -> &std::collections::HashMap<String, u64> {
        &self.counts
    }

    fn increment_iter(&mut self) {
        self.iteration += 1;
    }

    fn get_iter(&self) -> u64 {
        self.iteration
    }

    fn get_max_iters(&self) -> u64 {
        self.limit
    }

    fn get_termination_status(&self) -> &TerminationStatus {
        &self.status
    }

    fn get_termination_reason(&self) -> Option<&TerminationReason> {
        match &self.status {
            TerminationStatus::Terminated(reason) => Some(reason),
            TerminationStatus::NotTerminated => None,
        }
    }

    fn time(&mut self, time: Option<std::time::Duration>) -> &mut Self {
        self.time = time;
        self
    }

    fn get_time(&self) -> Option<std::time::Duration> {
        self.time
    }

    fn get_last_best_iter(&self) -> u64 {
        self.iteration
    }

    fn is_best(&self) -> bool {
        self.records.last().is_none_or(|record| record.accepted)
    }
}

struct Crank<'a> {
    iteration: Iteration<'a>,
}

impl<O> Solver<O, Progress> for Crank<'_> {
    fn name(&self) -> &str {
        "Gauss-Helmert adjustment"
    }

    fn next_iter(
        &mut self,
        _: &mut Wrapped<O>,
        mut state: Progress,
    ) -> Result<(Progress, Option<KV>), Error> {
        self.iteration.advance()?;
        state.records.clone_from(&self.iteration.records);
        let Some(record) = state.records.last().copied() else {
            return Ok((state, None));
        };
        Ok((
            state,
            Some(kv!("step_sigmas" => record.step_sigmas; "damping" => record.damping;)),
        ))
    }

    fn terminate(&mut self, _: &Progress) -> TerminationStatus {
        match self.iteration.status {
            Some(_) => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            None => TerminationStatus::NotTerminated,
        }
    }
}

/// Solves like [`super::solve`], telling `observer` of every iteration.
///
/// # Errors
/// See [`AdjustError`].
pub fn solve_observed<'a>(
    problem: &'a Problem<'a>,
    start: Estimate,
    options: &'a Options,
    observer: impl Observe<Progress> + 'static,
) -> Result<Solution, AdjustError> {
    let iteration = Iteration::start(problem, start, options)?;
    let executor =
        Executor::new((), Crank { iteration }).add_observer(observer, ObserverMode::Always);
    let done = executor
        .ctrlc(false)
        .timer(false)
        .run()
        .map_err(unwrapped)?;
    done.solver.iteration.finish()
}

fn unwrapped(error: Error) -> AdjustError {
    error
        .downcast::<AdjustError>()
        .unwrap_or_else(|error| AdjustError::Driver {
            message: error.to_string(),
        })
}

#[cfg(test)]
mod tests {
    use super::super::toys::Toy;
    use super::super::*;
    use super::*;
    use std::sync::{Arc, Mutex};

    struct Log(Arc<Mutex<Vec<f64>>>);

    impl Observe<Progress> for Log {
        fn observe_iter(&mut self, state: &Progress, _: &KV) -> Result<(), Error> {
            self.0.lock().unwrap().push(state.get_cost());
            Ok(())
        }
    }

    #[test]
    fn same_bytes_as_the_plain_loop_and_every_iteration_observed() {
        let toy = Toy::new(41, 90, 5);
        let (problem, options) = (toy.problem(), Options::default());
        let plain = solve(&problem, Estimate::new(toy.parameters()), &options).unwrap();
        let costs = Arc::new(Mutex::new(Vec::new()));
        let observed = solve_observed(
            &problem,
            Estimate::new(toy.parameters()),
            &options,
            Log(costs.clone()),
        )
        .unwrap();
        assert_eq!(plain.estimate, observed.estimate);
        assert_eq!(plain.iterations, observed.iterations);
        assert_eq!(*costs.lock().unwrap().last().unwrap(), plain.cost);
        assert!(costs.lock().unwrap().len() >= plain.iterations.len());
    }
}
