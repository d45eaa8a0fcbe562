//! Trials of a scenario on this machine or, seeds by seeds, on any; and error budgets.

use std::path::PathBuf;
use std::sync::Arc;

use boresight::budget::experiment::{Ended, Experiment, ledger_of};
use boresight::budget::{self as budgets, DEPTHS_M};
use boresight::calibrate::tried::Tried;
use boresight::calibrate::vary::{Setting, Vary, points};
use boresight::report::{self, budget as pages};
use boresight::watch::Watch;
use boresight::{ScenarioRun, Settings};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes};
use sha2::{Digest, Sha256};

use super::errors::Failure;
use super::survey::{Survey, scenario_of};
use super::work::{run, run_to_its_end};

/// What is to be tried.
struct Plan {
    scenario: Box<dyn ScenarioRun>,
    trials: u64,
    single: u64,
    seed: u64,
    vary: Vec<Vary>,
}

impl Plan {
    /// The experiment in the scenario's words, for as long as `then` needs it.
    fn with<T>(
        &self,
        then: impl FnOnce(&Experiment<'_>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let tried = self.scenario.tried()?;
        let experiment = Experiment::new(&*tried, self.seed, self.trials, self.single);
        let experiment = experiment.with_sweep(points(&self.vary), self.trials)?;
        then(&experiment)
    }
}

/// Trials of a scenario: cells of one setting each, all under the same seeds.
#[pyclass(frozen, module = "boresight._core")]
pub struct Campaign {
    plan: Arc<Plan>,
}

#[pymethods]
impl Campaign {
    /// From a scenario's file or text; every cell is checked.
    #[new]
    fn new(
        py: Python<'_>,
        file: PathBuf,
        text: Option<String>,
        trials: u64,
        single: u64,
        vary: Vec<(String, Vec<Bound<'_, PyAny>>)>,
        seed: u64,
    ) -> PyResult<Self> {
        let vary: PyResult<Vec<Vary>> = vary
            .into_iter()
            .map(|(key, values)| {
                let values: PyResult<Vec<Setting>> = values.iter().map(setting).collect();
                Ok(Vary {
                    key,
                    values: values?,
                })
            })
            .collect();
        let vary = vary?;
        let plan = run(py, None, None, move |_| {
            let scenario = scenario_of(&file, text.as_deref())?;
            let plan = Plan {
                scenario,
                trials,
                single,
                seed,
                vary,
            };
            plan.with(|experiment| experiment.check().map_err(Failure::Refused))?;
            Ok(plan)
        })?;
        Ok(Self {
            plan: Arc::new(plan),
        })
    }

    /// Name of the scenario.
    #[getter]
    fn scenario(&self) -> &str {
        self.plan.scenario.name()
    }

    /// Name, file and number of trials of every cell, and SHA-256 of its ledger's header.
    fn cells(&self, py: Python<'_>) -> PyResult<Vec<(String, String, u64, String)>> {
        let cells = self.plan.with(|experiment| {
            let of = |cell| {
                let file = ledger_of("".as_ref(), cell).display().to_string();
                let digest = Sha256::digest(experiment.header(cell).text());
                let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
                (cell.name.clone(), file, cell.trials, digest)
            };
            Ok(experiment.cells.iter().map(of).collect())
        });
        cells.map_err(|failure| failure.raise(py))
    }

    /// Checks and mends the ledgers in a folder; how many trials of each cell are done.
    fn prepare(&self, py: Python<'_>, folder: PathBuf, resume: bool) -> PyResult<Vec<u64>> {
        let plan = Arc::clone(&self.plan);
        run(py, None, None, move |_| {
            plan.with(|experiment| Ok(experiment.prepare(&folder, resume)?))
        })
    }

    /// Runs what is missing on the threads of this process; whether it came to its end.
    #[pyo3(signature = (folder, done, threads=None, progress=None))]
    fn run(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        done: Vec<u64>,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        let plan = Arc::clone(&self.plan);
        run_to_its_end(py, threads, progress, move |caller| {
            plan.with(|experiment| {
                let of = experiment.trials();
                let said = |done: u64| caller.count("trials", done, of);
                let ended = experiment.run(&folder, &done, caller.stop, &said)?;
                Ok(ended == Ended::Complete)
            })
        })
    }

    /// The lines of a cell's ledger for `count` seeds from its `first`-th, counted from 0.
    #[pyo3(signature = (cell, first, count, threads=None))]
    fn records<'py>(
        &self,
        py: Python<'py>,
        cell: usize,
        first: u64,
        count: u64,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let plan = Arc::clone(&self.plan);
        let lines = run(py, threads, None, move |caller| {
            plan.with(|experiment| {
                let cell = experiment.cells.get(cell).ok_or(Failure::Stopped)?;
                let begin = experiment.first_seed + first;
                let seeds = begin..begin + count;
                experiment
                    .records(cell, seeds, caller.stop)
                    .ok_or(Failure::Stopped)
            })
        })?;
        Ok(PyBytes::new(py, &lines))
    }

    /// The budget that the ledgers in a folder make, as the bytes of its `result.json`; its files are written into `out` if there is one.
    #[pyo3(signature = (folder, depths_m, command, out=None, progress=None))]
    fn summed<'py>(
        &self,
        py: Python<'py>,
        folder: PathBuf,
        depths_m: Option<Vec<f64>>,
        command: String,
        out: Option<PathBuf>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let plan = Arc::clone(&self.plan);
        let bytes = run(py, None, progress, move |caller| {
            plan.with(|experiment| {
                let step = |what: &str| caller.step(what);
                let depths_m = depths_m.as_deref().unwrap_or(&DEPTHS_M);
                let done = Some((experiment, folder.as_path()));
                let mut result = budgets::budget(experiment.tried, done, depths_m, &step)?;
                result.command = command;
                if let Some(out) = out {
                    report::write_budget(&out, &result)?;
                }
                Ok(pages::to_bytes(&result)?)
            })
        })?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// A value of a varied key.
fn setting(value: &Bound<'_, PyAny>) -> PyResult<Setting> {
    if value.is_instance_of::<PyBool>() {
        return Ok(Setting::Flag(value.extract()?));
    }
    match value.extract::<f64>() {
        Ok(number) => Ok(Setting::Number(number)),
        Err(_) => Ok(Setting::Text(value.extract()?)),
    }
}

/// The error budget by propagation of a scenario or of a survey, as the bytes of its `result.json`.
#[pyfunction]
#[pyo3(signature = (file, text, survey, depths_m, seed, progress=None))]
pub fn budget<'py>(
    py: Python<'py>,
    file: PathBuf,
    text: Option<String>,
    survey: Option<&Bound<'_, Survey>>,
    depths_m: Option<Vec<f64>>,
    seed: u64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let survey = survey.map(|survey| survey.get().shared());
    let bytes = run(py, None, progress, move |caller| {
        let step = |what: &str| caller.step(what);
        let propagated = |tried: &dyn Tried| {
            if !tried.has_derivatives() {
                let text = format!(
                    "budget: found a {} scenario, which has no derivatives to propagate; run a Campaign of it",
                    tried.procedure()
                );
                return Err(Failure::Refused(text));
            }
            let depths_m = depths_m.as_deref().unwrap_or(&DEPTHS_M);
            let result = budgets::budget(tried, None, depths_m, &step)?;
            Ok(pages::to_bytes(&result)?)
        };
        match survey {
            None => propagated(&*scenario_of(&file, text.as_deref())?.tried()?),
            Some(survey) => {
                let settings = Settings {
                    seed: Some(seed),
                    ..Settings::default()
                };
                match survey.loaded().observed(&settings)? {
                    Some(observed) => propagated(&*observed),
                    None => Err(Failure::Refused(
                        "budget: found a survey that does not say how its instruments err, expected one whose laser points are in the scanner's frame, or a scenario".to_owned(),
                    )),
                }
            }
        }
    })?;
    Ok(PyBytes::new(py, &bytes))
}
