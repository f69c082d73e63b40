//! The board's one lease, which port, console and supervisor share: [`firmware_parts::hold`] in a critical section.

use core::cell::Cell;

use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time::Instant;
use firmware_parts::hold::Hold;

pub(crate) struct Lease(CriticalSectionMutex<Cell<Hold>>);

impl Lease {
    pub(crate) fn new() -> Self {
        Self(CriticalSectionMutex::new(Cell::default()))
    }

    /// Lets `act` change it at this time, µs.
    pub(crate) fn with<R>(&self, act: impl FnOnce(&mut Hold, u64) -> R) -> R {
        self.0.lock(|cell| {
            let mut hold = cell.get();
            let done = act(&mut hold, Instant::now().as_micros());
            cell.set(hold);
            done
        })
    }
}
