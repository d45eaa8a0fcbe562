//! What the readers of recorder files share: records in our frame, framing and resynchronisation, counts of what was lost.
//!
//! A recorder's file gives several streams. A reader hands each record to a [`Sink`] as it comes, so that memory does not grow
//! with the file, and returns a [`Summary`]. It never allocates by a count that it has not held against the bytes at hand.

pub mod bytes;
pub mod out;
pub mod scan;
pub mod summary;
pub mod table;
pub mod types;
pub mod utc;
pub mod window;

pub use bytes::Bytes;
pub use out::Out;
pub use scan::{Frame, Framing, holds, scan};
pub use summary::{Losses, Summary, TimeScale};
pub use types::*;
pub use window::Window;
