//! Survey and scenario files of a USBL calibration.

pub mod file;
pub(crate) mod keys;
pub mod load;
pub mod scenario;
pub mod write;

pub use file::UsblFile;
pub use load::{LoadedUsbl, load};
pub use scenario::UsblScenarioFile;
pub use write::write_survey;
