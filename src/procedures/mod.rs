//! Calibration procedures: each a folder, and a line in [`ALL`].
//!
//! A procedure knows its instruments, their conditions and its reference path. Everything that is not special to an instrument is on
//! the floors below, and whoever works with procedures does so through [`calibrate::seam`](crate::calibrate::seam).

pub mod pool;
pub mod rail;
pub mod seabed;
pub mod usbl;

mod named;

pub use named::{find, formats, is_survey, names, of_file, of_text, read, scenario, scenario_text};
pub use pool::calibrate_arrays;

use crate::calibrate::seam::Procedure;

/// Every procedure; the only list of them.
pub static ALL: &[&dyn Procedure] = &[
    &pool::procedure::Pool,
    &usbl::procedure::Usbl,
    &rail::procedure::Rail,
    &seabed::procedure::SeabedProcedure,
];
