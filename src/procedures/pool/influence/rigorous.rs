//! The joint path's influences: its problem built anew on the ties that it ended with, linearised once.

use nalgebra::{DMatrix, Matrix6, Matrix6x3};

use super::super::conditions::{ReturnConditions, SoundingConditions, TrajectoryErrors};
use super::super::config::{Drift, JointConfig, Planes};
use super::super::joint::{Epochs, JointOutcome, RETURNS, SOUNDINGS, options};
use super::super::scene::Scene;
use super::super::ties::{Tie, TieSet, TrajectoryVariance};
use super::{Pull, Pulls};
use crate::adjust::{
    AdjustError, Estimate, Figures, Options, ParameterSet, Problem, Source, figures, influence,
    solve,
};

/// The joint path, linearised.
#[derive(Clone, Debug)]
pub struct JointInfluence {
    /// Pulls of the observations.
    pub pulls: Pulls,
    /// Cofactors of the six parameters with the same weights (rad, m).
    pub covariance: Matrix6<f64>,
}

/// The problem of a joint outcome, built anew on its ties and handed to `then`. `parts[group]` is the share of a condition's
/// weight that counts (soundings, returns), 1 under least squares.
fn with_problem<T>(
    scene: &Scene,
    joint: &JointOutcome,
    config: &JointConfig,
    parts: [f64; 2],
    then: impl FnOnce(&Problem) -> T,
) -> Result<T, AdjustError> {
    let rows = joint.soundings.iter().map(|tie| tie.row);
    let reach_s = if config.latency { 0.5 } else { 0.0 };
    let epochs = Epochs::number(scene, &joint.returns, rows, reach_s)?;
    let as_states = config.drift == Drift::On && epochs.chain.is_some();
    let trajectory = if as_states {
        TrajectoryErrors::States(&epochs.of_record)
    } else {
        let noise = &scene.campaign.trajectory.noise;
        TrajectoryErrors::Variance(TrajectoryVariance::new(noise, false))
    };
    let (blocks, x) = (&joint.blocks, &joint.solution.estimate.parameters);
    let soundings = SoundingConditions {
        scene,
        ties: &joint.soundings,
        planes: &blocks.faces,
        mounting: blocks.mounting,
        latency: blocks.latency,
        range_scale: blocks.range_scale,
        extras: &blocks.extras,
        latency_at_start_s: blocks.latency.map_or(0.0, |id| x.euclidean(id)[0]),
        trajectory,
        group: SOUNDINGS,
        cells: None,
    };
    let returns = ReturnConditions {
        scene,
        ties: &joint.returns,
        planes: &blocks.faces,
        scanner: blocks.scanner,
        trajectory,
        group: RETURNS,
        cells: None,
    };
    let mut sources = vec![Source::new(&soundings)];
    if config.planes == Planes::Adjusted {
        sources.push(Source::new(&returns));
    }
    let mut problem = match &epochs.chain {
        Some(chain) if as_states => Problem::with_chain(sources, chain),
        _ => Problem::dense(sources),
    };
    problem.large = config.large.clone();
    problem.components = parts.map(|part| 1.0 / part).to_vec();
    Ok(then(&problem))
}

/// Residual, sigma, redundancy and normalised residual of every tied sounding and return, in the order of the ties; of returns only where
/// the planes were unknowns. The adjustment is run again on the ties that it ended with.
///
/// # Errors
/// [`AdjustError`] from the engine.
pub fn observations(
    scene: &Scene,
    outcome: &JointOutcome,
    config: &JointConfig,
) -> Result<Vec<Vec<Figures>>, AdjustError> {
    let start = Estimate::new(outcome.solution.estimate.parameters.clone());
    with_problem(scene, outcome, config, [1.0, 1.0], |problem| {
        figures(problem, &solve(problem, start, &options(config))?)
    })?
}

/// Linearises the joint path at its outcome under least squares, with a part of every condition's weight (soundings, returns).
///
/// # Errors
/// [`AdjustError`] from the engine.
pub fn joint(
    scene: &Scene,
    outcome: &JointOutcome,
    config: &JointConfig,
    parts: [f64; 2],
) -> Result<JointInfluence, AdjustError> {
    let start = Estimate::new(outcome.solution.estimate.parameters.clone());
    with_problem(scene, outcome, config, parts, |problem| {
        let solution = solve(problem, start, &Options::default())?;
        let mut found = influence(problem, &solution)?.conditions.into_iter();
        let mut of = |ties: &TieSet| found.next().map_or(vec![], |sought| pulls(ties, &sought));
        Ok(JointInfluence {
            pulls: Pulls {
                soundings: of(&outcome.soundings),
                returns: of(&outcome.returns),
                turns: vec![Matrix6x3::zeros(); scene.target.faces.len()],
            },
            covariance: six(&solution.cofactor),
        })
    })?
}

/// Cofactors of the six parameters from other parameters (priors) and the noise that the scene's campaign states.
///
/// # Errors
/// [`AdjustError`] from the engine.
pub fn cofactor(
    scene: &Scene,
    outcome: &JointOutcome,
    parameters: ParameterSet,
    config: &JointConfig,
) -> Result<Matrix6<f64>, AdjustError> {
    with_problem(scene, outcome, config, [1.0; 2], |problem| {
        let solution = solve(problem, Estimate::new(parameters), &Options::default())?;
        Ok(six(&solution.cofactor))
    })?
}

/// The mounting's columns come first.
fn six(cofactor: &DMatrix<f64>) -> Matrix6<f64> {
    cofactor.fixed_view::<6, 6>(0, 0).into_owned()
}

/// The mounting's six come first among the parameters sought.
fn pulls(ties: &TieSet, sought: &DMatrix<f64>) -> Vec<Pull> {
    let pull = |(k, tie): (usize, Tie)| Pull {
        row: tie.row,
        face: tie.face,
        six: sought.fixed_view::<6, 1>(0, k).into_owned(),
    };
    ties.iter().enumerate().map(pull).collect()
}
