//! Work that takes time: Python's other threads go on meanwhile, and Ctrl-C ends it.
//!
//! Python tells of signals on its main thread only, so it is the caller who looks for them, not the threads that work. Those end with
//! the call: a process that forks later (multiprocessing on Linux) inherits no pool that hangs.

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use haptic_io::escaped;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::raised::Raised;

/// How long Ctrl-C may wait.
const LOOK: Duration = Duration::from_millis(20);

/// A sentence of the simulator as Python raises it.
pub(crate) fn refused(said: impl ToString) -> PyErr {
    PyValueError::new_err(escaped(&said.to_string()).into_owned())
}

/// Work on the caller's own thread, detached from the interpreter: what it does, or what Python had to say in between, Ctrl-C or a law
/// that raised. The work asks now and then whether it is to go on; what it gives after a no is thrown away.
pub(crate) fn here<T: Send>(py: Python<'_>, work: impl FnOnce(&dyn Fn() -> bool) -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| {
        let raised = Raised::default();
        let (looked, signal) = (Cell::new(Instant::now()), RefCell::new(None));
        let go_on = || {
            if looked.get().elapsed() >= LOOK {
                looked.set(Instant::now());
                *signal.borrow_mut() = Python::attach(|py| py.check_signals()).err();
            }
            signal.borrow().is_none() && raised.is_none()
        };
        let done = raised.during(|| work(&go_on));
        match signal.take().or(raised.take()) {
            Some(error) => Err(error),
            None => done,
        }
    })
}

/// The same on this many threads of its own (0: as many as there are cores); inside, `rayon` works on them.
pub(crate) fn on_threads<T: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> PyResult<T> + Send,
) -> PyResult<T> {
    py.detach(|| {
        let (raised, stop) = (Raised::default(), AtomicBool::new(false));
        let slot = raised.clone();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).start_handler(move |_| slot.enter()).build();
        let pool = pool.map_err(|cause| PyRuntimeError::new_err(format!("cannot start threads: {cause}")))?;
        let go_on = || !stop.load(Ordering::Relaxed) && raised.is_none();
        let mut signal = None;
        let done = thread::scope(|scope| {
            let (alive, ended) = channel::<()>();
            let (pool, go_on) = (&pool, &go_on);
            let worker = scope.spawn(move || {
                let _alive = alive;
                pool.install(|| work(go_on))
            });
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if signal.is_none() {
                    signal = Python::attach(|py| py.check_signals()).err();
                    stop.store(signal.is_some(), Ordering::Relaxed);
                }
            }
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        match signal.or(raised.take()) {
            Some(error) => Err(error),
            None => done,
        }
    })
}
