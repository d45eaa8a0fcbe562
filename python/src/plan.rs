//! Which pass to sail next.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use boresight::InputError;
use boresight::procedures::pool::JointConfig;
use boresight::procedures::pool::budget::plan::{PlanRequest, candidates};
use boresight::procedures::pool::budget::planned::planned;
use boresight::procedures::pool::survey::scenario;
use boresight::report::plan as pages;
use boresight::results::PlanCriterion;
use boresight::simulate::Scenario;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::errors::Failure;
use super::work::run;

/// Plans on a pool scenario, its passes counting as sailed unless told otherwise; the bytes of `plan.json`. `wanted` is in radians and
/// metres.
#[pyfunction]
#[pyo3(signature = (file, text, wanted, distances_m, speeds_m_s, crabs_deg, both_directions, from_scratch, smallest, most, progress=None))]
#[expect(clippy::too_many_arguments, reason = "the package gives them by name")]
pub fn plan<'py>(
    py: Python<'py>,
    file: PathBuf,
    text: Option<String>,
    wanted: [f64; 6],
    distances_m: Vec<f64>,
    speeds_m_s: Vec<f64>,
    crabs_deg: Vec<f64>,
    both_directions: bool,
    from_scratch: bool,
    smallest: &str,
    most: usize,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let request = PlanRequest {
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
    };
    let bytes = run(py, None, progress, move |caller| {
        let (scenario, config) = read(&file, text.as_deref())?;
        let request = request.widened(&scenario);
        let of = candidates(&scenario, &request).len() as u64;
        let done = AtomicU64::new(0);
        let count = || caller.count("planning", done.fetch_add(1, SeqCst) + 1, of);
        let result = planned(&scenario, &request, &[], &config, &count);
        let result = result.map_err(InputError::unworkable)?;
        Ok(pages::to_bytes(&result)?)
    })?;
    Ok(PyBytes::new(py, &bytes))
}

fn read(file: &Path, text: Option<&str>) -> Result<(Scenario, JointConfig), Failure> {
    let procedure = boresight::procedures::of_file(file);
    if let (None, Ok(procedure)) = (text, procedure)
        && procedure.name() != "pool"
    {
        let text = format!(
            "plan: found a {} scenario, expected a pool scenario",
            procedure.name()
        );
        return Err(Failure::Refused(text));
    }
    let read = match text {
        Some(text) => scenario::beside(file, text)?,
        None => scenario::read(file)?,
    };
    let joint = read.calibration(file)?.joint;
    Ok((read.scenario, joint))
}
