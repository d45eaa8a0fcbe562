//! Results: what a calibration found, as plain serialisable data.
//!
//! [`PoolResult`] is `result.json`, field by field and in its order (`docs/` and the interface page show an example); [`ReportSamples`]
//! are the decimated points that the report's pictures are drawn from and that `result.json` does not hold.
//!
//! Nothing here calculates. Lengths are metres, angles degrees where a name ends in `_deg` and radians inside covariances. What could not
//! be determined is `None` (`null` in the file), never NaN.

mod any;
mod budget;
mod comparison;
mod named_budget;
mod parameters;
mod plan;
mod pool;
mod provenance;
mod quality;
mod rail;
mod samples;
mod solution;
mod swath;
mod usbl;
mod verdict;
mod write;

pub use any::AnyResult;
pub use budget::{
    Agreement, BUDGET_FORMAT_VERSION, BudgetPath, BudgetResult, Interval, Nees, Origin, PathBudget,
    PathStatistics, RefusalCount, Reported, SixFigures, SourceDescription, SourceShare, Sweep,
    SweepPoint, SweepValue,
};
pub use comparison::{Comparison, Difference, ResidualRms};
pub use named_budget::{
    NAMED_BUDGET_FORMAT_VERSION, NamedBudget, NamedFigures, NamedHonesty, NamedParameter,
    NamedPath, NamedRefusal, NamedShare, NamedSource,
};
pub use parameters::{Parameter, ParameterComparison, ParameterDifference};
pub use plan::{
    PLAN_FORMAT_VERSION, PlanCandidate, PlanCriterion, PlanResult, PlanStep, PlanVariation,
    PlanVariations, PlannedPass,
};
pub use pool::{Counts, PoolResult, SCHEMA, SensorCounts, Solutions, TargetPose};
pub use provenance::{InputFile, Provenance, Software};
pub use quality::{
    GlobalTest, GroupQuality, Observability, Prior, Quality, Reliability, SnoopingTest,
    WeakDirection, WorstObservation,
};
pub use rail::{
    HausdorffStep, Outline, ProfileSample, ProfilerCounts, RAIL_SCHEMA, RailAgainstTruth,
    RailJointSolution, RailMounting, RailReferenceSolution, RailReferenceSteps, RailResult,
    RailSamples, RailSolutions, ResidualSample,
};
pub use samples::{
    FaceSample, FaceStatistics, PerPath, ReportSamples, ReturnSample, SoundingSample, Truth,
};
pub use solution::{
    Angles, Estimate, ExtraParameter, JointIteration, JointSolution, MountingAngles,
    SequentialIteration, SequentialSolution, SixSigmas, SixValues, Status,
};
pub use swath::{
    CovarianceOrigin, OrderLimit, PathSwath, SwathBeam, SwathDepth, SwathLimits, SwathResult,
    Uncertainty95,
};
pub use usbl::{
    UsblBeacon, UsblFixSample, UsblIteration, UsblJoint, UsblPrintedAngles, UsblReference,
    UsblResiduals, UsblResult, UsblSamples, UsblSolutions, UsblTruth, UsblVerification,
};
pub use verdict::{Finding, Severity, Verdict, VerdictState};
pub use write::{WriteError, write_whole};

/// A 3 by 3 matrix by rows.
pub type Matrix3 = [[f64; 3]; 3];

/// A 6 by 6 matrix by rows; order pitch, roll, yaw, lx, ly, lz unless its field says otherwise.
pub type Matrix6 = [[f64; 6]; 6];
