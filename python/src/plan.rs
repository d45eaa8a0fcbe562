//! Which pass to sail next.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use boresight::calibrate::planning::PlanAsk;
use boresight::formats::error::read_text;
use boresight::procedures;
use boresight::report::plan as pages;
use boresight::results::PlanCriterion;
use boresight::survey::SurveyError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::errors::Failure;
use super::work::run;

/// Plans on a pool scenario, its passes counting as sailed unless told otherwise; the bytes of `plan.json`. `wanted` is in degrees and
/// millimetres.
#[pyfunction]
#[pyo3(signature = (file, text, wanted, distances_m, speeds_m_s, crabs_deg, both_directions, from_scratch, smallest, most, progress=None))]
#[expect(clippy::too_many_arguments, reason = "the package gives them by name")]
pub fn plan<'py>(
    py: Python<'py>,
    file: PathBuf,
    text: Option<String>,
    wanted: Vec<(String, f64)>,
    distances_m: Vec<f64>,
    speeds_m_s: Vec<f64>,
    crabs_deg: Vec<f64>,
    both_directions: bool,
    from_scratch: bool,
    smallest: &str,
    most: usize,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let ask = PlanAsk {
        distances_m,
        speeds_m_s,
        crabs_deg,
        both_directions,
        keep_passes: !from_scratch,
        criterion: if smallest == "variances" {
            PlanCriterion::A
        } else {
            PlanCriterion::D
        },
        wanted,
        most,
        vary: vec![],
    };
    let bytes = run(py, None, progress, move |caller| {
        let text = match text {
            Some(text) => text,
            None => read_text(&file).map_err(SurveyError::from)?,
        };
        let procedure = procedures::of_text(&file, &text)?;
        let Some(planner) = procedure.planner(&file, &text, &ask)? else {
            return Err(Failure::Refused(format!(
                "plan: found a {} scenario, expected a pool scenario",
                procedure.name()
            )));
        };
        let (of, done) = (planner.surveys() as u64, AtomicU64::new(0));
        let count = || caller.count("planning", done.fetch_add(1, SeqCst) + 1, of);
        Ok(pages::to_bytes(&planner.plan(&count)?)?)
    })?;
    Ok(PyBytes::new(py, &bytes))
}
