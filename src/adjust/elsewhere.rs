//! Blocks of a chain that are worked on in other processes.
//!
//! ```text
//! coordinator                                                    worker, one per question
//! question(block): where to linearise, states of the block  ->   the block's conditions, reduced: ReducedNormals
//! combine in the blocks' order, step
//! question(block): the step of the columns and the cuts     ->   steps of the states inside the block
//! question(block): cofactors at the block's ends            ->   figures of its conditions, window by window
//! ```
//!
//! An answer depends on the question and the observations alone: whoever is asked again, or instead, gives the same bytes. A worker
//! holds the factor of a block that it reduced, and makes it again where it has not got it.

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::DMatrix;

use super::bits::Bits;
use super::block::{Cut, Inside, ReducedNormals, inside};
use super::chain::{ChainModel, ChainState};
use super::error::AdjustError;
use super::kernel::Kernel;
use super::linearise::{factor_bytes, reduced_alone};
use super::parameters::ParameterSet;
use super::partition::{blocks, conditions_of, sees_chain};
use super::pass::{Pass, Tally, Weighting};
use super::problem::{Estimate, Problem};
use super::store::{Page, Reader, Store};
use crate::files::wire::{Packer, Torn, Unpacker};
use crate::watch::Stopped;

/// Whoever hands questions to other processes.
pub trait Elsewhere: Sync {
    /// Asks one question of each block, in the blocks' order, and gives the answers of [`Worker::answer`] in the same order.
    ///
    /// # Errors
    /// [`Stopped`].
    fn ask(&self, questions: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Stopped>;
}

/// Which conditions of each set belong to each block of a problem's chain; those that do not see the chain belong to the first. Nothing
/// where the chain is not cut, as there is nothing to hand out.
#[must_use]
pub fn shares(problem: &Problem) -> Vec<Vec<Range<usize>>> {
    let blocks = problem.chain.map(|chain| blocks(chain, &problem.large));
    let blocks = blocks.filter(|blocks| blocks.len() > 1).unwrap_or_default();
    let share = |(block, intervals): (usize, &Range<usize>)| {
        let of_set = |set: usize| match (sees_chain(problem, set), block) {
            (true, _) => conditions_of(problem, set, intervals),
            (false, 0) => 0..problem.sources[set].conditions.len(),
            (false, _) => 0..0,
        };
        (0..problem.sources.len()).map(of_set).collect()
    };
    blocks.iter().enumerate().map(share).collect()
}

/// What a question is about.
const REDUCE: u8 = 1;
const STEP: u8 = 2;
/// How an answer begins: it is one, or there was none.
const FOUND: u8 = 1;
const NOTHING: u8 = 0;

impl From<Torn> for AdjustError {
    fn from(torn: Torn) -> Self {
        AdjustError::Torn(torn)
    }
}

/// Has the blocks reduced elsewhere. Nothing where one of them could not be: whoever asked does it himself then, and finds why.
pub(super) fn reduced(
    elsewhere: &dyn Elsewhere,
    pass: &Pass,
    blocks: &[Range<usize>],
) -> Result<Option<(Vec<ReducedNormals>, Inside)>, AdjustError> {
    let points = points(pass, blocks);
    let question = |point: &Vec<u8>| Packer::default().byte(REDUCE).bytes(point).done();
    let answers = elsewhere.ask(points.iter().map(question).collect())?;
    let mut parts = Vec::new();
    for answer in &answers {
        let Some(mut answer) = found(answer)? else {
            return Ok(None);
        };
        parts.push(ReducedNormals::unpack(&mut answer)?);
        answer.end()?;
    }
    Ok(Some((parts, Inside::Elsewhere(points))))
}

/// Steps of the states inside the blocks; `columns` and `ahead` are those of [`inside`]. Nothing where a block gave none.
pub(super) fn steps(
    elsewhere: &dyn Elsewhere,
    points: &[Vec<u8>],
    step: impl Fn(usize) -> (Vec<f64>, Vec<f64>),
) -> Result<Option<Vec<Vec<f64>>>, AdjustError> {
    let question = |(block, point): (usize, &Vec<u8>)| {
        let (columns, ahead) = step(block);
        let mut question = Packer::default();
        question.byte(STEP).bytes(point).numbers(&columns);
        question.numbers(&ahead).done()
    };
    let questions = points.iter().enumerate().map(question).collect();
    let answers = elsewhere.ask(questions)?;
    let (mut steps, blocks) = (Vec::new(), points.len());
    for (expected, answer) in answers.iter().enumerate() {
        let Some(mut answer) = found(answer)? else {
            return Ok(None);
        };
        let block = answer.count()?;
        if block != expected || block >= blocks {
            return Err(AdjustError::SurplusBlock { block, blocks });
        }
        steps.push(answer.numbers()?);
        answer.end()?;
    }
    match steps.len() {
        block if block < blocks => Err(AdjustError::MissingBlock { block, blocks }),
        _ => Ok(Some(steps)),
    }
}

/// What an answer holds.
fn found(answer: &[u8]) -> Result<Option<Unpacker<'_>>, Torn> {
    let mut rest = Unpacker::new(answer);
    match rest.byte()? {
        FOUND => Ok(Some(rest)),
        NOTHING => Ok(None),
        _ => Err(Torn),
    }
}

/// Where each block is to be linearised.
fn points(pass: &Pass, blocks: &[Range<usize>]) -> Vec<Vec<u8>> {
    let shares = shares(pass.problem);
    let point = |(block, intervals): (usize, &Range<usize>)| {
        let mut point = Packer::default();
        point.count(block).count(blocks.len());
        let x = &pass.at.parameters;
        point.numbers(&x.values());
        let held = x.blocks().iter().flat_map(|block| &block.held);
        point.bytes(&held.map(|held| u8::from(*held)).collect::<Vec<_>>());
        pack_weighting(pass.weighting, &mut point);
        point.numbers(&pass.problem.components);
        let states = pass.at.chain.as_ref();
        point.numbers(states.map_or(&[], |s| s.stretch(intervals.start..intervals.end + 1)));
        for (source, share) in pass.problem.sources.iter().zip(&shares[block]) {
            let ignored = |k: &usize| source.ignored.is_some_and(|ignored| ignored.get(*k));
            let ignored: Vec<usize> = share.clone().filter(ignored).collect();
            point.count(ignored.len());
            let mut last = share.start;
            for k in ignored {
                point.count(k - last);
                last = k;
            }
        }
        point.done()
    };
    blocks.iter().enumerate().map(point).collect()
}

fn pack_weighting(weighting: Weighting, to: &mut Packer) {
    let (tag, value) = match weighting {
        Weighting::Uniform(weight) => (0, weight),
        Weighting::Kernel(Kernel::LeastSquares) => (1, 0.0),
        Weighting::Kernel(Kernel::Huber { k }) => (2, k),
        Weighting::Kernel(Kernel::Cauchy { k }) => (3, k),
        Weighting::Kernel(Kernel::Tukey { k }) => (4, k),
        Weighting::Kernel(Kernel::GemanMcClure { k }) => (5, k),
    };
    to.byte(tag).number(value);
}

fn unpack_weighting(from: &mut Unpacker) -> Result<Weighting, Torn> {
    let (tag, k) = (from.byte()?, from.number()?);
    Ok(match tag {
        0 => Weighting::Uniform(k),
        1 => Weighting::Kernel(Kernel::LeastSquares),
        2 => Weighting::Kernel(Kernel::Huber { k }),
        3 => Weighting::Kernel(Kernel::Cauchy { k }),
        4 => Weighting::Kernel(Kernel::Tukey { k }),
        5 => Weighting::Kernel(Kernel::GemanMcClure { k }),
        _ => return Err(Torn),
    })
}

/// Where a block is linearised.
struct Point {
    block: usize,
    intervals: Range<usize>,
    at: Estimate,
    weighting: Weighting,
    components: Vec<f64>,
    ignored: Vec<Bits>,
}

impl Point {
    /// Of the bytes; `problem` holds the conditions of the block alone.
    fn unpack(
        bytes: &[u8],
        problem: &Problem,
        model: &ChainModel,
        x: &ParameterSet,
    ) -> Result<Self, Torn> {
        let mut from = Unpacker::new(bytes);
        let blocks = blocks(model, &problem.large);
        let (block, of) = (from.count()?, from.count()?);
        let intervals = blocks.get(block).cloned().ok_or(Torn)?;
        let mut parameters = x.with_values(&from.numbers()?).ok_or(Torn)?;
        hold(&mut parameters, from.bytes()?)?;
        let weighting = unpack_weighting(&mut from)?;
        let components = from.numbers()?;
        let states = from.numbers()?;
        let expected = (intervals.len() + 1) * model.state_size();
        if of != blocks.len() || states.len() != expected {
            return Err(Torn);
        }
        let chain = ChainState::of_stretch(model, intervals.start, states);
        let sources = problem.sources.iter();
        let ignored = sources.map(|source| marks(&mut from, source.conditions.len()));
        let ignored = ignored.collect::<Result<_, _>>()?;
        from.end()?;
        let at = Estimate {
            parameters,
            chain: Some(chain),
        };
        Ok(Self {
            block,
            intervals,
            at,
            weighting,
            components,
            ignored,
        })
    }
}

fn hold(parameters: &mut ParameterSet, held: &[u8]) -> Result<(), Torn> {
    let mut held = held.iter();
    for id in parameters.ids() {
        for mark in &mut parameters.block_mut(id).held {
            *mark = *held.next().ok_or(Torn)? > 0;
        }
    }
    held.next().map_or(Ok(()), |_| Err(Torn))
}

fn marks(from: &mut Unpacker, conditions: usize) -> Result<Bits, Torn> {
    let (mut bits, mut k) = (Bits::none(conditions), 0);
    for _ in 0..from.count()? {
        k += from.count()?;
        bits.set(k);
    }
    Ok(bits)
}

/// What a process that works on blocks holds from question to question: the factors of the blocks that it reduced last.
#[derive(Debug, Default)]
pub struct Worker {
    held: HashMap<usize, Held>,
}

/// The factor of a block's interior.
#[derive(Debug)]
struct Held {
    /// Where the block was linearised.
    point: Vec<u8>,
    pages: Vec<Page>,
    store: Store,
}

impl Worker {
    /// The block that a question is about.
    ///
    /// # Errors
    /// [`AdjustError::Torn`].
    pub fn block_of(question: &[u8]) -> Result<usize, AdjustError> {
        let mut from = Unpacker::new(question);
        from.byte()?;
        Ok(Unpacker::new(from.bytes()?).count()?)
    }

    /// Answers a question. `problem` holds the conditions of its block alone ([`shares`]), `x` the parameters at any value.
    ///
    /// # Errors
    /// [`AdjustError::Torn`]. What is wrong with the conditions is no error: whoever asked finds it himself.
    pub fn answer(
        &mut self,
        problem: &Problem,
        x: &ParameterSet,
        question: &[u8],
    ) -> Result<Vec<u8>, AdjustError> {
        match self.answered(problem, x, question) {
            Err(AdjustError::Torn(torn)) => Err(torn.into()),
            Err(_) => Ok(vec![NOTHING]),
            Ok(mut answer) => Ok(answer.done()),
        }
    }

    fn answered(
        &mut self,
        problem: &Problem,
        x: &ParameterSet,
        question: &[u8],
    ) -> Result<Packer, AdjustError> {
        let model = problem.chain.ok_or(Torn)?;
        let mut question = Unpacker::new(question);
        let kind = question.byte()?;
        let bytes = question.bytes()?;
        let point = Point::unpack(bytes, problem, model, x)?;
        let mut answer = Packer::default();
        answer.byte(FOUND);
        match kind {
            REDUCE => self
                .reduce(problem, model, bytes, &point)?
                .pack(&mut answer),
            STEP => {
                let (columns, ahead) = (question.numbers()?, question.numbers()?);
                let held = self.factor(problem, model, bytes, &point)?;
                let reader = Reader::new(&held.store, &held.pages);
                answer.count(point.block);
                answer.numbers(&inside(reader, &columns, ahead, model.state_size())?);
            }
            _ => return Err(Torn.into()),
        }
        question.end()?;
        Ok(answer)
    }

    /// The factor of a block at a point.
    fn factor(
        &mut self,
        problem: &Problem,
        model: &ChainModel,
        bytes: &[u8],
        point: &Point,
    ) -> Result<&Held, AdjustError> {
        let held = self.held.get(&point.block);
        if held.is_none_or(|held| held.point != bytes) {
            self.reduce(problem, model, bytes, point)?;
        }
        self.held.get(&point.block).ok_or(Torn.into())
    }

    /// Reduces a block and holds its factor.
    fn reduce(
        &mut self,
        problem: &Problem,
        model: &ChainModel,
        bytes: &[u8],
        point: &Point,
    ) -> Result<ReducedNormals, AdjustError> {
        let mut problem = problem.clone();
        problem.components.clone_from(&point.components);
        let masks = problem.sources.iter_mut().zip(&point.ignored);
        masks.for_each(|(source, ignored)| source.ignored = Some(ignored));
        let pass = Pass {
            problem: &problem,
            at: &point.at,
            weighting: point.weighting,
        };
        let old = self.held.remove(&point.block);
        let (spare, store) = old.map_or((vec![], None), |old| (old.pages, Some(old.store)));
        let columns = point.at.parameters.free_columns().len() + 1;
        let all = blocks(model, &problem.large);
        let bytes_of_all = factor_bytes(model, columns, &all)?;
        let store = Store::of_size(bytes_of_all, &problem.large, store)?;
        let block = (point.block, &point.intervals);
        let (reduced, pages) = reduced_alone(&pass, model, block, &store, spare)?;
        let held = Held {
            point: bytes.to_vec(),
            pages,
            store,
        };
        self.held.insert(point.block, held);
        Ok(reduced)
    }
}

impl ReducedNormals {
    fn pack(&self, to: &mut Packer) {
        to.count(self.block);
        to.count(self.normal.width).numbers(&self.normal.values);
        pack_matrix(&self.loss, to);
        let t = &self.tally;
        to.count(t.conditions);
        to.numbers(&[t.cost, t.omega, t.influence_square, t.slope, t.slope_square]);
        to.number(self.prior_cost);
        for cut in [&self.first, &self.last] {
            to.byte(u8::from(cut.is_some()));
            if let Some(cut) = cut {
                pack_matrix(&cut.own, to);
                pack_matrix(&cut.border, to);
            }
        }
        pack_matrix(&self.between, to);
    }

    fn unpack(from: &mut Unpacker) -> Result<Self, Torn> {
        let block = from.count()?;
        let (width, values) = (from.count()?, from.numbers()?);
        if width.checked_mul(width) != Some(values.len()) {
            return Err(Torn);
        }
        let loss = unpack_matrix(from)?;
        let conditions = from.count()?;
        let sums: [f64; 5] = from.numbers()?.try_into().map_err(|_| Torn)?;
        let [cost, omega, influence_square, slope, slope_square] = sums;
        let prior_cost = from.number()?;
        let mut cut = || -> Result<Option<Cut>, Torn> {
            Ok(match from.byte()? {
                0 => None,
                _ => Some(Cut {
                    own: unpack_matrix(from)?,
                    border: unpack_matrix(from)?,
                }),
            })
        };
        let (first, last) = (cut()?, cut()?);
        Ok(ReducedNormals {
            block,
            normal: super::accumulate::Normal { width, values },
            loss,
            tally: Tally {
                cost,
                conditions,
                omega,
                influence_square,
                slope,
                slope_square,
            },
            prior_cost,
            first,
            last,
            between: unpack_matrix(from)?,
        })
    }
}

fn pack_matrix(matrix: &DMatrix<f64>, to: &mut Packer) {
    to.count(matrix.nrows()).numbers(matrix.as_slice());
}

fn unpack_matrix(from: &mut Unpacker) -> Result<DMatrix<f64>, Torn> {
    let (rows, values) = (from.count()?, from.numbers()?);
    match values.len().checked_rem(rows) {
        Some(0) => Ok(DMatrix::from_vec(rows, values.len() / rows, values)),
        None if values.is_empty() => Ok(DMatrix::zeros(0, 0)),
        _ => Err(Torn),
    }
}

#[cfg(test)]
mod tests {
    use super::super::toys::Toy;
    use super::super::*;
    use super::{NOTHING, STEP, Worker, shares};
    use crate::watch::Stopped;
    use std::ops::Range;
    use std::sync::Mutex;

    /// Some conditions of a toy, numbered from zero.
    struct Part<'a>(&'a Toy, Range<usize>);

    impl Conditions for Part<'_> {
        fn len(&self) -> usize {
            self.1.len()
        }

        fn group(&self, k: usize) -> u16 {
            self.0.group(self.1.start + k)
        }

        fn interval(&self, k: usize) -> Option<u32> {
            self.0.interval(self.1.start + k)
        }

        fn linearise(&self, k: usize, x: &ParameterSet, at: Option<&ChainState>, row: &mut Row) {
            self.0.linearise(self.1.start + k, x, at, row);
        }
    }

    /// What becomes of the answers on their way.
    #[derive(Clone, Copy, PartialEq)]
    enum Way {
        /// Each question is answered by the worker that answered the last one.
        Same,
        /// Each by a worker of its own, which holds nothing.
        Another,
        /// By two in turn: who is asked for steps has reduced the block elsewhere.
        Turns,
        /// Now and then there is none.
        Gap,
        /// The answer of the second block comes twice.
        Twice,
        /// Two blocks' steps are swapped.
        Swapped,
        /// The steps of the last block are missing.
        Short,
        /// It ends too early.
        Torn,
    }

    /// Workers in this process, each with the conditions of one block.
    struct Hired<'a> {
        toy: &'a Toy,
        large: Large,
        shares: Vec<Vec<Range<usize>>>,
        way: Way,
        workers: Mutex<[Worker; 2]>,
        asked: Mutex<usize>,
    }

    impl Elsewhere for Hired<'_> {
        fn ask(&self, questions: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Stopped> {
            let mut workers = self.workers.lock().unwrap();
            let turn = usize::from(self.way == Way::Turns && questions[0][0] == STEP);
            let worker = &mut workers[turn];
            let x = self.toy.parameters();
            let mut answers = Vec::new();
            for (block, question) in questions.iter().enumerate() {
                assert_eq!(Worker::block_of(question), Ok(block));
                let part = Part(self.toy, self.shares[block][0].clone());
                let mut problem = Problem::with_chain(vec![Source::new(&part)], &self.toy.model);
                problem.large = self.large.clone();
                if self.way == Way::Another {
                    *worker = Worker::default();
                }
                let mut asked = self.asked.lock().unwrap();
                *asked += 1;
                let mut answer = worker.answer(&problem, &x, question).unwrap();
                match self.way {
                    Way::Gap if asked.is_multiple_of(5) => answer = vec![NOTHING],
                    Way::Torn => answer.truncate(answer.len() - 1),
                    _ => {}
                }
                answers.push(answer);
            }
            let steps = questions[0][0] == STEP;
            match self.way {
                Way::Twice => answers[2] = answers[1].clone(),
                Way::Swapped if steps => answers.swap(3, 4),
                Way::Short if steps => drop(answers.pop()),
                _ => {}
            }
            Ok(answers)
        }
    }

    /// A toy with gross errors.
    fn toy() -> Toy {
        let mut toy = Toy::new(77, 301, 3);
        let wrong = [(77, 6.0), (450, -9.0), (899, 5.0)];
        wrong
            .iter()
            .for_each(|(k, error)| toy.rows[*k].observed += error);
        toy
    }

    fn large() -> Large {
        Large {
            block_records: 43,
            ..Large::default()
        }
    }

    fn hired(toy: &Toy, large: Large, way: Way) -> Hired<'_> {
        let mut problem = toy.problem();
        problem.large = large.clone();
        Hired {
            toy,
            shares: shares(&problem),
            large,
            way,
            workers: Mutex::default(),
            asked: Mutex::new(0),
        }
    }

    /// Everything that snooping says, and how many questions were asked.
    fn snooped(
        toy: &Toy,
        large: &Large,
        kernel: Kernel,
        hired: Option<&Hired>,
    ) -> Result<(String, usize), AdjustError> {
        let mut problem = toy.problem();
        problem.large = large.clone();
        problem.components = vec![1.0, 1.3];
        problem.elsewhere = hired.map(|hired| hired as &dyn Elsewhere);
        let options = Options {
            kernel,
            ..Options::default()
        };
        let (start, quality) = (Estimate::new(toy.parameters()), QualityOptions::default());
        let found = snoop(&problem, start, &options, &quality, 3)?;
        let masks = problem.sources.iter_mut().zip(&found.ignored);
        masks.for_each(|(source, ignored)| source.ignored = Some(ignored));
        let influence = influence(&problem, &found.solution)?;
        let solution = &found.solution;
        let asked = hired.map_or(0, |hired| *hired.asked.lock().unwrap());
        let all = format!(
            "{:?} {:?} {} {} {:?} {:?} {:?} {:?}",
            solution.estimate,
            solution.iterations,
            solution.cost,
            solution.omega,
            solution.cofactor,
            found.quality,
            found.removed,
            influence
        );
        Ok((all, asked))
    }

    #[test]
    fn blocks_of_other_processes_leave_the_same_bits() {
        let toy = toy();
        for kernel in [Kernel::LeastSquares, Kernel::Huber { k: 1.345 }] {
            let (here, _) = snooped(&toy, &large(), kernel, None).unwrap();
            assert!(here.contains("(0, 77)") && here.contains("(0, 899)"));
            for way in [Way::Same, Way::Another, Way::Turns, Way::Gap] {
                let hired = hired(&toy, large(), way);
                let (there, asked) = snooped(&toy, &large(), kernel, Some(&hired)).unwrap();
                let apart = there.bytes().zip(here.bytes()).position(|(a, b)| a != b);
                let around =
                    |text: &str, at: usize| text[at.saturating_sub(200)..][..300].to_owned();
                let shown = apart.map(|at| (around(&here, at), around(&there, at)));
                assert!(there == here, "{kernel:?} {shown:?}");
                // seven blocks, reduced and stepped at least twice by each of two adjustments
                assert!(asked >= 7 * 8 && asked % 7 == 0, "{asked}");
            }
        }
    }

    #[test]
    fn a_factor_of_another_process_may_go_to_a_file() {
        let toy = toy();
        let small = Large {
            factor_memory: 0,
            ..large()
        };
        let (here, _) = snooped(&toy, &large(), Kernel::LeastSquares, None).unwrap();
        let hired = hired(&toy, small.clone(), Way::Same);
        let there = snooped(&toy, &small, Kernel::LeastSquares, Some(&hired)).unwrap();
        assert!(there.0 == here);
    }

    #[test]
    fn a_chain_that_is_not_cut_stays_here() {
        let (toy, whole) = (toy(), Large::default());
        let hired = hired(&toy, whole.clone(), Way::Same);
        assert!(hired.shares.is_empty());
        let (_, asked) = snooped(&toy, &whole, Kernel::LeastSquares, Some(&hired)).unwrap();
        assert_eq!(asked, 0);
    }

    #[test]
    fn a_missing_a_double_and_a_torn_answer_are_refused() {
        let toy = toy();
        let refused = |way| {
            let hired = hired(&toy, large(), way);
            let ended = snooped(&toy, &large(), Kernel::LeastSquares, Some(&hired));
            ended.unwrap_err().to_string()
        };
        let double = refused(Way::Twice);
        assert!(
            double.starts_with("block 1 of the trajectory chain came twice"),
            "{double}"
        );
        assert!(refused(Way::Swapped).starts_with("block 4 of the trajectory chain came twice"));
        assert_eq!(
            refused(Way::Short),
            "block 6 of 7 of the trajectory chain is missing"
        );
        assert!(refused(Way::Torn).contains("cannot be read"));
        let hired = hired(&toy, large(), Way::Same);
        let part = Part(&toy, hired.shares[0][0].clone());
        let mut problem = Problem::with_chain(vec![Source::new(&part)], &toy.model);
        problem.large = large();
        let mut worker = Worker::default();
        for nonsense in [&[][..], &[9, 1, 0], &[1, 0], &[1, 3, 99, 7, 0]] {
            let answer = worker.answer(&problem, &toy.parameters(), nonsense);
            assert!(matches!(answer, Err(AdjustError::Torn(_))), "{nonsense:?}");
        }
    }
}
