//! Block Cholesky elimination of the chain.
//!
//! The normal matrix is block tridiagonal over the epochs with a border of the parameters. Epoch after epoch:
//! `A = L L^T`, `U = L^-1 O`, `W = L^-1 B`; the next epoch loses `U^T U` and `U^T W`, the parameters lose `W^T W`
//! (Triggs et al., "Bundle adjustment – a modern synthesis", 2000, sec. 6).

use crate::math::dense::add_squares;
use std::ops::Range;

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

use super::accumulate::{Window, pair};
use super::chain::{ChainModel, ChainState};
use super::error::AdjustError;
use super::factor::{Factor, Quad, Square, carried, cholesky, compiled_size, forward, with_size};

/// How a process runs from an epoch to the next.
#[derive(Clone, Copy)]
struct Link {
    /// Transition.
    phi: f64,
    /// Inverse variance of the innovation.
    information: f64,
}

/// Forward elimination in progress.
pub(super) struct Elimination<'a> {
    model: &'a ChainModel,
    state: &'a ChainState,
    /// Columns kept: the free ones, then the misclosure.
    columns: &'a [usize],
    factor: Factor,
    /// What the epochs so far have taken from the next one, `-U^T [U | W]`.
    carry: Vec<Quad>,
    /// Links of the processes into the epoch, and out of it.
    links: [Vec<Link>; 2],
    /// Schur complement's loss `W^T W` over free columns and right-hand side.
    loss: DMatrix<f64>,
    /// Cost of the states' priors.
    pub prior_cost: f64,
    /// The widest instructions of this machine; they give the same bits as any others.
    arch: Arch,
}

/// Elimination of an epoch with the widest instructions: `L^T`, or nothing where the block is not positive definite.
struct Step<'a, const N: usize> {
    own: Square<N>,
    rows: &'a mut [Quad],
    carry: &'a mut [Quad],
    quads: usize,
}

impl<const N: usize> WithSimd for Step<'_, N> {
    type Output = Option<Square<N>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let upper = cholesky(self.own)?;
        forward(&upper, self.rows, self.quads);
        carried::<N>(self.rows, self.quads, self.carry);
        Some(upper)
    }
}

impl<'a> Elimination<'a> {
    /// Starts; `recycled` lends its memory.
    pub(super) fn new(
        model: &'a ChainModel,
        state: &'a ChainState,
        columns: &'a [usize],
        recycled: Option<Factor>,
    ) -> Result<Self, AdjustError> {
        let (size, width) = (compiled_size(model.state_size())?, columns.len());
        let factor = recycled
            .unwrap_or_default()
            .sized(size, width, model.epochs());
        let start = |process: &super::Process| Link {
            phi: 0.0,
            information: process.sigma.powi(-2),
        };
        let first: Vec<Link> = model.processes().iter().map(start).collect();
        Ok(Elimination {
            model,
            state,
            columns,
            carry: vec![[0.0; 4]; size * factor.quads],
            factor,
            links: [first.clone(), first],
            loss: DMatrix::zeros(width, width),
            prior_cost: 0.0,
            arch: Arch::new(),
        })
    }

    /// Eliminates the epochs of a window, all but its last one unless the window ends the chain.
    pub(super) fn eliminate(&mut self, window: &Window) -> Result<(), AdjustError> {
        let end =
            window.intervals.end + usize::from(window.intervals.end == self.model.intervals());
        for epoch in window.intervals.start..end {
            let local = epoch - window.intervals.start;
            with_size!(self.factor.size, N => self.epoch::<N>(epoch, local, window)?);
        }
        self.subtract(window.intervals.start..end);
        Ok(())
    }

    /// The factor, and the loss of the parameters' normal matrix.
    pub(super) fn finish(self) -> (Factor, DMatrix<f64>) {
        (self.factor, self.loss)
    }

    fn epoch<const N: usize>(
        &mut self,
        epoch: usize,
        local: usize,
        window: &Window,
    ) -> Result<(), AdjustError> {
        self.link(epoch);
        let own = self.own::<N>(local, window);
        self.fill::<N>(epoch, local, window);
        self.prior_gradient::<N>(epoch);
        let quads = self.factor.quads;
        let step = Step {
            own,
            rows: self.factor.rows_mut(epoch),
            carry: &mut self.carry,
            quads,
        };
        let upper = self.arch.dispatch(step);
        let upper = upper.ok_or(AdjustError::NotPositive { epoch })?;
        self.factor.set_upper(epoch, &upper);
        Ok(())
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
        let rows = self.factor.rows_mut(epoch).chunks_exact_mut(quads);
        for (i, (row, carry)) in rows.zip(self.carry.chunks_exact(quads)).enumerate() {
            row.copy_from_slice(carry);
            let (next, border) = row.as_flattened_mut().split_at_mut(N);
            next.fill(0.0);
            let Some(a) = processes.get(i) else { continue };
            if !last {
                let sums = window.next(local);
                next.iter_mut()
                    .zip(processes)
                    .for_each(|(entry, b)| *entry = sums[pair(a.component, b.component)]);
                next[i] -= self.links[1][i].phi * self.links[1][i].information;
            }
            let sums = window.border(local, a.component);
            border
                .iter_mut()
                .zip(self.columns)
                .for_each(|(entry, column)| *entry += sums[*column]);
        }
    }

    /// Adds the gradient of the process priors around this epoch, and the cost of the innovation leading to it.
    fn prior_gradient<const N: usize>(&mut self, epoch: usize) {
        let (quads, rhs) = (self.factor.quads, N + self.columns.len() - 1);
        let rows = self.factor.rows_mut(epoch).chunks_exact_mut(quads);
        for (i, row) in rows.enumerate().take(self.model.state_size()) {
            let here = self.state.state(epoch)[i];
            let before = if epoch > 0 {
                self.state.state(epoch - 1)[i]
            } else {
                0.0
            };
            let (into, out) = (self.links[0][i], self.links[1][i]);
            let innovation = here - into.phi * before;
            self.prior_cost += 0.5 * innovation * innovation * into.information;
            row.as_flattened_mut()[rhs] += innovation * into.information;
            if epoch < self.model.intervals() {
                let ahead = self.state.state(epoch + 1)[i] - out.phi * here;
                row.as_flattened_mut()[rhs] -= out.phi * ahead * out.information;
            }
        }
    }

    /// Adds `W^T W` of finished epochs to the loss.
    fn subtract(&mut self, epochs: Range<usize>) {
        let rows = self.factor.rows(epochs);
        add_squares(&mut self.loss, rows, self.factor.quads, self.factor.size);
    }
}
