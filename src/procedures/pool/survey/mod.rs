//! Survey and scenario files of a pool calibration: read, checked as a whole, and composed into what the floors below need.
//!
//! [`load`](load()) reads a survey file and every file that it names.

pub mod arrays;
pub mod claims;
mod export;
pub mod file;
pub(super) mod from_files;
pub(crate) mod keys;
pub mod large;
pub mod load;
mod observations;
mod recorded;
mod rules;
pub mod scenario;
pub mod write;

pub use arrays::Arrays;
pub use file::SurveyFile;
pub use load::{Counts, LoadedSurvey, load, parse_survey, parse_target, read_survey_file};
pub use scenario::ScenarioFile;
pub use write::write_survey;
