//! A network that does as a script says: any message at any time, any number of times, or never.

use cohold_protocol::wire::PeerId;
use heapless::Deque;

use super::script::Script;

/// Most messages under way; then the oldest is lost.
const MOST: usize = 64;

/// Messages on their way.
pub(super) struct Net<M> {
    /// From, to, what.
    flying: Vec<(usize, usize, M)>,
    /// Whom [`Net::take_all`] neither brings anything nor takes anything from.
    pub(super) cut: Option<usize>,
}

impl<M: Clone> Net<M> {
    /// A network with no message under way.
    pub(super) fn new() -> Self {
        Self { flying: Vec::new(), cut: None }
    }

    /// A message sets out.
    pub(super) fn send(&mut self, from: usize, to: usize, message: M) {
        if self.flying.len() == MOST {
            self.flying.remove(0);
        }
        self.flying.push((from, to, message));
    }

    /// What somebody has to say sets out.
    pub(super) fn post<const N: usize>(&mut self, from: usize, out: &mut Deque<(PeerId, M), N>) {
        while let Some((to, message)) = out.pop_front() {
            self.send(from, usize::from(to.0), message);
        }
    }

    /// Cuts somebody off; if anybody is, everybody is there again.
    pub(super) fn cut_or_mend(&mut self, who: usize) {
        self.cut = if self.cut.is_none() { Some(who) } else { None };
    }

    /// The one that arrives now, if any: taken off the way, or a copy of it.
    pub(super) fn deliver(&mut self, script: &mut Script) -> Option<(usize, usize, M)> {
        let choice = script.byte();
        let at = usize::from(choice >> 1).checked_rem(self.flying.len())?;
        Some(if choice & 1 == 0 { self.flying.remove(at) } else { self.flying[at].clone() })
    }

    /// Drops one message that is under way.
    pub(super) fn lose(&mut self, script: &mut Script) {
        if let Some(at) = script.below(256).checked_rem(self.flying.len()) {
            self.flying.remove(at);
        }
    }

    /// Everything that is under way, in the order of sending; what is from or for somebody who is cut off is lost.
    pub(super) fn take_all(&mut self) -> Vec<(usize, usize, M)> {
        let mut all = std::mem::take(&mut self.flying);
        all.retain(|(from, to, _)| self.cut != Some(*from) && self.cut != Some(*to));
        all
    }
}

/// A clock that starts anywhere and runs as fast as it likes, in millionths of true time.
pub(super) struct Clock {
    /// What it shows at time 0, µs.
    pub(super) start_us: u64,
    /// How much faster it runs, ppm.
    pub(super) fast_ppm: i64,
}

impl Clock {
    /// What it shows, µs.
    pub(super) fn at(&self, time_us: u64) -> u64 {
        self.start_us + time_us * 1_000_000_u64.saturating_add_signed(self.fast_ppm) / 1_000_000
    }
}
