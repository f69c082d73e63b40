//! A server of a static world over UDP: one thread, one socket, no queue of its own.
//!
//! **Turnaround** is measured in two ways. `answer`: from the batch in hand that a datagram came in to the last answer to that batch
//! handed to the system.
//! `turnaround`: the same, and how long it may have waited in the socket's queue at the most. A queue is first in, first out,
//! so a datagram came after the queue was last known to be empty; where it is known when its client sent it
//! (`cohold shared world crowd`), that is taken instead.
//! Real-time priority is asked for and reported; the thread is not pinned (`taskset` does that).

use std::net::SocketAddr;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use cohold_live::endpoint::{Endpoint, Live, Stop, Ticker};
use cohold_live::quantiles::{Quantiles, Times};
use cohold_sim::engine::{Actor, Out};
use serde::Serialize;

use crate::Error;
use crate::world::PACKET_US;
use crate::world::host::{Counts, Host};

/// A socket that takes longer than this had nothing, and the datagram came right then, ns.
const WAITED_NS: u64 = 20_000;

/// What a server saw and did.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// What the endpoint's clock showed at the end, s.
    pub served_s: f64,
    /// Checksum of the world that was served last, 16 hexadecimal digits.
    pub world: String,
    /// Most clients with a session at once.
    pub clients: usize,
    /// Counts of what the server has done.
    pub counts: Counts,
    /// Who sent the last of those refused that tells something, and why it was refused.
    pub refused: Option<String>,
    /// From a batch of datagrams taken to its last answer sent.
    pub answer: Quantiles,
    /// From a datagram in the socket's queue, at the earliest it can have come, to its last answer sent.
    pub turnaround: Quantiles,
    /// Answers that the system did not take.
    pub unsent: u64,
    /// Share of one core that the thread used; `None` where the system does not tell.
    pub cpu_share: Option<f64>,
    /// Processor time for a datagram that came and one that went, user and system, µs; about as many go as come.
    pub us_per_pair: Option<f64>,
    /// Datagrams that came with one system call, mean.
    pub per_batch: f64,
    /// Whether the thread ran at a real-time priority.
    pub realtime_priority: bool,
}

/// What a thread computes from a time on.
#[derive(Clone, Copy, Debug)]
pub struct Computed {
    from_s: Option<f64>,
    at: Instant,
}

impl Computed {
    /// From now on, on this thread.
    pub fn now() -> Self {
        Self { from_s: Self::so_far_s(), at: Instant::now() }
    }

    fn so_far_s() -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?)
    }

    /// Processor time since then, user and system, s; `None` where the system does not tell.
    pub fn seconds(&self) -> Option<f64> {
        Some(Self::so_far_s()? - self.from_s?)
    }

    /// Share of one core since then; `None` where the system does not tell.
    pub fn share(&self) -> Option<f64> {
        Some(self.seconds()? / self.at.elapsed().as_secs_f64().max(1e-9))
    }
}

/// How long to serve, and what is measured from when on.
pub struct Options<F> {
    /// How long to serve if it is not stopped, s.
    pub duration_s: f64,
    /// Times before this are not in the quantiles, s.
    pub warm_up_s: f64,
    /// When the client on a line last sent, ns on the endpoint's clock, if that is known.
    pub sent_ns: F,
}

struct Serving<'a, F> {
    endpoint: &'a Endpoint,
    host: &'a mut Host<SocketAddr>,
    options: Options<F>,
    answer: Times,
    turnaround: Times,
    clients: usize,
    /// Since the warm-up was over.
    computed: Option<Computed>,
    /// Whose turn the next tick is.
    turn: u32,
    /// Batches taken.
    batches: u64,
    /// When each datagram of the batch in hand was sent at the earliest, ns.
    batch: Vec<u64>,
    /// When that batch was taken, ns.
    taken_ns: u64,
    /// When the socket was last asked for a datagram, ns.
    asked_ns: u64,
    /// When the queue was last known to be empty, ns.
    empty_ns: u64,
}

impl<F: Fn(u32) -> Option<u64>> Actor<SocketAddr> for Serving<'_, F> {
    type Packet = [u8];

    fn hear(&mut self, taken_ns: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        if self.batch.is_empty() {
            self.taken_ns = taken_ns;
            if taken_ns - self.asked_ns > WAITED_NS {
                self.empty_ns = taken_ns;
            }
        }
        let line = self.host.receive(taken_ns / 1_000, from, datagram, out);
        let sent_ns = line.and_then(&self.options.sent_ns).unwrap_or(self.empty_ns);
        self.batch.push(sent_ns.min(self.taken_ns));
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        self.host.tick_turn(now_ns / 1_000, self.turn, out);
        self.turn = (self.turn + 1) % Host::<SocketAddr>::TURNS;
        if let Some(news) = self.host.news(now_ns / 1_000) {
            cohold_io::say(format_args!("refused: {news}"));
        }
        self.clients = self.clients.max(self.host.clients());
        let now_s = 1e-9 * now_ns as f64;
        if self.computed.is_none() && now_s >= self.options.warm_up_s {
            self.computed = Some(Computed::now());
        }
        self.asked_ns = self.endpoint.now_ns();
    }
}

impl<F: Fn(u32) -> Option<u64>> Live for Serving<'_, F> {
    fn goodbye(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        self.host.goodbye(now_ns / 1_000, out);
    }

    fn sent(&mut self, now_ns: u64) {
        self.batches += u64::from(!self.batch.is_empty() && self.computed.is_some());
        for sent_ns in self.batch.drain(..).filter(|_| self.computed.is_some()) {
            self.answer.add(now_ns - self.taken_ns);
            self.turnaround.add(now_ns - sent_ns);
        }
        self.asked_ns = now_ns;
    }
}

/// Serves until the time is over, or it is stopped.
pub fn run(
    endpoint: &Endpoint,
    host: &mut Host<SocketAddr>,
    options: Options<impl Fn(u32) -> Option<u64>>,
    stop: &Stop,
) -> Result<Report, Error> {
    let turn_us = PACKET_US / u64::from(Host::<SocketAddr>::TURNS);
    let ticker = Ticker::realtime(Duration::from_micros(turn_us)).lasting(options.duration_s);
    let mut serving = Serving {
        endpoint,
        host,
        options,
        answer: Times::default(),
        turnaround: Times::default(),
        clients: 0,
        computed: None,
        turn: 0,
        batches: 0,
        batch: Vec::new(),
        taken_ns: 0,
        asked_ns: 0,
        empty_ns: 0,
    };
    let kept = endpoint.run(ticker, f64::MAX, stop, &mut serving)?;
    let answer = serving.answer.quantiles();
    let heard = answer.samples;
    Ok(Report {
        served_s: 1e-9 * endpoint.now_ns() as f64,
        world: format!("{:016x}", serving.host.server.world()),
        clients: serving.clients,
        counts: serving.host.counts,
        refused: serving.host.refused(),
        answer,
        turnaround: serving.turnaround.quantiles(),
        unsent: endpoint.unsent.load(Ordering::Relaxed),
        cpu_share: serving.computed.and_then(|computed| computed.share()),
        per_batch: heard as f64 / serving.batches.max(1) as f64,
        us_per_pair: serving.computed.and_then(|computed| Some(1e6 * computed.seconds()? / heard.max(1) as f64)),
        realtime_priority: kept.realtime_priority,
    })
}
