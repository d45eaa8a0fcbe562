//! Pool calibration (patent CN105425246B): boresight and lever arm of a multibeam against a target that a scanner sees too.
//!
//! | file | what |
//! |---|---|
//! | [`procedure`] | the calibration behind the seam |
//! | [`run`] | the whole in memory: [`run::calibrate`] |
//! | [`scene`] | trajectory, refined target pose, rough mounting |
//! | `arrays` | soundings of a transmit and a receive array |
//! | [`frame`] | how the refined pose follows each laser point |
//! | `poses` | poses at the observations, kept while they are few |
//! | [`ties`], `tie_set`, [`planes`] | which point lies on which face, two bytes a row; the scanner's planes |
//! | [`rows`] | chosen rows, one bit each |
//! | [`sequential`] | the reference path |
//! | [`joint`], [`conditions`] | the joint path |
//! | [`coverage`] | what the faces' directions determine |
//! | [`verdict`] | when there is no usable result |
//! | `alternatives` | which discrete mistake turns a misfit into a fit |
//! | [`judge`], [`doubts`] | what speaks against a solution |
//! | [`influence`] | first derivatives of both paths by every observation's error |
//! | [`summary`] | the outcome as `result.json` and as samples for pictures |
//! | [`survey`] | survey and scenario files |
//! | [`apply`] | all points of a survey under a calibration |
//! | [`preview`] | what a survey will determine, before anything is solved |
//! | [`budget`] | its error sources: trials, propagation, swath, plan |
//! | `doors` | [`calibrate_arrays`] |
//! | [`designed`] | what a pass would tell whose mounting and target are known |

mod alternatives;
pub mod apply;
mod arrays;
pub mod budget;
mod check;
pub mod conditions;
pub mod config;
pub mod coverage;
pub mod designed;
mod doors;
pub mod doubts;
pub mod frame;
pub mod influence;
pub mod joint;
pub mod judge;
pub mod planes;
mod poses;
pub mod preview;
pub mod procedure;
pub mod rows;
pub mod run;
pub mod scene;
pub mod sequential;
pub mod summary;
pub mod survey;
mod tie_set;
pub mod ties;
pub mod verdict;

pub use config::{JointConfig, SequentialConfig};
pub use designed::DesignedPass;
pub use doors::calibrate_arrays;
pub use run::{
    Method, PoolError, PoolInput, PoolOutcome, calibrate, calibrate_with, calibrate_with_true_ties,
};
pub use scene::Scene;
