//! What recorder files are good for: put together, told in words, and held against the sounder's own solution.
//!
//! | file | what |
//! |---|---|
//! | [`collect`] | all streams of a file in columns |
//! | [`observed`], [`navigation`](mod@navigation) | several files as soundings and one trajectory, for a calibration |
//! | [`info`] | what a file holds and what a calibration would still need |
//! | [`recording`] | streams written as a recorder writes them |
//! | [`own_solution`] | our georeferencing with the installation values against the sounder's own points |

pub mod collect;
pub mod info;
pub mod navigation;
pub mod observed;
pub mod own_solution;
pub mod recording;

pub use collect::Recorded;
pub use navigation::{Fixes, Heights, Navigation, navigation};
pub use observed::Observed;
pub use own_solution::{Agreement, Choice, against_own_solution};
