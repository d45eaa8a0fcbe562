//! Calibration procedures: each builds conditions and hands them to the adjustment.

pub mod choices;
pub mod metric;
pub mod pool;
pub mod quality;
pub mod rail;
pub mod usbl;
