//! Linearisation of a whole problem: every condition and prior into one reduced system of the parameters.
//!
//! Without a chain and up to [`QR_ROWS`] conditions the whitened Jacobian is orthogonalised chunk by chunk, so no digit is lost
//! to normal equations; above that, and with a chain, normal equations with column scaling are summed. Their loss, half the
//! digits of the condition number of the *scaled* Jacobian, is harmless up to a condition of about 1e6 (seen: 1e4).

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::accumulate::{Normal, Run, Window};
use super::block::{ChainFactor, Inside, ReducedNormals, combine};
use super::chain::{ChainModel, ChainState, VISIBLE};
use super::elimination::{Elimination, Plan};
use super::elsewhere;
use super::error::AdjustError;
use super::factor::{Factor, compiled_size};
use super::orthogonal::orthogonalised;
use super::partition::{blocks, chunks, conditions_of, in_waves, sees_chain, windows};
use super::pass::{Pass, Tally, Weighting};
use super::problem::{Estimate, Problem};
use super::spectrum::{Reduced, Spectrum};
use super::store::{Page, Store};

/// Conditions up to which a problem without chain is solved by orthogonalisation.
const QR_ROWS: usize = 20_000;
/// Rows of a chunk of a set without chain.
const CHUNK: usize = 4096;
/// Windows accumulated at a time, while the ones before are eliminated.
const BATCH: usize = 16;

/// A problem linearised at an estimate.
#[derive(Debug)]
pub(super) struct Linearisation {
    /// Half the (robust) weighted sum of squares, priors and states included.
    pub cost: f64,
    /// Sums over the conditions alone.
    pub tally: Tally,
    /// Cost of the priors of parameters and states.
    pub prior_cost: f64,
    /// Reduced system over the free columns.
    pub reduced: Reduced,
    /// That system in its axes, each column scaled by its own length.
    pub spectrum: Spectrum,
    /// Fall of the cost by the states alone, parameters standing still.
    pub state_promise: f64,
    /// Factor of the chain, where it was kept.
    pub factor: Option<ChainFactor>,
}

impl Linearisation {
    /// Checks and decomposes a reduced system.
    pub(super) fn new(
        pass: &Pass,
        reduced: Reduced,
        tally: Tally,
        prior_cost: f64,
    ) -> Result<Self, AdjustError> {
        if !reduced.is_finite() {
            return Err(culprit(pass));
        }
        let spectrum = reduced.spectrum(&reduced.lengths())?;
        let cost = tally.cost + prior_cost;
        Ok(Linearisation {
            cost,
            tally,
            prior_cost,
            reduced,
            spectrum,
            state_promise: 0.0,
            factor: None,
        })
    }
}

/// The first condition with a derivative that is not a number.
fn culprit(pass: &Pass) -> AdjustError {
    let what = "derivative";
    for (set, source) in pass.problem.sources.iter().enumerate() {
        let mut found = None;
        let visited = pass.visit(set, 0..source.conditions.len(), |weighted| {
            let visible = weighted
                .row
                .chain
                .map_or([0.0; VISIBLE], |chain| chain.visible);
            let bad = weighted
                .row
                .values()
                .iter()
                .chain(&visible)
                .copied()
                .find(|value| !value.is_finite());
            found = found.or(bad.map(|found| (weighted.condition, found)));
        });
        if let (Ok(_), Some((condition, found))) = (visited, found) {
            return AdjustError::NotFinite {
                set,
                condition,
                what,
                found,
            };
        }
    }
    AdjustError::NotFinite {
        set: 0,
        condition: 0,
        what: "sum of derivatives",
        found: f64::INFINITY,
    }
}

/// Linearises a problem.
pub(super) fn linearise(
    problem: &Problem,
    at: &Estimate,
    weighting: Weighting,
    keep: Keep,
) -> Result<Linearisation, AdjustError> {
    let pass = Pass {
        problem,
        at,
        weighting,
    };
    match (problem.chain, &at.chain) {
        (Some(model), Some(state)) => with_chain(&pass, model, state, keep),
        _ if problem.condition_count() <= QR_ROWS => orthogonalised(&pass),
        _ => summed(&pass),
    }
}

/// The factor of a problem's chain, made by this process.
pub(super) fn factor_here(
    problem: &Problem,
    at: &Estimate,
    weighting: Weighting,
) -> Result<Option<ChainFactor>, AdjustError> {
    let mut problem = problem.clone();
    problem.elsewhere = None;
    Ok(linearise(&problem, at, weighting, Keep::Factor(None))?.factor)
}

fn summed(pass: &Pass) -> Result<Linearisation, AdjustError> {
    let (mut normal, tally) = sum_without_chain(pass, |_| true)?;
    let prior_cost = add_priors(pass.at, &mut normal)?;
    let free = pass.at.parameters.free_columns();
    let none = DMatrix::zeros(free.len() + 1, free.len() + 1);
    Linearisation::new(pass, reduce(&normal, &none, &free), tally, prior_cost)
}

fn sum_without_chain(
    pass: &Pass,
    wanted: impl Fn(usize) -> bool,
) -> Result<(Normal, Tally), AdjustError> {
    let columns = pass.at.parameters.columns();
    let chunks = chunks(pass.problem, CHUNK, wanted);
    let part = |(set, range): (usize, Range<usize>)| {
        let mut normal = Normal::zero(columns);
        let tally = sum_runs(pass, set, range, &mut normal, None)?;
        Ok((normal, tally))
    };
    let parts: Result<Vec<_>, AdjustError> = chunks.into_par_iter().map(part).collect();
    let mut sum = (Normal::zero(columns), Tally::default());
    for (normal, tally) in parts? {
        sum.0.add(&normal);
        sum.1.add(&tally);
    }
    Ok(sum)
}

/// Adds the conditions of a range, run by run.
fn sum_runs(
    pass: &Pass,
    set: usize,
    range: Range<usize>,
    normal: &mut Normal,
    mut window: Option<&mut Window>,
) -> Result<Tally, AdjustError> {
    let last = normal.width - 1;
    let mut run = Run::new();
    let tally = pass.visit(set, range, |weighted| {
        if !run.takes(weighted.row) {
            run.flush(normal, window.as_deref_mut());
            run.start(weighted.row, last);
        }
        run.add(weighted);
    })?;
    run.flush(normal, window);
    Ok(tally)
}

fn add_priors(at: &Estimate, normal: &mut Normal) -> Result<f64, AdjustError> {
    let mut cost = 0.0;
    for prior in at.parameters.prior_rows()? {
        cost += 0.5 * prior.residual * prior.residual;
        normal.add_row(prior.column, &prior.derivatives, prior.residual);
    }
    Ok(cost)
}

/// Schur complement over the free columns.
fn reduce(normal: &Normal, loss: &DMatrix<f64>, free: &[usize]) -> Reduced {
    let n = free.len();
    let rhs = normal.width - 1;
    let matrix = DMatrix::from_fn(n, n, |i, j| normal.at(free[i], free[j]) - loss[(i, j)]);
    let gradient: Vec<f64> = (0..n)
        .map(|j| normal.at(free[j], rhs) - loss[(j, n)])
        .collect();
    let before: Vec<f64> = free
        .iter()
        .map(|column| normal.at(*column, *column))
        .collect();
    Reduced::Normal {
        matrix,
        gradient,
        before,
    }
}

/// What becomes of the factor of the chain.
pub(super) enum Keep {
    /// It is kept; an old one lends its memory.
    Factor(Option<ChainFactor>),
    /// It is not: only the reduced system is wanted.
    Nothing,
}

fn with_chain(
    pass: &Pass,
    model: &ChainModel,
    state: &ChainState,
    keep: Keep,
) -> Result<Linearisation, AdjustError> {
    let free = pass.at.parameters.free_columns();
    let blocks = blocks(model, &pass.problem.large);
    let handed_out = blocks.len() > 1 && matches!(keep, Keep::Factor(_));
    let found = match pass.problem.elsewhere.filter(|_| handed_out) {
        Some(elsewhere) => elsewhere::reduced(elsewhere, pass, &blocks)?,
        None => None,
    };
    let (parts, inside) = match found {
        Some((parts, inside)) => (parts, Some(inside)),
        None => reduced_here(pass, model, state, keep, &blocks)?,
    };
    let mut network = combine(parts, model, &blocks)?;
    let prior_cost = add_priors(pass.at, &mut network.normal)? + network.prior_cost;
    let (loss, tally) = (&network.loss, network.tally);
    let state_promise = 0.5 * loss[(free.len(), free.len())];
    let reduced = reduce(&network.normal, loss, &free);
    let solved = Linearisation::new(pass, reduced, tally, prior_cost)?;
    let cuts = network.cuts;
    let factor = inside.map(|inside| ChainFactor {
        blocks,
        inside,
        cuts,
    });
    Ok(Linearisation {
        state_promise,
        factor,
        ..solved
    })
}

/// The blocks reduced by this process, and what is inside them where that is kept.
fn reduced_here(
    pass: &Pass,
    model: &ChainModel,
    state: &ChainState,
    keep: Keep,
    blocks: &[Range<usize>],
) -> Result<(Vec<ReducedNormals>, Option<Inside>), AdjustError> {
    let without = sum_without_chain(pass, |set| !sees_chain(pass.problem, set))?;
    let kept = kept_columns(pass);
    let (store, spare) = match keep {
        Keep::Nothing => (Store::Nowhere, Vec::new()),
        Keep::Factor(old) => {
            let (old, spare) = old.map_or((None, Vec::new()), ChainFactor::into_parts);
            let bytes = factor_bytes(model, kept.len(), blocks)?;
            (Store::of_size(bytes, &pass.problem.large, old)?, spare)
        }
    };
    let plan = Plan {
        model,
        state,
        columns: &kept,
        store: &store,
    };
    let (parts, pages) = reduced_blocks(pass, plan, blocks, without, spare)?;
    let kept = !matches!(store, Store::Nowhere);
    Ok((parts, kept.then_some(Inside::Here { pages, store })))
}

/// One block reduced by itself, with the sums of the conditions without chain in the first; its factor goes to `store`.
pub(super) fn reduced_alone(
    pass: &Pass,
    model: &ChainModel,
    (block, intervals): (usize, &Range<usize>),
    store: &Store,
    spare: Vec<Page>,
) -> Result<(ReducedNormals, Vec<Page>), AdjustError> {
    let Some(state) = &pass.at.chain else {
        return Err(AdjustError::MissingBlock { block, blocks: 0 });
    };
    let without = sum_without_chain(pass, |set| !sees_chain(pass.problem, set))?;
    let kept = kept_columns(pass);
    let plan = Plan {
        model,
        state,
        columns: &kept,
        store,
    };
    let progress = Progress {
        pass,
        done: AtomicUsize::new(0),
        windows: windows(intervals).len(),
    };
    reduced_block(&progress, plan, (block, intervals), without, spare)
}

/// Columns that stay when the states are eliminated: the free ones, then the misclosure.
fn kept_columns(pass: &Pass) -> Vec<usize> {
    let mut kept = pass.at.parameters.free_columns();
    kept.push(pass.at.parameters.columns());
    kept
}

/// Bytes of the factor of a chain.
pub(super) fn factor_bytes(
    model: &ChainModel,
    kept: usize,
    blocks: &[Range<usize>],
) -> Result<u64, AdjustError> {
    let size = compiled_size(model.state_size())?;
    let first = usize::from(blocks.len() > 1) * size;
    Ok(model.epochs() as u64 * Factor::bytes(size, first + kept))
}

/// Accumulates and eliminates the blocks beside one another; the sums of the conditions without chain, `without`, go to the first.
fn reduced_blocks(
    pass: &Pass,
    plan: Plan,
    blocks: &[Range<usize>],
    without: (Normal, Tally),
    spare: Vec<Vec<Page>>,
) -> Result<(Vec<ReducedNormals>, Vec<Vec<Page>>), AdjustError> {
    let windows = blocks.iter().map(|block| windows(block).len()).sum();
    let progress = Progress {
        pass,
        done: AtomicUsize::new(0),
        windows,
    };
    let columns = pass.at.parameters.columns();
    let empty = || (Normal::zero(columns), Tally::default());
    let sums = std::iter::once(without).chain(std::iter::repeat_with(empty));
    let spare = spare.into_iter().chain(std::iter::repeat_with(Vec::new));
    let (mut parts, mut interiors) = (Vec::new(), Vec::new());
    in_waves(
        blocks.iter().enumerate().zip(sums.zip(spare)),
        |(block, (sums, spare))| reduced_block(&progress, plan, block, sums, spare),
        |(part, interior)| {
            parts.push(part);
            interiors.push(interior);
        },
    )?;
    Ok((parts, interiors))
}

/// The blocks of a problem, reduced at an estimate, and their intervals.
#[cfg(test)]
pub(super) fn reduced_blocks_of(
    problem: &Problem,
    at: &Estimate,
) -> Result<(Vec<ReducedNormals>, Vec<Range<usize>>), AdjustError> {
    let weighting = Weighting::Uniform(1.0);
    let pass = Pass {
        problem,
        at,
        weighting,
    };
    let mut columns = at.parameters.free_columns();
    columns.push(at.parameters.columns());
    let (Some(model), Some(state)) = (problem.chain, &at.chain) else {
        return Ok((vec![], vec![]));
    };
    let (columns, store) = (&columns[..], &Store::Memory);
    let plan = Plan {
        model,
        state,
        columns,
        store,
    };
    let (blocks, none) = (blocks(model, &problem.large), Vec::new());
    let without = (Normal::zero(at.parameters.columns()), Tally::default());
    let (parts, _) = reduced_blocks(&pass, plan, &blocks, without, none)?;
    Ok((parts, blocks))
}

/// A pass over the windows of a chain and how far it is.
struct Progress<'a> {
    pass: &'a Pass<'a>,
    done: AtomicUsize,
    windows: usize,
}

/// Reduces a block; its sums are added to what is there.
fn reduced_block(
    progress: &Progress,
    plan: Plan,
    (block, intervals): (usize, &Range<usize>),
    (mut normal, mut tally): (Normal, Tally),
    spare: Vec<Page>,
) -> Result<(ReducedNormals, Vec<Page>), AdjustError> {
    let mut elimination = Elimination::new(plan, intervals.clone(), spare)?;
    let left = sweep(progress, &windows(intervals), |windows: &[WindowSums]| {
        for sums in windows {
            normal.add(&sums.normal);
            tally.add(&sums.tally);
        }
        elimination.eliminate(windows.iter().map(|sums| &sums.window))
    })?;
    let eliminated = elimination.finish(left.as_ref());
    Ok(ReducedNormals::new(block, (normal, tally), eliminated))
}

struct WindowSums {
    window: Window,
    normal: Normal,
    tally: Tally,
}

/// Accumulates a block window by window and hands batches of them, in order, to `eliminate`, which runs beside the accumulation of
/// the next batch. Returns what the last window leaves at the epoch behind it.
fn sweep(
    progress: &Progress,
    windows: &[Range<usize>],
    mut eliminate: impl FnMut(&[WindowSums]) -> Result<(), AdjustError> + Send,
) -> Result<Option<Window>, AdjustError> {
    let pass = progress.pass;
    let mut ready: Vec<WindowSums> = Vec::new();
    let mut left: Option<Window> = None;
    for batch in windows.chunks(BATCH) {
        let done = progress.done.fetch_add(batch.len(), Ordering::Relaxed);
        pass.problem.counted(done, progress.windows);
        let current = std::mem::take(&mut ready);
        let accumulate = || {
            batch
                .par_iter()
                .map(|intervals| window_sums(pass, intervals.clone()))
                .collect()
        };
        let (next, done): (Result<Vec<_>, AdjustError>, _) =
            rayon::join(accumulate, || eliminate(&current));
        done?;
        ready = next?;
        join_windows(&mut ready, &mut left);
    }
    eliminate(&ready)?;
    Ok(left)
}

/// Gives each window what the one before left at their common epoch.
fn join_windows(ready: &mut [WindowSums], left: &mut Option<Window>) {
    for sums in ready.iter_mut() {
        if let Some(before) = left.take() {
            sums.window.take_over(&before);
        }
        *left = Some(sums.window.last_epoch());
    }
}

fn window_sums(pass: &Pass, intervals: Range<usize>) -> Result<WindowSums, AdjustError> {
    let mut normal = Normal::zero(pass.at.parameters.columns());
    let mut window = Window::zero(intervals.clone(), normal.width);
    let mut tally = Tally::default();
    for set in (0..pass.problem.sources.len()).filter(|set| sees_chain(pass.problem, *set)) {
        let range = conditions_of(pass.problem, set, &intervals);
        tally.add(&sum_runs(pass, set, range, &mut normal, Some(&mut window))?);
    }
    Ok(WindowSums {
        window,
        normal,
        tally,
    })
}

#[cfg(test)]
mod tests {
    use super::super::toys::{DenseToy, GLOBALS, Toy};
    use super::super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    fn tight() -> Options {
        Options {
            step_tolerance_sigmas: 1e-9,
            ..Options::default()
        }
    }

    /// Elimination of the chain against orthogonalisation of the whole Jacobian, with the states as ordinary parameters.
    #[test]
    fn chain_agrees_with_dense() {
        let toy = Toy::new(7, 12, 8);
        let chained = solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap();
        let dense = DenseToy(&toy);
        let problem = Problem::dense(vec![Source::new(&dense)]);
        let whole = solve(&problem, Estimate::new(dense.parameters()), &tight()).unwrap();
        assert!(chained.status.was_successful() && whole.status.was_successful());
        assert_relative_eq!(chained.cost, whole.cost, max_relative = 1e-10);
        let blocks = whole.estimate.parameters.blocks();
        assert_abs_diff_eq!(
            chained.estimate.parameters.blocks()[0].value[..],
            blocks[0].value[..],
            epsilon = 1e-9
        );
        let states = chained.estimate.chain.as_ref().unwrap();
        for epoch in 0..toy.model.epochs() {
            assert_abs_diff_eq!(
                states.state(epoch)[..],
                blocks[epoch + 1].value[..],
                epsilon = 1e-9
            );
        }
        let corner = whole.cofactor.view((0, 0), (GLOBALS, GLOBALS)).into_owned();
        assert_relative_eq!(chained.cofactor, corner, max_relative = 1e-9);
    }

    /// Several windows and batches give what one factorisation of all of it gives: the cost is stationary in every state.
    #[test]
    fn long_chain_is_stationary() {
        let toy = Toy::new(8, 1500, 4);
        let solution = solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap();
        assert_eq!(solution.status, Status::Converged);
        assert!(solution.linearisation.state_promise < 1e-15 * solution.cost);
        for (x, truth) in solution.estimate.parameters.blocks()[0]
            .value
            .iter()
            .zip(toy.truth)
        {
            assert!((x - truth).abs() < 4.0 * solution.cofactor[(0, 0)].sqrt());
        }
    }

    #[test]
    fn one_and_two_threads_give_the_same_bytes() {
        let toy = Toy::new(9, 1500, 4);
        let run = |threads| {
            let workers = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let solution = workers.install(|| {
                solve(&toy.problem(), Estimate::new(toy.parameters()), &tight()).unwrap()
            });
            (
                solution.estimate,
                solution.cost.to_bits(),
                solution.cofactor,
            )
        };
        assert_eq!(run(1), run(2));
    }

    #[test]
    fn a_held_column_stays_and_has_no_variance() {
        let toy = Toy::new(10, 80, 6);
        let mut parameters = toy.parameters();
        let id = parameters.find("globals").unwrap();
        parameters.block_mut(id).held[1] = true;
        parameters.block_mut(id).value[1] = toy.truth[1];
        let solution = solve(&toy.problem(), Estimate::new(parameters), &tight()).unwrap();
        assert_eq!(
            solution.estimate.parameters.blocks()[0].value[1],
            toy.truth[1]
        );
        assert_eq!(solution.cofactor[(1, 1)], 0.0);
        assert!(solution.cofactor[(0, 0)] > 0.0);
    }
}
