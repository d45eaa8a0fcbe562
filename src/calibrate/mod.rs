//! What every calibration has in common: the seam, what is chosen, how figures are judged and shown.

pub mod choices;
pub mod cloud;
pub mod compare;
pub mod conventions;
pub mod driver;
pub mod grid;
pub mod large;
pub mod metric;
pub mod planning;
pub mod quality;
pub mod seam;
pub mod solution;
pub mod tried;
pub mod truth;
pub mod vary;
pub mod verdict;
