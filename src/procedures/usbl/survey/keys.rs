//! The keys of a USBL survey file, with their limits.

use crate::survey::limits::{ABOVE, Limits, limits};

pub(crate) const SIGMA_M: Limits = limits(ABOVE, 100.0, "metres above 0 and up to 100");
pub(crate) const SIGMA_DEG: Limits = limits(ABOVE, 30.0, "degrees above 0 and up to 30");
pub(crate) const SIGMA_DEG_OR_NONE: Limits = limits(0.0, 30.0, "degrees from 0 to 30");
