//! The joint driver: the one loop that every procedure's joint path runs in.
//!
//! ```text
//! begin              start values and the first ties
//! repeat             adjust what is tied, then let the model look: tie again, rest, or give up
//! snoop              the last adjustment, by data snooping
//! judge              tests, reliability, what the data determine
//! ```
//!
//! A procedure brings a [`Model`]: how its observations are tied, its conditions, and when its ties are at rest. When a judged outcome
//! is refused is said in the procedure's `verdict`, with the limit that all of them share, [`ABSURD_VARIANCE_FACTOR`].

use crate::adjust::{
    AdjustError, Bits, Estimate, Limits, Observability, Options, ParameterSet, Problem, Quality,
    QualityOptions, Snooped, Solution, observability, snoop, solve,
};
use crate::calibrate::verdict::Doubted;
use crate::watch::Watch;

/// A variance factor above this is absurd: the residuals are three times what was claimed.
pub const ABSURD_VARIANCE_FACTOR: f64 = 9.0;

/// What the driver needs to know of a procedure's joint path.
pub trait Model {
    /// Which observation is tied to what.
    type Ties;

    /// Start values and the ties under them.
    ///
    /// # Errors
    /// [`AdjustError`] for start values that no adjustment can begin with.
    fn begin(&mut self) -> Result<(Estimate, Self::Ties), AdjustError>;

    /// How the adjustments are run.
    fn schedule(&self) -> Schedule;

    /// Builds the adjustment of these ties, linearised from these parameters, and hands it to `then`.
    fn with_problem<T>(
        &self,
        ties: &Self::Ties,
        from: &ParameterSet,
        then: impl FnOnce(&Problem) -> T,
    ) -> T;

    /// Fewer ties for an adjustment that only brings the estimate near; `None` for all of them.
    fn thinned(&self, round: usize, ties: &Self::Ties) -> Option<Self::Ties> {
        let _ = (round, ties);
        None
    }

    /// Looks at an adjustment: ties again under it, or says that the ties are at rest.
    fn next(&mut self, pass: &Pass<'_, Self::Ties>) -> Next<Self::Ties>;

    /// What speaks against the last adjustment, asked once and only of one that ended well. The problem leaves out what data snooping
    /// removed; the ties are those that it was built from, removed ones included.
    ///
    /// # Errors
    /// [`AdjustError`] from a pass over the conditions.
    fn judge(
        &self,
        ties: &Self::Ties,
        problem: &Problem,
        found: &Snooped,
    ) -> Result<Doubted, AdjustError> {
        let _ = (ties, problem, found);
        Ok(Doubted::default())
    }

    /// Where the last adjustment starts: at the solution, unless the model says otherwise.
    fn last_start(&self, solution: &Solution) -> Estimate {
        solution.estimate.clone()
    }
}

/// How a model's adjustments are run.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// Those before the last: they bring the estimate near and are not judged.
    pub passing: Options,
    /// The last one.
    pub last: Options,
    /// How the last one is judged.
    pub quality: QualityOptions,
    /// Rounds of data snooping at the most.
    pub most_snoops: usize,
    /// Above which standard deviation a direction counts as open.
    pub limits: Limits,
}

/// An adjustment that has just been made.
#[derive(Debug)]
pub struct Pass<'a, T> {
    /// Its number, from 0.
    pub round: usize,
    /// The parameters that it began with.
    pub before: &'a ParameterSet,
    /// What it found.
    pub solution: &'a Solution,
    /// All ties that hold, of which a thinned adjustment used some.
    pub ties: &'a T,
    /// Whether it was thinned.
    pub thinned: bool,
}

/// What follows an adjustment; without ties of its own those that hold stay.
#[derive(Debug)]
pub enum Next<T> {
    /// Adjust again, with these ties.
    Again(T),
    /// Go on to the last adjustment.
    Rest {
        /// Its ties.
        ties: Option<T>,
        /// Whether they are at rest, and not only out of rounds.
        stable: bool,
    },
    /// Nothing can be judged: the adjustment as it is, is the end.
    End(Option<T>),
}

/// How a joint path ended.
#[derive(Debug)]
pub struct Solved<T> {
    /// The last adjustment.
    pub solution: Solution,
    /// The ties that entered it, with those that data snooping switched off.
    pub ties: T,
    /// Whether the ties came to rest.
    pub stable: bool,
    /// What the engine says of it; `None` when it could not be judged.
    pub judged: Option<Judged>,
}

/// What the engine says of the last adjustment.
#[derive(Debug)]
pub struct Judged {
    /// Global test, groups, worst conditions.
    pub quality: Quality,
    /// What the data determine.
    pub observability: Observability,
    /// What speaks against it, by the model's own doubts.
    pub doubted: Doubted,
    /// Conditions that data snooping removed.
    pub removed: usize,
    /// Of every set of conditions, which of them it switched off.
    pub ignored: Vec<Bits>,
}

/// Runs a model's joint path to its end. How it ended is in the outcome.
///
/// # Errors
/// [`AdjustError`]: stopped by `watch`, nothing to adjust, or values that are not finite.
pub fn run<M: Model>(model: &mut M, watch: &dyn Watch) -> Result<Solved<M::Ties>, AdjustError> {
    let (mut estimate, mut ties) = model.begin()?;
    let schedule = model.schedule();
    let mut round = 0;
    loop {
        let before = estimate.parameters.clone();
        let fewer = model.thinned(round, &ties);
        let used = fewer.as_ref().unwrap_or(&ties);
        let solution = model.with_problem(used, &before, |problem| {
            solve(&problem.watched(watch), estimate, &schedule.passing)
        })?;
        let pass = Pass {
            round,
            before: &before,
            solution: &solution,
            ties: &ties,
            thinned: fewer.is_some(),
        };
        match model.next(&pass) {
            Next::Again(again) => ties = again,
            Next::Rest { ties: last, stable } => {
                let start = model.last_start(&solution);
                let ties = last.unwrap_or(ties);
                return judged(model, watch, &schedule, start, ties, stable);
            }
            Next::End(last) => return Ok(unjudged(solution, last.unwrap_or(ties))),
        }
        estimate = solution.estimate;
        round += 1;
    }
}

/// Data snooping from ties at rest, and the judgement.
fn judged<M: Model>(
    model: &M,
    watch: &dyn Watch,
    schedule: &Schedule,
    start: Estimate,
    ties: M::Ties,
    stable: bool,
) -> Result<Solved<M::Ties>, AdjustError> {
    let from = start.parameters.clone();
    let (options, tests, most) = (&schedule.last, &schedule.quality, schedule.most_snoops);
    let found = model.with_problem(&ties, &from, |problem| {
        snoop(&problem.watched(watch), start, options, tests, most)
    })?;
    let judged = Judged {
        doubted: doubted(model, watch, &ties, &found)?,
        observability: observability(&found.solution, &schedule.limits),
        quality: found.quality,
        removed: found.removed.len(),
        ignored: found.ignored,
    };
    Ok(Solved {
        solution: found.solution,
        ties,
        stable,
        judged: Some(judged),
    })
}

/// What the model finds against the last adjustment.
fn doubted<M: Model>(
    model: &M,
    watch: &dyn Watch,
    ties: &M::Ties,
    found: &Snooped,
) -> Result<Doubted, AdjustError> {
    if !found.solution.status.was_successful() {
        return Ok(Doubted::default());
    }
    let at = &found.solution.estimate.parameters;
    model.with_problem(ties, at, |problem| {
        let mut kept = problem.watched(watch);
        for (source, mask) in kept.sources.iter_mut().zip(&found.ignored) {
            source.ignored = Some(mask);
        }
        model.judge(ties, &kept, found)
    })
}

fn unjudged<T>(solution: Solution, ties: T) -> Solved<T> {
    Solved {
        solution,
        ties,
        stable: false,
        judged: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::{Block, BlockId, ChainState, Component, Conditions, Row, Source, Unit};
    use crate::watch::Unwatched;

    /// The mean of those heights that lie within a gate of it.
    struct Level {
        heights_m: Vec<f64>,
        gate_m: f64,
        block: BlockId,
        start: ParameterSet,
        passes: usize,
    }

    struct Heights<'a>(&'a Level, &'a [usize]);

    impl Conditions for Heights<'_> {
        fn len(&self) -> usize {
            self.1.len()
        }

        fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
            row.clear();
            row.misclosure = x.euclidean(self.0.block)[0] - self.0.heights_m[self.1[k]];
            row.variance = 1e-4;
            row.extend(x.offset(self.0.block), &[1.0]);
        }
    }

    impl Level {
        fn new(gate_m: f64) -> Self {
            let mut start = ParameterSet::new();
            let height = vec![Component::new("height", Unit::Metre)];
            let block = start.push(Block::euclidean("level", height, &[0.1]));
            let spread = |k: u32| 0.01 * (f64::from(k) * 0.618_033_988_749_894_9).fract();
            let near = (0..40).map(spread);
            Self {
                heights_m: near.chain([5.0, 6.0]).collect(),
                gate_m,
                block: block.expect("a block"),
                start,
                passes: 0,
            }
        }

        fn tie(&self, x: &ParameterSet) -> Vec<usize> {
            let level_m = x.euclidean(self.block)[0];
            let near = |k: &usize| (self.heights_m[*k] - level_m).abs() < self.gate_m;
            (0..self.heights_m.len()).filter(near).collect()
        }
    }

    impl Model for Level {
        type Ties = Vec<usize>;

        fn begin(&mut self) -> Result<(Estimate, Vec<usize>), AdjustError> {
            let all = (0..self.heights_m.len()).collect();
            Ok((Estimate::new(self.start.clone()), all))
        }

        fn schedule(&self) -> Schedule {
            Schedule {
                passing: Options::default(),
                last: Options::default(),
                quality: QualityOptions::default(),
                most_snoops: 1,
                limits: Limits::default(),
            }
        }

        fn with_problem<T>(
            &self,
            ties: &Vec<usize>,
            _: &ParameterSet,
            then: impl FnOnce(&Problem) -> T,
        ) -> T {
            let heights = Heights(self, ties);
            then(&Problem::dense(vec![Source::new(&heights)]))
        }

        fn next(&mut self, pass: &Pass<'_, Vec<usize>>) -> Next<Vec<usize>> {
            self.passes += 1;
            let again = self.tie(&pass.solution.estimate.parameters);
            if again.is_empty() {
                return Next::End(Some(again));
            }
            if again == *pass.ties {
                let ties = Some(again);
                return Next::Rest { ties, stable: true };
            }
            Next::Again(again)
        }
    }

    #[test]
    fn ties_are_made_again_until_they_rest_and_the_end_is_judged() {
        let mut level = Level::new(0.5);
        let solved = run(&mut level, &Unwatched).expect("a solution");
        assert!(solved.stable && level.passes > 1);
        assert_eq!(solved.ties, (0..40).collect::<Vec<_>>());
        let found = solved.solution.estimate.parameters.euclidean(level.block)[0];
        let near = &level.heights_m[..40];
        assert!((found - near.iter().sum::<f64>() / 40.0).abs() < 1e-9);
        let judged = solved.judged.expect("a judgement");
        assert!((judged.quality.global.degrees_of_freedom - 39.0).abs() < 1e-9);
    }

    #[test]
    fn a_model_that_gives_up_is_not_judged() {
        let mut level = Level::new(1e-9);
        let solved = run(&mut level, &Unwatched).expect("an end");
        assert!(solved.judged.is_none() && !solved.stable && solved.ties.is_empty());
        assert_eq!(level.passes, 1);
    }
}
