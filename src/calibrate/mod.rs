//! Calibration procedures: each builds conditions and hands them to the adjustment.

pub mod choices;
pub mod metric;
pub mod quality;
pub mod verdict;
