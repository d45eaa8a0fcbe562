//! The file of trials: one line per seed, in the order of seeds, appended as they are done.
//!
//! # Layout
//! A comment line with the [`Header`] as JSON, a line of column names, then a CSV record per seed: seed, then for the joint path
//! error, lower triangle of the covariance by rows, variance factor and refusal, then error and refusal of every other path. Angles
//! are radians, lengths metres; floats are written with the digits that bring them back exactly. The number of trials is not part of
//! the header: a ledger can be continued to any number.

mod line;

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::adjust::fingerprint;
use crate::calibrate::tried::{Trial, Tried};
use crate::formats::digest::sha256_of;
pub use line::Columns;

/// Version of the layout.
pub const FORMAT: u32 = 3;

/// What a ledger's trials are of. Only trials of an equal header may stand in one ledger.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the layout.
    pub format: u32,
    /// Version of the program: another one may give other numbers.
    pub version: String,
    /// Fingerprint of the arithmetic ([`fingerprint`]): on another one the same seeds give other last digits.
    #[serde(default)]
    pub numerics: String,
    /// Name of the procedure.
    pub procedure: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Which sources act: name of the cell.
    pub acting: String,
    /// Seed of the first record.
    pub first_seed: u64,
    /// SHA-256 of the scenario as it took effect, with its source switches, but for its seed.
    pub scenario_sha256: String,
    /// SHA-256 of the configuration of all paths.
    pub configuration_sha256: String,
    /// What each record holds.
    #[serde(flatten)]
    pub columns: Columns,
}

impl Header {
    /// For trials of this scenario; `acting` is the name of its cell.
    #[must_use]
    pub fn new(tried: &dyn Tried, acting: &str, first_seed: u64) -> Self {
        Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            numerics: fingerprint().to_owned(),
            procedure: tried.procedure().to_owned(),
            scenario: tried.scenario().to_owned(),
            acting: acting.to_owned(),
            first_seed,
            scenario_sha256: sha256_of(&tried.content()),
            configuration_sha256: sha256_of(tried.configuration().to_string().as_bytes()),
            columns: Columns::of(tried),
        }
    }

    /// The first field that differs, with both values.
    fn difference(&self, found: &Self) -> Option<(&'static str, String, String)> {
        let numbers = |a: u64, b: u64| (a.to_string(), b.to_string());
        let texts = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        let all = [
            ("layout", numbers(found.format.into(), self.format.into())),
            ("program version", texts(&found.version, &self.version)),
            ("procedure", texts(&found.procedure, &self.procedure)),
            ("scenario name", texts(&found.scenario, &self.scenario)),
            ("set of sources", texts(&found.acting, &self.acting)),
            (
                "scenario (SHA-256)",
                texts(&found.scenario_sha256, &self.scenario_sha256),
            ),
            (
                "configuration (SHA-256)",
                texts(&found.configuration_sha256, &self.configuration_sha256),
            ),
            ("first seed", numbers(found.first_seed, self.first_seed)),
            (
                "set of columns",
                texts(&found.columns.text(), &self.columns.text()),
            ),
        ];
        all.into_iter()
            .find(|(_, (a, b))| a != b)
            .map(|(name, (a, b))| (name, a, b))
    }

    /// The first two lines of a ledger, each with its line end.
    #[must_use]
    pub fn text(&self) -> String {
        let json = serde_json::to_string(self).unwrap_or_default();
        format!("{MARK}{json}\n{}\n", self.columns.text())
    }
}

/// A file of trials cannot be used.
#[derive(Debug, Error)]
pub enum LedgerError {
    /// The operating system refused.
    #[error("{}: {found}", file.display())]
    System {
        /// The file.
        file: PathBuf,
        /// What it said.
        found: String,
    },
    /// Trials of something else.
    #[error(
        "{}: its trials are of another {what}: found {found}, expected {expected}; choose another --out or remove the file",
        file.display()
    )]
    Other {
        /// The file.
        file: PathBuf,
        /// What differs.
        what: &'static str,
        /// What the file says.
        found: String,
        /// What this run needs.
        expected: String,
    },
    /// Trials whose last digits are another machine's.
    #[error(
        "{}: its trials were computed where the last digits come out otherwise (numerics {found}, here {expected}); continue them with the build and on the kind of machine that began them, or choose another --out",
        file.display()
    )]
    Numerics {
        /// The file.
        file: PathBuf,
        /// Beginning of the file's fingerprint.
        found: String,
        /// Beginning of this build's.
        expected: String,
    },
    /// Trials are there and nobody said that they are to be continued.
    #[error(
        "{}: found trials of an earlier run; continue them with --resume, or choose another --out",
        file.display()
    )]
    Taken {
        /// The file.
        file: PathBuf,
    },
    /// Joined ledgers where there are some.
    #[error("{}: found trials that are there already; choose another --out", file.display())]
    Joined {
        /// The file.
        file: PathBuf,
    },
    /// Not a file of trials, or damaged other than at its end.
    #[error("{}: line {line}: found {found}, expected {expected}", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What stands there.
        found: String,
        /// What should.
        expected: String,
    },
}

const MARK: &str = "# boresight trials ";
/// A ledger that is being filled.
#[derive(Debug)]
pub struct Ledger {
    file: PathBuf,
    out: File,
    columns: Columns,
}

impl Ledger {
    /// Opens a file that [`prepare`] found good.
    ///
    /// # Errors
    /// [`LedgerError::System`].
    pub fn open(file: &Path, columns: &Columns) -> Result<Self, LedgerError> {
        let out = OpenOptions::new().append(true).open(file);
        Ok(Self {
            file: file.to_owned(),
            out: out.map_err(|e| system(file, &e))?,
            columns: columns.clone(),
        })
    }

    /// Appends a trial, the next seed's.
    ///
    /// # Errors
    /// [`LedgerError::System`].
    pub fn append(&mut self, trial: &Trial) -> Result<(), LedgerError> {
        let line = self.columns.line(trial);
        self.out
            .write_all(&line)
            .map_err(|e| system(&self.file, &e))
    }
}

/// Makes a ledger ready to be appended to and says how many trials it holds: a missing one is begun, a record torn by a crash is cut off.
///
/// # Errors
/// [`LedgerError`]: trials of something else, a damaged file, the operating system.
pub fn prepare(file: &Path, header: &Header) -> Result<u64, LedgerError> {
    let begin = header.text();
    let old = match File::open(file) {
        Ok(old) => old,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            std::fs::write(file, begin).map_err(|e| system(file, &e))?;
            return Ok(0);
        }
        Err(e) => return Err(system(file, &e)),
    };
    let length = old.metadata().map_err(|e| system(file, &e))?.len();
    if length < begin.len() as u64 {
        let bytes = std::fs::read(file).map_err(|e| system(file, &e))?;
        if begin.as_bytes().starts_with(&bytes) {
            std::fs::write(file, begin).map_err(|e| system(file, &e))?;
            return Ok(0);
        }
    }
    let mut records = Records::begin(file, old, header)?;
    let mut done = 0;
    for trial in records.by_ref() {
        trial?;
        done += 1;
    }
    if records.good_bytes < length {
        let out = OpenOptions::new().write(true).open(file);
        out.and_then(|out| out.set_len(records.good_bytes))
            .map_err(|e| system(file, &e))?;
    }
    Ok(done)
}

/// What a ledger says of itself.
///
/// # Errors
/// [`LedgerError`]: no ledger, or one that cannot be read.
pub fn header_of(file: &Path) -> Result<Header, LedgerError> {
    let open = File::open(file).map_err(|e| system(file, &e))?;
    let mut head = vec![];
    let mut input = BufReader::new(open);
    input
        .read_until(b'\n', &mut head)
        .map_err(|e| system(file, &e))?;
    header_in(&head).ok_or_else(|| damaged(file, 1, &head, A_HEADER))
}

/// The header in a ledger's first line.
fn header_in(line: &[u8]) -> Option<Header> {
    let text = String::from_utf8_lossy(line);
    serde_json::from_str(text.strip_prefix(MARK)?).ok()
}

/// What the first line should be.
const A_HEADER: &str = "the header of a boresight file of trials";

/// The trials of a ledger in the order of seeds; a torn record at the end is left out.
///
/// # Errors
/// [`LedgerError`] as [`prepare`].
pub fn read(file: &Path, header: &Header) -> Result<Records, LedgerError> {
    let open = File::open(file).map_err(|e| system(file, &e))?;
    Records::begin(file, open, header)
}

/// Trials, one at a time.
#[derive(Debug)]
pub struct Records {
    file: PathBuf,
    input: BufReader<File>,
    columns: Columns,
    seed: u64,
    line: u64,
    good_bytes: u64,
}

impl Records {
    fn begin(file: &Path, open: File, header: &Header) -> Result<Self, LedgerError> {
        let mut records = Self {
            file: file.to_owned(),
            input: BufReader::with_capacity(1 << 16, open),
            columns: header.columns.clone(),
            seed: header.first_seed,
            line: 0,
            good_bytes: 0,
        };
        let head = records.line()?;
        let Some(found) = header_in(&head) else {
            return Err(records.damaged(&head, A_HEADER));
        };
        if let Some((what, found, expected)) = header.difference(&found) {
            let file = file.to_owned();
            return Err(LedgerError::Other {
                file,
                what,
                found,
                expected,
            });
        }
        if found.numerics != header.numerics {
            let begin = |all: &str| all.chars().take(12).collect();
            return Err(LedgerError::Numerics {
                file: file.to_owned(),
                found: begin(&found.numerics),
                expected: begin(&header.numerics),
            });
        }
        records.good_bytes = head.len() as u64;
        let names = records.line()?;
        if names != format!("{}\n", header.columns.text()).into_bytes() {
            return Err(records.damaged(&names, "the names of the columns"));
        }
        records.good_bytes += names.len() as u64;
        Ok(records)
    }

    fn line(&mut self) -> Result<Vec<u8>, LedgerError> {
        let mut line = vec![];
        self.line += 1;
        self.input
            .read_until(b'\n', &mut line)
            .map_err(|e| system(&self.file, &e))?;
        Ok(line)
    }

    fn damaged(&self, found: &[u8], expected: &str) -> LedgerError {
        damaged(&self.file, self.line, found, expected)
    }

    /// Bytes up to the end of the last whole record.
    pub(super) fn good_bytes(&self) -> u64 {
        self.good_bytes
    }

    /// The next whole record; `None` at the end or where only a torn one is left.
    fn record(&mut self) -> Result<Option<Trial>, LedgerError> {
        let line = self.line()?;
        let found = line
            .ends_with(b"\n")
            .then(|| self.columns.parse_line(&line))
            .flatten()
            .filter(|trial| trial.seed == self.seed);
        let Some(trial) = found else {
            let last = self.line()?.is_empty();
            self.line -= 1;
            let expected = format!("the trial of seed {}", self.seed);
            return if last {
                Ok(None)
            } else {
                Err(self.damaged(&line, &expected))
            };
        };
        self.good_bytes += line.len() as u64;
        self.seed += 1;
        Ok(Some(trial))
    }
}

impl Iterator for Records {
    type Item = Result<Trial, LedgerError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.record().transpose()
    }
}

fn damaged(file: &Path, line: u64, found: &[u8], expected: &str) -> LedgerError {
    let text = String::from_utf8_lossy(found);
    let begin: String = text.trim_end().chars().take(60).collect();
    LedgerError::Damaged {
        file: file.to_owned(),
        line,
        found: format!("\"{begin}\""),
        expected: expected.to_owned(),
    }
}

fn system(file: &Path, error: &std::io::Error) -> LedgerError {
    LedgerError::System {
        file: file.to_owned(),
        found: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::toy::Toy;
    use crate::calibrate::tried::{Reason, Said};
    use nalgebra::DMatrix;

    fn header() -> Header {
        Header::new(&Toy::default(), "together", 7)
    }

    fn trial(seed: u64) -> Trial {
        let x = seed as f64;
        let refused = Reason {
            code: "no_wall".to_owned(),
            text: "it said \"no wall\", then\tnothing".to_owned(),
        };
        let joint = Said {
            error: vec![-1e-300 * x, 0.1 + 0.2],
            covariance: Some(DMatrix::from_fn(2, 2, |i, j| {
                1e-7 / ((i + 1) * (j + 1)) as f64
            })),
            variance_factor: (seed != 8).then_some(1.0 / 3.0),
        };
        let reference = Said {
            error: vec![x.sqrt(), 5e-324],
            covariance: None,
            variance_factor: None,
        };
        let odd = seed.is_multiple_of(3);
        Trial {
            seed,
            paths: vec![
                if odd { Err(refused.clone()) } else { Ok(joint) },
                if odd { Ok(reference) } else { Err(refused) },
            ],
        }
    }

    fn filled(folder: &Path, count: u64) -> PathBuf {
        let file = folder.join("a.csv");
        assert_eq!(prepare(&file, &header()).expect("begun"), 0);
        let mut ledger = Ledger::open(&file, &header().columns).expect("open");
        for seed in 7..7 + count {
            ledger.append(&trial(seed)).expect("appended");
        }
        file
    }

    fn all(file: &Path) -> Vec<Trial> {
        let records = read(file, &header()).expect("readable");
        records.map(|r| r.expect("a record")).collect()
    }

    #[test]
    fn what_is_read_is_what_was_written_to_the_last_bit() {
        let folder = tempfile::tempdir().expect("folder");
        let file = filled(folder.path(), 5);
        let expected: Vec<Trial> = (7..12).map(trial).collect();
        assert_eq!(all(&file), expected);
        assert_eq!(prepare(&file, &header()).expect("good"), 5);
        let names = std::fs::read_to_string(&file).expect("text");
        let names = names.lines().nth(1).expect("columns").to_owned();
        let expected = "seed,joint_error_a_rad,joint_error_b_m,joint_covariance_a_rad_a_rad,joint_covariance_b_m_a_rad,\
            joint_covariance_b_m_b_m,joint_variance_factor,joint_refusal,joint_reason,reference_error_a_rad,\
            reference_error_b_m,reference_refusal,reference_reason";
        assert_eq!(names, expected);
    }

    /// Cut at every byte of the last record: the records before stay, the torn one goes, and what is appended then stands whole.
    #[test]
    fn a_torn_last_record_is_cut_off() {
        let folder = tempfile::tempdir().expect("folder");
        let whole = std::fs::read(filled(folder.path(), 3)).expect("bytes");
        let two = 1 + whole[..whole.len() - 1]
            .iter()
            .rposition(|b| *b == b'\n')
            .expect("a line");
        for cut in two..whole.len() {
            let file = folder.path().join("torn.csv");
            std::fs::write(&file, &whole[..cut]).expect("written");
            assert_eq!(
                prepare(&file, &header()).expect("mended"),
                2,
                "cut at {cut}"
            );
            let mut ledger = Ledger::open(&file, &header().columns).expect("open");
            ledger.append(&trial(9)).expect("appended");
            assert_eq!(std::fs::read(&file).expect("bytes"), whole);
        }
    }

    #[test]
    fn a_torn_header_is_begun_again_and_a_foreign_file_is_not() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("a.csv");
        let begin = header().text();
        for cut in [0, 1, 20, begin.len() - 1] {
            std::fs::write(&file, &begin[..cut]).expect("written");
            assert_eq!(prepare(&file, &header()).expect("begun"), 0, "cut at {cut}");
            assert_eq!(std::fs::read_to_string(&file).expect("text"), begin);
        }
        std::fs::write(&file, "seed,error\n1,2\n").expect("written");
        let message = prepare(&file, &header()).expect_err("foreign").to_string();
        assert!(
            message.contains("line 1: found \"seed,error\""),
            "{message}"
        );
        assert_eq!(
            std::fs::read_to_string(&file).expect("text"),
            "seed,error\n1,2\n"
        );
    }

    #[test]
    fn damage_in_the_middle_is_named() {
        let folder = tempfile::tempdir().expect("folder");
        let file = filled(folder.path(), 3);
        let text = std::fs::read_to_string(&file).expect("text");
        std::fs::write(&file, text.replace("\n8,", "\n88,")).expect("written");
        let message = prepare(&file, &header()).expect_err("damaged").to_string();
        assert!(message.contains("line 4"), "{message}");
        assert!(message.contains("the trial of seed 8"), "{message}");
    }

    #[test]
    fn trials_of_something_else_are_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let file = filled(folder.path(), 1);
        let before = std::fs::read(&file).expect("bytes");
        let toy = Toy::default();
        let other = Toy { spread: 2.0 };
        let mut version = header();
        version.version = "0.0.0".to_owned();
        let mut configured = header();
        configured.configuration_sha256.clear();
        let cases = [
            (
                Header::new(&other, "together", 7),
                "another scenario (SHA-256)",
            ),
            (configured, "another configuration (SHA-256)"),
            (
                Header::new(&toy, "only-first", 7),
                "another set of sources: found together, expected only-first",
            ),
            (
                Header::new(&toy, "together", 8),
                "another first seed: found 7, expected 8",
            ),
            (version, "another program version"),
        ];
        for (header, expected) in cases {
            let message = prepare(&file, &header).expect_err("other").to_string();
            assert!(message.contains(expected), "{message}");
        }
        let mut elsewhere = header();
        elsewhere.numerics = format!("0123456789abcdef{}", &elsewhere.numerics[16..]);
        let message = prepare(&file, &elsewhere).expect_err("other").to_string();
        let differ = "last digits come out otherwise";
        assert!(
            message.contains(differ) && message.contains("here 0123456789ab)"),
            "{message}"
        );
        assert_eq!(std::fs::read(&file).expect("bytes"), before);
    }
}
