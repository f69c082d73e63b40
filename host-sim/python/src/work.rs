//! Work that takes time: Python's other threads go on meanwhile, and Ctrl-C ends it, whatever a law in Python is doing.
//!
//! Python tells of signals on its main thread only, so the caller looks for them, and threads of their own work. Told to stop they ask
//! no law any more, and a law that they are inside of is interrupted. One that does not let itself be is left behind: its thread owns
//! all that it works on, and ends when the law lets it. The others end with the call: a process that forks later (multiprocessing on
//! Linux) inherits no pool that hangs.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use cohold_io::escaped;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::raised::Raised;

/// How long Ctrl-C may wait.
const LOOK: Duration = Duration::from_millis(20);
/// How long it then waits for the threads, which a law may keep.
const GRACE: Duration = Duration::from_millis(100);
/// As much as a main thread has, bytes.
const STACK: usize = 8 << 20;

/// A sentence of the simulator as Python raises it.
pub(crate) fn refused(said: impl ToString) -> PyErr {
    PyValueError::new_err(escaped(&said.to_string()).into_owned())
}

/// How far work is, of which a function of Python's is told when that has changed: what is done, and of how much.
#[derive(Clone, Default)]
pub(crate) struct Progress {
    done: Arc<AtomicU64>,
    total: u64,
    tell: Option<Arc<Py<PyAny>>>,
}

impl Progress {
    pub(crate) fn new(tell: Option<Py<PyAny>>, total: u64) -> Self {
        Self { total, tell: tell.map(Arc::new), ..Self::default() }
    }

    /// So much more is done.
    pub(crate) fn add(&self, more: u64) {
        self.done.fetch_add(more, Ordering::Relaxed);
    }

    /// So much is done.
    pub(crate) fn is_at(&self, done: u64) {
        self.done.store(done, Ordering::Relaxed);
    }

    /// Tells it, unless `told` says so already.
    fn look(&self, told: &mut u64) -> PyResult<()> {
        let done = self.done.load(Ordering::Relaxed);
        let Some(tell) = self.tell.as_ref().filter(|_| done != *told) else { return Ok(()) };
        *told = done;
        Python::attach(|py| tell.call1(py, (done, self.total))).map(drop)
    }
}

/// Work on a thread of its own: what it does, or what Python had to say in between, Ctrl-C or a law that raised. The work asks now and
/// then whether it is to go on; what it gives after a no is thrown away.
pub(crate) fn here<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    here_telling(py, &Progress::default(), work)
}

/// The same, which tells how far it is; what that raises ends it.
pub(crate) fn here_telling<T: Send + 'static>(
    py: Python<'_>,
    progress: &Progress,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    py.detach(|| {
        let mut told = 0;
        let raised = Raised::default();
        let (own, (give, given)) = (raised.clone(), channel());
        let thread = thread::Builder::new().name("work".to_owned()).stack_size(STACK).spawn(move || {
            let done = own.during(|| work(&|| own.is_none()));
            // Whoever left it behind does not listen.
            let _ = give.send(done);
        });
        let thread = thread.map_err(|cause| PyRuntimeError::new_err(format!("cannot start a thread: {cause}")))?;
        let mut asked: Option<Instant> = None;
        let done = loop {
            match given.recv_timeout(LOOK) {
                Ok(done) => break done,
                Err(RecvTimeoutError::Disconnected) => {
                    // It panicked.
                    return thread.join().map_or_else(|panic| std::panic::resume_unwind(panic), |()| unsaid());
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            let signal = Python::attach(|py| py.check_signals());
            let signal = signal.and_then(|()| if asked.is_none() { progress.look(&mut told) } else { Ok(()) }).err();
            asked = asked.or_else(|| signal.is_some().then(Instant::now));
            if let Some(signal) = signal {
                raised.stop(signal);
            }
            if asked.is_some() {
                raised.interrupt();
            }
            if asked.is_some_and(|asked| asked.elapsed() >= GRACE) {
                return raised.left().map_or_else(unsaid, Err);
            }
        };
        let _ = thread.join();
        let done = raised.take().map_or(done, Err)?;
        progress.look(&mut told).map(|()| done)
    })
}

fn unsaid<T>() -> PyResult<T> {
    Err(PyRuntimeError::new_err("the work ended without a word"))
}

/// [`here_telling`] on this many threads of its own (0: as many as there are cores); inside, `rayon` works on them.
pub(crate) fn on_threads<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    progress: &Progress,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    here_telling(py, progress, move |go_on| {
        let slot = Raised::current();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).start_handler(move |_| slot.enter()).build();
        let pool = pool.map_err(|cause| PyRuntimeError::new_err(format!("cannot start threads: {cause}")))?;
        pool.install(|| work(go_on))
    })
}
