//! A path that has become shorter is let in slowly: what comes by it waits, and waits less and less, by 1 ms in [`SLIDE`].
//!
//! A line that hears 32 ms more at once makes up for them at once, and hands feel a step. So where flow came by the relay and now comes directly, it is
//! held for as long as the relay takes longer than the direct path, at first. How much that is, both paths' signals say: each carries
//! its sender's clock, and what the two clocks are apart is the same on both. The least of the last [`WINDOW`] or two counts.
//!
//! **Invariants**: order is kept, for a hold shrinks more slowly than time goes; nothing waits longer than the relay would have taken, nor longer than
//! [`MOST`]; no more than [`ROOM`] datagrams wait. The link above sees a delay that falls, and no change of path.
//! **Limit**: a path that has become longer is heard when it is heard; nothing can be made of what has not come.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// A hold shrinks by a ms in so many.
const SLIDE: u32 = 20;
/// Nothing is held for longer: a relay that takes so much longer is no line for a hand.
const MOST: Duration = Duration::from_millis(200);
/// Datagrams that wait at once: a packet each tick for [`MOST`], and half as many again.
const ROOM: usize = 300;
/// How long a signal's time counts, at least; twice as long at the most.
const WINDOW: Duration = Duration::from_millis(500);

/// The least that signals took of late by one path, as the two clocks say, µs.
#[derive(Clone, Copy, Debug, Default)]
struct Least {
    since: Option<Instant>,
    now_us: Option<i64>,
    before_us: Option<i64>,
}

impl Least {
    fn turn(&mut self, now: Instant) {
        let age = self.since.map_or(Duration::MAX, |since| now.saturating_duration_since(since));
        if age >= WINDOW {
            self.before_us = self.now_us.take().filter(|_| age < 2 * WINDOW);
            self.since = Some(now);
        }
    }

    fn took(&mut self, now: Instant, us: i64) {
        self.turn(now);
        self.now_us = Some(self.now_us.map_or(us, |least| least.min(us)));
    }

    fn get(&mut self, now: Instant) -> Option<i64> {
        self.turn(now);
        self.now_us.into_iter().chain(self.before_us).min()
    }
}

/// How long what comes directly is held.
#[derive(Clone, Copy, Debug, Default)]
enum Held {
    /// Not at all.
    #[default]
    Free,
    /// Flow has come by the relay of late: until it is known how much longer that takes, for [`MOST`].
    Relayed,
    /// For so long, and less and less from then on.
    Slides(Duration, Instant),
}

/// What waits.
#[derive(Debug, Default)]
pub(crate) struct Hold {
    held: Held,
    /// By the relay, and directly.
    took: [Least; 2],
    waits: VecDeque<(Instant, Vec<u8>)>,
}

impl Hold {
    /// A signal has come by a path; what its sender's clock said, µs, and this end's.
    pub(crate) fn took(&mut self, now: Instant, direct: bool, sent_us: u64, now_us: u64) {
        // Two clocks of u64 differ by what i64 holds, if anybody's clock is one.
        self.took[usize::from(direct)].took(now, now_us.wrapping_sub(sent_us).cast_signed());
    }

    /// Flow comes by the relay, and none directly.
    pub(crate) fn is_relayed(&mut self) {
        // What waits yet is let go first.
        if self.waits.is_empty() {
            self.held = Held::Relayed;
        }
    }

    /// How long what comes now is held.
    fn time(&mut self, now: Instant) -> Duration {
        if let Held::Relayed = self.held {
            let [relay, direct] = self.took.each_mut().map(|least| least.get(now));
            let (Some(relay), Some(direct)) = (relay, direct) else { return MOST };
            let longer = Duration::from_micros(u64::try_from(relay.saturating_sub(direct)).unwrap_or_default());
            let longer = longer.min(MOST);
            // The first that is held leaves when it would have come by the relay, and from there on the hold shrinks.
            self.held = Held::Slides(longer, now + longer);
        }
        let Held::Slides(at_first, since) = self.held else { return Duration::ZERO };
        let left = at_first.saturating_sub(now.saturating_duration_since(since) / SLIDE);
        if left.is_zero() {
            self.held = Held::Free;
        }
        left
    }

    /// Takes what has come directly; whether it is held.
    pub(crate) fn takes(&mut self, now: Instant, datagram: &[u8]) -> bool {
        let goes_on = self.waits.is_empty() && self.time(now).is_zero() || self.waits.len() >= ROOM;
        if !goes_on {
            self.waits.push_back((now, datagram.to_vec()));
        }
        !goes_on
    }

    /// The oldest that has waited for long enough.
    pub(crate) fn release(&mut self, now: Instant) -> Option<Vec<u8>> {
        let came = self.waits.front()?.0;
        let due = now.saturating_duration_since(came) >= self.time(now);
        if due { self.waits.pop_front().map(|(_, datagram)| datagram) } else { None }
    }
}

#[cfg(test)]
#[path = "../tests/inside/hold.rs"]
mod tests;
