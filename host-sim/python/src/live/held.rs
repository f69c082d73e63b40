//! A peer's thread, and its end: whatever lets go of it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};
use std::thread::JoinHandle;

use cohold_live::endpoint::Stop;
use cohold_live::steering::Steering;
use pyo3::prelude::*;

/// Why a peer did not begin, or ended.
pub(super) enum Why {
    /// The system said so, of a file or a socket.
    System(String),
    Refused(String),
}

impl From<cohold_live::Error> for Why {
    fn from(error: cohold_live::Error) -> Self {
        match &error {
            cohold_live::Error::Sim(cohold_sim::Error::Io(..)) => Self::System(error.to_string()),
            _ => Self::Refused(error.to_string()),
        }
    }
}

/// The report as JSON, or why there is none.
pub(super) type Outcome = Result<String, Why>;

/// A peer and its thread.
pub(super) struct Held {
    pub(super) steering: Arc<Steering>,
    pub(super) stop: Stop,
    /// The process that has the thread: a child that was forked has none.
    pub(super) process: u32,
    pub(super) thread: Mutex<Option<JoinHandle<Outcome>>>,
    pub(super) outcome: OnceLock<Outcome>,
}

impl Held {
    fn thread(&self) -> MutexGuard<'_, Option<JoinHandle<Outcome>>> {
        self.thread.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What came of it, if it has ended; `waits` for that.
    pub(super) fn outcome(&self, waits: bool) -> Option<&Outcome> {
        if self.process == std::process::id() {
            let mut thread = self.thread();
            if let Some(ended) = thread.take_if(|thread| waits || thread.is_finished()) {
                let failed = |_| Err(Why::Refused("the peer's thread has failed".to_owned()));
                let _ = self.outcome.set(ended.join().unwrap_or_else(failed));
            }
        }
        self.outcome.get()
    }

    /// Lets go, and waits until it has. Whoever calls this holds no interpreter: a device in Python needs it.
    pub(super) fn end(&self) {
        self.stop.ask();
        self.outcome(true);
    }
}

/// Every peer of this process, for its end.
static HELD: Mutex<Vec<Weak<Held>>> = Mutex::new(Vec::new());

/// Lets go of every peer of this process.
#[pyfunction]
fn let_all_go(py: Python<'_>) {
    let all = std::mem::take(&mut *HELD.lock().unwrap_or_else(PoisonError::into_inner));
    py.detach(|| all.iter().filter_map(Weak::upgrade).for_each(|held| held.end()));
}

/// Has the interpreter let go of this peer when it ends.
pub(super) fn remember(py: Python<'_>, held: &Arc<Held>) -> PyResult<()> {
    static AT_EXIT: AtomicBool = AtomicBool::new(false);
    if !AT_EXIT.swap(true, Ordering::Relaxed) {
        let let_all_go = pyo3::wrap_pyfunction!(let_all_go, py)?;
        py.import("atexit")?.call_method1("register", (let_all_go,))?;
    }
    let mut all = HELD.lock().unwrap_or_else(PoisonError::into_inner);
    all.retain(|held| held.strong_count() > 0);
    all.push(Arc::downgrade(held));
    Ok(())
}
