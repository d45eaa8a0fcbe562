//! The extension module `boresight._core`: what Python calls of the library. Numbers are made in the library, tables and pages of
//! documentation in the package `boresight`; here is only the border between them.
//!
//! | file | what |
//! |---|---|
//! | `errors` | what ends a call, as the package's exceptions |
//! | `work` | long calls on threads of their own: progress, Ctrl-C, panics |
//! | `arrays` | columns from and to numpy, always copied |
//! | `survey` | surveys from files and from arrays, and what can be done with them |
//! | `blocks` | a pool survey prepared to answer questions about the blocks of its trajectory |
//! | `finished` | a calibration's result |
//! | `campaign` | trials of a scenario, budgets |
//! | `plan` | which pass to sail next |
//! | `adjust` | the engine on conditions that Python evaluates |

mod adjust;
mod arrays;
mod blocks;
mod campaign;
mod errors;
mod finished;
mod plan;
mod survey;
mod work;

use pyo3::prelude::*;

/// Runs the command line on these arguments, the program's name first, and gives its exit code.
#[pyfunction]
fn cli(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| boresight::cli::run_code(arguments))
}

/// The text of a procedure's built-in scenario.
#[pyfunction]
fn demo_scenario(py: Python<'_>, procedure: &str) -> PyResult<String> {
    match boresight::procedures::find(procedure) {
        Some(found) => Ok(found.demo()),
        None => {
            let names = boresight::procedures::names().join(", ");
            let message = format!("procedure: found \"{procedure}\", expected one of {names}");
            Err(errors::input(py, message, vec![]))
        }
    }
}

/// Digest of the arithmetic: machines on which it is equal make equal numbers.
#[pyfunction]
fn numerics() -> &'static str {
    boresight::adjust::fingerprint()
}

#[pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use super::adjust::adjust;
    #[pymodule_export]
    use super::blocks::BlockWorker;
    #[pymodule_export]
    use super::campaign::{Campaign, budget};
    #[pymodule_export]
    use super::finished::Finished;
    #[pymodule_export]
    use super::plan::plan;
    #[pymodule_export]
    use super::survey::{Survey, read_target, simulate};
    #[pymodule_export]
    use super::work::panic_for_tests;
    #[pymodule_export]
    use super::{cli, demo_scenario, numerics};

    /// Version of the library.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
