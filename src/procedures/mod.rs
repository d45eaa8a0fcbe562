//! The procedures: each builds conditions and hands them to the adjustment.

pub mod pool;
pub mod rail;
pub mod seabed;
pub mod usbl;
