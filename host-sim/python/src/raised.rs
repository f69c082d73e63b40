//! What Python raised in the middle of a tick, where nobody can be told of it, until the call that the tick is part of ends.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// What was raised first during one call, or Ctrl-C after it. Which call, its threads know.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Kept>>);

#[derive(Default)]
struct Kept {
    error: Option<PyErr>,
    /// The threads of the call that have asked a law, as Python calls them.
    threads: BTreeSet<u64>,
}

thread_local! {
    static RAISED: RefCell<Option<Raised>> = const { RefCell::new(None) };
    /// This thread as Python calls it, once it was asked.
    static THREAD: Cell<Option<u64>> = const { Cell::new(None) };
}

impl Raised {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Of the call that this thread works for.
    pub(crate) fn current() -> Self {
        RAISED.with_borrow(|slot| slot.clone().unwrap_or_default())
    }

    /// This thread works for the call from now on.
    pub(crate) fn enter(&self) {
        RAISED.set(Some(self.clone()));
    }

    /// This thread does so for the time of the work.
    pub(crate) fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        let before = RAISED.replace(Some(self.clone()));
        let done = work();
        RAISED.set(before);
        done
    }

    /// Whether nothing was raised.
    pub(crate) fn is_none(&self) -> bool {
        self.kept().error.is_none()
    }

    /// What was raised.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.kept().error.take()
    }

    /// What was raised, which the threads that are left behind go on to see.
    pub(crate) fn left(&self) -> Option<PyErr> {
        // Python first: a law's thread that has it may be waiting for what is kept.
        Python::attach(|py| self.kept().error.as_ref().map(|error| error.clone_ref(py)))
    }

    /// Ends the call with this, whatever was raised before.
    pub(crate) fn stop(&self, signal: PyErr) {
        self.kept().error = Some(signal);
    }

    /// Whether laws are asked any more: not once the call that this thread works for is to end. Python may interrupt this thread then.
    pub(crate) fn asks(py: Python<'_>) -> PyResult<bool> {
        RAISED.with_borrow(|slot| {
            let Some(slot) = slot else { return Ok(true) };
            if slot.kept().error.is_some() {
                return Ok(false);
            }
            let thread = match THREAD.get() {
                Some(thread) => thread,
                None => py.import("threading")?.call_method0("get_ident")?.extract()?,
            };
            THREAD.set(Some(thread));
            slot.kept().threads.insert(thread);
            Ok(true)
        })
    }

    /// Interrupts the laws that threads of the call are inside of: what they do in Python ends, what they wait for outside of it does not.
    pub(crate) fn interrupt(&self) {
        let threads = self.kept().threads.clone();
        let interrupted = Python::attach(|py| {
            let ctypes = py.import("ctypes")?;
            let interrupt = ctypes.getattr("pythonapi")?.getattr("PyThreadState_SetAsyncExc")?;
            let error = ctypes.call_method1("py_object", (py.get_type::<PyKeyboardInterrupt>(),))?;
            for thread in threads {
                interrupt.call1((ctypes.call_method1("c_ulong", (thread,))?, &error))?;
            }
            PyResult::Ok(())
        });
        // Without ctypes a law ends when it ends.
        drop(interrupted);
    }

    /// Keeps it for the call that this thread works for, unless there is one already.
    pub(crate) fn put(error: PyErr) {
        RAISED.with_borrow(|slot| match slot {
            Some(slot) => {
                slot.kept().error.get_or_insert(error);
            }
            None => Python::attach(|py| error.write_unraisable(py, None)),
        });
    }
}
