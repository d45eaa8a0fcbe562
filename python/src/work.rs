//! Long calls: on a thread of their own and in a pool of ours, so that the caller hears of progress and of Ctrl-C meanwhile.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use boresight::watch::{Stopped, Watch, Workers};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use rayon::ThreadPool;

use super::errors::Failure;

/// How often the caller looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// How long the caller waits for work that was told to stop; what does not look whether it should, goes on unseen and is dropped at its end.
const PATIENCE: Duration = Duration::from_millis(500);

/// No trial takes longer.
const FOR_EVER: Duration = Duration::from_secs(24 * 3600);

/// What the work tells its caller.
enum Message<T> {
    Step(Step),
    Ask(Questions),
    Ended(Result<T, Failure>),
}

/// Questions to other processes, whose answers the work waits for.
struct Questions {
    /// Tells the packets from those of other questions.
    number: u64,
    /// What each question needs besides.
    packets: Arc<Vec<Vec<u8>>>,
    questions: Vec<Vec<u8>>,
    answers: Sender<Vec<Vec<u8>>>,
}

/// What is being done, how much of it is done, of how much; of 0 where nobody counts.
pub type Step = (String, u64, u64);

/// What the work sees of its caller: a [`Watch`].
pub struct Caller<'a> {
    /// Set when the call is to stop.
    pub stop: &'a AtomicBool,
    tell: &'a (dyn Fn(Step) + Sync),
    /// Asks other processes, where the caller has some.
    ask: Option<&'a (dyn Fn(Questions) + Sync)>,
    /// The step that was told last.
    step: Mutex<String>,
}

impl Watch for Caller<'_> {
    fn step(&self, what: &str) {
        what.clone_into(&mut self.step.lock().unwrap_or_else(PoisonError::into_inner));
        (self.tell)((what.to_owned(), 0, 0));
    }

    fn counted(&self, done: usize, of: usize) {
        let step = self.step.lock().unwrap_or_else(PoisonError::into_inner);
        (self.tell)((step.clone(), done as u64, of as u64));
    }

    fn stopped(&self) -> bool {
        self.stop.load(SeqCst)
    }

    fn workers(&self) -> Option<&dyn Workers> {
        self.ask.map(|_| self as &dyn Workers)
    }
}

impl Workers for Caller<'_> {
    fn ask(
        &self,
        number: u64,
        packets: &Arc<Vec<Vec<u8>>>,
        questions: Vec<Vec<u8>>,
    ) -> Result<Vec<Vec<u8>>, Stopped> {
        let (answers, answered) = mpsc::channel();
        let packets = Arc::clone(packets);
        if let Some(ask) = self.ask {
            ask(Questions {
                number,
                packets,
                questions,
                answers,
            });
        }
        // whoever stopped the call answers no more
        answered.recv().map_err(|_| Stopped)
    }
}

impl Caller<'_> {
    /// Says how much of something is done.
    pub fn count(&self, what: &str, done: u64, of: u64) {
        (self.tell)((what.to_owned(), done, of));
    }
}

/// Runs work in a pool of so many threads, without holding the interpreter. `progress` is called on the caller's thread; what it
/// raises, and Ctrl-C, stop the work and are raised.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Caller<'_>) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    run_with(py, threads, progress, None, work)
}

/// As [`run`], with other processes to ask: `workers` is called on the caller's thread with the number of the packets, the packets (none
/// where they are those of the last call) and the questions, and returns the answers; all of them bytes.
pub fn run_with<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    workers: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Caller<'_>) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let caller = Listener::new(progress, workers);
    begun(py, threads, caller, PATIENCE, work)
}

/// As [`run`], for work that writes into files of the caller's: once stopped it is waited for, so that nothing is written any more when
/// the call has ended.
pub fn run_to_its_end<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Caller<'_>) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let caller = Listener::new(progress, None);
    begun(py, threads, caller, FOR_EVER, work)
}

/// What the caller gave to be called meanwhile.
struct Listener<'a, 'py> {
    progress: Option<&'a Bound<'py, PyAny>>,
    workers: Option<&'a Bound<'py, PyAny>>,
    /// The step that was said last.
    said: Option<Step>,
    /// The packets that were handed on last.
    sent: Option<u64>,
}

impl<'a, 'py> Listener<'a, 'py> {
    fn new(
        progress: Option<&'a Bound<'py, PyAny>>,
        workers: Option<&'a Bound<'py, PyAny>>,
    ) -> Self {
        Self {
            progress,
            workers,
            said: None,
            sent: None,
        }
    }

    fn say(&mut self, step: Step) -> PyResult<()> {
        if let Some(progress) = self.progress.filter(|_| self.said.as_ref() != Some(&step)) {
            progress.call1(step.clone())?;
            self.said = Some(step);
        }
        Ok(())
    }

    /// Has questions answered.
    fn ask(&mut self, py: Python<'py>, asked: Questions) -> PyResult<()> {
        let Some(workers) = self.workers else {
            return Ok(());
        };
        let bytes = |all: &[Vec<u8>]| {
            let each = all.iter().map(|bytes| PyBytes::new(py, bytes));
            PyList::new(py, each)
        };
        let new = self.sent != Some(asked.number);
        let packets = new.then(|| bytes(&asked.packets)).transpose()?;
        self.sent = Some(asked.number);
        let found = workers.call1((asked.number, packets, bytes(&asked.questions)?))?;
        // the work does not wait any more where it was stopped
        drop(asked.answers.send(found.extract()?));
        Ok(())
    }
}

fn begun<'py, T: Send + 'static>(
    py: Python<'py>,
    threads: Option<usize>,
    mut caller: Listener<'_, 'py>,
    patience: Duration,
    work: impl FnOnce(&Caller<'_>) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let pool = pool(threads)?;
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, mut receiver) = mpsc::channel();
    let asks = caller.workers.is_some();
    let begun = begin(pool, (Arc::clone(&stop), asks), sender, work);
    begun.map_err(|e| PyValueError::new_err(format!("no thread could be started: {e}")))?;
    loop {
        match hear(py, &mut receiver, &mut caller) {
            Ok(None) => {}
            Ok(Some(ended)) => return ended.map_err(|failure| failure.raise(py)),
            Err(error) => {
                stop.store(true, SeqCst);
                py.detach(move || wait(&receiver, patience));
                return Err(error);
            }
        }
    }
}

fn begin<T: Send + 'static>(
    pool: Arc<ThreadPool>,
    (stop, asks): (Arc<AtomicBool>, bool),
    sender: Sender<Message<T>>,
    work: impl FnOnce(&Caller<'_>) -> Result<T, Failure> + Send + 'static,
) -> std::io::Result<()> {
    let body = move || {
        // nobody listens any more to a call that was given up
        let tell = |step| drop(sender.send(Message::Step(step)));
        let ask = |questions| drop(sender.send(Message::Ask(questions)));
        let caller = Caller {
            stop: &stop,
            tell: &tell,
            ask: asks.then_some(&ask),
            step: Mutex::default(),
        };
        let ended = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(&caller))));
        let ended = ended.unwrap_or_else(|panic| Err(Failure::Panic(words(&*panic))));
        drop(sender.send(Message::Ended(ended)));
    };
    let thread = std::thread::Builder::new().name("boresight".to_owned());
    thread.spawn(body).map(drop)
}

/// Waits for the next message and hands it on; the result when it was the last. Of several counts of one step that wait, a slow
/// listener hears the last.
fn hear<'py, T: Send>(
    py: Python<'py>,
    receiver: &mut Receiver<Message<T>>,
    caller: &mut Listener<'_, 'py>,
) -> PyResult<Option<Result<T, Failure>>> {
    let waited = &mut *receiver;
    let first = py.detach(move || waited.recv_timeout(LOOK));
    py.check_signals()?;
    let mut next = match first {
        Err(RecvTimeoutError::Timeout) => return Ok(None),
        Err(RecvTimeoutError::Disconnected) => {
            let text = "a thread ended without a word".to_owned();
            return Ok(Some(Err(Failure::Panic(text))));
        }
        Ok(message) => message,
    };
    loop {
        let step = match next {
            Message::Ended(ended) => return Ok(Some(ended)),
            Message::Ask(asked) => {
                caller.ask(py, asked)?;
                return Ok(None);
            }
            Message::Step(step) => step,
        };
        let Ok(message) = receiver.try_recv() else {
            caller.say(step)?;
            return Ok(None);
        };
        match &message {
            Message::Step(newer) if newer.0 == step.0 && step.1 > 0 => {}
            _ => caller.say(step)?,
        }
        next = message;
    }
}

/// Gives stopped work the time to end.
fn wait<T>(receiver: &Receiver<Message<T>>, patience: Duration) {
    while let Ok(Message::Step(_) | Message::Ask(_)) = receiver.recv_timeout(patience) {}
}

pub fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or(panic.downcast_ref::<&str>().copied());
    format!(
        "boresight failed inside: {}; this is a fault of the program, please report it",
        text.unwrap_or("a panic without words")
    )
}

/// The pool of the process, with the process that made it.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// A pool of so many threads, or the one of the process. A forked child does not have the threads of its parent and gets a pool of its
/// own; that of the parent is left alone there, as waiting for its threads would never end.
pub fn pool(threads: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    let make = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(Arc::new)
            .map_err(|e| PyValueError::new_err(format!("threads: {e}")))
    };
    match threads {
        Some(0) => Err(PyValueError::new_err(
            "threads: found 0, expected 1 or more, or None for one per processor",
        )),
        Some(threads) => make(threads),
        None => {
            let process = std::process::id();
            let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, pool)) = kept.as_ref().filter(|(owner, _)| *owner == process) {
                return Ok(Arc::clone(pool));
            }
            let pool = make(0)?;
            std::mem::forget(kept.replace((process, Arc::clone(&pool))));
            Ok(pool)
        }
    }
}

/// Panics, so that a test can see what becomes of it.
#[pyfunction]
pub fn panic_for_tests(py: Python<'_>, message: String) -> PyResult<()> {
    run(py, None, None, move |_| panic!("{message}"))
}
