//! Block Cholesky elimination of a block of the chain.
//!
//! The normal matrix is block tridiagonal over the epochs with a border of the parameters. Epoch after epoch:
//! `A = L L^T`, `U = L^-1 O`, `W = L^-1 B`; the next epoch loses `U^T U` and `U^T W`, the parameters lose `W^T W`
//! (Triggs et al., "Bundle adjustment – a modern synthesis", 2000, sec. 6).
//!
//! A block lies between two cuts, epochs whose states stay ([`super::block`]). Those of the first cut are further columns of the
//! border, in front of the parameters; those of the last one are what the last epoch inside is coupled with. A chain that is not cut
//! is one block without cuts.

use crate::math::dense::add_squares;
use std::ops::Range;

use nalgebra::DMatrix;
use pulp::Arch;

use super::accumulate::{Window, pair};
use super::block::Cut;
use super::chain::{ChainModel, ChainState};
use super::error::AdjustError;
use super::factor::{Factor, Quad, Square, compiled_size, with_size};
use super::store::{Page, Store};

/// How a process runs from an epoch to the next.
#[derive(Clone, Copy)]
struct Link {
    /// Transition.
    phi: f64,
    /// Inverse variance of the innovation.
    information: f64,
}

/// What a block's elimination is about.
#[derive(Clone, Copy)]
pub(super) struct Plan<'a> {
    pub model: &'a ChainModel,
    pub state: &'a ChainState,
    /// Columns kept: the free ones, then the misclosure.
    pub columns: &'a [usize],
    /// Where the factor is kept.
    pub store: &'a Store,
}

impl Plan<'_> {
    /// Whether a block begins at a cut, not with the chain.
    pub(super) fn begins_at_cut(block: &Range<usize>) -> bool {
        block.start > 0
    }

    /// Whether it ends at a cut.
    fn ends_at_cut(&self, block: &Range<usize>) -> bool {
        block.end < self.model.intervals()
    }

    /// Compiled state size and columns of `W` of a block.
    pub(super) fn shape(&self, block: &Range<usize>) -> Result<(usize, usize), AdjustError> {
        let size = compiled_size(self.model.state_size())?;
        let first = usize::from(Self::begins_at_cut(block)) * size;
        Ok((size, first + self.columns.len()))
    }
}

/// Forward elimination in progress.
pub(super) struct Elimination<'a> {
    plan: Plan<'a>,
    model: &'a ChainModel,
    /// Intervals of the block.
    block: Range<usize>,
    /// Columns in front of the parameters: the states of the first cut.
    first_columns: usize,
    /// The epochs being eliminated.
    factor: Factor,
    /// The epochs before.
    kept: Vec<Page>,
    /// Memory to be used again.
    spare: Vec<Factor>,
    /// What the epochs so far have taken from the next one, `-U^T [U | W]`.
    carry: Vec<Quad>,
    /// Links of the processes into the epoch, and out of it.
    links: [Vec<Link>; 2],
    /// Schur complement's loss `W^T W` over first cut, free columns and right-hand side.
    loss: DMatrix<f64>,
    /// Cost of the states' priors.
    prior_cost: f64,
    /// The first cut as the block's own conditions and processes see it, nothing eliminated.
    first: Option<Cut>,
    /// The widest instructions of this machine; they give the same bits as any others.
    arch: Arch,
}

/// A block, eliminated.
pub(super) struct Eliminated {
    /// The factor of its interior.
    pub kept: Vec<Page>,
    /// What the interior takes from the parameters, over free columns and right-hand side.
    pub loss: DMatrix<f64>,
    /// Cost of the states' priors, those of the last cut included.
    pub prior_cost: f64,
    /// What is left of its cuts.
    pub first: Option<Cut>,
    pub last: Option<Cut>,
    /// First cut by last cut.
    pub between: DMatrix<f64>,
}

impl<'a> Elimination<'a> {
    /// Starts; `recycled` lends its memory.
    pub(super) fn new(
        plan: Plan<'a>,
        block: Range<usize>,
        recycled: Vec<Page>,
    ) -> Result<Self, AdjustError> {
        let (size, width) = plan.shape(&block)?;
        let model = plan.model;
        let start = |process: &super::Process| Link {
            phi: 0.0,
            information: process.sigma.powi(-2),
        };
        let first: Vec<Link> = model.processes().iter().map(start).collect();
        let factor = Factor::default().sized(size, width, 0..0);
        Ok(Elimination {
            model,
            plan,
            first_columns: width - plan.columns.len(),
            carry: vec![[0.0; 4]; size * factor.quads],
            factor,
            kept: Vec::new(),
            spare: recycled.into_iter().filter_map(Page::memory).collect(),
            links: [first.clone(), first],
            loss: DMatrix::zeros(width, width),
            prior_cost: 0.0,
            first: None,
            block,
            arch: Arch::new(),
        })
    }

    /// Eliminates the epochs of neighbouring windows, all but the last one unless it ends the chain, and keeps their factor.
    pub(super) fn eliminate<'w>(
        &mut self,
        windows: impl Iterator<Item = &'w Window> + Clone,
    ) -> Result<(), AdjustError> {
        let ranges = windows.clone().map(|window| self.inside(window));
        let Some(epochs) = ranges.reduce(|all, next| all.start..next.end) else {
            return Ok(());
        };
        let memory = self.spare.pop().unwrap_or_default();
        self.factor = memory.sized(self.factor.size, self.factor.width, epochs);
        for window in windows {
            with_size!(self.factor.size, N => self.window::<N>(window)?);
        }
        let page = std::mem::take(&mut self.factor);
        let (size, width) = (page.size, page.width);
        let memory = self.plan.store.keep(page, &mut self.kept)?;
        self.spare.extend(memory);
        self.factor = Factor::default().sized(size, width, 0..0);
        Ok(())
    }

    /// Epochs of a window that are eliminated.
    fn inside(&self, window: &Window) -> Range<usize> {
        let intervals = &window.intervals;
        let cut = intervals.start == self.block.start && Plan::begins_at_cut(&self.block);
        let ends = intervals.end == self.model.intervals();
        intervals.start + usize::from(cut)..intervals.end + usize::from(ends)
    }

    fn window<const N: usize>(&mut self, window: &Window) -> Result<(), AdjustError> {
        let inside = self.inside(window);
        if inside.start > window.intervals.start {
            self.first_cut(window);
        }
        for epoch in inside.clone() {
            self.epoch::<N>(epoch, window)?;
        }
        let rows = self.factor.rows(inside);
        add_squares(&mut self.loss, rows, self.factor.quads, self.factor.size);
        Ok(())
    }

    fn epoch<const N: usize>(&mut self, epoch: usize, window: &Window) -> Result<(), AdjustError> {
        let local = epoch - window.intervals.start;
        self.link(epoch);
        let own = self.own::<N>(local, window);
        self.fill::<N>(epoch, local, window);
        self.prior_gradient::<N>(epoch);
        self.factor
            .eliminate(epoch, own, &mut self.carry, self.arch)
    }

    /// Moves on to the links out of an epoch; out of the last one leads nothing.
    fn link(&mut self, epoch: usize) {
        self.links.swap(0, 1);
        let ends = epoch == self.model.intervals();
        for (link, process) in self.links[1].iter_mut().zip(self.model.processes()) {
            *link = match ends {
                true => Link {
                    phi: 0.0,
                    information: 0.0,
                },
                false => Link {
                    phi: self.model.transition(process, epoch),
                    information: 1.0 / self.model.innovation(process, epoch),
                },
            };
        }
    }

    /// The epoch's own block: conditions, priors, and what earlier epochs took. Idle states have unit information.
    fn own<const N: usize>(&self, local: usize, window: &Window) -> Square<N> {
        let (processes, sums) = (self.model.processes(), window.own(local));
        let mut own = [[0.0; N]; N];
        for (i, (row, carry)) in own
            .iter_mut()
            .zip(self.carry.chunks_exact(self.factor.quads))
            .enumerate()
        {
            row.copy_from_slice(&carry.as_flattened()[..N]);
            match processes.get(i) {
                Some(a) => {
                    row.iter_mut()
                        .zip(processes)
                        .for_each(|(entry, b)| *entry += sums[pair(a.component, b.component)]);
                    let (into, out) = (self.links[0][i], self.links[1][i]);
                    row[i] += into.information + out.phi * out.phi * out.information;
                }
                None => row[i] += 1.0,
            }
        }
        own
    }

    /// Fills the rows `[O | B]` of an epoch.
    fn fill<const N: usize>(&mut self, epoch: usize, local: usize, window: &Window) {
        let (processes, quads) = (self.model.processes(), self.factor.quads);
        let last = epoch == self.model.intervals();
        let follows_cut = self.first_columns > 0 && epoch == self.block.start + 1;
        let rows = self.factor.rows_mut(epoch).chunks_exact_mut(quads);
        for (i, (row, carry)) in rows.zip(self.carry.chunks_exact(quads)).enumerate() {
            row.copy_from_slice(carry);
            let (next, border) = row.as_flattened_mut().split_at_mut(N);
            let (first, border) = border.split_at_mut(self.first_columns);
            next.fill(0.0);
            let Some(a) = processes.get(i) else { continue };
            if !last {
                let sums = window.next(local);
                next.iter_mut()
                    .zip(processes)
                    .for_each(|(entry, b)| *entry = sums[pair(a.component, b.component)]);
                next[i] -= self.links[1][i].phi * self.links[1][i].information;
            }
            if follows_cut {
                let sums = window.next(local - 1);
                first
                    .iter_mut()
                    .zip(processes)
                    .for_each(|(entry, b)| *entry = sums[pair(a.component, b.component)]);
                first[i] -= self.links[0][i].phi * self.links[0][i].information;
            }
            let sums = window.border(local, a.component);
            border
                .iter_mut()
                .zip(self.plan.columns)
                .for_each(|(entry, column)| *entry += sums[*column]);
        }
    }

    /// Adds the gradient of the process priors around this epoch, and the cost of the innovation leading to it.
    fn prior_gradient<const N: usize>(&mut self, epoch: usize) {
        let rhs = N + self.first_columns + self.plan.columns.len() - 1;
        for i in 0..self.model.state_size() {
            let into = self.innovation(epoch, i);
            let out = (epoch < self.model.intervals()).then(|| self.ahead(epoch, i));
            let row = i * self.factor.quads;
            let gradient = &mut self.factor.rows_mut(epoch)[row..].as_flattened_mut()[rhs];
            *gradient += into;
            if let Some(out) = out {
                *gradient -= out;
            }
        }
    }

    /// Gradient by an epoch's state of the innovation that leads to it, whose cost is counted.
    fn innovation(&mut self, epoch: usize, i: usize) -> f64 {
        let into = self.links[0][i];
        let before = match epoch {
            0 => 0.0,
            _ => self.plan.state.state(epoch - 1)[i],
        };
        let innovation = self.plan.state.state(epoch)[i] - into.phi * before;
        self.prior_cost += 0.5 * innovation * innovation * into.information;
        innovation * into.information
    }

    /// Less that of the innovation that leads away from it.
    fn ahead(&self, epoch: usize, i: usize) -> f64 {
        let (out, state) = (self.links[1][i], self.plan.state);
        let ahead = state.state(epoch + 1)[i] - out.phi * state.state(epoch)[i];
        out.phi * ahead * out.information
    }

    /// Begins with the epoch that is the first cut.
    fn first_cut(&mut self, window: &Window) {
        let epoch = window.intervals.start;
        self.link(epoch);
        let mut cut = self.seen(window, 0);
        for i in 0..self.model.state_size() {
            let out = self.links[1][i];
            cut.own[(i, i)] += out.phi * out.phi * out.information;
            cut.border[(i, self.plan.columns.len() - 1)] -= self.ahead(epoch, i);
        }
        self.first = Some(cut);
    }

    /// Ends at the epoch that is the last cut; `window` is what the last window left there.
    fn last_cut(&mut self, window: &Window) -> (Cut, DMatrix<f64>) {
        let epoch = window.intervals.start;
        self.links.swap(0, 1);
        let (mut cut, size) = (self.seen(window, 0), self.factor.size);
        for i in 0..self.model.state_size() {
            cut.own[(i, i)] += self.links[0][i].information;
            cut.border[(i, self.plan.columns.len() - 1)] += self.innovation(epoch, i);
        }
        let carry = |i: usize, j: usize| self.carry[i * self.factor.quads..].as_flattened()[j];
        let (first, kept) = (self.first_columns, self.plan.columns.len());
        cut.own += DMatrix::from_fn(size, size, &carry);
        cut.border += DMatrix::from_fn(size, kept, |i, j| carry(i, size + first + j));
        let between = DMatrix::from_fn(first, size, |i, j| carry(j, size + i));
        (cut, between)
    }

    /// Sums of the conditions at a local epoch of a window, in states.
    fn seen(&self, window: &Window, local: usize) -> Cut {
        let (size, columns) = (self.factor.size, self.plan.columns);
        let mut cut = Cut {
            own: DMatrix::zeros(size, size),
            border: DMatrix::zeros(size, columns.len()),
        };
        for (i, a) in self.model.processes().iter().enumerate() {
            for (j, b) in self.model.processes().iter().enumerate() {
                cut.own[(i, j)] = window.own(local)[pair(a.component, b.component)];
            }
            let sums = window.border(local, a.component);
            for (j, column) in columns.iter().enumerate() {
                cut.border[(i, j)] = sums[*column];
            }
        }
        cut
    }

    /// The end; `left` is what the last window leaves at the epoch behind it.
    pub(super) fn finish(mut self, left: Option<&Window>) -> Eliminated {
        let (first, kept) = (self.first_columns, self.plan.columns.len());
        let left = left.filter(|_| self.plan.ends_at_cut(&self.block));
        let (last, between) = match left {
            Some(left) => {
                let (cut, between) = self.last_cut(left);
                (Some(cut), between)
            }
            None => (None, DMatrix::zeros(first, self.factor.size)),
        };
        if let Some(cut) = &mut self.first {
            cut.own -= self.loss.view((0, 0), (first, first));
            cut.border -= self.loss.view((0, first), (first, kept));
        }
        Eliminated {
            kept: self.kept,
            loss: self.loss.view((first, first), (kept, kept)).into_owned(),
            prior_cost: self.prior_cost,
            first: self.first,
            last,
            between,
        }
    }
}
