//! From points to ties: which face of the target a point lies on.
//!
//! [`Patches`] holds the faces that one sensor can see, behind a k-d tree of samples; [`mod@register`] finds where
//! the points belong from a rough start; [`Patches::assign`] ties single points, or says why not.

pub mod patches;
pub mod register;

pub use patches::{Attraction, Gate, Patches, Spread, Verdict, Water};
pub use register::{Movable, Registration, Response, Sight, register, responses, score};
