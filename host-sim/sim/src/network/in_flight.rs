//! In flight: each thing comes out when its time has come; of those due at once, in the order in which they were sent.

use std::collections::BTreeMap;

/// What is on its way.
#[derive(Clone, Debug)]
pub struct InFlight<T> {
    /// When each is due, µs, and its number.
    due: BTreeMap<(u64, u64), T>,
    sent: u64,
}

impl<T> Default for InFlight<T> {
    fn default() -> Self {
        Self { due: BTreeMap::new(), sent: 0 }
    }
}

impl<T> InFlight<T> {
    /// Takes something that is due at `due_us`.
    pub fn send(&mut self, due_us: u64, what: T) {
        self.due.insert((due_us, self.sent), what);
        self.sent += 1;
    }

    /// The next that is due by `now_us`, and when it was.
    pub fn take(&mut self, now_us: u64) -> Option<(u64, T)> {
        let next = self.due.first_entry().filter(|next| next.key().0 <= now_us)?;
        let ((due_us, _), what) = next.remove_entry();
        Some((due_us, what))
    }
}
