//! Which trials are run: cells of one scenario each, all under the same seeds, spread over all cores.
//!
//! Trials are taken in the order cell by cell, seed by seed, and one that was taken is always finished: whenever the run ends, each
//! ledger holds the first seeds without a gap. Which thread ran a trial leaves no trace.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::ledger::{self, Columns, Header, Ledger, LedgerError, Records};
use crate::calibrate::tried::{Acting, Trial, Tried};
use crate::calibrate::vary::{Point, VaryError};

/// What a cell is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Role {
    /// All sources together.
    Together,
    /// No source: the method's own error. It has one trial, as nothing in it is left to chance.
    Nothing,
    /// The source of this place alone.
    Alone(usize),
    /// All sources together, each observation tied to the face that it truly struck.
    TrueTies,
    /// A point of a sweep, by its place among the experiment's points.
    Sweep(usize),
}

impl Role {
    fn acting(&self) -> Acting {
        match self {
            Role::Together | Role::Sweep(_) => Acting::All,
            Role::Nothing => Acting::None,
            Role::Alone(place) => Acting::Only(*place),
            Role::TrueTies => Acting::AllWithTrueTies,
        }
    }
}

/// Trials of one scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// What for.
    pub role: Role,
    /// Name of its ledger, also a word for progress.
    pub name: String,
    /// How many seeds, from the experiment's first.
    pub trials: u64,
}

/// A set of cells.
pub struct Experiment<'a> {
    /// What is tried.
    pub tried: &'a dyn Tried,
    /// First seed of every cell: common random numbers.
    pub first_seed: u64,
    /// The cells, all together first.
    pub cells: Vec<Cell>,
    /// The points of a sweep, each with its scenario.
    pub points: Vec<(Point, Box<dyn Tried>)>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every trial is done.
    Complete,
    /// It was told to stop.
    Interrupted {
        /// Trials done, those of earlier runs included.
        done: u64,
        /// Trials wanted.
        of: u64,
    },
}

impl<'a> Experiment<'a> {
    /// `trials` of all sources together and, with `single` above 0, one of none, that many of each acting source alone and, where the
    /// simulation knows true ties, as many of all with them (no more than `trials`, with which they are compared).
    #[must_use]
    pub fn new(tried: &'a dyn Tried, first_seed: u64, trials: u64, single: u64) -> Self {
        let cell = |role, name: &str, trials| Cell {
            role,
            name: name.to_owned(),
            trials,
        };
        let mut cells = vec![cell(Role::Together, "together", trials)];
        if single > 0 {
            cells.push(cell(Role::Nothing, "nothing", 1));
            for (place, source) in tried.sources().iter().enumerate() {
                let name = format!("only-{}", source.source);
                cells.push(cell(Role::Alone(place), &name, single));
            }
            if tried.knows_true_ties() {
                cells.push(cell(Role::TrueTies, "true-ties", single.min(trials)));
            }
        }
        Self {
            tried,
            first_seed,
            cells,
            points: vec![],
        }
    }

    /// Adds a sweep: `trials` at each of its points, under the same seeds.
    ///
    /// # Errors
    /// [`VaryError`]: an unknown key, or a value that makes the scenario impossible.
    pub fn with_sweep(mut self, points: Vec<Point>, trials: u64) -> Result<Self, VaryError> {
        for point in points {
            self.cells.push(Cell {
                role: Role::Sweep(self.points.len()),
                name: point.file_name(),
                trials,
            });
            let tried = self.tried.varied(&point)?;
            self.points.push((point, tried));
        }
        Ok(self)
    }

    /// What a cell tries.
    fn tried_in(&self, cell: &Cell) -> &dyn Tried {
        match cell.role {
            Role::Sweep(place) => &*self.points[place].1,
            _ => self.tried,
        }
    }

    /// Whether every cell can be simulated.
    ///
    /// # Errors
    /// What stands against it.
    pub fn check(&self) -> Result<(), String> {
        self.cells
            .iter()
            .try_for_each(|cell| self.tried_in(cell).check())
    }

    /// Trials wanted.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.cells.iter().map(|cell| cell.trials).sum()
    }

    /// What a cell's ledger must say.
    #[must_use]
    pub fn header(&self, cell: &Cell) -> Header {
        Header::new(self.tried_in(cell), &cell.name, self.first_seed)
    }

    /// Checks and mends the ledgers in a folder, which is made when missing; says how many trials are done by cell, at most
    /// those wanted. Without `resume` there must be none.
    ///
    /// # Errors
    /// [`LedgerError`].
    pub fn prepare(&self, folder: &Path, resume: bool) -> Result<Vec<u64>, LedgerError> {
        let is_old = |cell: &&Cell| ledger_of(folder, cell).exists();
        if !resume && let Some(cell) = self.cells.iter().find(is_old) {
            let file = ledger_of(folder, cell);
            return Err(LedgerError::Taken { file });
        }
        let prepared = |cell: &Cell| {
            let done = ledger::prepare(&ledger_of(folder, cell), &self.header(cell))?;
            Ok(done.min(cell.trials))
        };
        // every old one is judged before a new one is written
        for cell in self.cells.iter().filter(is_old) {
            prepared(cell)?;
        }
        std::fs::create_dir_all(folder).map_err(|e| LedgerError::System {
            file: folder.to_owned(),
            found: e.to_string(),
        })?;
        self.cells.iter().map(prepared).collect()
    }

    /// Runs the trials that are missing in the ledgers of a prepared folder on the threads of the current pool. `done` is what
    /// [`Self::prepare`] said. No further trial is begun once `stop` is set. `progress` is told how many trials are done.
    ///
    /// # Errors
    /// [`LedgerError::System`]: a ledger cannot be written.
    pub fn run(
        &self,
        folder: &Path,
        done: &[u64],
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Ended, LedgerError> {
        let queue = Queue::new(&self.cells, done, self.first_seed);
        let before: u64 = done.iter().sum();
        let (next, finished) = (AtomicU64::new(0), AtomicU64::new(before));
        let sink = Mutex::new(Sink::new(self, folder, done));
        // one loop for each thread: a loop that could be stolen would hold up the trial whose thread stole it
        rayon::broadcast(|_| {
            while !stop.load(SeqCst) {
                let Some((cell, seed)) = queue.get(next.fetch_add(1, SeqCst)) else {
                    break;
                };
                let of = &self.cells[cell];
                let trial = self.tried_in(of).trial(seed, of.role.acting());
                let mut sink = sink.lock().unwrap_or_else(PoisonError::into_inner);
                if !sink.put(cell, trial) {
                    break;
                }
                progress(finished.fetch_add(1, SeqCst) + 1);
            }
        });
        let sink = sink.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = sink.failed {
            return Err(error);
        }
        let (done, of) = (finished.into_inner(), self.trials());
        Ok(if done < of {
            Ended::Interrupted { done, of }
        } else {
            Ended::Complete
        })
    }

    /// A trial as its line of a ledger, with the line end.
    #[must_use]
    pub fn line(&self, trial: &Trial) -> Vec<u8> {
        Columns::of(self.tried).line(trial)
    }

    /// The lines of a cell's ledger for these seeds, whether or not the experiment has them: simulated and calibrated on the threads of
    /// the current pool, in the order of seeds, each with its line end. They hang on [`Self::header`] and the seeds alone, so that
    /// another process may make them. `None` once `stop` is set.
    #[must_use]
    pub fn records(&self, cell: &Cell, seeds: Range<u64>, stop: &AtomicBool) -> Option<Vec<u8>> {
        let (tried, acting) = (self.tried_in(cell), cell.role.acting());
        let columns = Columns::of(self.tried);
        let line = |seed: u64| match stop.load(SeqCst) {
            true => None,
            false => Some(columns.line(&tried.trial(seed, acting))),
        };
        let lines: Option<Vec<Vec<u8>>> = seeds.into_par_iter().map(line).collect();
        lines.map(|lines| lines.concat())
    }

    /// The trials of a cell, in the order of seeds, no more than wanted.
    ///
    /// # Errors
    /// [`LedgerError`].
    pub fn read(
        &self,
        folder: &Path,
        cell: &Cell,
    ) -> Result<std::iter::Take<Records>, LedgerError> {
        let records = ledger::read(&ledger_of(folder, cell), &self.header(cell))?;
        Ok(records.take(usize::try_from(cell.trials).unwrap_or(usize::MAX)))
    }
}

/// File of a cell's trials.
#[must_use]
pub fn ledger_of(folder: &Path, cell: &Cell) -> PathBuf {
    folder.join(format!("{}.csv", cell.name))
}

/// The missing trials in order.
struct Queue {
    /// Number of missing trials before each cell, its index, its first missing seed.
    cells: Vec<(u64, usize, u64)>,
    length: u64,
}

impl Queue {
    fn new(cells: &[Cell], done: &[u64], first_seed: u64) -> Self {
        let mut queue = Self {
            cells: vec![],
            length: 0,
        };
        for (index, (cell, done)) in cells.iter().zip(done).enumerate() {
            queue.cells.push((queue.length, index, first_seed + done));
            queue.length += cell.trials - done;
        }
        queue
    }

    /// Cell and seed of the n-th missing trial.
    fn get(&self, n: u64) -> Option<(usize, u64)> {
        let after = self.cells.partition_point(|(before, ..)| *before <= n);
        let (before, cell, seed) = *self.cells.get(after.checked_sub(1)?)?;
        (n < self.length).then_some((cell, seed + (n - before)))
    }
}

/// Puts trials into the ledgers in the order of seeds, whatever the order in which they come.
struct Sink {
    columns: Columns,
    cells: Vec<Waiting>,
    failed: Option<LedgerError>,
}

struct Waiting {
    file: PathBuf,
    ledger: Option<Ledger>,
    next_seed: u64,
    end_seed: u64,
    early: BTreeMap<u64, Trial>,
}

impl Sink {
    fn new(experiment: &Experiment<'_>, folder: &Path, done: &[u64]) -> Self {
        let waiting = |(cell, done): (&Cell, &u64)| Waiting {
            file: ledger_of(folder, cell),
            ledger: None,
            next_seed: experiment.first_seed + done,
            end_seed: experiment.first_seed + cell.trials,
            early: BTreeMap::new(),
        };
        Self {
            columns: Columns::of(experiment.tried),
            cells: experiment.cells.iter().zip(done).map(waiting).collect(),
            failed: None,
        }
    }

    /// False when nothing can be written any more.
    fn put(&mut self, cell: usize, trial: Trial) -> bool {
        if self.failed.is_none() {
            self.failed = self.cells[cell].put(trial, &self.columns).err();
        }
        self.failed.is_none()
    }
}

impl Waiting {
    fn put(&mut self, trial: Trial, columns: &Columns) -> Result<(), LedgerError> {
        self.early.insert(trial.seed, trial);
        while let Some(trial) = self.early.remove(&self.next_seed) {
            let ledger = match &mut self.ledger {
                Some(ledger) => ledger,
                none => none.insert(Ledger::open(&self.file, columns)?),
            };
            ledger.append(&trial)?;
            self.next_seed += 1;
        }
        if self.next_seed == self.end_seed {
            self.ledger = None;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::toy::Toy;

    #[test]
    fn the_queue_is_cell_by_cell_and_leaves_out_what_is_done() {
        let toy = Toy::default();
        let experiment = Experiment::new(&toy, 10, 3, 2);
        let queue = Queue::new(&experiment.cells, &[1, 1, 0, 2], 10);
        let all: Vec<_> = (0..6).map(|n| queue.get(n)).collect();
        assert_eq!(
            all,
            [
                Some((0, 11)),
                Some((0, 12)),
                Some((2, 10)),
                Some((2, 11)),
                None,
                None
            ]
        );
    }

    /// Lines that several calls made are those of a run, in every cell.
    #[test]
    fn records_are_the_lines_of_a_ledger() {
        let toy = Toy::default();
        let experiment = Experiment::new(&toy, 10, 7, 5);
        let folder = tempfile::tempdir().expect("folder");
        let done = experiment.prepare(folder.path(), false).expect("ledgers");
        let stop = AtomicBool::new(false);
        let ended = experiment.run(folder.path(), &done, &stop, &|_| {});
        assert_eq!(ended.expect("a run"), Ended::Complete);
        for cell in &experiment.cells {
            let mut bytes = experiment.header(cell).text().into_bytes();
            let end = 10 + cell.trials;
            for seeds in [10..end.min(13), end.min(13)..end] {
                bytes.extend(experiment.records(cell, seeds, &stop).expect("lines"));
            }
            let ledger = std::fs::read(ledger_of(folder.path(), cell)).expect("bytes");
            assert_eq!(bytes, ledger, "{}", cell.name);
        }
        stop.store(true, SeqCst);
        let none = experiment.records(&experiment.cells[0], 10..12, &stop);
        assert_eq!(none, None);
    }

    #[test]
    fn every_acting_source_has_its_cell() {
        let toy = Toy::default();
        let experiment = Experiment::new(&toy, 1, 3, 2);
        let names: Vec<&str> = experiment.cells.iter().map(|c| &*c.name).collect();
        assert_eq!(names, ["together", "nothing", "only-first", "only-second"]);
        assert_eq!(experiment.trials(), 3 + 1 + 2 * 2);
    }
}
