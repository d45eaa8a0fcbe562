//! The one place where the georeferencing equation stands: `X = p(t) + R_b^t(t) [ R u + l ]` (patent \[0034\]).

pub mod beam;
pub mod effects;
pub mod eigenray;
pub mod equation;
pub mod localise;
pub mod rays;
pub mod refraction;
pub mod two_arrays;

pub use beam::{Beam, BeamPartials};
pub use eigenray::{Eigenray, Medium};
pub use equation::{NormalPartials, along_normal, georeference};
pub use localise::{Localised, local_trajectory};
pub use rays::{Layers, RayEnd, RayError};
pub use refraction::{Launch, Water};
pub use two_arrays::{ArrayAim, ArrayPair, ConePartials};

/// Compiles the code of the method page.
#[cfg(doctest)]
#[doc = include_str!("../../docs/georeferencing.md")]
struct MethodPage;
