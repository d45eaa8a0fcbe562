//! Helmert blocks: a long chain is cut, each block is reduced by itself, and a small network over the cuts puts the blocks together.
//!
//! Wolf, "The Helmert block method, its origin and development", 1978. A cut is an epoch whose states stay when the epochs inside the
//! blocks beside it are eliminated. What a block leaves, [`ReducedNormals`], belongs to the parameters and its two cuts; summed over
//! the blocks these are normal equations that are block tridiagonal again, over the cuts ([`Network`]). Cuts depend on the chain's
//! length alone and sums run in the blocks' order, so results have the same bytes on any number of threads.

use std::ops::Range;

use nalgebra::DMatrix;
use pulp::Arch;

use super::accumulate::Normal;
use super::chain::ChainModel;
use super::elimination::Eliminated;
use super::elsewhere::{self, Elsewhere};
use super::error::AdjustError;
use super::factor::{Factor, Quad, compiled_size, with_size};
use super::partition::in_waves;
use super::pass::Tally;
use super::selected::Ends;
use super::store::{Page, Reader, Store};
use crate::math::dense::add_squares;

/// What is left at a cut.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cut {
    /// Its states by themselves.
    pub own: DMatrix<f64>,
    /// Its states by free columns and misclosure.
    pub border: DMatrix<f64>,
}

/// What a block leaves for the parameters and its cuts, its interior eliminated.
#[derive(Debug, Clone)]
pub(super) struct ReducedNormals {
    /// Number of the block, from zero.
    pub block: usize,
    /// Normal equations of its conditions over all columns and the misclosure, nothing eliminated.
    pub normal: Normal,
    /// What the interior takes from those of the free columns and the misclosure.
    pub loss: DMatrix<f64>,
    /// Sums over its conditions.
    pub tally: Tally,
    /// Cost of the priors of its states.
    pub prior_cost: f64,
    /// The cut that it begins with, if it does.
    pub first: Option<Cut>,
    /// The cut that it ends with, if it does.
    pub last: Option<Cut>,
    /// First cut by last cut.
    pub between: DMatrix<f64>,
}

impl ReducedNormals {
    /// Of an eliminated block, and the factor of its interior.
    pub(super) fn new(
        block: usize,
        (normal, tally): (Normal, Tally),
        eliminated: Eliminated,
    ) -> (Self, Vec<Page>) {
        let reduced = ReducedNormals {
            block,
            normal,
            loss: eliminated.loss,
            tally,
            prior_cost: eliminated.prior_cost,
            first: eliminated.first,
            last: eliminated.last,
            between: eliminated.between,
        };
        (reduced, eliminated.kept)
    }
}

/// The blocks put together, the cuts eliminated.
#[derive(Debug)]
pub(super) struct Network {
    /// Normal equations of the conditions over all columns and the misclosure, nothing eliminated.
    pub normal: Normal,
    /// What the states take from those of the free columns and the misclosure.
    pub loss: DMatrix<f64>,
    /// Sums over the conditions.
    pub tally: Tally,
    /// Cost of the priors of the states.
    pub prior_cost: f64,
    /// Factor over the cuts.
    pub cuts: Factor,
}

/// Puts the blocks of a chain together, in whatever order they come.
///
/// # Errors
/// [`AdjustError::MissingBlock`] and [`AdjustError::SurplusBlock`] unless each of the chain's blocks is there once;
/// [`AdjustError::NotPositive`].
pub(super) fn combine(
    mut parts: Vec<ReducedNormals>,
    model: &ChainModel,
    blocks: &[Range<usize>],
) -> Result<Network, AdjustError> {
    parts.sort_by_key(|part| part.block);
    check(&parts, blocks.len())?;
    let (mut cuts, mut losses) = (
        Cuts::new(&parts, model)?,
        parts.iter().map(|part| &part.loss),
    );
    let mut loss = losses.next().cloned().unwrap_or_default();
    losses.for_each(|part| loss += part);
    for (cut, pair) in parts.windows(2).enumerate() {
        let epoch = |error| match error {
            AdjustError::NotPositive { .. } => AdjustError::NotPositive {
                epoch: blocks[cut].end,
            },
            other => other,
        };
        with_size!(cuts.factor.size, N => cuts.cut::<N>(cut, (&pair[0], &pair[1])).map_err(epoch)?);
    }
    let factor = cuts.factor;
    let rows = factor.rows(factor.epochs.clone());
    add_squares(&mut loss, rows, factor.quads, factor.size);
    let mut parts = parts.into_iter();
    let Some(first) = parts.next() else {
        return Err(AdjustError::MissingBlock {
            block: 0,
            blocks: 0,
        });
    };
    let mut network = Network {
        normal: first.normal,
        loss,
        tally: first.tally,
        prior_cost: first.prior_cost,
        cuts: factor,
    };
    for part in parts {
        network.normal.add(&part.normal);
        network.tally.add(&part.tally);
        network.prior_cost += part.prior_cost;
    }
    Ok(network)
}

/// Each block once.
fn check(parts: &[ReducedNormals], blocks: usize) -> Result<(), AdjustError> {
    for (expected, part) in parts.iter().enumerate() {
        let block = part.block;
        if block < expected || block >= blocks {
            return Err(AdjustError::SurplusBlock { block, blocks });
        }
        if block > expected {
            let block = expected;
            return Err(AdjustError::MissingBlock { block, blocks });
        }
    }
    match parts.len() {
        block if block < blocks => Err(AdjustError::MissingBlock { block, blocks }),
        _ => Ok(()),
    }
}

/// Elimination of the cuts in progress.
struct Cuts {
    factor: Factor,
    carry: Vec<Quad>,
    /// States that are in use; idle ones have unit information.
    used: usize,
}

impl Cuts {
    fn new(parts: &[ReducedNormals], model: &ChainModel) -> Result<Self, AdjustError> {
        let used = model.state_size();
        let size = compiled_size(used)?;
        let width = parts.first().map_or(0, |part| part.loss.ncols());
        let cuts = parts.len().saturating_sub(1);
        let factor = Factor::default().sized(size, width, 0..cuts);
        Ok(Cuts {
            carry: vec![[0.0; 4]; size * factor.quads],
            factor,
            used,
        })
    }

    /// Eliminates the cut between two blocks.
    fn cut<const N: usize>(
        &mut self,
        cut: usize,
        (before, behind): (&ReducedNormals, &ReducedNormals),
    ) -> Result<(), AdjustError> {
        let (Some(last), Some(first)) = (&before.last, &behind.first) else {
            let (block, blocks) = (behind.block, self.factor.epochs.len() + 1);
            return Err(AdjustError::SurplusBlock { block, blocks });
        };
        let quads = self.factor.quads;
        let entries = |i: usize| self.carry[i * quads..].as_flattened();
        let mut own = [[0.0; N]; N];
        for (i, row) in own.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = entries(i)[j] + last.own[(i, j)] + first.own[(i, j)];
            }
            row[i] += f64::from(u8::from(i >= self.used));
        }
        let rows = self.factor.rows_mut(cut).chunks_exact_mut(quads);
        for (i, row) in rows.enumerate() {
            let row = row.as_flattened_mut();
            row.copy_from_slice(self.carry[i * quads..(i + 1) * quads].as_flattened());
            let (next, border) = row.split_at_mut(N);
            next.iter_mut()
                .enumerate()
                .for_each(|(j, entry)| *entry = behind.between[(i, j)]);
            border
                .iter_mut()
                .zip(last.border.row(i).iter().zip(&first.border.row(i)))
                .for_each(|(entry, (last, first))| *entry += last + first);
        }
        self.factor
            .eliminate(cut, own, &mut self.carry, Arch::new())
    }
}

/// The factor of a whole chain.
#[derive(Debug)]
pub(super) struct ChainFactor {
    /// Intervals of the blocks.
    pub blocks: Vec<Range<usize>>,
    /// What is inside the blocks.
    pub inside: Inside,
    /// Factor over the cuts.
    pub cuts: Factor,
}

/// The factors of the blocks' interiors.
#[derive(Debug)]
pub(super) enum Inside {
    /// They are here.
    Here {
        /// Block by block.
        pages: Vec<Vec<Page>>,
        /// Where those are.
        store: Store,
    },
    /// Other processes hold them; where each block was linearised.
    Elsewhere(Vec<Vec<u8>>),
}

impl ChainFactor {
    /// The interior of a block, to be read; nothing of it where other processes hold it.
    pub(super) fn reader(&self, block: usize) -> Reader<'_> {
        match &self.inside {
            Inside::Here { pages, store } => Reader::new(store, &pages[block]),
            Inside::Elsewhere(_) => Reader::new(&Store::Nowhere, &[]),
        }
    }

    /// Whether other processes hold what is inside the blocks.
    pub(super) fn is_elsewhere(&self) -> bool {
        matches!(self.inside, Inside::Elsewhere(_))
    }

    /// Its store and its memory, to be used again.
    pub(super) fn into_parts(self) -> (Option<Store>, Vec<Vec<Page>>) {
        match self.inside {
            Inside::Here { pages, store } => (Some(store), pages),
            Inside::Elsewhere(_) => (None, Vec::new()),
        }
    }

    /// Step of all states for a step of the free columns; nothing where another process cannot give its part.
    pub(super) fn back_substitute(
        &self,
        (model, elsewhere): (&ChainModel, Option<&dyn Elsewhere>),
        x: &[f64],
    ) -> Result<Option<Vec<f64>>, AdjustError> {
        let (size, used) = (self.cuts.size, model.state_size());
        let mut at_cuts = vec![0.0; self.cuts.epochs.len() * size];
        (self.cuts).back_substitute(x, &mut vec![0.0; size], &mut at_cuts, size);
        let cut = |cut: usize| &at_cuts[cut * size..(cut + 1) * size];
        let ends = |block: usize| {
            let mut columns = Vec::with_capacity(size + x.len());
            let mut ahead = vec![0.0; size];
            if block > 0 {
                columns.extend_from_slice(cut(block - 1));
            }
            if block + 1 < self.blocks.len() {
                ahead.copy_from_slice(cut(block));
            }
            columns.extend_from_slice(x);
            (columns, ahead)
        };
        let mut steps = Vec::with_capacity(model.epochs() * used);
        let mut done = 0;
        let take = |inside: Vec<f64>| {
            if done > 0 {
                steps.extend_from_slice(&cut(done - 1)[..used]);
            }
            steps.extend(inside);
            done += 1;
        };
        match (&self.inside, elsewhere) {
            (Inside::Elsewhere(points), Some(elsewhere)) => {
                let Some(found) = elsewhere::steps(elsewhere, points, ends)? else {
                    return Ok(None);
                };
                found.into_iter().for_each(take);
            }
            _ => {
                let of_block = |block| {
                    let (columns, ahead) = ends(block);
                    inside(self.reader(block), &columns, ahead, used)
                };
                in_waves(0..self.blocks.len(), of_block, take)?;
            }
        }
        Ok(Some(steps))
    }

    /// Cofactors at the ends of every block, from those of the free columns: the backward recursion over the cuts.
    pub(super) fn ends(&self, parameters: &DMatrix<f64>) -> Vec<Ends> {
        Ends::of_cuts(&self.cuts, parameters)
    }
}

/// Steps of the states inside a block for those of its columns (the states of the first cut, then the free columns) and `ahead`, those
/// of its last cut.
pub(super) fn inside(
    mut reader: Reader,
    columns: &[f64],
    mut ahead: Vec<f64>,
    used: usize,
) -> Result<Vec<f64>, AdjustError> {
    let mut pages = Vec::new();
    for page in (0..reader.len()).rev() {
        let factor = reader.open(page)?;
        let mut steps = vec![0.0; factor.epochs.len() * used];
        factor.back_substitute(columns, &mut ahead, &mut steps, used);
        pages.push(steps);
    }
    pages.reverse();
    Ok(pages.concat())
}

#[cfg(test)]
mod tests {
    use super::super::linearise::reduced_blocks_of;
    use super::super::toys::Toy;
    use super::super::*;
    use super::*;

    const INTERVALS: usize = 300;

    fn toy(seed: u64) -> Toy {
        Toy::new(seed, INTERVALS + 1, 3)
    }

    fn cut(block_records: usize) -> Large {
        Large {
            block_records,
            ..Large::default()
        }
    }

    fn spilled(block_records: usize, folder: &std::path::Path) -> Large {
        Large {
            block_records,
            factor_memory: 0,
            spill: Some(folder.to_owned()),
        }
    }

    fn options(kernel: Kernel) -> Options {
        Options {
            // reweighting nears its end slowly
            step_tolerance_sigmas: if kernel.is_least_squares() {
                1e-8
            } else {
                1e-3
            },
            kernel,
            ..Options::default()
        }
    }

    fn solved(toy: &Toy, large: &Large, kernel: Kernel) -> Result<Solution, AdjustError> {
        let mut problem = toy.problem();
        problem.large = large.clone();
        solve(&problem, Estimate::new(toy.parameters()), &options(kernel))
    }

    /// Everything that comes out, list by list, each with the unit that its differences are measured in.
    fn answer(toy: &Toy, large: &Large, kernel: Kernel) -> Vec<(&'static str, f64, Vec<f64>)> {
        let mut problem = toy.problem();
        problem.large = large.clone();
        let solution = solved(toy, large, kernel).unwrap();
        assert!(solution.status.was_successful(), "{:?}", solution.status);
        let figures = figures(&problem, &solution).unwrap().concat();
        let influence = influence(&problem, &solution).unwrap();
        let chain = solution.estimate.chain.as_ref().unwrap();
        let states = (0..toy.model.epochs()).flat_map(|epoch| chain.state(epoch).to_vec());
        let sigma = solution.cofactor.diagonal().amax().sqrt();
        let largest = influence.conditions[0].amax();
        vec![
            (
                "x",
                sigma,
                solution.estimate.parameters.blocks()[0].value.clone(),
            ),
            ("states", 0.3, states.collect()),
            (
                "cofactor",
                solution.cofactor.amax(),
                solution.cofactor.as_slice().to_vec(),
            ),
            ("cost", solution.cost, vec![solution.cost]),
            ("omega", solution.omega, vec![solution.omega]),
            (
                "redundancy",
                1.0,
                figures.iter().map(|one| one.redundancy).collect(),
            ),
            // w / sqrt r errs by dr / r of itself
            (
                "normalised",
                1.0,
                figures
                    .iter()
                    .map(|one| one.normalised * one.redundancy)
                    .collect(),
            ),
            (
                "influence",
                largest,
                influence.conditions[0].as_slice().to_vec(),
            ),
        ]
    }

    /// Largest difference of each list, in its unit.
    fn compare(
        whole: &[(&'static str, f64, Vec<f64>)],
        parts: &[(&'static str, f64, Vec<f64>)],
    ) -> Vec<(&'static str, f64)> {
        let pairs = whole.iter().zip(parts);
        pairs
            .map(|((name, unit, a), (_, _, b))| {
                assert_eq!(a.len(), b.len());
                let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs() / unit);
                (*name, apart.fold(0.0, f64::max))
            })
            .collect()
    }

    #[test]
    fn blocks_give_what_the_whole_gives() {
        let toy = toy(71);
        for kernel in [Kernel::LeastSquares, Kernel::Huber { k: 1.345 }] {
            let whole = answer(&toy, &cut(INTERVALS), kernel);
            // 2, 7, 100 and 150 blocks, and a last block of one record
            for block_records in [150, 43, 3, 2, INTERVALS - 1] {
                let parts = answer(&toy, &cut(block_records), kernel);
                let apart = compare(&whole, &parts);
                println!("{kernel:?} {block_records} {apart:?}");
                for (name, apart) in apart {
                    assert!(apart < 1e-12, "{block_records}: {name} {apart}");
                }
            }
        }
    }

    /// A gap in the conditions that is longer than several blocks.
    #[test]
    fn blocks_without_conditions() {
        let mut toy = toy(72);
        toy.rows.retain(|row| !(90..205).contains(&row.interval));
        let whole = answer(&toy, &cut(INTERVALS), Kernel::LeastSquares);
        let parts = answer(&toy, &cut(25), Kernel::LeastSquares);
        for (name, apart) in compare(&whole, &parts) {
            assert!(apart < 1e-12, "{name} {apart}");
        }
    }

    fn bits(answer: Vec<(&'static str, f64, Vec<f64>)>) -> Vec<u64> {
        let numbers = answer.into_iter().flat_map(|(_, _, numbers)| numbers);
        numbers.map(f64::to_bits).collect()
    }

    #[test]
    fn one_and_two_threads_and_a_file_give_the_same_bytes() {
        let (toy, folder) = (toy(73), tempfile::tempdir().unwrap());
        let kernel = Kernel::Huber { k: 1.345 };
        let run = |threads, large: Large| {
            let workers = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            bits(workers.install(|| answer(&toy, &large, kernel)))
        };
        let expected = run(1, cut(40));
        assert_eq!(expected, run(2, cut(40)));
        assert_eq!(expected, run(2, spilled(40, folder.path())));
        assert_ne!(expected, run(2, cut(39)), "cuts elsewhere round elsewhere");
        let whole = run(2, cut(INTERVALS));
        assert_eq!(whole, run(1, spilled(INTERVALS, folder.path())));
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    }

    #[test]
    fn snooping_and_score_tests_do_not_see_the_cuts() {
        let mut toy = toy(74);
        for (k, error) in [(77, 6.0), (450, -9.0), (899, 5.0)] {
            toy.rows[k].observed += error;
        }
        let snooped = |large: Large| {
            let mut problem = toy.problem();
            problem.large = large;
            let quality = QualityOptions::default();
            let options = options(Kernel::LeastSquares);
            let start = Estimate::new(toy.parameters());
            let mut found = snoop(&problem, start, &options, &quality, 10).unwrap();
            let score_options = ScoreOptions {
                family_alpha: 0.01,
                most_guilty: 0,
                misfit: (0.0, 1.0),
            };
            let wave = Suspect {
                name: "wave".to_owned(),
                components: vec![Component::new("wave", Unit::Metre)],
                jumps: vec![],
            };
            let (solution, columns) = (&found.solution, [Some(&Wave as &dyn ScoreColumns)]);
            let scores = score_tests(&problem, solution, &[wave], &columns, &score_options);
            found.removed.sort_unstable();
            (found.removed, scores.unwrap().alone[0].statistic)
        };
        let whole = snooped(cut(INTERVALS));
        assert!([77, 450, 899].iter().all(|k| whole.0.contains(&(0, *k))));
        let parts = snooped(cut(15));
        assert_eq!(whole.0, parts.0);
        let apart = (whole.1 - parts.1).abs() / whole.1;
        assert!(apart < 1e-10, "{whole:?} {parts:?}");
    }

    /// A suspect column that every condition has.
    struct Wave;

    impl ScoreColumns for Wave {
        fn derive(&self, k: usize, _: &Solved, _: &Row, push: &mut dyn FnMut(usize, f64)) {
            push(0, crate::math::sin(0.013 * k as f64));
        }
    }

    #[test]
    fn every_block_once() {
        let toy = toy(75);
        let mut problem = toy.problem();
        problem.large = cut(43);
        let at = Estimate {
            parameters: toy.parameters(),
            chain: Some(ChainState::zero(&toy.model)),
        };
        let (parts, blocks) = reduced_blocks_of(&problem, &at).unwrap();
        let together = |parts| combine(parts, &toy.model, &blocks);
        let expected = together(parts.clone()).unwrap();
        let mut turned = parts.clone();
        turned.reverse();
        let turned = together(turned).unwrap();
        assert_eq!(turned.loss, expected.loss);
        assert_eq!(turned.normal, expected.normal);

        let refused = |parts| together(parts).unwrap_err().to_string();
        let mut missing = parts.clone();
        missing.remove(3);
        assert_eq!(
            refused(missing),
            "block 3 of 7 of the trajectory chain is missing"
        );
        let mut short = parts.clone();
        short.pop();
        assert_eq!(
            refused(short),
            "block 6 of 7 of the trajectory chain is missing"
        );
        let mut double = parts.clone();
        double.push(parts[2].clone());
        assert!(refused(double).starts_with("block 2 of the trajectory chain came twice"));
        assert!(refused(vec![]).starts_with("block 0 of 7"));
        let mut alien = parts.clone();
        alien[6].block = 7;
        assert!(refused(alien).starts_with("block 7 of the trajectory chain"));
        let mut alien = parts.clone();
        alien.push(parts[0].clone());
        alien[7].block = 7;
        assert!(refused(alien).starts_with("block 7 of the trajectory chain"));
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let (toy, folder) = (toy(76), tempfile::tempdir().unwrap());
        let place = folder.path().join("nowhere");
        let error = solved(&toy, &spilled(100, &place), Kernel::LeastSquares).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("cannot open a file in "), "{text}");
        assert!(
            text.contains("nowhere") && text.contains("[large] spill"),
            "{text}"
        );
    }
}
