//! Notices: a bounded queue of what has happened, taken once and oldest first; when it is full, the oldest are dropped.

use heapless::Deque;

#[derive(Clone, Debug)]
/// What has happened and was not taken yet, at most `N` of it.
pub struct Notices<T, const N: usize>(Deque<T, N>);

impl<T, const N: usize> Default for Notices<T, N> {
    fn default() -> Self {
        Self(Deque::new())
    }
}

impl<T, const N: usize> Notices<T, N> {
    /// One more; the oldest goes where there is no room.
    pub fn put(&mut self, notice: T) {
        if self.0.is_full() {
            self.0.pop_front();
        }
        // There is room now.
        let _ = self.0.push_back(notice);
    }

    /// The oldest, once.
    pub fn take(&mut self) -> Option<T> {
        self.0.pop_front()
    }

    /// All of them, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }
}
