//! Boresight angles and lever arms of survey sensors by least-squares adjustment, with standard deviations that hold.
//!
//! ```
//! use boresight::procedures::pool::{JointConfig, Method, PoolInput, SequentialConfig, calibrate};
//! use boresight::simulate::{DEMO, Scenario, simulate};
//!
//! let mut scenario = Scenario::from_toml(DEMO)?;
//! (scenario.multibeam.beams, scenario.lidar.points_per_line) = (64, 100); // thinned, to be quick
//! let survey = simulate(&scenario, 1)?;
//! let (sequential, joint) = (SequentialConfig::default(), JointConfig::default());
//! let (campaign, target, prior) = (&survey.campaign, &survey.target, &survey.prior);
//! let (method, seed, extras) = (Method::Both, 1, &[][..]);
//! let input = PoolInput { campaign, target, prior, method, sequential: &sequential, joint: &joint, seed, extras };
//! let found = calibrate(&input, &|step: &str| eprintln!("{step}"))?.joint.ok_or("refused")?;
//! let (lever_arm_m, sigma) = (found.mounting.lever_arm_m, found.covariance.diagonal().map(f64::sqrt));
//! println!("forward lever arm {:.4} m, one sigma {:.4} m", lever_arm_m.y, sigma[4]);
//! # assert!((lever_arm_m - survey.truth.lever_arm()).norm() < 0.02 && sigma[4] < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Data flows one way: files → observations → georeferencing → planes and ties → adjustment → results → report.
//! A module imports only from floors below its own (`tests/it/layers.rs` holds the table).

pub mod adjust;
pub mod budget;
pub mod calibrate;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod doors;
pub mod files;
pub mod formats;
pub mod geometry;
pub mod georef;
pub mod matching;
pub mod math;
pub mod observe;
pub mod procedures;
pub mod recorders;
pub mod report;
pub mod results;
pub mod ruled;
pub mod simulate;
pub mod stats;
pub mod survey;
pub mod target;
pub mod units;
pub mod watch;

pub use calibrate::seam::{
    Checked, Finished, InputError, Loaded, Procedure, ScenarioRun, Settings, Simulated,
};
pub use doors::{calibrate, calibrate_with, check, simulate};
/// The linear algebra of every matrix and vector in this library's signatures.
pub use nalgebra;
pub use procedures::calibrate_arrays;

/// What a program that calibrates from arrays needs.
pub mod prelude {
    pub use crate::calibrate::choices::Method;
    pub use crate::calibrate::seam::{Finished, InputError, Settings};
    pub use crate::geometry::ellipsoid::TargetPose;
    pub use crate::geometry::{Ellipsoid, Geodetic};
    pub use crate::observe::{
        Campaign, GeodeticTrajectory, LaserCoordinates, LaserNoise, LaserScan, Mounting,
        MountingSigma, SonarNoise, SoundSpeed, SoundingRange, Soundings, TrajectoryNoise,
    };
    pub use crate::results::{Calibration, Parameter, Solution};
    pub use crate::target::{Target, TargetModel, WallModel};
}

/// The code in README and `docs/` compiles and runs as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/conventions.md")]
pub struct DocsPages;
