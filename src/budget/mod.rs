//! Error budgets: which error source costs how much of which parameter, by which path, and what survey would do better.
//!
//! | file | what |
//! |---|---|
//! | [`swath`] | what a calibration's covariance means for a sounding, against IHO S-44 |
//! | [`plan`], [`passes`] | which pass to sail next, and how many |

pub mod passes;
pub mod plan;
pub mod swath;
