//! Survey and scenario files.

pub mod scenario;
pub mod write;

pub use scenario::{ScenarioError, ScenarioFile};
pub use write::write_survey;
