//! What simulated observations truly struck: the answer that an association of points with faces is judged by.

/// Mark of an observation that is none of a face: gross error, clutter, late echo, or another surface.
pub const NO_FACE: u16 = u16::MAX;

/// Face of the target that each observation truly struck, by its index in the design, or [`NO_FACE`]; in the order of the observations.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Struck {
    /// By the laser returns.
    pub returns: Vec<u16>,
    /// By the soundings.
    pub soundings: Vec<u16>,
}
