//! Truth to observations with noise, in memory: what a survey would have recorded, and the answer to it.
//!
//! Rays are cast against the scene; the georeferencing equation and its derivatives are not used here, so that simulator and
//! estimator check each other. Every error source has its own random stream ([`Source`]): switching one off ([`Sources`]) leaves
//! the numbers of all others as they were.
//!
//! ```
//! use boresight::simulate::{Scenario, simulate};
//! let scenario = Scenario::from_toml(boresight::simulate::DEMO)?;
//! let survey = simulate(&scenario, scenario.seed)?;
//! assert!(survey.campaign.soundings.len() > 10_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arrays;
mod check;
pub mod fan;
mod ins;
mod laser;
pub mod motion;
pub mod reality;
pub(crate) mod refraction;
pub mod scenario;
pub mod scene;
mod sectors;
mod sonar;
pub mod sources;
mod spoil;
pub mod switches;
pub mod truth;

pub use reality::Reality;
pub use scenario::Scenario;
pub use sectors::Sectors;
pub use sources::{Source, Sources};
pub use truth::Truth;

use nalgebra::Vector3;
use thiserror::Error;

use crate::geometry::ellipsoid::TargetPose;
use crate::observe::{Campaign, MountingSigma, SoundSpeed, SoundSpeedProfile, Struck};
use crate::target::{Target, TargetError};
use motion::Motion;
use scene::Scene;

/// The scenario of `boresight demo`.
pub const DEMO: &str = include_str!("../../models/scenarios/demo.toml");

/// Time of the first pass's begin, seconds.
pub const START_S: f64 = 1000.0;

/// A simulated survey.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// What was observed, as a calibration gets it.
    pub campaign: Campaign,
    /// The target as designed.
    pub target: Target,
    /// Where the surveyor believes the target to stand.
    pub prior: TargetPose,
    /// The answer.
    pub truth: Truth,
    /// Everything that was drawn once for this survey.
    pub reality: Reality,
    /// The face that each observation struck.
    pub struck: Struck,
}

/// Why a scenario cannot be simulated.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SimulateError {
    /// Impossible values; every fault at once.
    #[error("scenario: {}", faults.join("; "))]
    Scenario {
        /// One sentence each: key, found, expected.
        faults: Vec<String>,
    },
    /// Impossible target.
    #[error("scenario: target.model: {0}")]
    Target(#[from] TargetError),
}

/// Simulates the scenario under a seed; the same seed gives the same survey, whatever the number of threads.
///
/// # Errors
/// [`SimulateError`] with every fault of the scenario.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<Simulated, SimulateError> {
    let faults = scenario.check();
    if !faults.is_empty() {
        return Err(SimulateError::Scenario { faults });
    }
    let target = Target::from_model(&scenario.target.model)?;
    let reality = Reality::draw(scenario, &target, seed);
    let motion = Motion::new(&scenario.motion, &scenario.pass, START_S);
    let below = Scene::new(scenario, &target, &reality.offsets_m, START_S);
    let above = below.without_floor();
    let (laser, returns) = laser::scan(scenario, &reality, &motion, &above, seed);
    let (soundings, struck) = sonar::sound(scenario, &reality, &motion, &below, seed);
    let campaign = Campaign {
        trajectory: ins::record(scenario, &reality, &motion, seed),
        laser,
        soundings,
        scanner: reality.nominal_scanner,
        scanner_sigma: scanner_sigma(scenario),
        sonar: reality.nominal_sonar,
        sound_speed: known_water(scenario),
        water_level_m: scenario.target.water_level_m,
    };
    Ok(Simulated {
        campaign,
        target,
        prior: reality.prior,
        truth: Truth::of(&reality),
        reality,
        struck: Struck {
            returns,
            soundings: struck,
        },
    })
}

/// What the survey says of its scanner's calibration; nothing where the scenario gives no uncertainty.
fn scanner_sigma(scenario: &Scenario) -> Option<MountingSigma> {
    let lidar = &scenario.lidar;
    let rotation_rad = Vector3::from(lidar.mounting_sigma_deg).map(f64::to_radians);
    let lever_arm_m = Vector3::from(lidar.lever_arm_sigma_m);
    (rotation_rad.amax() > 0.0 || lever_arm_m.amax() > 0.0).then_some(MountingSigma {
        rotation_rad,
        lever_arm_m,
    })
}

/// The sound speed as the survey knows it.
fn known_water(scenario: &Scenario) -> Option<SoundSpeed> {
    let water = scenario.sound_speed.as_ref()?;
    if let Some(speed) = water.speed_m_s {
        return Some(SoundSpeed::Constant(speed));
    }
    Some(SoundSpeed::Profile(SoundSpeedProfile {
        depth_m: water.profile.iter().map(|s| s[0]).collect(),
        speed_m_s: water.profile.iter().map(|s| s[1]).collect(),
    }))
}
