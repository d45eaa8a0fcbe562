//! The result of any procedure with what its pictures are drawn from.

use super::{PoolResult, RailResult, RailSamples, ReportSamples, UsblResult, UsblSamples};

/// One of the procedures' results.
#[derive(Clone, Debug)]
pub enum AnyResult {
    /// Of a pool calibration.
    Pool(Box<PoolResult>, Box<ReportSamples>),
    /// Of a USBL calibration.
    Usbl(Box<UsblResult>, Box<UsblSamples>),
    /// Of a rail calibration.
    Rail(Box<RailResult>, Box<RailSamples>),
}

impl AnyResult {
    /// Whether the deciding solution may be used.
    #[must_use]
    pub fn usable(&self) -> bool {
        match self {
            Self::Pool(result, _) => result.usable,
            Self::Usbl(result, _) => result.usable,
            Self::Rail(result, _) => result.usable,
        }
    }
}
