//! Which path flow takes, and what each of the two is like.
//!
//! The direct path is **good** while something has come by it within [`DEAF`] and a signal within [`UNPROVED`], and the other end says the same
//! of its own side. While it is not, everything goes both ways, at once. The relay rests only after the direct path has been good for a
//! second, twice as long each time that it was not, up to [`LONGEST_TRIAL`]; after [`FORGIVEN`] without that, a second again. So paths do not swap under load.

use std::time::{Duration, Instant};

use cohold_live::road::PathFigures;
use hdrhistogram::Histogram;

/// Nothing came directly for so long, and the relay is used as well.
pub(crate) const DEAF: Duration = Duration::from_millis(15);
/// No signal came directly for so long: what comes from there may be anybody's.
const UNPROVED: Duration = Duration::from_millis(100);
/// How long the direct path has to be good before the relay rests.
const TRIAL: Duration = Duration::from_secs(1);
const LONGEST_TRIAL: Duration = Duration::from_secs(30);
/// After so long the trial is a second again.
const FORGIVEN: Duration = Duration::from_secs(60);
/// Round trips are kept up to this, µs, within 1 %.
const LONGEST_US: u64 = 1 << 30;

/// One of the two paths.
pub(crate) struct Path {
    round_trips: Histogram<u64>,
    /// The first and the newest count of the other end's signals, and how many came.
    counts: Option<[u32; 2]>,
    came: u64,
    /// Signals of this end on it.
    pub(crate) sent: u32,
    pub(crate) sent_at: Option<Instant>,
    /// The newest counter of the other end's, its clock in it, and when it came.
    pub(crate) newest: Option<(u64, u64, Instant)>,
    pub(crate) datagrams: u64,
}

impl Path {
    fn new() -> Self {
        let round_trips = Histogram::new_with_bounds(1, LONGEST_US, 2).expect("bounds that are allowed");
        Self { round_trips, counts: None, came: 0, sent: 0, sent_at: None, newest: None, datagrams: 0 }
    }

    /// A signal of the other end's has come, the so-manieth that it sent by this path.
    pub(crate) fn came(&mut self, count: u32, round_trip_us: Option<u64>) {
        self.came += 1;
        self.counts = Some(self.counts.map_or([count; 2], |[first, newest]| [first, newest.max(count)]));
        if let Some(us) = round_trip_us {
            self.round_trips.saturating_record(us.max(1));
        }
    }

    /// The other end has begun anew, and counts anew.
    pub(crate) fn forget(&mut self) {
        (self.counts, self.newest, self.came) = (None, None, 0);
    }

    pub(crate) fn figures(&self) -> PathFigures {
        let ms = |us: u64| 1e-3 * us as f64;
        // Of a path by which nothing came nobody knows what was lost.
        let sent = self.counts.map_or(0, |[first, newest]| u64::from(newest - first) + 1).max(self.came).max(1);
        let missing = self.counts.map_or(0, |_| sent - self.came);
        PathFigures {
            signals: self.round_trips.len(),
            round_trip_ms: ms(self.round_trips.value_at_quantile(0.5)),
            p99_ms: ms(self.round_trips.value_at_quantile(0.99)),
            largest_ms: ms(self.round_trips.max()),
            lost: missing as f64 / sent as f64,
            datagrams: self.datagrams,
        }
    }
}

/// Both paths.
pub(crate) struct Paths {
    /// By the relay, and directly.
    pub(crate) of: [Path; 2],
    heard: Option<Instant>,
    proved: Option<Instant>,
    /// Whether the other end hears this one directly, as it said last, and when.
    hears: Option<(bool, Instant)>,
    good_since: Option<Instant>,
    bad_since: Instant,
    trial: Duration,
}

fn within(at: Option<Instant>, now: Instant, time: Duration) -> bool {
    at.is_some_and(|at| now.saturating_duration_since(at) <= time)
}

impl Paths {
    pub(crate) fn new(now: Instant) -> Self {
        let of = [Path::new(), Path::new()];
        let (heard, proved, hears, good_since) = Default::default();
        Self { of, heard, proved, hears, good_since, bad_since: now, trial: TRIAL }
    }

    /// Something came directly; whether it was a signal.
    pub(crate) fn heard(&mut self, now: Instant, signal: bool) {
        self.heard = Some(now);
        if signal {
            self.proved = Some(now);
        }
    }

    /// The other end says whether it hears this one directly.
    pub(crate) fn said(&mut self, now: Instant, hears: bool) {
        self.hears = Some((hears, now));
    }

    /// Whether this end hears the other one directly.
    pub(crate) fn hears(&self, now: Instant) -> bool {
        within(self.heard, now, DEAF) && within(self.proved, now, UNPROVED)
    }

    /// Takes note of the time.
    pub(crate) fn look(&mut self, now: Instant) {
        let good = self.hears(now) && matches!(self.hears, Some((true, at)) if within(Some(at), now, UNPROVED));
        match (good, self.good_since) {
            (true, None) => self.good_since = Some(now),
            (false, Some(since)) => {
                let lasted = now.saturating_duration_since(since);
                self.trial = if lasted > FORGIVEN { TRIAL } else { (2 * self.trial).min(LONGEST_TRIAL) };
                (self.good_since, self.bad_since) = (None, now);
            }
            _ => {}
        }
    }

    /// Whether flow goes by the relay.
    pub(crate) fn uses_relay(&self, now: Instant) -> bool {
        self.good_since.is_none_or(|since| now.saturating_duration_since(since) < self.trial)
    }

    /// Whether the direct path is good.
    pub(crate) fn is_direct(&self) -> bool {
        self.good_since.is_some()
    }

    /// For how long it has not been.
    pub(crate) fn bad_for(&self, now: Instant) -> Duration {
        if self.is_direct() { Duration::ZERO } else { now.saturating_duration_since(self.bad_since) }
    }
}

#[cfg(test)]
#[path = "../tests/inside/paths.rs"]
mod tests;
