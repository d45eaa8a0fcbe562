//! Surveys of recorder files: what every procedure that takes them does in the same way.
//!
//! | file | what |
//! |---|---|
//! | [`files`] | which files a survey file names, read together |
//! | [`mounted`] | nominal mountings from the installation record |
//! | [`clock`] | what the times of other files are, and whether they meet the soundings |
//! | [`navigation`] | the trajectory |
//! | [`own_points`] | the check against the sounder's own points |

pub(crate) mod clock;
pub(crate) mod files;
pub(crate) mod mounted;
pub(crate) mod navigation;
pub(crate) mod own_points;
