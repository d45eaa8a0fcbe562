//! The reference path: the classical patch test, one parameter after the other on pairs of lines.

pub mod overall;
pub mod patch;

pub use patch::{Patch, PatchConfig, Step, patch_test};
