//! Reports: a result as text for the terminal, as `result.json` and as a self-contained `report.html` with pictures.
//!
//! Recomputes nothing and knows no procedure: what is shown stands in [`Calibration`](crate::results::Calibration) or in
//! [`Page`](crate::results::Page), which holds a procedure's own section.

pub mod budget;
pub mod card;
pub mod change;
pub mod courses;
pub mod csv;
pub mod export;
pub mod html;
pub mod json;
pub mod plan;
pub mod text;
pub mod wanted;

mod budget_headline;
mod files;
mod format;
mod headline;

pub use budget::{WrittenBudget, write_budget};
pub use budget_headline::headline as budget_headline;
pub use export::Export;
pub use files::{ReportError, Written, write_all};
pub use headline::{SIGNIFICANCE, headline};
pub use plan::{WrittenPlan, write_plan};
