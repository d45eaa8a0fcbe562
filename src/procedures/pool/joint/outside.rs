//! Blocks of the trajectory on other processes: what is sent along with the engine's questions, and how it is answered.
//!
//! A worker reads the same survey and prepares it by the same functions as whoever asks: target's pose, planes, candidates, epochs,
//! unknowns. What the rounds of the joint path change, it is sent: the block's ties, and where to linearise.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use sha2::{Digest, Sha256};

use super::super::config::JointConfig;
use super::super::doubts::Passes;
use super::super::run::{PoolError, PoolInput, Scanned, Sounded};
use super::super::scene::Scene;
use super::super::tie_set::{Tie, TieSet};
use super::round::{Frame, Ties};
use super::unknowns::parameters;
use super::{Epochs, JointStart, reach_s};
use crate::adjust::{AdjustError, Elsewhere, Large, ParameterSet, Worker};
use crate::files::wire::{Packer, Torn, Unpacker};
use crate::watch::{Stopped, Workers};

/// An adjustment whose blocks are handed out.
pub(super) struct HandedOut<'a> {
    workers: &'a dyn Workers,
    ties: &'a Ties,
    passes: &'a Passes,
    /// Digest of the preparation, and the parameters that the conditions were made from.
    kept: ([u8; 32], Vec<f64>),
    shares: Vec<Vec<Range<usize>>>,
    packets: OnceLock<Arc<Vec<Vec<u8>>>>,
    number: u64,
}

impl<'a> HandedOut<'a> {
    pub(super) fn new(
        workers: &'a dyn Workers,
        (ties, passes): (&'a Ties, &'a Passes),
        kept: ([u8; 32], Vec<f64>),
        shares: Vec<Vec<Range<usize>>>,
    ) -> Self {
        static ADJUSTMENTS: AtomicU64 = AtomicU64::new(0);
        Self {
            workers,
            ties,
            passes,
            kept,
            shares,
            packets: OnceLock::new(),
            number: ADJUSTMENTS.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// What is sent along with every question about a block.
    fn packet(&self, share: &[Range<usize>]) -> Vec<u8> {
        let mut packet = Packer::default();
        packet.bytes(&self.kept.0).numbers(&self.kept.1);
        packet.numbers(self.passes.begins_s());
        for ties in [&self.ties.soundings, &self.ties.returns].iter().zip(share) {
            pack_ties(ties.0, ties.1.clone(), &mut packet);
        }
        packet.done()
    }
}

impl Elsewhere for HandedOut<'_> {
    fn ask(&self, questions: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Stopped> {
        let make = || Arc::new(self.shares.iter().map(|share| self.packet(share)).collect());
        self.workers
            .ask(self.number, self.packets.get_or_init(make), questions)
    }
}

/// Runs of neighbouring rows on one face: rows left out before, face, rows.
fn pack_ties(ties: &TieSet, range: Range<usize>, to: &mut Packer) {
    let (mut runs, mut all): (usize, Packer) = (0, Packer::default());
    let mut run: Option<(Tie, usize)> = None;
    let mut behind = 0;
    let mut put = |(first, rows): (Tie, usize)| {
        let row = first.row as usize;
        all.count(row - behind).count(first.face.into()).count(rows);
        (runs, behind) = (runs + 1, row + rows);
    };
    for tie in ties.from(range.start).take(range.len()) {
        run = match run {
            Some((first, n)) if first.face == tie.face && first.row + n as u32 == tie.row => {
                Some((first, n + 1))
            }
            other => {
                other.into_iter().for_each(&mut put);
                Some((tie, 1))
            }
        };
    }
    run.into_iter().for_each(&mut put);
    to.count(runs).bytes(&all.done());
}

fn unpack_ties(from: &mut Unpacker, rows: usize, faces: usize) -> Result<TieSet, Torn> {
    let runs = from.count()?;
    let mut packed = Unpacker::new(from.bytes()?);
    let (mut ties, mut row) = (vec![], 0usize);
    for _ in 0..runs {
        let (before, face, count) = (packed.count()?, packed.count()?, packed.count()?);
        let first = row.checked_add(before).ok_or(Torn)?;
        row = first.checked_add(count).ok_or(Torn)?;
        if row > rows || face >= faces {
            return Err(Torn);
        }
        ties.push((first..row, face as u16));
    }
    packed.end()?;
    let tie = |row: usize, face: u16| Tie {
        row: row as u32,
        face,
    };
    let ties = ties.into_iter();
    let ties = ties.flat_map(|(run, face)| run.map(move |row| tie(row, face)));
    Ok(TieSet::of_ties(rows, ties))
}

/// Why a process cannot answer questions about blocks.
#[derive(Debug, thiserror::Error)]
pub enum OutsideError {
    /// Its survey is not that of whoever asks.
    #[error(
        "this process has prepared another survey than the one that asks: the files or the [joint] keys differ"
    )]
    Other,
    /// The adjustment's own.
    #[error(transparent)]
    Adjust(#[from] AdjustError),
    /// The survey cannot be calibrated.
    #[error(transparent)]
    Pool(#[from] PoolError),
}

impl From<Torn> for OutsideError {
    fn from(torn: Torn) -> Self {
        Self::Adjust(torn.into())
    }
}

/// A survey prepared to answer questions about the blocks of its trajectory.
pub struct BlockWorker<'a> {
    frame: &'a Frame<'a>,
    start: &'a ParameterSet,
    /// Digest of the preparation.
    identity: [u8; 32],
    worker: Worker,
}

impl BlockWorker<'_> {
    /// Prepares a survey, as a calibration by the joint path does before its first adjustment, and hands it to `then`.
    ///
    /// # Errors
    /// [`OutsideError`] for a survey whose calibration ends before.
    pub fn prepared<T>(
        input: &PoolInput,
        then: impl FnOnce(&mut BlockWorker<'_>) -> T,
    ) -> Result<T, OutsideError> {
        let scene = Scene::prepare(input.campaign, input.target, input.prior);
        let scene = scene.map_err(PoolError::from)?;
        let scanned = Scanned::by(&scene, input);
        let rough = scene.rough_mounting();
        let sounded = Sounded::by(&scene, input, &rough.mounting, &scanned.fitted);
        let start = JointStart {
            mounting: rough.mounting,
            planes: &scanned.planes,
            returns: &scanned.returns,
            candidates: &sounded.candidates,
            soundings: &sounded.ties,
        };
        let (candidates, config) = (start.candidates.iter(), input.joint);
        let epochs = Epochs::number(&scene, start.returns, candidates, reach_s(config))?;
        let (x, blocks) = parameters(&scene, &start, config)?;
        if let Some(fault) = input.campaign.soundings.fault() {
            return Err(PoolError::from(fault.clone()).into());
        }
        let frame = Frame {
            scene: &scene,
            start: &start,
            config,
            epochs: &epochs,
            blocks: &blocks,
            workers: None,
        };
        Ok(then(&mut BlockWorker {
            frame: &frame,
            start: &x,
            identity: frame.identity(),
            worker: Worker::default(),
        }))
    }

    /// Answers a question with what was sent along with it.
    ///
    /// # Errors
    /// [`OutsideError`].
    pub fn answer(&mut self, packet: &[u8], question: &[u8]) -> Result<Vec<u8>, OutsideError> {
        let mut from = Unpacker::new(packet);
        if from.bytes()? != self.identity {
            return Err(OutsideError::Other);
        }
        let x = self.start.with_values(&from.numbers()?).ok_or(Torn)?;
        let passes = Passes::beginning(from.numbers()?);
        let (campaign, faces) = (
            self.frame.scene.campaign,
            self.frame.scene.target.faces.len(),
        );
        let ties = Ties {
            soundings: unpack_ties(&mut from, campaign.soundings.len(), faces)?,
            returns: unpack_ties(&mut from, campaign.laser.len(), faces)?,
        };
        from.end()?;
        let conditions = self.frame.conditions(&ties, &x, &passes);
        let problem = self.frame.problem(&conditions);
        let answered = self.worker.answer(&problem, self.start, question);
        match campaign.soundings.fault() {
            Some(fault) => Err(PoolError::from(fault.clone()).into()),
            None => Ok(answered?),
        }
    }
}

impl Frame<'_> {
    /// Digest of what was prepared before the first adjustment.
    pub(super) fn identity(&self) -> [u8; 32] {
        let mut digest = Sha256::new();
        let mut numbers = |values: &mut dyn Iterator<Item = f64>| {
            values.for_each(|value| digest.update(value.to_le_bytes()));
        };
        let (start, chain) = (self.start, self.epochs.chain.as_ref());
        numbers(&mut start.mounting.rotation.iter().copied());
        numbers(&mut start.mounting.lever_arm_m.iter().copied());
        for plane in start.planes.iter().flatten() {
            let plane = &plane.fit.plane;
            numbers(&mut plane.normal.iter().copied().chain([plane.offset_m]));
        }
        numbers(&mut chain.iter().flat_map(|c| c.times_s().iter().copied()));
        let records = self.epochs.of_record.iter();
        records.for_each(|epoch| digest.update(epoch.to_le_bytes()));
        let config = JointConfig {
            simple: false,
            large: Large {
                spill: None,
                ..self.config.large.clone()
            },
            ..self.config.clone()
        };
        digest.update(format!("{config:?}").as_bytes());
        digest.finalize().into()
    }
}
