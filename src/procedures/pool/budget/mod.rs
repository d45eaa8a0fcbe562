//! What the error budget knows of a pool besides its trials: every source through the derivatives of both paths, the swath, the plan.
//!
//! | file | what |
//! |---|---|
//! | [`trials`] | a scenario on trial, a survey as it was observed |
//! | [`sources`] | the error sources in words, which of them act, each alone |
//! | [`analytic`] | the budget by propagation, without a trial |
//! | [`influence`] | from an error source to the parameters, through the pulls of one path |
//! | [`records`] | errors of trajectory records, white and drifting |
//! | `propagate` | every source of a scenario |
//! | [`swath`] | what a calibration's covariance means for a sounding, against IHO S-44 |
//! | [`soundings`] | the same for a scenario's sensors, as a section of `result.json` |
//! | [`plan`], [`passes`], [`fusion`] | which pass to sail next, and how many |
//! | [`sailed`] | a survey that was sailed as a scenario to plan on |
//! | [`planned`] | the plan as `plan.json` |

pub mod analytic;
pub mod fusion;
pub mod influence;
pub mod passes;
pub mod plan;
pub mod planned;
pub(super) mod planner;
mod propagate;
pub mod records;
pub mod sailed;
pub mod soundings;
pub mod sources;
pub mod swath;
pub mod trials;
