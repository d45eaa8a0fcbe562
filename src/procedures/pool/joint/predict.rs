//! What ties promise before anything is solved: one linearisation of the joint adjustment.

use nalgebra::{DMatrix, Matrix6};

use super::super::config::JointConfig;
use super::super::doubts::Passes;
use super::super::scene::Scene;
use super::round::{Frame, options, six_covariance};
use super::unknowns::parameters;
use super::{Epochs, JointStart};
use crate::adjust::{AdjustError, Estimate, Options, ParameterSet, Solution, solve};

/// Covariance of the six parameters (order of [`super::SIX`]; rad, m) that these ties promise at the start, and the number of tied
/// soundings.
///
/// # Errors
/// [`AdjustError`] from the engine.
pub fn predict(
    scene: &Scene,
    start: &JointStart,
    config: &JointConfig,
) -> Result<(Matrix6<f64>, usize), AdjustError> {
    linearised(scene, start, config, |frame, solution, soundings| {
        Ok((six_covariance(&solution, frame.blocks), soundings))
    })
}

/// Information of one pass on every parameter that passes share.
#[derive(Clone, Debug, PartialEq)]
pub struct Information {
    /// Names of the columns; the first six are those of [`super::SIX`].
    pub columns: Vec<String>,
    /// Information of the observations (the trajectory's errors eliminated), without the priors.
    pub observed: DMatrix<f64>,
    /// Information of the priors: scanner mounting, face offsets; they count once however many passes there are.
    pub prior: DMatrix<f64>,
    /// Tied soundings.
    pub soundings: usize,
    /// Tied laser returns.
    pub returns: usize,
}

/// Information that the ties at the start hold: angles in radians, lengths in metres.
///
/// # Errors
/// [`AdjustError`] from the engine.
pub fn information(
    scene: &Scene,
    start: &JointStart,
    config: &JointConfig,
) -> Result<Information, AdjustError> {
    linearised(scene, start, config, |_, solution, soundings| {
        let x = &solution.estimate.parameters;
        let prior = x.prior_information()?;
        Ok(Information {
            columns: x.components().map(|c| c.name.clone()).collect(),
            observed: solution.information() - &prior,
            prior,
            soundings,
            returns: start.returns.len(),
        })
    })
}

/// One linearisation, under least squares, of the soundings tied at the start.
fn linearised<T>(
    scene: &Scene,
    start: &JointStart,
    config: &JointConfig,
    then: impl FnOnce(&Frame, Solution, usize) -> Result<T, AdjustError>,
) -> Result<T, AdjustError> {
    let epochs = Epochs::number(scene, start.returns, start.candidates.iter(), 0.0)?;
    let (parameters, blocks) = parameters(scene, start, config)?;
    let frame = Frame {
        scene,
        start,
        config,
        epochs: &epochs,
        blocks: &blocks,
        workers: None,
    };
    let estimate = Estimate::new(parameters);
    let ties = frame.first_ties();
    let once = Options {
        max_iterations: 1,
        ..options(config)
    };
    let at: ParameterSet = estimate.parameters.clone();
    let passes = Passes::of(scene, &ties.soundings);
    let conditions = frame.conditions(&ties, &at, &passes);
    let solution = solve(&frame.problem(&conditions), estimate, &once)?;
    then(&frame, solution, ties.soundings.len())
}
