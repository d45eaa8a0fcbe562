//! Calibration procedures: each builds conditions and hands them to the adjustment.

pub mod choices;
pub mod conventions;
pub mod metric;
pub mod quality;
pub mod solution;
pub mod truth;
