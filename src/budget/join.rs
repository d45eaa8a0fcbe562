//! Ledgers of several runs of one experiment, joined into those of a single run: the same lines, one header.
//!
//! Each part holds some seeds of each cell. Together they must hold every seed from the first to the last once.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::experiment::{Experiment, Role, ledger_of};
use super::ledger::{self, Header, LedgerError};
use crate::calibrate::tried::Tried;
use crate::calibrate::vary::{Point, VaryError};
use crate::files::{WriteError, write_whole};

/// Subfolder of the ledgers in the folder of a budget.
pub const TRIALS: &str = "trials";

/// Parts cannot be joined.
#[derive(Debug, Error)]
pub enum JoinError {
    /// A ledger that cannot be used.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// Trials of something else.
    #[error(
        "{}: its trials are of another {what}: found {found}, expected {expected}; leave this part out, or run it again as the others",
        file.display()
    )]
    Other {
        /// The ledger.
        file: PathBuf,
        /// What differs.
        what: &'static str,
        /// What the ledger says.
        found: String,
        /// What the command asks for.
        expected: String,
    },
    /// Trials whose last digits are another machine's.
    #[error(
        "{}: its trials were computed where the last digits come out otherwise (numerics {found}, here {expected}); join where the parts were run, or run this part again here",
        file.display()
    )]
    Numerics {
        /// The ledger.
        file: PathBuf,
        /// Beginning of the ledger's fingerprint.
        found: String,
        /// Beginning of this build's.
        expected: String,
    },
    /// A sweep that cannot be run.
    #[error(transparent)]
    Vary(#[from] VaryError),
    /// A joined ledger cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A folder without trials of all sources together.
    #[error("{}: found no trials, expected the folder of a run with --only-trials", folder.display())]
    Empty {
        /// The folder.
        folder: PathBuf,
    },
    /// A ledger of something that is not asked for.
    #[error("{}: found trials of \"{found}\", which this command does not ask for; say the same --vary as for the parts", file.display())]
    Unknown {
        /// The ledger.
        file: PathBuf,
        /// Name of its cell.
        found: String,
    },
    /// A part that was stopped within a line.
    #[error("{}: its last line is cut off; finish this part first, with its own command and --resume", file.display())]
    Torn {
        /// The ledger.
        file: PathBuf,
    },
    /// The same seeds twice.
    #[error("{} and {}: both hold the trial of seed {seed}; leave one out", first.display(), second.display())]
    Overlap {
        /// A ledger.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// The first seed that stands in both.
        seed: u64,
    },
    /// Seeds that nobody has.
    #[error("{}: it begins with seed {found}, and no part holds {expected} to {}; finish or add the part that should", file.display(), found - 1)]
    Gap {
        /// The ledger behind the gap.
        file: PathBuf,
        /// Its first seed.
        found: u64,
        /// The seed that should come next.
        expected: u64,
    },
    /// One set has more trials than the others.
    #[error(
        "\"{cell}\": found {found} trials from seed {first_seed} on, expected {expected} as {like}; finish or add the part that lacks them"
    )]
    Uneven {
        /// Name of the cell.
        cell: String,
        /// Trials found.
        found: u64,
        /// First seed of all.
        first_seed: u64,
        /// Trials expected.
        expected: u64,
        /// Who says so.
        like: String,
    },
}

/// Some seeds of a cell.
#[derive(Debug)]
struct Stretch {
    file: PathBuf,
    /// As it should be, with the first seed that it has.
    header: Header,
    first: u64,
    count: u64,
}

/// Parts that belong together.
pub struct Joined<'a> {
    /// The experiment that they make.
    pub experiment: Experiment<'a>,
    /// Of each cell, its stretches in order.
    stretches: BTreeMap<String, Vec<Stretch>>,
}

impl<'a> Joined<'a> {
    /// Reads the parts in these folders, checks every line, and finds the experiment that they make; writes nothing. `points` are those
    /// of the sweep that the parts ran.
    ///
    /// # Errors
    /// [`JoinError`]: trials of something else, seeds that are missing or there twice, a damaged or torn ledger.
    pub fn of(
        tried: &'a dyn Tried,
        points: &[Point],
        folders: &[PathBuf],
    ) -> Result<Self, JoinError> {
        let mut ledgers = vec![];
        for folder in folders {
            ledgers.extend(ledgers_in(folder)?);
        }
        let together = ledgers.iter().filter(|(_, h)| h.acting == TOGETHER);
        let first_seed = together.map(|(_, h)| h.first_seed).min().unwrap_or(0);
        let all = Experiment::new(tried, first_seed, 1, 2).with_sweep(points.to_vec(), 1)?;
        let mut stretches: BTreeMap<String, Vec<Stretch>> = BTreeMap::new();
        for (file, found) in ledgers {
            let cell = found.acting.clone();
            let stretch = stretch(&all, file, &found)?;
            stretches.entry(cell).or_default().push(stretch);
        }
        for (cell, all) in &mut stretches {
            all.sort_by_key(|s| s.first);
            if cell == NOTHING {
                // nothing in it is left to chance: every part has it, under its own first seed
                all.truncate(1);
                all.iter_mut().for_each(|s| s.count = s.count.min(1));
            }
            contiguous(all, first_seed)?;
        }
        let experiment = experiment(tried, points, first_seed, &stretches)?;
        Ok(Self {
            experiment,
            stretches,
        })
    }

    /// Writes the joined ledgers into a folder, each of them whole or not at all.
    ///
    /// # Errors
    /// [`LedgerError::Taken`] where there are ledgers; what the operating system says.
    pub fn write(&self, folder: &Path) -> Result<(), JoinError> {
        let cells = &self.experiment.cells;
        let old = cells.iter().map(|cell| ledger_of(folder, cell));
        if let Some(file) = old.into_iter().find(|file| file.exists()) {
            return Err(JoinError::Ledger(LedgerError::Joined { file }));
        }
        for cell in cells {
            let header = self.experiment.header(cell);
            let mut failed = None;
            let written = write_whole(&ledger_of(folder, cell), |out| -> std::io::Result<()> {
                out.write_all(header.text().as_bytes())?;
                for part in self.stretches.get(&cell.name).into_iter().flatten() {
                    let take = usize::try_from(part.count).unwrap_or(usize::MAX);
                    let records = ledger::read(&part.file, &part.header);
                    let records = records.map_err(|e| kept(&mut failed, e))?;
                    for trial in records.take(take) {
                        let trial = trial.map_err(|e| kept(&mut failed, e))?;
                        out.write_all(&self.experiment.line(&trial))?;
                    }
                }
                Ok(())
            });
            if let Some(error) = failed {
                return Err(error.into());
            }
            written?;
        }
        Ok(())
    }
}

/// Keeps an error of a ledger on its way through one of writing.
fn kept(place: &mut Option<LedgerError>, error: LedgerError) -> std::io::Error {
    let other = std::io::Error::other(error.to_string());
    *place = Some(error);
    other
}

/// Names of the cells that every experiment may have.
const TOGETHER: &str = "together";
const NOTHING: &str = "nothing";

/// The ledgers of a part with what they say of themselves.
fn ledgers_in(folder: &Path) -> Result<Vec<(PathBuf, Header)>, JoinError> {
    let inner = folder.join(TRIALS);
    let place = if inner.is_dir() { &inner } else { folder };
    let empty = || JoinError::Empty {
        folder: folder.to_owned(),
    };
    let entries = std::fs::read_dir(place).map_err(|_| empty())?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|e| e == "csv"));
    files.sort();
    let mut found = vec![];
    for file in files {
        let header = ledger::header_of(&file)?;
        found.push((file, header));
    }
    if !found.iter().any(|(_, header)| header.acting == TOGETHER) {
        return Err(empty());
    }
    Ok(found)
}

/// Reads a ledger to its end.
fn stretch(all: &Experiment<'_>, file: PathBuf, found: &Header) -> Result<Stretch, JoinError> {
    let Some(cell) = all.cells.iter().find(|cell| cell.name == found.acting) else {
        let found = found.acting.clone();
        return Err(JoinError::Unknown { file, found });
    };
    let mut header = all.header(cell);
    header.first_seed = found.first_seed;
    let mut records = ledger::read(&file, &header).map_err(of_a_part)?;
    let mut count = 0;
    for trial in records.by_ref() {
        trial?;
        count += 1;
    }
    if std::fs::metadata(&file).is_ok_and(|m| records.good_bytes() < m.len()) {
        return Err(JoinError::Torn { file });
    }
    Ok(Stretch {
        file,
        first: found.first_seed,
        header,
        count,
    })
}

/// What a ledger's fault means where it is one part of many.
fn of_a_part(error: LedgerError) -> JoinError {
    match error {
        LedgerError::Other {
            file,
            what,
            found,
            expected,
        } => JoinError::Other {
            file,
            what,
            found,
            expected,
        },
        LedgerError::Numerics {
            file,
            found,
            expected,
        } => JoinError::Numerics {
            file,
            found,
            expected,
        },
        other => other.into(),
    }
}

/// Whether stretches in order follow one another from the first seed on.
fn contiguous(stretches: &[Stretch], first_seed: u64) -> Result<(), JoinError> {
    let mut expected = first_seed;
    for (place, part) in stretches.iter().enumerate() {
        if part.first > expected {
            return Err(JoinError::Gap {
                file: part.file.clone(),
                found: part.first,
                expected,
            });
        }
        if part.first < expected {
            return Err(JoinError::Overlap {
                first: stretches[place.saturating_sub(1)].file.clone(),
                second: part.file.clone(),
                seed: part.first,
            });
        }
        expected = part.first + part.count;
    }
    Ok(())
}

/// The experiment whose cells hold so many trials.
fn experiment<'a>(
    tried: &'a dyn Tried,
    points: &[Point],
    first_seed: u64,
    stretches: &BTreeMap<String, Vec<Stretch>>,
) -> Result<Experiment<'a>, JoinError> {
    let count = |name: &str| {
        let all = stretches.get(name).into_iter().flatten();
        all.map(|s| s.count).sum::<u64>()
    };
    let trials = count(TOGETHER);
    let whole = |single| {
        Experiment::new(tried, first_seed, trials, single).with_sweep(points.to_vec(), trials)
    };
    // as many of each source alone as the most that one of them has
    let alone = whole(2)?;
    let alone = alone.cells.iter();
    let alone = alone.filter(|cell| matches!(cell.role, Role::Alone(_)));
    let single = alone.map(|cell| count(&cell.name)).max().unwrap_or(0);
    let single = single.max(count(NOTHING));
    let experiment = whole(single)?;
    for cell in &experiment.cells {
        let found = count(&cell.name);
        if found != cell.trials {
            let like = match cell.role {
                Role::Alone(_) | Role::TrueTies | Role::Nothing => "the other sources alone have",
                _ => "all sources together have",
            };
            return Err(JoinError::Uneven {
                cell: cell.name.clone(),
                found,
                first_seed,
                expected: cell.trials,
                like: like.to_owned(),
            });
        }
    }
    Ok(experiment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::toy::Toy;
    use std::sync::atomic::AtomicBool;

    fn run(toy: &Toy, folder: &Path, first: u64, trials: u64, single: u64) {
        let experiment = Experiment::new(toy, first, trials, single);
        let done = experiment.prepare(folder, false).expect("ledgers");
        let never = AtomicBool::new(false);
        let ended = experiment.run(folder, &done, &never, &|_| {});
        ended.expect("a run");
    }

    /// The bytes of every file by name.
    fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
        let all = std::fs::read_dir(folder).expect("a folder").flatten();
        all.map(|e| {
            let name = e.file_name().to_string_lossy().into_owned();
            (name, std::fs::read(e.path()).expect("bytes"))
        })
        .collect()
    }

    fn joined<'a>(toy: &'a Toy, parts: &[PathBuf]) -> Result<Joined<'a>, String> {
        Joined::of(toy, &[], parts).map_err(|e| e.to_string())
    }

    #[test]
    fn parts_in_any_order_make_the_bytes_of_one_run() {
        let (toy, folder) = (Toy::default(), tempfile::tempdir().expect("folder"));
        let place = |name: &str| folder.path().join(name);
        // alone as often as together in every part; or alone in the first part only
        for (kind, singles) in [("each", [4, 7, 2]), ("first", [3, 0, 0]), ("none", [0; 3])] {
            let part = |k: usize| place(&format!("{kind}-{k}"));
            for (k, (first, trials)) in [(5, 4), (9, 7), (16, 2)].into_iter().enumerate() {
                run(&toy, &part(k).join(TRIALS), first, trials, singles[k]);
            }
            let whole = place(&format!("{kind}-whole"));
            run(&toy, &whole, 5, 13, singles.iter().sum());
            let found = joined(&toy, &[part(2), part(0), part(1).join(TRIALS)]).expect(kind);
            found.write(&place(kind)).expect("written");
            assert_eq!(bytes(&place(kind)), bytes(&whole), "{kind}");
            let again = found.write(&place(kind)).expect_err("taken").to_string();
            assert!(again.contains("choose another --out"), "{again}");
        }
    }

    #[test]
    fn what_cannot_be_joined_is_said() {
        let (toy, folder) = (Toy::default(), tempfile::tempdir().expect("folder"));
        let part = |first: u64| folder.path().join(format!("p{first}"));
        for (first, trials) in [(1, 3), (4, 3), (6, 3), (9, 1)] {
            run(&toy, &part(first), first, trials, 0);
        }
        let said = |parts: &[u64]| {
            let all: Vec<PathBuf> = parts.iter().map(|first| part(*first)).collect();
            joined(&toy, &all).err().unwrap_or_default()
        };
        assert_eq!(said(&[1, 4]), "");
        assert!(said(&[1, 4, 6]).contains("both hold the trial of seed 6"));
        assert!(said(&[1, 6]).contains("begins with seed 6, and no part holds 4 to 5"));
        assert!(said(&[1, 2]).contains("p2: found no trials"));
        assert!(said(&[1, 1]).contains("both hold the trial of seed 1"));

        let file = part(4).join("together.csv");
        let whole = std::fs::read(&file).expect("bytes");
        std::fs::write(&file, &whole[..whole.len() - 3]).expect("torn");
        assert!(said(&[1, 4]).contains("its last line is cut off"));
        let text = String::from_utf8(whole).expect("text");
        let zeros = "0".repeat(64);
        for (from, to, expected) in [
            (
                crate::adjust::fingerprint(),
                &*zeros,
                "last digits come out otherwise",
            ),
            (
                "\"scenario\":\"",
                "\"scenario\":\"another ",
                "another scenario name",
            ),
            (
                "\"version\":\"",
                "\"version\":\"9.",
                "another program version",
            ),
            ("\"together\"", "\"vary-x=1\"", "found no trials"),
        ] {
            std::fs::write(&file, text.replacen(from, to, 1)).expect("written");
            assert!(said(&[1, 4]).contains(expected), "{}", said(&[1, 4]));
        }
    }

    #[test]
    fn a_set_that_lacks_trials_is_named() {
        let (toy, folder) = (Toy::default(), tempfile::tempdir().expect("folder"));
        let place = |name: &str| folder.path().join(name);
        run(&toy, &place("a"), 1, 3, 3);
        run(&toy, &place("b"), 4, 3, 3);
        std::fs::remove_file(place("b").join("only-second.csv")).expect("removed");
        let said = |parts: &[PathBuf]| joined(&toy, parts).err().unwrap_or_default();
        let both = [place("a"), place("b")];
        assert!(said(&both).contains("\"only-second\": found 3 trials from seed 1 on, expected 6"));
        std::fs::rename(place("b").join("only-first.csv"), place("b").join("x.csv"))
            .expect("named");
        let text = std::fs::read_to_string(place("b").join("x.csv")).expect("text");
        let other = text.replacen("only-first", "vary-k=2", 1);
        std::fs::write(place("b").join("x.csv"), other).expect("written");
        assert!(said(&both).contains("found trials of \"vary-k=2\""));
    }
}
