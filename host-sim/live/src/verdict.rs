//! Whether a peer may arm: what its scene is at the delays that its link measures, asked of whoever can say, before and while it is armed.
//!
//! **Measured**: half of the last 16 round trips, without an eighth of them at either end, which a busy machine makes; nothing counts of
//! what was before a step; and how late the device of this end is, where it is not the scene's ([`Seen::delay_ticks`]). **Asked**: after 4 round trips, and again, a second after the last time at the earliest, when they
//! fill other ticks than those that were judged. **Said**: every change from stable to unstable and back.
//!
//! **Before it is armed** a peer waits for the first verdict, and as long as that is that the scene is unstable, unless it is to arm anyway;
//! what is not judged is not refused. **Afterwards** a verdict stops nothing: that is for the guards of the peer.
//!
//! Judging takes milliseconds to seconds: it has a thread of its own, which stands back behind what has to be in time from the first verdict on;
//! before that nothing is held.
//!
//! **Limits**: only the line to the other end is measured, also where that is a hub; how a round trip falls to its two ways nobody can measure.

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use cohold_core::safety::Mode;
use cohold_sim::device::Device;
use serde::Serialize;

use crate::devices::Seen;
use crate::endpoint::stand_back;
use crate::{Error, node::Node};

/// Round trips that delays are taken from.
const KEPT: usize = 16;
/// Round trips before the first verdict: a quarter of a second with a packet every 8 ms.
const LEAST: usize = 4;
/// Newest round trips that tell a step, more than a tick away from all before them: as soon as an eighth does not hide them.
const STEP: usize = 3;
/// Between two verdicts, µs.
const AGAIN_US: u64 = 1_000_000;
/// How far the judge stands back behind what has to be in time.
const NICENESS: i32 = 10;

/// What is known of a scene at measured delays.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// Least and largest measured delay of one way, ms.
    pub one_way_ms: [f64; 2],
    /// Ticks from sensing to force that the device of this end was judged with; none of the scene's own.
    pub device_delay_ticks: Option<u32>,
    /// None where it was not judged.
    pub stable: Option<bool>,
    /// Largest spectral radius of a packet period.
    pub spectral_radius: Option<f64>,
    /// In words, with what to change.
    pub text: String,
    /// `key=value` that would make it stable, if one gain does.
    pub instead: Option<String>,
    /// What the verdict leaves out.
    pub not_judged: Vec<&'static str>,
}

/// What a live end has measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Least and largest delay of one way, s.
    pub one_way_s: [f64; 2],
    /// Whole ticks from sensing to force at the device of this end ([`Seen::delay_ticks`]); none of the scene's own.
    pub device_ticks: Option<u32>,
}

/// Who judges, and what comes of it.
#[derive(Clone)]
pub struct Judge {
    /// Judges the scene at what was measured.
    pub find: Arc<dyn Fn(Measured) -> Verdict + Send + Sync>,
    /// How to have an unstable scene armed all the same; none, and it is.
    pub unless: Option<&'static str>,
}

impl fmt::Debug for Judge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Judge").field("unless", &self.unless).finish_non_exhaustive()
    }
}

/// What is asked and answered while a peer runs.
#[derive(Debug)]
pub struct Judging {
    asks: SyncSender<Measured>,
    answers: Receiver<Verdict>,
    unless: Option<&'static str>,
    period_s: f64,
    /// The device of this end, where it is not the scene's.
    device: Option<Seen>,
    /// Times of the newest exchange, and its round trip and those before, s.
    exchange: Option<[u64; 4]>,
    round_trips_s: VecDeque<f64>,
    /// When it was asked last, µs, and of round trips and a device of how many ticks.
    asked: Option<(u64, [u64; 2], Option<u32>)>,
    waits: bool,
    /// The newest one.
    pub verdict: Option<Verdict>,
    /// Every one that was said, and when, s.
    pub said: Vec<(f64, String)>,
}

impl Judging {
    /// With a thread of the judge's own; of a control period of `period_s`, s.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(judge: &Judge, period_s: f64) -> Result<Self, Error> {
        let ((asks, asked), (answer, answers)) = (sync_channel(1), sync_channel(1));
        let find = Arc::clone(&judge.find);
        let work = move || {
            let first = asked.recv().into_iter().try_for_each(|delays| answer.send(find(delays)));
            stand_back(NICENESS);
            first.and_then(|()| asked.into_iter().try_for_each(|delays| answer.send(find(delays))))
        };
        std::thread::Builder::new()
            .name("judge".into())
            .spawn(work)
            .map_err(cohold_sim::Error::cannot("start", &"the judge's thread"))?;
        Ok(Self::new(asks, answers, judge.unless, period_s))
    }

    fn new(
        asks: SyncSender<Measured>,
        answers: Receiver<Verdict>,
        unless: Option<&'static str>,
        period_s: f64,
    ) -> Self {
        let (round_trips_s, said) = (VecDeque::with_capacity(KEPT), Vec::new());
        let (device, exchange, asked, verdict) = (None, None, None, None);
        Self { asks, answers, unless, period_s, device, exchange, round_trips_s, asked, waits: false, verdict, said }
    }

    /// With what is seen of the device of this end, where it is not the scene's: it is asked about the delay of that one too.
    #[must_use]
    pub fn of_device(self, device: Option<Seen>) -> Self {
        Self { device, ..self }
    }

    /// Takes the newest times of a probe and its reply, µs: sent, received there, answered there, back.
    pub fn see(&mut self, exchange: Option<[u64; 4]>) {
        let Some([sent, there, answered, back]) = exchange.filter(|_| exchange != self.exchange) else { return };
        self.exchange = exchange;
        if self.round_trips_s.len() == KEPT {
            self.round_trips_s.pop_front();
        }
        let away_us = back.saturating_sub(sent);
        self.round_trips_s.push_back(1e-6 * away_us.saturating_sub(answered.saturating_sub(there)) as f64);
        let before = self.round_trips_s.len().saturating_sub(STEP);
        let range = |from: usize, to: usize| {
            let some = self.round_trips_s.range(from..to);
            some.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], s| [least.min(*s), most.max(*s)])
        };
        let ([least, most], [newest_least, newest_most]) = (range(0, before), range(before, self.round_trips_s.len()));
        if newest_least > most + self.period_s || newest_most < least - self.period_s {
            self.round_trips_s.drain(..before);
        }
    }

    /// Least and largest round trip, s, as far as they count; none before there are enough.
    fn range_s(&self) -> Option<[f64; 2]> {
        let mut sorted: Vec<f64> = self.round_trips_s.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let (left_out, last) = (sorted.len().div_ceil(8), sorted.len().saturating_sub(1));
        (sorted.len() >= LEAST).then(|| [sorted[left_out], sorted[last - left_out]])
    }

    /// Keeps the motors of a peer off until the verdict lets them be armed, and while a person has `stopped` them; once they are armed, a verdict
    /// leaves them so. To be called before each tick, at `now_us` of the peer's clock, µs; what is to be said of the verdict, if that is new.
    pub fn heed<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized>(
        &mut self,
        now_us: u64,
        node: &mut Node<SHARED, N, D>,
        stopped: bool,
    ) -> Option<String> {
        let mode = node.peer.mode();
        let words = self.look(now_us, mode == Mode::Armed);
        let held = stopped || !self.lets_arm();
        if mode == Mode::Disarmed && node.is_halted() != held {
            node.halt(held);
        }
        words
    }

    /// Looks for an answer, and asks anew where the network has moved; what is to be said of it. `armed` is what the peer is.
    fn look(&mut self, now_us: u64, armed: bool) -> Option<String> {
        let answer = self.answers.try_recv().ok();
        self.waits &= answer.is_none();
        let due = !self.waits && self.asked.is_none_or(|(at_us, ..)| now_us >= at_us + AGAIN_US);
        if let Some(range_s) = self.range_s().filter(|_| due) {
            let ticks = range_s.map(|round_trip_s| (round_trip_s / self.period_s).ceil() as u64);
            let device_ticks = self.device.as_ref().map(|seen| seen.delay_ticks(self.period_s));
            // Of a device that has not been read there is nothing to ask.
            let known = device_ticks.is_none_or(|ticks| ticks.is_some());
            let device_ticks = device_ticks.flatten();
            let moved = self.asked.is_none_or(|(_, of, device)| (of, device) != (ticks, device_ticks));
            let measured = Measured { one_way_s: range_s.map(|round_trip_s| 0.5 * round_trip_s), device_ticks };
            if known && moved && self.asks.try_send(measured).is_ok() {
                (self.asked, self.waits) = (Some((now_us, ticks, device_ticks)), true);
            }
        }
        let verdict = answer?;
        let news = self.verdict.as_ref().is_none_or(|before| before.stable != verdict.stable);
        self.verdict = Some(verdict);
        let words = news.then(|| self.words(armed)).flatten()?;
        self.said.push((1e-6 * now_us as f64, words.clone()));
        Some(words)
    }

    /// The newest verdict in words, and what comes of it.
    fn words(&self, armed: bool) -> Option<String> {
        let Verdict { one_way_ms: [least, most], device_delay_ticks, stable, text, .. } = self.verdict.as_ref()?;
        let comes = match (stable, self.unless) {
            (Some(false), _) if armed => ". It stays armed",
            (Some(false), Some(unless)) => &format!(". It does not arm until the network is better; {unless}"),
            (Some(false), None) => ". It arms all the same",
            _ => "",
        };
        let late = device_delay_ticks.map_or_else(String::new, |ticks| {
            format!(", its device late by {ticks} tick{}", if ticks == 1 { "" } else { "s" })
        });
        Some(format!("the scene at {least:.2} to {most:.2} ms one way{late}: {text}{comes}"))
    }

    /// Why the peer is not to arm, if its scene is unstable.
    pub fn refuses(&self) -> Option<&Verdict> {
        self.verdict.as_ref().filter(|verdict| verdict.stable == Some(false) && self.unless.is_some())
    }

    /// Whether the peer may be armed.
    pub fn lets_arm(&self) -> bool {
        self.verdict.is_some() && self.refuses().is_none()
    }
}

/// The state of a peer. The motors are on in `alone` (both ends have not been live yet) and in `armed`. They are off in `calling`,
/// `waiting`, `refused` and `faulted`.
pub(crate) fn state<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized>(
    node: &Node<SHARED, N, D>,
    judging: Option<&Judging>,
) -> &'static str {
    match node.peer.mode() {
        Mode::Faulted(_) => "faulted",
        _ if node.gone().is_some() => "faulted",
        Mode::Armed if node.is_moving() => "armed",
        Mode::Armed => "alone",
        Mode::Disarmed if judging.is_some_and(|judging| judging.refuses().is_some()) => "refused",
        _ if node.line.link.is_up() => "waiting",
        _ => "calling",
    }
}

#[cfg(test)]
#[path = "../tests/inside/verdict.rs"]
mod tests;
