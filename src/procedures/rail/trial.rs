//! Simulate and calibrate one seed, for Monte Carlo and budgets.

use nalgebra::{DMatrix, Vector3};

use super::config::{RailJointConfig, RailReferenceConfig};
use super::model::{SOUGHT, SOUGHT_NAMES};
use super::observed::Profiler;
use super::profile::RailProfile;
use super::run::{RailInput, calibrate};
use crate::calibrate::choices::Method;
use crate::observe::Mounting;
use crate::procedures::rail::simulate::{RailScenario, RailScenarioError, RailSources, simulate};

/// What one seed gave.
#[derive(Clone, Debug)]
pub struct RailTrial {
    /// Names of the parameters: pitch, roll, yaw, lx, lz of each profiler in turn, then ly of each.
    pub names: Vec<String>,
    /// Units, `rad` or `m`.
    pub units: Vec<&'static str>,
    /// Errors of the reference path, radians and metres, where it has a result: rotation as `log(R R_true^T)`.
    pub reference: Option<Vec<f64>>,
    /// Errors of the joint path with their covariance, where it has a usable result.
    pub joint: Option<(Vec<f64>, DMatrix<f64>)>,
    /// Variance factor of the joint path.
    pub variance_factor: Option<f64>,
    /// Why there is no usable result.
    pub refusal: Option<String>,
    /// Why the reference path has none.
    pub reference_refusal: Option<String>,
}

/// Correction of a mounting: pitch, roll, yaw (radians), lx, lz (metres) against another.
///
/// Covariances are those of a left perturbation of the mounting found. An error or a difference is therefore the correction against the
/// truth or the other result, not the difference of two corrections against the nominal mounting: with corrections of one degree the
/// latter mixes about 1 % of one angle into another, which is many sigmas in directions that are known best.
#[must_use]
pub fn correction(mounting: &Mounting, from: &Mounting) -> [f64; SOUGHT] {
    let turn: Vector3<f64> = mounting.correction_from(from);
    let arm = mounting.lever_arm_m - from.lever_arm_m;
    [turn.x, turn.y, turn.z, arm.x, arm.z]
}

/// Corrections of all mountings against others in one list.
#[must_use]
pub fn corrections_from<'m>(
    mountings: impl Iterator<Item = &'m Mounting>,
    from: impl Iterator<Item = &'m Mounting>,
) -> Vec<f64> {
    let pairs = mountings.zip(from);
    pairs.flat_map(|(m, from)| correction(m, from)).collect()
}

/// Corrections of all profilers against their nominal mountings.
#[must_use]
pub fn corrections<'m>(
    mountings: impl Iterator<Item = &'m Mounting>,
    profilers: &'m [Profiler],
) -> Vec<f64> {
    corrections_from(mountings, profilers.iter().map(|p| &p.nominal))
}

/// Names of all parameters in the order of [`corrections`].
#[must_use]
pub fn names(profilers: &[Profiler]) -> Vec<String> {
    let all = profilers
        .iter()
        .flat_map(|p| SOUGHT_NAMES.map(|n| format!("{} {n}", p.name)));
    all.collect()
}

/// Simulates a scenario with these sources under a seed and calibrates it by both paths as they are without configuration.
///
/// # Errors
/// [`RailScenarioError`] with every fault of the scenario.
pub fn trial(
    scenario: &RailScenario,
    rail: &RailProfile,
    sources: &RailSources,
    seed: u64,
) -> Result<RailTrial, RailScenarioError> {
    let (reference, joint) = (RailReferenceConfig::default(), RailJointConfig::default());
    trial_with(scenario, rail, sources, (&reference, &joint), seed)
}

/// As [`trial`], with the configuration of both paths.
///
/// # Errors
/// As [`trial`].
pub fn trial_with(
    scenario: &RailScenario,
    rail: &RailProfile,
    sources: &RailSources,
    (reference, joint): (&RailReferenceConfig, &RailJointConfig),
    seed: u64,
) -> Result<RailTrial, RailScenarioError> {
    let scenario = RailScenario {
        sources: sources.clone(),
        ..scenario.clone()
    };
    let simulated = simulate(&scenario, rail, seed)?;
    let profilers = &simulated.campaign.profilers;
    let outcome = calibrate(&RailInput {
        campaign: &simulated.campaign,
        rail,
        method: Method::Both,
        reference,
        joint,
    });
    let usable = outcome
        .joint
        .as_ref()
        .and_then(|j| j.as_ref().ok())
        .filter(|_| outcome.refusal.is_none());
    let by_reference = outcome.reference.as_ref().and_then(|r| r.as_ref().ok());
    let errors = |mountings: Vec<&Mounting>| {
        let truth = &simulated.reality.mountings;
        let mut values = corrections_from(mountings.iter().copied(), truth.iter());
        let along = mountings.iter().zip(truth);
        values.extend(along.map(|(m, t)| m.lever_arm_m.y - t.lever_arm_m.y));
        values
    };
    let count = (SOUGHT + 1) * profilers.len();
    let mut named = names(profilers);
    named.extend(profilers.iter().map(|p| format!("{} ly", p.name)));
    let angles = profilers
        .iter()
        .flat_map(|_| ["rad", "rad", "rad", "m", "m"]);
    Ok(RailTrial {
        names: named,
        units: angles.chain(profilers.iter().map(|_| "m")).collect(),
        reference: by_reference.map(|found| errors(found.iter().map(|r| &r.mounting).collect())),
        joint: usable.map(|j| {
            let covariance = j.solution.cofactor.view((0, 0), (count, count));
            (
                errors(j.mountings.iter().collect()),
                covariance.into_owned(),
            )
        }),
        variance_factor: usable.map(|j| j.quality.global.variance_factor),
        refusal: outcome.refusal.as_ref().map(ToString::to_string),
        reference_refusal: match &outcome.reference {
            Some(Err(error)) => Some(error.to_string()),
            _ => None,
        },
    })
}
