//! LAS and LAZ point clouds with GPS time.
//!
//! The header is checked against the file's size in [`raw`] before anything is decoded, so that a truncated file gives a
//! message and not a surprise half-way through; LAZ is decoded in [`laz`]. Times are taken as they stand: GPS week seconds or
//! adjusted standard time. Points that are not in order of time are sorted, repeated ones kept once, both with a note.

pub mod compression;
pub mod laz;
pub mod raw;
mod read;
pub mod stream;
pub mod wkt;
mod write;

pub use read::{read, read_from, read_untimed};
pub use write::{PointColumns, write, write_columns, write_to};
