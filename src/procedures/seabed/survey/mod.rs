//! A seabed survey file: its keys, its types, and everything that it names in memory.

pub mod file;
mod keys;
pub mod load;

pub use file::SeabedSurveyFile;
pub use keys::SURVEY;
pub use load::{LoadedSeabed, load, parse_survey};
