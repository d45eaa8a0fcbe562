//! Information of one pass of a scenario, from an error-free simulation of it.

use thiserror::Error;

use crate::adjust::AdjustError;
use crate::calibrate::pool::joint::Information;
use crate::calibrate::pool::{DesignedPass, JointConfig, PoolError};
use crate::simulate::scenario::Pass;
use crate::simulate::{Scenario, SimulateError, Sources, simulate};

/// Why a pass tells nothing.
#[derive(Debug, Error)]
pub enum PassError {
    /// It cannot be simulated.
    #[error("{0}")]
    Simulate(#[from] SimulateError),
    /// One of the sensors does not see the target.
    #[error(
        "pass at {distance_m} m from {from_m} m to {to_m} m: {soundings} soundings and {returns} laser returns lie on the target; both are needed"
    )]
    Unseen {
        /// Distance from the wall.
        distance_m: f64,
        /// Begin of the pass along Y.
        from_m: f64,
        /// Its end.
        to_m: f64,
        /// Tied soundings.
        soundings: usize,
        /// Tied returns.
        returns: usize,
    },
    /// It cannot be calibrated with.
    #[error("{0}")]
    Calibrate(#[from] PoolError),
    /// The engine refused it.
    #[error("adjustment: {0}")]
    Adjust(#[from] AdjustError),
}

/// Fewest soundings, and returns, of a pass that tells anything.
const LEAST: usize = 30;

/// Information of `pass` sailed in `scenario`, on all parameters that passes share.
///
/// # Errors
/// [`PassError`] when the pass cannot be simulated, or when one of the sensors does not see the target from it.
pub fn information_of(scenario: &Scenario, pass: &Pass) -> Result<Information, PassError> {
    let alone = error_free(scenario, pass);
    let survey = simulate(&alone, alone.seed)?;
    let designed = DesignedPass {
        campaign: &survey.campaign,
        target: &survey.target,
        pose: &survey.prior,
        mounting: survey.reality.sonar,
    };
    let information = designed.information(&JointConfig::default())??;
    if information.soundings < LEAST || information.returns < LEAST {
        return Err(PassError::Unseen {
            distance_m: pass.distance_m,
            from_m: pass.from_m,
            to_m: pass.to_m,
            soundings: information.soundings,
            returns: information.returns,
        });
    }
    Ok(information)
}

/// The scenario with this pass only, nothing going wrong, and the target where the survey says.
fn error_free(scenario: &Scenario, pass: &Pass) -> Scenario {
    let mut alone = scenario.clone();
    alone.pass = vec![pass.clone()];
    alone.sources = Sources::none();
    alone.disturbance = crate::simulate::scenario::Disturbance::default();
    alone.target.prior_offset_m = [0.0; 3];
    alone.target.prior_turn_deg = 0.0;
    alone
}
