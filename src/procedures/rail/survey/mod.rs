//! Survey and scenario files of the rail procedure.

pub mod file;
pub(crate) mod keys;
pub mod load;
pub mod scenario;
pub mod write;

pub use file::RailSurveyFile;
pub use load::{LoadedRail, load};
pub use scenario::{RailScenarioFile, read_scenario};
pub use write::write_rail;
