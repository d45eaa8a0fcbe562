//! Boresight angles and lever arms of survey sensors by least-squares adjustment, with an uncertainty that is true.
//!
//! Data flows one way: files → observations → georeferencing → planes and ties → adjustment → results → report.
//! A module imports only from floors below its own (`tests/layers.rs` holds the table).

pub mod adjust;
pub mod calibrate;
pub mod cli;
pub mod formats;
pub mod geometry;
pub mod georef;
pub mod matching;
pub mod observe;
pub mod report;
pub mod results;
pub mod simulate;
pub mod stats;
pub mod survey;
pub mod target;
pub mod units;

/// The code in `docs/` compiles and runs as tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/conventions.md")]
pub struct DocsPages;
