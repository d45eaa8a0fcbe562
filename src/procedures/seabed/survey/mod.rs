//! A seabed survey file: its keys, its types, and everything that it names in memory.

pub mod file;
pub mod load;

pub use file::SeabedSurveyFile;
pub use load::{LoadedSeabed, load, parse_survey};
