//! LAS and LAZ point clouds with GPS time.
//!
//! The header is checked against the file's size in [`raw`] before anything is decoded, so that a truncated file gives a
//! message and not a surprise half-way through. Times are taken as they stand: GPS week seconds or adjusted standard time.

mod layers;
pub mod raw;
mod read;
pub mod stream;
pub mod wkt;
mod write;

pub use read::{read, read_from};
pub use write::{PointColumns, write, write_columns, write_to};
