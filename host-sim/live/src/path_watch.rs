//! The paths of a carried line as whoever watches it has them: each change is said and recorded when it happens, and each second has a row.

use std::sync::Arc;

use crate::recording::recorder::Recorder;
use crate::recording::ticks;
use crate::road::{PathReport, Road};
use crate::tell::{PathSecond, Teller};

/// Watches the paths of one line.
#[derive(Debug)]
pub struct PathWatch {
    road: Arc<dyn Road>,
    /// Where rows go, and the channel that they have there.
    recorder: Option<(Arc<Recorder>, u16)>,
}

impl PathWatch {
    /// Of the paths of this road; nothing is recorded.
    pub fn new(road: Arc<dyn Road>) -> Self {
        Self { road, recorder: None }
    }

    /// This watch, which records from now on into this channel ([`ticks::path_channel`]).
    #[must_use]
    pub fn recording(self, recorder: Arc<Recorder>, channel: u16) -> Self {
        Self { recorder: Some((recorder, channel)), ..self }
    }

    /// What there is to say of the paths now.
    pub fn report(&self) -> PathReport {
        self.road.report()
    }

    /// Says and records what has changed since the last look, at `now_ns` of the endpoint's clock, ns; whether anything has.
    pub fn look(&self, now_ns: u64, teller: &Teller) -> bool {
        let mut changed = false;
        while let Some(change) = self.road.take_change() {
            let ago_ns = change.at.elapsed().as_nanos() as u64;
            let (at_ns, report) =
                (now_ns.saturating_sub(ago_ns), PathReport { way: change.way, lan: change.lan, ..self.report() });
            self.record(at_ns, &report);
            teller.path(at_ns / 1_000, &PathSecond::of(&report));
            changed = true;
        }
        changed
    }

    /// Records how they are, and says it to whoever asks.
    pub fn second(&self, now_ns: u64) -> PathReport {
        let report = self.report();
        self.record(now_ns, &report);
        report
    }

    fn record(&self, at_ns: u64, report: &PathReport) {
        if let Some((recorder, channel)) = &self.recorder {
            recorder.put(*channel, at_ns, &ticks::path(at_ns, report));
        }
    }
}
