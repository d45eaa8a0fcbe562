//! Survey files: what every procedure's reader shares. A procedure's own sections are in its folder.
//!
//! All faults of a survey file are listed at once, each with its line, what was found and what was expected; unknown keys come with
//! the nearest known one. Nothing is repaired.
//!
//! [`schema`] and [`document`] know no key: survey and scenario files of every procedure are checked by them with tables of their own.

pub mod clock;
pub(crate) mod decimals;
pub mod document;
pub mod limits;
pub mod problem;
pub(crate) mod procedure;
pub(crate) mod reading;
pub(crate) mod recorded;
pub(crate) mod scenario;
pub mod schema;
pub(crate) mod section;
pub mod sections;
pub mod template;

pub use problem::{Problem, ScenarioError, SurveyError};
pub use procedure::is_survey;

/// Name of the survey file in the folder of a simulated survey.
pub const SURVEY_FILE: &str = "survey.toml";
/// Name of the file with the answer.
pub const TRUTH_FILE: &str = "truth.json";
