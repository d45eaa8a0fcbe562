//! Information of one pass of a scenario, from an error-free simulation of it; what a scenario's own passes promise.

use nalgebra::Matrix6;
use rayon::prelude::*;
use thiserror::Error;

use super::fusion::Fusion;
use crate::adjust::AdjustError;
use crate::procedures::pool::joint::Information;
use crate::procedures::pool::{DesignedPass, JointConfig, PoolError};
use crate::simulate::scenario::{Disturbance, Pass};
use crate::simulate::{Scenario, SimulateError, Sources, simulate};

/// Why a pass tells nothing.
#[derive(Debug, Error)]
pub enum PassError {
    /// It cannot be simulated.
    #[error("{0}")]
    Simulate(#[from] SimulateError),
    /// One of the sensors does not see the target.
    #[error(
        "{soundings} soundings and {returns} laser returns would lie on the target, at least {LEAST} of both are needed: it is out of \
         range, or the boat turns its other side to it"
    )]
    Unseen {
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

/// A pass and when it begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// The pass.
    pub pass: Pass,
    /// Begin after the scenario's begin, seconds: the phase of the boat's motion.
    pub begin_s: f64,
}

/// The scenario's own passes at their times.
#[must_use]
pub fn own_passes(scenario: &Scenario) -> Vec<Timed> {
    let mut end_s = 0.0;
    let timed = |(k, pass): (usize, &Pass)| {
        let begin_s = if k > 0 { end_s + pass.gap_s } else { 0.0 };
        end_s = begin_s + (pass.to_m - pass.from_m).abs() / pass.speed_m_s;
        Timed {
            pass: pass.clone(),
            begin_s,
        }
    };
    scenario.pass.iter().enumerate().map(timed).collect()
}

/// Information of a pass sailed in `scenario`, on all parameters that passes share.
///
/// # Errors
/// [`PassError`] when the pass cannot be simulated, or when one of the sensors does not see the target from it.
pub fn information_of(
    scenario: &Scenario,
    timed: &Timed,
    config: &JointConfig,
) -> Result<Information, PassError> {
    let alone = error_free(scenario, timed);
    let survey = simulate(&alone, alone.seed)?;
    let designed = DesignedPass {
        campaign: &survey.campaign,
        target: &survey.target,
        pose: &survey.prior,
        mounting: survey.reality.sonar,
    };
    let unseen = |soundings, returns| PassError::Unseen { soundings, returns };
    let information = match designed.information(config)? {
        Err(AdjustError::TooFew { .. }) => return Err(unseen(0, 0)),
        told => told?,
    };
    if information.soundings < LEAST || information.returns < LEAST {
        return Err(unseen(information.soundings, information.returns));
    }
    Ok(information)
}

/// Information of several passes in their order, on all cores.
#[must_use]
pub fn information_of_all(
    scenario: &Scenario,
    passes: &[Timed],
    config: &JointConfig,
    progress: &(dyn Fn() + Sync),
) -> Vec<Result<Information, PassError>> {
    let one = |pass| {
        let information = information_of(scenario, pass, config);
        progress();
        information
    };
    passes.par_iter().map(one).collect()
}

/// Covariance of the six parameters (rad, m) that a scenario's own passes promise, each taken as independent of the others but for
/// what they share.
///
/// # Errors
/// [`PassError`] of the first pass that tells nothing.
pub fn predicted(scenario: &Scenario, config: &JointConfig) -> Result<Matrix6<f64>, PassError> {
    let mut sum = Fusion::default();
    for information in information_of_all(scenario, &own_passes(scenario), config, &|| {}) {
        sum.add(&information?);
    }
    Ok(sum.covariance())
}

/// The scenario with this pass only, nothing going wrong, and the target where the survey says.
fn error_free(scenario: &Scenario, timed: &Timed) -> Scenario {
    let mut alone = scenario.clone();
    alone.pass = vec![timed.pass.clone()];
    let m = &mut alone.motion;
    let all = [
        &mut m.sway,
        &mut m.surge,
        &mut m.height,
        &mut m.roll,
        &mut m.pitch,
        &mut m.heading,
    ];
    for wave in all.into_iter().flat_map(|o| &mut o.wave) {
        let turned = wave.phase_deg + 360.0 * timed.begin_s / wave.period_s;
        wave.phase_deg = (turned + 180.0).rem_euclid(360.0) - 180.0;
    }
    alone.sources = Sources::none();
    alone.disturbance = Disturbance::default();
    alone.target.prior_offset_m = [0.0; 3];
    alone.target.prior_turn_deg = 0.0;
    alone
}
