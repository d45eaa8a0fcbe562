//! Files of a seabed calibration: the survey file and everything that it names in memory, the scenario, a simulated survey written.

mod casts;
pub mod export;
mod external;
pub mod file;
mod filled;
pub mod from_files;
mod heads;
pub mod load;
mod recorded;
pub mod scenario;
mod tide;
mod white;
pub mod write;

pub use file::SeabedSurveyFile;
pub use load::{LoadedSeabed, load, parse_survey};
pub use scenario::{DEMO, SeabedScenario, TwoArrays, parse_scenario};
