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

pub mod experiment;
pub mod interaction;
pub mod ledger;
pub mod sources;
pub mod statistics;
pub mod summary;
pub mod sweep;
pub mod trial;
