//! Pool calibration (patent CN105425246B): boresight and lever arm of a multibeam against a target that a scanner sees too.

pub mod config;
pub mod scene;
pub mod sequential;

pub use config::{JointConfig, SequentialConfig};
pub use scene::Scene;
pub mod conditions;
pub mod joint;
pub mod planes;
pub mod ties;
