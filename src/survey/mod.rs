//! Survey files: read, checked as a whole, and composed into what the floors below need.
//!
//! [`load`] reads a survey file and every file that it names. All faults of the survey file are listed at once, each with its
//! line, what was found and what was expected; unknown keys come with the nearest known one. Nothing is repaired.
//!
//! [`schema`] and [`document`] know no key: a scenario file is checked by them with tables of its own.

pub mod claims;
pub mod clock;
pub mod document;
pub mod file;
mod keys;
pub(crate) mod load;
mod observations;
pub mod problem;
mod procedure;
pub(crate) mod rules;
pub mod scenario;
pub mod schema;
pub mod write;

pub use file::SurveyFile;
pub use load::{Counts, LoadedSurvey, load, parse_survey, parse_target, read_survey_file};
pub use problem::{Problem, SurveyError};
pub use procedure::is_survey;
pub use scenario::{ScenarioError, ScenarioFile};
pub use write::write_survey;
