//! The rail calibration: several 2-D laser profilers and an INS on a measuring beam over a standard rail, on a two-axis table.
//!
//! | module | what |
//! |---|---|
//! | [`alternatives`] | signs, units, order: discrete mistakes |
//! | [`config`] | the `[reference]` and `[joint]` sections |
//! | [`observed`] | what the instruments say |
//! | [`formats`] | the files that only this procedure reads |
//! | [`profile`] | standard rails and their curves |
//! | [`scene`] | points and attitudes sorted by the table's positions |
//! | [`icp`] | coarse fit of a profile to the standard profile |
//! | [`reference`](mod@reference) | the patent's path (CN114162169A) |
//! | [`model`] | the unknowns and the cut of a light plane through the extruded rail |
//! | [`conditions`] | conditions with their derivatives |
//! | [`joint`] | the adjustment in rounds of association |
//! | [`trials`] | a scenario on trial, for the error budget |
//! | [`verdict`] | what the data do not determine, in words |
//! | [`procedure`] | the calibration behind the seam |
//! | [`run`] | both paths in memory |
//! | [`summary`] | the outcome as plain data |
//! | [`trial`] | simulate and calibrate one seed, for Monte Carlo and budgets |

pub mod alternatives;
pub mod conditions;
pub mod config;
pub mod doubts;
pub mod formats;
pub mod icp;
pub mod joint;
pub mod judge;
pub mod model;
pub mod observed;
pub mod procedure;
pub mod profile;
pub mod reference;
pub mod run;
pub mod scene;
pub mod simulate;
pub mod summary;
pub mod survey;
pub mod trial;
pub mod trials;
pub mod verdict;

pub use config::{RailJointConfig, RailReferenceConfig};
pub use observed::RailCampaign;
pub use profile::RailProfile;
pub use run::{RailInput, RailOutcome, calibrate};
pub use scene::RailScene;
