//! Reports: a result as text for the terminal, as `result.json` and as a self-contained `report.html` with pictures.
//!
//! Recomputes nothing: what is shown stands in [`PoolResult`](crate::results::PoolResult) or in
//! [`ReportSamples`](crate::results::ReportSamples).

pub mod any;
pub mod budget;
pub mod conventions;
pub mod html;
pub mod json;
pub mod named_budget;
pub mod plan;
pub mod rail;
pub mod text;
pub mod usbl;

mod budget_headline;
mod files;
mod format;
mod headline;

pub use budget::{WrittenBudget, write_budget};
pub use budget_headline::headline as budget_headline;
pub use files::{ReportError, Written, write_all};
pub use headline::{SIGNIFICANCE, headline};
pub use named_budget::{WrittenNamedBudget, write_named_budget};
pub use plan::{WrittenPlan, write_plan};
pub use rail::write_rail;
pub use usbl::write_usbl;
