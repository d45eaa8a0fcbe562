//! Results: what a calibration found, as plain serialisable data.
//!
//! [`Calibration`] is `result.json` of every procedure, field by field and in its order; [`Page`] is what a report shows beside it.
//!
//! Nothing here calculates. Lengths are metres, angles degrees where a name ends in `_deg` and radians inside covariances. What could not
//! be determined is `None` (`null` in the file), never NaN.

mod budget;
mod calibration;
mod change;
mod comparison;
mod convention;
mod page;
mod plan;
mod provenance;
mod quality;
mod solution;
mod swath;
mod verdict;

pub use crate::files::{WriteError, write_bytes as write_whole};
pub use budget::{
    Agreement, BUDGET_FORMAT_VERSION, BudgetParameter, BudgetResult, Figures, Interval, JOINT,
    Nees, Origin, PathBudget, PathStatistics, RefusalCount, Reported, SourceDescription,
    SourceShare, Sweep, SweepPoint, SweepValue,
};
pub use calibration::{Calibration, SCHEMA, SensorCounts, Solutions};
pub use change::{Change, ParameterChange};
pub use comparison::{Comparison, Difference};
pub use convention::{Convention, ConventionField};
pub use page::{AgainstTruth, DriftSample, Page, TextTable, TruthRow};
pub use plan::{
    PLAN_FORMAT_VERSION, PlanCandidate, PlanCriterion, PlanResult, PlanStep, PlanVariation,
    PlanVariations, PlannedPass,
};
pub use provenance::{InputFile, Provenance, Software};
pub use quality::{
    GlobalTest, GroupQuality, Observability, Prior, Quality, Reliability, SnoopingTest,
    WeakDirection, WorstObservation,
};
pub use solution::{
    Angles, Iteration, MountingAngles, MountingResult, Parameter, Solution, Status,
};
pub use swath::{
    CovarianceOrigin, OrderLimit, PathSwath, SwathBeam, SwathDepth, SwathLimits, SwathResult,
    Uncertainty95,
};
pub use verdict::{Bound, Finding, Severity, Verdict, VerdictState, largest};

/// A 3 by 3 matrix by rows.
pub type Matrix3 = [[f64; 3]; 3];
