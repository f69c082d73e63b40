//! What Python raised in the middle of a tick, where nobody can be told of it, until the call that the tick is part of ends.

use std::cell::RefCell;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;

/// What was raised first during one call. Which call, its threads know.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

thread_local! {
    static RAISED: RefCell<Option<Raised>> = const { RefCell::new(None) };
}

impl Raised {
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
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_none()
    }

    /// What was raised.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Keeps it for the call that this thread works for, unless there is one already.
    pub(crate) fn put(error: PyErr) {
        RAISED.with_borrow(|slot| match slot {
            Some(Self(slot)) => {
                slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
            None => Python::attach(|py| error.write_unraisable(py, None)),
        });
    }
}
