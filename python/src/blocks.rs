//! A survey prepared to answer questions about the blocks of its trajectory, on a thread of its own, which holds it between the
//! questions.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};

use boresight::InputError;
use boresight::procedures::pool::joint::BlockWorker as Prepared;
use boresight::procedures::pool::procedure::input;
use boresight::procedures::pool::survey::load;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::errors::Failure;
use super::survey::settings;
use super::work::{pool, words};

/// Path and SHA-256 of every file that was read.
type Inputs = Vec<(String, String)>;

/// A question, what was sent along with it, and where the answer goes.
struct Question {
    packet: Vec<u8>,
    question: Vec<u8>,
    answer: Sender<Result<Vec<u8>, Failure>>,
}

/// A pool survey prepared to answer questions about the blocks of its trajectory.
#[pyclass(frozen, module = "boresight._core")]
pub struct BlockWorker {
    questions: Mutex<Sender<Question>>,
    /// Path and SHA-256 of every file that was read.
    #[pyo3(get)]
    inputs: Inputs,
}

#[pymethods]
impl BlockWorker {
    /// Reads and prepares a survey, with the seed that the calibration has.
    #[new]
    #[pyo3(signature = (path, seed=None, threads=None))]
    fn prepare(
        py: Python<'_>,
        path: PathBuf,
        seed: Option<u64>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let threads = pool(threads)?;
        let (questions, asked) = mpsc::channel();
        let (ready, prepared) = mpsc::channel();
        let body = move || {
            let told = ready.clone();
            let serving = move || threads.install(move || serve(&path, seed, &told, &asked));
            let ended = catch_unwind(AssertUnwindSafe(serving));
            let ended = ended.unwrap_or_else(|panic| Err(Failure::Panic(words(&*panic))));
            // nobody listens once the preparation is done
            drop(ended.map_err(|failure| ready.send(Err(failure))));
        };
        let thread = std::thread::Builder::new().name("boresight".to_owned());
        let begun = thread.spawn(body);
        begun.map_err(|e| PyValueError::new_err(format!("no thread could be started: {e}")))?;
        let inputs = py.detach(move || prepared.recv());
        let gone = |_| Failure::Panic("a thread ended without a word".to_owned()).raise(py);
        let inputs = inputs.map_err(gone)?.map_err(|failure| failure.raise(py))?;
        let questions = Mutex::new(questions);
        Ok(Self { questions, inputs })
    }

    /// Answers a question with what was sent along with it.
    fn answer<'py>(
        &self,
        py: Python<'py>,
        packet: Vec<u8>,
        question: Vec<u8>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let (answer, answered) = mpsc::channel();
        let asked = Question {
            packet,
            question,
            answer,
        };
        let questions = self.questions.lock();
        let sent = (questions.unwrap_or_else(PoisonError::into_inner)).send(asked);
        let found = match sent {
            Ok(()) => py.detach(move || answered.recv()),
            Err(_) => Err(mpsc::RecvError),
        };
        let ended = Failure::Panic("the worker's thread has ended".to_owned());
        let found = found.unwrap_or(Err(ended));
        Ok(PyBytes::new(
            py,
            &found.map_err(|failure| failure.raise(py))?,
        ))
    }
}

/// Prepares a survey, says so, and answers until nobody asks any more.
fn serve(
    path: &Path,
    seed: Option<u64>,
    ready: &Sender<Result<Inputs, Failure>>,
    asked: &Receiver<Question>,
) -> Result<(), Failure> {
    let survey = load(path)?;
    let settings = settings("joint", seed, false, Arc::default(), "pool")?;
    let inputs = survey.inputs.iter();
    let inputs = inputs.map(|i| (i.path.clone(), i.sha256.clone())).collect();
    let ended = Prepared::prepared(&input(&survey, &settings), |worker| {
        drop(ready.send(Ok(inputs)));
        for Question {
            packet,
            question,
            answer,
        } in asked
        {
            let found = catch_unwind(AssertUnwindSafe(|| worker.answer(&packet, &question)));
            let found = match found {
                Ok(found) => found.map_err(|error| Failure::Refused(error.to_string())),
                Err(panic) => Err(Failure::Panic(words(&*panic))),
            };
            drop(answer.send(found));
        }
    });
    ended.map_err(|error| InputError::unworkable(error).into())
}
