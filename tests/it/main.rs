//! The integration tests, one binary: `cargo test --release --test it NAME` runs the tests of one file.

#![allow(
    clippy::disallowed_methods,
    reason = "no result of the program hangs on these"
)]
#![allow(clippy::unwrap_used)]

mod bad_input;
mod browser;
#[cfg(feature = "cli")]
mod budget;
mod budget_analytic;
#[cfg(feature = "cli")]
mod budget_named;
mod budget_pages;
#[cfg(feature = "cli")]
mod cases;
#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
mod common;
#[cfg(feature = "cli")]
mod compare;
mod coordinates;
mod dependencies;
mod extras;
mod extras_seabed;
mod foreign_bytes;
mod formats;
#[cfg(feature = "cli")]
mod hostile;
mod joint_derivatives;
mod large;
mod layers;
mod laz;
#[cfg(feature = "cli")]
mod mistakes_named;
mod nist;
mod patent_signs;
#[cfg(feature = "cli")]
mod plan;
mod pool_calibration;
mod proj;
mod rail;
#[cfg(feature = "cli")]
mod rail_cli;
#[cfg(feature = "cli")]
mod rail_parquet;
mod ransac;
mod rays;
mod recorders_mutants;
#[cfg(feature = "cli")]
mod recorders_pool;
mod recorders_pool_others;
mod recorders_real;
#[cfg(feature = "cli")]
mod recorders_survey;
mod report;
mod scenarios;
#[cfg(feature = "cli")]
mod seabed;
#[cfg(feature = "cli")]
mod seabed_dual;
mod seabed_tide;
#[cfg(feature = "cli")]
mod seam;
mod sequential_path;
mod shape;
mod simulate;
mod simulate_rays;
mod spheres;
mod stopping;
mod survey_files;
mod template;
#[cfg(feature = "cli")]
mod tutorials;
mod usbl;
#[cfg(feature = "cli")]
mod usbl_cli;
mod usbl_real;
#[cfg(feature = "cli")]
mod verdict;
mod verdict_usbl_rail;
#[cfg(feature = "cli")]
mod wanted;
mod week;
mod width;
