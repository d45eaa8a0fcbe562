//! Error budgets: which error source costs how much of which parameter, by which path, and what survey would do better.
//!
//! | file | what |
//! |---|---|
//! | [`sources`] | the error sources in words, which of them act, each alone |
//! | [`trial`] | one trial without files |
//! | [`ledger`] | the file of trials |
//! | [`experiment`] | which trials are run, on all cores, interrupted and gone on with |
//! | [`statistics`] | what the trials say of each path |
//! | [`interaction`] | what the sources do to each other |
//! | [`sweep`] | one or two scenario values over ranges |
//! | [`summary`] | the trials as `result.json` |
//! | [`swath`] | what a calibration's covariance means for a sounding, against IHO S-44 |
//! | [`plan`], [`passes`] | which pass to sail next, and how many |

pub mod experiment;
pub mod interaction;
pub mod ledger;
pub mod passes;
pub mod plan;
pub mod sources;
pub mod statistics;
pub mod summary;
pub mod swath;
pub mod sweep;
pub mod trial;
