//! Error budgets: which error source costs how much of which parameter, by which path, and what survey would do better.
//!
//! | file | what |
//! |---|---|
//! | [`sources`] | the error sources in words, which of them act, each alone |
//! | [`analytic`] | the budget by propagation, without a trial |
//! | [`influence`] | from an error source to the parameters, through the pulls of one path |
//! | [`records`] | errors of trajectory records, white and drifting |
//! | `propagate` | every source of a scenario |
//! | [`predicted`] | the analytic figures in the result, compared with the trials |
//! | [`trial`] | one trial without files |
//! | [`ledger`] | the file of trials |
//! | [`experiment`] | which trials are run, on all cores, interrupted and gone on with |
//! | [`statistics`] | what the trials say of each path |
//! | [`interaction`] | what the sources do to each other |
//! | [`sweep`] | one or two scenario values over ranges |
//! | [`summary`] | the trials as `result.json` |
//! | [`swath`] | what a calibration's covariance means for a sounding, against IHO S-44 |
//! | [`soundings`] | the same for a scenario's sensors, as a section of `result.json` |
//! | [`named`] | the budget of a procedure whose parameters are named (USBL, rail) |
//! | [`plan`], [`passes`], [`fusion`] | which pass to sail next, and how many |
//! | [`planned`] | the plan as `plan.json` |

pub mod analytic;
pub mod experiment;
pub mod fusion;
pub mod influence;
pub mod interaction;
pub mod ledger;
pub mod named;
pub mod passes;
pub mod plan;
pub mod planned;
pub mod predicted;
mod propagate;
pub mod records;
pub mod soundings;
pub mod sources;
pub mod statistics;
pub mod summary;
pub mod swath;
pub mod sweep;
pub mod trial;
