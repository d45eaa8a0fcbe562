//! A pool scenario on trial: simulate under a seed, calibrate by every path, compare with the truth; and the same for a survey that
//! was observed, of which no truth is known and every source is propagated.

use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};

use super::analytic::{Analytic, AnalyticError, PathBudget, Prediction, analytic_with, of_survey};
use super::soundings;
use super::sources::{about, acting, alone, described, nothing};
use crate::adjust::{BlockId, Unit};
use crate::calibrate::tried::{
    Acting, Moved, PathCovariance, Propagated, PropagatedPath, Reason, Said, SoughtParameter,
    Trial, Tried, TriedPath, faultless,
};
use crate::calibrate::vary::{Alias, Point, VaryError, at};
use crate::geometry::rotation;
use crate::observe::Mounting;
use crate::procedures::pool::config::Variant;
use crate::procedures::pool::joint::{JointOutcome, SIX};
use crate::procedures::pool::sequential::{Outcome, SequentialError};
use crate::procedures::pool::{
    JointConfig, Method, PoolInput, PoolOutcome, SequentialConfig, calibrate_with,
    calibrate_with_true_ties,
};
use crate::results::{SourceDescription, Status, SwathResult};
use crate::simulate::{Scenario, Simulated, Source, Truth, simulate};
use crate::target::Target;
use crate::watch::Unwatched;

/// Name of the pool in files and results.
const POOL: &str = "pool";

/// The paths, in the order of every trial.
const PATHS: [&str; 3] = ["joint", "reference", "reference_projected"];

/// A multibeam is tilted to starboard by a negative roll of its mounting.
pub const ALIASES: [Alias; 1] = [("multibeam.tilt_deg", "multibeam.mounting_deg.roll", -1.0)];

/// How trials are calibrated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Configuration {
    /// The reference path; the projected variant of the same runs beside it.
    pub sequential: SequentialConfig,
    /// The joint path.
    pub joint: JointConfig,
}

impl Configuration {
    /// The reference path with its projected variant, which has a derivative.
    #[must_use]
    pub fn projected(&self) -> SequentialConfig {
        SequentialConfig {
            variant: Variant::Projected,
            ..self.sequential.clone()
        }
    }

    /// The mounting's six, then what is unknown besides.
    fn parameters(&self) -> Vec<SoughtParameter> {
        let parameter = |name: &str, unit| SoughtParameter {
            name: name.to_owned(),
            unit,
        };
        let unit = |i: usize| if i < 3 { Unit::Radian } else { Unit::Metre };
        let mut all: Vec<_> = (0..6).map(|i| parameter(SIX[i], unit(i))).collect();
        let optional = [
            (self.joint.latency, "latency", Unit::Second),
            (self.joint.range_scale, "range scale", Unit::One),
        ];
        let unknown = optional.into_iter().filter(|(is_unknown, ..)| *is_unknown);
        all.extend(unknown.map(|(_, name, unit)| parameter(name, unit)));
        all
    }

    fn paths(&self) -> Vec<TriedPath> {
        let variants = [
            String::new(),
            variant_name(&self.sequential),
            variant_name(&self.projected()),
        ];
        let path = |(name, variant)| TriedPath { name, variant };
        PATHS.into_iter().zip(variants).map(path).collect()
    }

    fn value(&self) -> serde_json::Value {
        serde_json::json!({ "sequential": self.sequential, "joint": self.joint })
    }
}

fn variant_name(config: &SequentialConfig) -> String {
    let name = match config.variant {
        Variant::Literal => "literal",
        Variant::Projected => "projected",
    };
    let repeated = if config.repeated { ", repeated" } else { "" };
    format!("{name}{repeated}")
}

/// A scenario and how it is calibrated.
#[derive(Clone, Debug, PartialEq)]
pub struct PoolTrials {
    /// What is simulated.
    pub scenario: Scenario,
    /// How it is calibrated.
    pub configuration: Configuration,
}

/// A scenario as bytes, the seed apart: what a digest is taken of.
pub(super) fn content(scenario: &Scenario) -> Vec<u8> {
    let unseeded = Scenario {
        seed: 0,
        ..scenario.clone()
    };
    serde_json::to_vec(&unseeded).unwrap_or_default()
}

impl PoolTrials {
    /// The scenario with these sources.
    fn with(&self, sources: Acting) -> Scenario {
        match sources {
            Acting::All | Acting::AllWithTrueTies => self.scenario.clone(),
            Acting::None => nothing(&self.scenario),
            Acting::Only(place) => alone(&self.scenario, acting(&self.scenario)[place]),
        }
    }

    /// What a simulated survey's calibration found, every path's error or why it has none.
    fn calibrated(&self, survey: &Simulated, seed: u64, true_ties: bool) -> Trial {
        let input = PoolInput {
            campaign: &survey.campaign,
            target: &survey.target,
            prior: &survey.prior,
            method: Method::Both,
            sequential: &self.configuration.sequential,
            joint: &self.configuration.joint,
            seed,
            extras: &[],
        };
        let further = [self.configuration.projected()];
        let outcome = if true_ties {
            calibrate_with_true_ties(&input, &survey.struck, &further)
        } else {
            calibrate_with(&input, &further, &Unwatched)
        };
        match outcome {
            Ok(outcome) => judged(seed, &outcome, &survey.truth),
            Err(error) => without(seed, &Reason::new("not_run", &error)),
        }
    }
}

impl Tried for PoolTrials {
    fn procedure(&self) -> &'static str {
        POOL
    }

    fn scenario(&self) -> &str {
        &self.scenario.name
    }

    fn content(&self) -> Vec<u8> {
        content(&self.scenario)
    }

    fn check(&self) -> Result<(), String> {
        faultless(&self.scenario.check())?;
        let target = Target::from_model(&self.scenario.target.model);
        target
            .map(|_| ())
            .map_err(|error| format!("scenario: target.model: {error}"))
    }

    fn configuration(&self) -> serde_json::Value {
        self.configuration.value()
    }

    fn parameters(&self) -> Vec<SoughtParameter> {
        self.configuration.parameters()
    }

    fn paths(&self) -> Vec<TriedPath> {
        self.configuration.paths()
    }

    fn sources(&self) -> Vec<SourceDescription> {
        let sources = acting(&self.scenario).into_iter();
        sources.map(|s| described(&self.scenario, s)).collect()
    }

    fn knows_true_ties(&self) -> bool {
        true
    }

    fn trial(&self, seed: u64, acting: Acting) -> Trial {
        match simulate(&self.with(acting), seed) {
            Ok(survey) => self.calibrated(&survey, seed, acting == Acting::AllWithTrueTies),
            Err(error) => without(seed, &Reason::new("not_simulated", &error)),
        }
    }

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        Ok(Box::new(Self {
            scenario: at(&self.scenario, point, &ALIASES, Scenario::check)?,
            configuration: self.configuration.clone(),
        }))
    }

    fn has_derivatives(&self) -> bool {
        true
    }

    fn propagated(&self) -> Option<Result<Propagated, String>> {
        let (sequential, joint) = (&self.configuration.sequential, &self.configuration.joint);
        let found = analytic_with(&self.scenario, sequential, joint);
        Some(propagated(found, &self.scenario, &self.configuration))
    }

    fn swath(&self, known: Vec<PathCovariance>, depths_m: &[f64]) -> Option<SwathResult> {
        let known = soundings::or_predicted(known, &self.scenario, &self.configuration.joint);
        Some(soundings::section(&self.scenario, &known, depths_m))
    }
}

/// A survey as it was observed, its claims in a scenario's words.
pub struct PoolObserved<'a> {
    /// What its file claims of every instrument.
    pub claims: Scenario,
    /// How it is calibrated.
    pub configuration: Configuration,
    /// The survey.
    pub input: PoolInput<'a>,
    /// What was said when it was read.
    pub notes: Vec<String>,
}

/// What a reader of a survey's budget should know.
const SURVEY_NOTE: &str = "a survey's own budget: its observations, and the sigmas that its file claims; errors that the file does not mention (latency, sound speed, gross errors) are not in it, and no truth is known, so there is no bias";

impl PoolObserved<'_> {
    /// The claims as if they were a scenario.
    fn claimed(&self) -> PoolTrials {
        PoolTrials {
            scenario: self.claims.clone(),
            configuration: self.configuration.clone(),
        }
    }
}

impl Tried for PoolObserved<'_> {
    fn procedure(&self) -> &'static str {
        POOL
    }

    fn scenario(&self) -> &str {
        &self.claims.name
    }

    fn content(&self) -> Vec<u8> {
        self.claimed().content()
    }

    fn configuration(&self) -> serde_json::Value {
        self.configuration.value()
    }

    fn parameters(&self) -> Vec<SoughtParameter> {
        self.configuration.parameters()
    }

    fn paths(&self) -> Vec<TriedPath> {
        self.configuration.paths()
    }

    fn sources(&self) -> Vec<SourceDescription> {
        self.claimed().sources()
    }

    fn has_truth(&self) -> bool {
        false
    }

    fn trial(&self, seed: u64, _: Acting) -> Trial {
        without(
            seed,
            &Reason::new("observed", &"nobody knows the truth of a survey"),
        )
    }

    fn varied(&self, point: &Point) -> Result<Box<dyn Tried>, VaryError> {
        self.claimed().varied(point)
    }

    fn has_derivatives(&self) -> bool {
        true
    }

    fn propagated(&self) -> Option<Result<Propagated, String>> {
        let found = of_survey(&self.claims, &self.input);
        Some(propagated(found, &self.claims, &self.configuration))
    }

    fn swath(&self, known: Vec<PathCovariance>, depths_m: &[f64]) -> Option<SwathResult> {
        Some(soundings::section(&self.claims, &known, depths_m))
    }

    fn notes(&self) -> Vec<String> {
        let own = [SURVEY_NOTE.to_owned()];
        self.notes.iter().cloned().chain(own).collect()
    }
}

fn without(seed: u64, reason: &Reason) -> Trial {
    Trial {
        seed,
        paths: PATHS.map(|_| Err(reason.clone())).into(),
    }
}

fn judged(seed: u64, outcome: &PoolOutcome, truth: &Truth) -> Trial {
    let refusal = outcome.refusal.as_ref();
    let refused = refusal.map_or_else(
        || Reason::new("not_run", &"the path did not run"),
        |r| Reason::new(r.code(), r),
    );
    let joint = outcome.joint.as_ref().filter(|_| refusal.is_none());
    let unknown = outcome.joint.as_ref().map_or(0, |j| optional(j).len());
    let reference = |path: Option<&Result<Outcome, SequentialError>>| {
        path.map_or_else(|| Err(refused.clone()), |p| reference(p, truth, unknown))
    };
    let paths = vec![
        joint
            .map(|j| of_joint(j, truth))
            .ok_or_else(|| refused.clone()),
        reference(outcome.sequential.as_ref()),
        reference(outcome.further.first()),
    ];
    Trial { seed, paths }
}

fn of_joint(joint: &JointOutcome, truth: &Truth) -> Said {
    let x = &joint.solution.estimate.parameters;
    let unknown = optional(joint);
    let mut error = errors(&joint.mounting, truth).to_vec();
    let of_unknown = |(id, truth_of): &(BlockId, TruthOf)| x.euclidean(*id)[0] - truth_of(truth);
    error.extend(unknown.iter().map(of_unknown));
    let mut columns: Vec<usize> = (0..6).collect();
    columns.extend(unknown.iter().map(|(id, _)| x.offset(*id)));
    let cofactor = &joint.solution.cofactor;
    let mut covariance = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
        cofactor[(columns[i], columns[j])]
    });
    covariance
        .view_mut((0, 0), (6, 6))
        .copy_from(&joint.covariance);
    Said {
        error,
        covariance: Some(covariance),
        variance_factor: joint.variance_factor(),
    }
}

/// An unknown's value in the truth.
type TruthOf = fn(&Truth) -> f64;

/// Latency and range scale where they were unknowns, with their truth.
fn optional(joint: &JointOutcome) -> Vec<(BlockId, TruthOf)> {
    let latency: TruthOf = |truth| truth.latency_s;
    let range_scale: TruthOf = |truth| truth.range_scale;
    let unknowns = [
        (joint.blocks.latency, latency),
        (joint.blocks.range_scale, range_scale),
    ];
    let found = unknowns.into_iter();
    found.filter_map(|(id, truth)| Some((id?, truth))).collect()
}

/// A stalled end counts as usable, being out of passes does not. Of latency and range scale the path knows nothing.
fn reference(
    path: &Result<Outcome, SequentialError>,
    truth: &Truth,
    unknown: usize,
) -> Result<Said, Reason> {
    match path {
        Ok(found) if found.end.status() == Status::OutOfIterations => {
            Err(Reason::new("out_of_passes", &found.end.message()))
        }
        Ok(found) => {
            let mut error = errors(&found.mounting, truth).to_vec();
            error.extend(std::iter::repeat_n(f64::NAN, unknown));
            Ok(Said {
                error,
                covariance: None,
                variance_factor: None,
            })
        }
        Err(error) => Err(Reason::new("sequential", error)),
    }
}

/// Estimate minus truth: pitch, roll, yaw (radians), lx, ly, lz (metres), left perturbation in the body frame.
#[must_use]
pub fn errors(found: &Mounting, truth: &Truth) -> [f64; 6] {
    let r = Matrix3::from_fn(|i, j| truth.rotation_matrix[i][j]);
    let turn = rotation::log(&(found.rotation * r.transpose()));
    let arm = found.lever_arm_m - Vector3::from(truth.lever_arm_m);
    [turn.x, turn.y, turn.z, arm.x, arm.y, arm.z]
}

/// The analytic budget in the form that all procedures share. The literal variant of the reference path has no derivative; where it
/// is configured as projected, both are the same path. Nothing is propagated to latency and range scale.
fn propagated(
    found: Result<Analytic, AnalyticError>,
    scenario: &Scenario,
    configuration: &Configuration,
) -> Result<Propagated, String> {
    let found = found.map_err(|error| error.to_string())?;
    let form = Form {
        acting: acting(scenario),
        size: configuration.parameters().len(),
    };
    let mut paths = vec![form.path(PATHS[0], &found.joint)];
    let mut notes = vec![];
    match &found.sequential {
        Ok(budget) => {
            let both = configuration.sequential == configuration.projected();
            let names = if both { &PATHS[1..] } else { &PATHS[2..] };
            paths.extend(names.iter().map(|name| form.path(name, budget)));
        }
        Err(reason) => notes.push(format!("the reference path is not predicted: {reason}")),
    }
    Ok(Propagated {
        paths,
        bound: found.bound.map(|bound| form.list(&bound.diagonal())),
        notes,
    })
}

/// From six figures to those of all parameters.
struct Form {
    acting: Vec<Source>,
    size: usize,
}

impl Form {
    fn list(&self, six: &Vector6<f64>) -> Vec<f64> {
        let mut all: Vec<f64> = six.iter().copied().collect();
        all.resize(self.size, f64::NAN);
        all
    }

    fn matrix(&self, six: &Matrix6<f64>) -> DMatrix<f64> {
        DMatrix::from_column_slice(6, 6, six.as_slice()).resize(self.size, self.size, f64::NAN)
    }

    fn path(&self, name: &'static str, budget: &PathBudget) -> PropagatedPath {
        let moved = |(source, prediction): &(Source, Prediction)| {
            let moved = match prediction {
                Prediction::Linear { bias, covariance } => Ok(Moved {
                    bias: self.list(bias),
                    variance: self.list(&covariance.diagonal()),
                }),
                Prediction::NotPredicted { reason } => Err(*reason),
            };
            (about(*source).name.to_owned(), moved)
        };
        let acts = |(source, _): &&(Source, Prediction)| self.acting.contains(source);
        PropagatedPath {
            name,
            method_bias: self.list(&budget.method_bias),
            sources: budget.sources.iter().filter(acts).map(moved).collect(),
            bias: self.list(&budget.bias),
            covariance: self.matrix(&budget.covariance),
        }
    }
}
