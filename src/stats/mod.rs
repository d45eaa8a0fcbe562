//! Distributions, robust scale, and seeded random streams.

pub mod chi_square;
pub mod moments;
pub mod normal;
pub mod robust;
pub mod streams;

pub use chi_square::ChiSquare;
pub use moments::Moments;
pub use normal::normal_means;
pub use robust::{mad_sigma, median};
pub use streams::stream;
