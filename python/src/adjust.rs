//! The engine on conditions that Python evaluates, in batches.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use boresight::adjust::{
    AdjustError, Block, ChainState, Component, Conditions, Estimate, Kernel, Options, ParameterSet,
    Problem, QualityOptions, Row, Source, Status, Unit, assess, solve,
};
use boresight::nalgebra::{DMatrix, DVector};
use boresight::watch::Watch;
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::square;
use super::errors::Failure;
use super::work::run;

/// Rows that Python evaluates at a time.
const BATCH: usize = 4096;
/// Points whose rows are kept: an iteration may compare two while it looks at a third.
const KEPT: usize = 3;

/// A block of parameters: name, values, sigmas of its prior about them, which of them are held.
type Given = (String, Vec<f64>, Option<Vec<f64>>, Vec<bool>);
/// A set of conditions: what evaluates rows `first..last` at `x`, how many there are, the blocks that it sees.
type Set = (Py<PyAny>, usize, Vec<String>);

/// All rows of a set at one point.
struct Evaluated {
    at: Vec<u64>,
    misclosure: Vec<f64>,
    variance: Vec<f64>,
    /// As many as columns, row by row.
    derivatives: Vec<f64>,
}

/// Conditions that Python evaluates.
struct Batched {
    evaluate: Py<PyAny>,
    len: usize,
    /// Names of the blocks that it sees, in the order of its columns.
    blocks: Vec<String>,
    kept: RwLock<Vec<Arc<Evaluated>>>,
    failed: Arc<Mutex<Option<PyErr>>>,
}

impl Batched {
    /// The rows at a point: kept ones, or evaluated by the first who asks; `None` where Python raised.
    fn rows(&self, x: &ParameterSet) -> Option<Arc<Evaluated>> {
        let values = x.blocks().iter().flat_map(|block| &block.value);
        let at: Vec<u64> = values.map(|value| value.to_bits()).collect();
        let known = |kept: &[Arc<Evaluated>]| kept.iter().find(|e| e.at == at).map(Arc::clone);
        let kept = self.kept.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known(&kept) {
            return Some(found);
        }
        drop(kept);
        let mut kept = self.kept.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known(&kept) {
            return Some(found);
        }
        if self.raised() {
            return None;
        }
        match Python::attach(|py| self.evaluated(py, x, at)) {
            Ok(found) => {
                kept.truncate(KEPT - 1);
                kept.insert(0, Arc::new(found));
                kept.first().map(Arc::clone)
            }
            Err(error) => {
                *self.failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                None
            }
        }
    }

    fn raised(&self) -> bool {
        let failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.is_some()
    }

    fn evaluated(&self, py: Python<'_>, x: &ParameterSet, at: Vec<u64>) -> PyResult<Evaluated> {
        let seen = PyDict::new(py);
        for id in self.blocks.iter().filter_map(|name| x.find(name)) {
            let block = x.block(id);
            seen.set_item(&block.name, PyArray1::from_slice(py, &block.value))?;
        }
        let mut all = Evaluated {
            at,
            misclosure: Vec::with_capacity(self.len),
            variance: Vec::with_capacity(self.len),
            derivatives: vec![],
        };
        for first in (0..self.len).step_by(BATCH) {
            let last = (first + BATCH).min(self.len);
            let found = self.evaluate.bind(py).call1((first, last, &seen))?;
            let (misclosure, variance, derivatives): (
                PyReadonlyArray1<'_, f64>,
                PyReadonlyArray1<'_, f64>,
                PyReadonlyArray2<'_, f64>,
            ) = found.extract()?;
            all.misclosure.extend_from_slice(misclosure.as_slice()?);
            all.variance.extend_from_slice(variance.as_slice()?);
            all.derivatives.extend_from_slice(derivatives.as_slice()?);
        }
        Ok(all)
    }
}

impl Conditions for Batched {
    fn len(&self) -> usize {
        self.len
    }

    fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
        self.linearise_range(k..k + 1, x, chain, std::slice::from_mut(row));
    }

    fn linearise_range(
        &self,
        range: Range<usize>,
        x: &ParameterSet,
        _: Option<&ChainState>,
        rows: &mut [Row],
    ) {
        rows.iter_mut().for_each(Row::clear);
        let Some(all) = self.rows(x) else { return };
        let ids = self.blocks.iter().filter_map(|name| x.find(name));
        let columns = ids.flat_map(|id| x.offset(id)..x.offset(id) + x.block(id).value.len());
        let columns: Vec<usize> = columns.collect();
        for (k, row) in range.zip(rows) {
            row.misclosure = all.misclosure[k];
            row.variance = all.variance[k];
            let derivatives = &all.derivatives[k * columns.len()..(k + 1) * columns.len()];
            for (column, value) in columns.iter().zip(derivatives) {
                row.push(*column, *value);
            }
        }
    }
}

/// Solves conditions over blocks of numbers; what is found, by name.
#[pyfunction]
#[pyo3(signature = (sets, blocks, kernel, width, max_iterations, step_tolerance_sigmas, unknown_noise, worst, threads=None, progress=None))]
#[expect(clippy::too_many_arguments, reason = "the package gives them by name")]
pub fn adjust<'py>(
    py: Python<'py>,
    sets: Vec<Set>,
    blocks: Vec<Given>,
    kernel: &str,
    width: f64,
    max_iterations: usize,
    step_tolerance_sigmas: f64,
    unknown_noise: bool,
    worst: usize,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let k = width;
    let kernel = match kernel {
        "huber" => Kernel::Huber { k },
        "cauchy" => Kernel::Cauchy { k },
        "tukey" => Kernel::Tukey { k },
        "geman_mcclure" => Kernel::GemanMcClure { k },
        _ => Kernel::LeastSquares,
    };
    let options = Options {
        max_iterations,
        kernel,
        step_tolerance_sigmas,
        unknown_noise,
        ..Options::default()
    };
    let found = run(py, threads, progress, move |caller| {
        solved(sets, blocks, &options, worst, caller)
    })?;
    found.table(py)
}

/// What a solve ended with.
struct Found {
    x: Vec<f64>,
    covariance: DMatrix<f64>,
    status: &'static str,
    undetermined: Vec<Vec<f64>>,
    iterations: Vec<(f64, f64, f64, bool)>,
    omega: f64,
    degrees_of_freedom: f64,
    variance_factor: f64,
    interval: (f64, f64),
    critical: f64,
    /// Set, condition, residual, sigma, redundancy, normalised residual.
    worst: Vec<(usize, usize, f64, f64, f64, f64)>,
}

fn solved(
    sets: Vec<Set>,
    blocks: Vec<Given>,
    options: &Options,
    worst: usize,
    watch: &dyn Watch,
) -> Result<Found, Failure> {
    let refused = |error: AdjustError| Failure::Refused(error.to_string());
    let start = parameters(blocks).map_err(refused)?;
    let failed = Arc::new(Mutex::new(None));
    let of = |(evaluate, len, blocks): Set| Batched {
        evaluate,
        len,
        blocks,
        kept: RwLock::default(),
        failed: Arc::clone(&failed),
    };
    let sets: Vec<Batched> = sets.into_iter().map(of).collect();
    let mut problem = Problem::dense(sets.iter().map(|set| Source::new(set)).collect());
    problem.watch = Some(watch);
    let quality = QualityOptions {
        worst,
        ..QualityOptions::default()
    };
    let ended = solve(&problem, Estimate::new(start), options)
        .and_then(|solution| Ok((assess(&problem, &solution, &quality)?, solution)));
    let raised = failed.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(error) = raised {
        return Err(Failure::Python(error));
    }
    let (quality, solution) = ended.map_err(|error| match error {
        AdjustError::Stopped(_) => Failure::Stopped,
        other => refused(other),
    })?;
    let (status, undetermined) = match &solution.status {
        Status::Converged => ("converged", vec![]),
        Status::Stalled => ("stalled", vec![]),
        Status::OutOfIterations => ("out_of_iterations", vec![]),
        Status::RankDeficient { directions } => ("rank_deficient", directions.clone()),
    };
    let blocks = solution.estimate.parameters.blocks();
    let iterations = solution.iterations.iter();
    let worst = quality.worst.iter().map(|one| {
        let (set, condition) = (one.set, one.condition);
        let (residual, sigma) = (one.residual, one.sigma);
        (
            set,
            condition,
            residual,
            sigma,
            one.redundancy,
            one.normalised,
        )
    });
    Ok(Found {
        x: blocks.iter().flat_map(|b| b.value.clone()).collect(),
        status,
        undetermined,
        iterations: iterations
            .map(|i| (i.cost, i.damping, i.step_sigmas, i.accepted))
            .collect(),
        omega: quality.global.omega,
        degrees_of_freedom: quality.global.degrees_of_freedom,
        variance_factor: quality.global.variance_factor,
        interval: quality.global.interval,
        critical: quality.family.critical,
        worst: worst.collect(),
        covariance: solution.cofactor,
    })
}

fn parameters(blocks: Vec<Given>) -> Result<ParameterSet, AdjustError> {
    let mut all = ParameterSet::new();
    for (name, value, sigmas, held) in blocks {
        let one = value.len() == 1;
        let component = |k: usize| match one {
            true => name.clone(),
            false => format!("{name} {k}"),
        };
        let components = (0..value.len()).map(|k| Component::new(component(k), Unit::One));
        let mut block = Block::euclidean(name.clone(), components.collect(), &value).sought();
        block.held = held;
        if let Some(sigmas) = sigmas {
            let squares = DVector::from_iterator(sigmas.len(), sigmas.iter().map(|s| s * s));
            block = block.with_prior(value, DMatrix::from_diagonal(&squares));
        }
        all.push(block)?;
    }
    Ok(all)
}

impl Found {
    fn table(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let all = PyDict::new(py);
        all.set_item("x", PyArray1::from_vec(py, self.x))?;
        all.set_item("covariance", square(py, &self.covariance)?)?;
        all.set_item("status", self.status)?;
        all.set_item("undetermined", self.undetermined)?;
        all.set_item("iterations", self.iterations)?;
        all.set_item("omega", self.omega)?;
        all.set_item("redundancy", self.degrees_of_freedom)?;
        all.set_item("variance_factor", self.variance_factor)?;
        all.set_item("interval", self.interval)?;
        all.set_item("critical", self.critical)?;
        all.set_item("worst", self.worst)?;
        Ok(all)
    }
}
