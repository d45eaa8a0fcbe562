//! What to sail next: the question, and what answers it. A procedure that has plans implements [`Planner`].

use super::seam::InputError;
use super::vary::Vary;
use crate::results::{PlanCriterion, PlanResult};

/// What a plan is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanAsk {
    /// Distances of candidate passes, metres; none: the procedure's own choice.
    pub distances_m: Vec<f64>,
    /// Speeds, metres per second; none: the procedure's own choice.
    pub speeds_m_s: Vec<f64>,
    /// Heading minus course, degrees; none: the procedure's own choice.
    pub crabs_deg: Vec<f64>,
    /// Whether each candidate is also sailed the other way.
    pub both_directions: bool,
    /// Whether the passes of the file count as sailed.
    pub keep_passes: bool,
    /// What is made smallest.
    pub criterion: PlanCriterion,
    /// Standard deviations wanted by parameter, degrees and millimetres; the others as the procedure has them.
    pub wanted: Vec<(String, f64)>,
    /// Passes that are added at the most.
    pub most: usize,
    /// Values of the scenario over ranges, one or two keys: the prediction of its own passes at each.
    pub vary: Vec<Vary>,
}

/// A file whose passes can be planned on.
pub trait Planner: Sync {
    /// Its name.
    fn name(&self) -> &str;

    /// Surveys without data that the plan needs.
    fn surveys(&self) -> usize;

    /// The plan; `progress` is told of each survey without data.
    ///
    /// # Errors
    /// [`InputError`] for passes that tell nothing.
    fn plan(&self, progress: &(dyn Fn() + Sync)) -> Result<PlanResult, InputError>;
}
