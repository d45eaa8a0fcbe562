//! `[reference]`: which reference path runs, and how.

use super::image::Grey;
use super::patch::ORDERS;
use crate::survey::limits::limits;
use crate::survey::schema::Kind;
use crate::survey::section::section;

section! {
    #[settings]
    /// `[reference]`.
    #[derive(Clone, Debug, PartialEq, Eq)]
    pub struct ReferenceConfig {
        /// `patch-test`: the classical patch test. `features`: the paper's path, features of the seabed's images matched between lines.
        method: String = or (METHODS[0].to_owned()), Kind::OneOf(METHODS);
        /// Patch test: the order in which the parameters are found; the first is that of the IHO manual.
        order: String = or (ORDERS[0].to_owned()), Kind::OneOf(ORDERS);
        /// Patch test: how often the whole order is repeated.
        rounds: usize = or (1), Kind::Count(limits(1.0, 10.0, "1 to 10"));
        /// Features: grey levels over the whole range of depths, as the paper has it, or over the relief on it.
        grey: String = or (GREY[0].to_owned()), Kind::OneOf(GREY);
        /// Features: the latency bounded as the paper has it (the position late, never the sounding), or free.
        latency: String = or (LATENCY[0].to_owned()), Kind::OneOf(LATENCY);
    }
}

const METHODS: &[&str] = &["patch-test", "features"];
const GREY: &[&str] = &["relief", "depth"];
pub(super) const LATENCY: &[&str] = &["bounded", "free"];

impl ReferenceConfig {
    /// Whether the paper's path runs.
    #[must_use]
    pub fn by_features(&self) -> bool {
        self.method == METHODS[1]
    }

    /// What the path is called in tables.
    #[must_use]
    pub fn variant(&self) -> &str {
        if self.by_features() {
            METHODS[1]
        } else {
            &self.order
        }
    }

    pub(super) fn grey(&self) -> Grey {
        if self.grey == GREY[0] {
            Grey::Relief
        } else {
            Grey::Depth
        }
    }
}
