//! What every calibration has in common: the seam, what is chosen, how figures are judged and shown.

pub mod choices;
pub mod metric;
pub mod quality;
pub mod seam;
pub mod tried;
pub mod verdict;
