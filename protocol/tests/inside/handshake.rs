//! A handshake that makes a mistake, for the search ([`crate::link`]).

use super::*;

impl Handshake {
    /// A challenge without a lifetime: the ones that were offered are as good as new.
    pub(crate) fn keep_challenges(&mut self, now: u64) {
        self.offered.iter_mut().for_each(|(_, first_us)| *first_us = now);
    }
}
