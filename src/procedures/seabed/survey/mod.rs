//! Files of a seabed calibration: the survey file and everything that it names in memory, the scenario, a simulated survey written.

pub mod file;
pub mod load;
pub mod scenario;
pub mod write;

pub use file::SeabedSurveyFile;
pub use load::{LoadedSeabed, load, parse_survey};
pub use scenario::{DEMO, SeabedScenario, parse_scenario};
