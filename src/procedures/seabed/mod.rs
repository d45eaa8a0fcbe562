//! Multibeam over natural seabed: soundings of overlapping lines, no target, no second sensor (method: `docs/seabed-measured.md`).
//!
//! | part | what it does |
//! |---|---|
//! | [`survey`] | the survey file and everything that it names |
//! | [`scene`], [`parameters`], [`model`], [`states`] | the survey in memory; what is sought of it; from observation to seabed with derivatives; INS drift |
//! | [`screen`], [`tiles`], [`field`], [`reml`] | gross errors; pieces of seabed; collocation; the field's parameters |
//! | [`normal`], [`joint()`] | the adjustment |
//! | [`shared`], [`shares`] | what soundings of one ping have in common; what each source has in the covariance |
//! | [`surface`], `views` | lines against each other in small cells; what the report draws of them |
//! | [`foresight`], `plan`, `sailed` | what a scenario's survey would give, source by source; which line to sail next; a survey that was sailed in a scenario's words |
//! | [`layout`], [`verdict`] | what the lines are good for; what may be used |
//! | [`doubts`] | score tests of what the model has not |
//! | `tides` | does the tide of the survey file fit the heights? |
//! | `alternatives` | signs, order, units: discrete mistakes |
//! | [`simulate`](mod@simulate) | surveys of a known seabed |
//! | [`reference`](mod@reference) | the classical patch test; features matched between lines, and the paper's overall adjustment of them |

mod alternatives;
pub mod apply;
mod cones;
pub mod config;
pub mod doubts;
pub mod field;
pub mod foresight;
pub mod joint;
pub mod layout;
pub mod model;
pub mod normal;
pub mod parameters;
mod plan;
pub mod procedure;
pub mod reference;
pub mod reml;
pub mod run;
mod sailed;
pub mod scene;
pub mod screen;
pub mod shared;
pub mod shares;
pub mod simulate;
pub mod states;
mod summary;
pub mod surface;
pub mod survey;
mod tides;
pub mod tiles;
mod trials;
pub mod verdict;
mod views;

pub use config::{JointSettings, SeabedConfig};
pub use joint::{Joint, JointError, joint};
pub use layout::Layout;
pub use reference::{Patch, Reference, ReferenceConfig, ReferenceError, patch_test};
pub use run::{SeabedInput, SeabedOutcome, calibrate};
pub use scene::Scene;
pub use verdict::{Judgement, judge};
