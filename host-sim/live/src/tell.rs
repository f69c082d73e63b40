//! What a live command says while it runs: a line each second, and what happens in between, on a thread of its own, so that a terminal
//! that does not take them holds up nobody.
//!
//! Somebody on the network who drops or delays datagrams causes notices and changes of path. A person is shown one of these lines each
//! second, 20 at once, and how many were left out; a program that reads JSON gets all that fit in the queue.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

use crate::allowance::Allowance;
use crate::road::{PathReport, Way};
use cohold_protocol::link::Notice;
use serde::Serialize;
use serde_json::json;

use crate::recording::mcap::INFO;
use crate::recording::recorder::Recorder;

/// Lines that may wait.
const WAITING: usize = 64;

/// Lines about the network that a person is shown each second, and at once.
const SHOWN: [f64; 2] = [1.0, 20.0];

/// How lines are said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Manner {
    /// In words, on standard error.
    #[default]
    Words,
    /// The same without the line of each second.
    Events,
    /// As one JSON object each, on standard output.
    Json,
    /// Nothing at all is printed.
    Quiet,
}

/// Which path a line takes, and what it is like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PathSecond {
    /// Relayed, direct, or both.
    pub way: Way,
    /// The direct path stays within a local network.
    pub lan: bool,
    /// Median round trip of that path, ms.
    pub round_trip_ms: f64,
    /// Round trip that 99 % do not exceed, ms.
    pub p99_ms: f64,
    /// Share of the carriers' own signals that were lost on it.
    pub lost: f64,
}

impl PathSecond {
    /// From what a carrier reports.
    pub fn of(report: &PathReport) -> Self {
        let of = if matches!(report.way, Way::Direct | Way::Both) { report.direct } else { report.relayed };
        let (round_trip_ms, p99_ms, lost) = (of.round_trip_ms, of.p99_ms, of.lost);
        Self { way: report.way, lan: report.lan, round_trip_ms, p99_ms, lost }
    }

    /// In words.
    pub fn words(&self) -> String {
        let near = if self.lan { "LAN" } else { "direct" };
        let way = match self.way {
            Way::Nowhere => return "no path".to_owned(),
            Way::Relayed => "relayed".to_owned(),
            Way::Both => format!("{near}, relay beside it"),
            Way::Direct => near.to_owned(),
        };
        if self.round_trip_ms == 0.0 {
            return way;
        }
        let (round, p99, lost) = (self.round_trip_ms, self.p99_ms, 1e2 * self.lost);
        format!("{way} {round:.1} ms (99 %: {p99:.1}), {lost:.1} % lost")
    }
}

/// A second of a live end.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Second {
    /// Time since the start, s.
    pub time_s: f64,
    /// Of an experiment whose length is known, what is over, s, and its length, s.
    pub done_s: f64,
    /// Length of the whole experiment, s; 0 of one that goes on until it is stopped.
    pub of_s: f64,
    /// `calling`, `waiting`, `refused`, `alone`, `armed`, `faulted`. The motors are on in `alone` and `armed`.
    pub state: &'static str,
    /// Who is at the other end.
    pub partner: String,
    /// Smoothed round trip of the link, µs; of a hub that of its slowest line.
    pub round_trip_us: Option<u32>,
    /// Root of the mean square distance of the copies in this second, mm.
    pub rms_true_discrepancy_mm: Option<f64>,
    /// Largest distance of the copies in this second, mm.
    pub largest_true_discrepancy_mm: Option<f64>,
    /// Largest error of a distance of the copies that the clocks may cause, mm.
    pub true_discrepancy_error_mm: Option<f64>,
    /// Half of the smallest round trip, and what chance adds.
    pub clock_error_us: Option<f64>,
    /// Share of the second in which the line lived.
    pub live_share: Option<f64>,
    /// Whether the scene is stable at the delays that are measured, as far as that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stable: Option<bool>,
    /// Which path it takes, where it is not a plain address.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathSecond>,
    /// What stopped this end, if anything did.
    pub fault: Option<String>,
}

impl Second {
    /// In words.
    pub fn words(&self) -> String {
        let Self { done_s, of_s, state, partner, .. } = self;
        // A bar of ten.
        let full = (10.0 * done_s / of_s).clamp(0.0, 10.0) as usize;
        let bar = format!("{}{}", "#".repeat(full), ".".repeat(10 - full));
        let mut words = format!("[{bar}] {done_s:.0}/{of_s:.0} s  {state}, {partner}");
        if let Some(us) = self.round_trip_us {
            words += &format!("  round trip {:.2} ms", f64::from(us) * 1e-3);
        }
        let clock = self.true_discrepancy_error_mm.unwrap_or_default();
        if let (Some(rms), Some(largest)) = (self.rms_true_discrepancy_mm, self.largest_true_discrepancy_mm) {
            words += &format!("  true discrepancy {rms:.3} mm rms, {largest:.3} at most (clocks ±{clock:.3})");
        }
        if let Some(share) = self.live_share {
            words += &format!("  live {:.0} %", 1e2 * share);
        }
        if self.stable == Some(false) {
            words += "  unstable";
        }
        if let Some(path) = &self.path {
            words += &format!("  {}", path.words());
        }
        match &self.fault {
            Some(fault) => words + "  " + fault,
            None => words,
        }
    }
}

/// A notice of a link, as reports and lines have it.
#[derive(Clone, Debug, Serialize)]
pub struct Noticed {
    /// Since the start, s.
    pub time_s: f64,
    /// Its name.
    pub notice: String,
    /// What it means.
    pub words: String,
}

impl Noticed {
    /// Of one link, with their times, µs.
    pub fn all<'a>(notices: impl IntoIterator<Item = &'a (u64, Notice)>) -> Vec<Self> {
        notices.into_iter().map(|(at_us, notice)| Self::new(*at_us, "", notice)).collect()
    }

    /// At this time, µs. `whose` is empty if there is one link only.
    pub fn new(time_us: u64, whose: &str, notice: &Notice) -> Self {
        let mut name = format!("{whose}{notice:?}");
        name.truncate(name.find('(').unwrap_or(name.len()));
        Self { time_s: time_us as f64 / 1e6, notice: name, words: format!("{whose}{}", words(notice)) }
    }
}

fn words(notice: &Notice) -> String {
    match notice {
        Notice::Joined => "the other end is there and holds the key: a session has begun".to_owned(),
        Notice::NewPeer(0) => "the other end is here for the first time, or has started anew".to_owned(),
        Notice::NewPeer(dropped) => {
            format!("the other end has started anew: {dropped} events that it had not taken are dropped")
        }
        Notice::Engaged => "flow comes: the coordination begins from rest".to_owned(),
        Notice::Fading => "no flow for 3 packet periods: a law that fades begins to release".to_owned(),
        Notice::Resumed => "flow comes again: the coordination takes hold from where it was".to_owned(),
        Notice::Disengaged => {
            "the coordination has let go: nothing came for too long, or the session has ended".to_owned()
        }
        Notice::Lost => "the session has ended: the other end said goodbye, fell silent or started anew".to_owned(),
        Notice::Old(us) => {
            format!(
                "flow comes too late and is not taken: {:.0} ms one way (safety.max_delay_s)",
                f64::from(*us) * 1e-3
            )
        }
        Notice::Refused(table) => {
            format!("the other end was told other parameters: table [{table}] of the scene differs")
        }
    }
}

/// A line that waits, as JSON has it.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Line {
    Second(Box<Second>),
    Notice(Noticed),
    Path { time_s: f64, path: PathSecond, words: String },
    Words { words: String },
}

/// Says lines until it is dropped; the default one says none.
#[derive(Debug, Default)]
pub struct Teller {
    queue: Option<SyncSender<Line>>,
    thread: Option<JoinHandle<()>>,
    /// The recording in whose log all that happens is said, too.
    pub log: Option<Arc<Recorder>>,
}

impl Teller {
    /// Starts a thread that says lines in this manner; a quiet teller has none.
    pub fn new(manner: Manner) -> Self {
        if manner == Manner::Quiet {
            return Self::default();
        }
        let (queue, lines) = sync_channel(WAITING);
        let thread = std::thread::Builder::new().name("teller".to_owned()).spawn(move || say(&lines, manner)).ok();
        Self { queue: Some(queue), thread, log: None }
    }

    /// Records what happened, now if nobody knows when.
    fn record(&self, time_us: Option<u64>, words: &str) {
        if let Some(log) = &self.log {
            let time_ns = time_us.map_or_else(|| log.now_ns(), |us| 1_000 * us);
            log.log(time_ns, INFO, words);
        }
    }

    /// Where there is no room, a line is not said: there will be others.
    fn put(&self, line: Line) {
        let _ = self.queue.as_ref().map(|queue| queue.try_send(line));
    }

    /// Says the line of a second; where too many lines wait already, it is dropped.
    pub fn second(&self, second: Second) {
        self.put(Line::Second(Box::new(second)));
    }

    /// Something has happened to a link; `whose` is empty where there is one only.
    pub fn notice(&self, time_us: u64, whose: &str, notice: &Notice) {
        let noticed = Noticed::new(time_us, whose, notice);
        self.record(Some(time_us), &noticed.words);
        self.put(Line::Notice(noticed));
    }

    /// Flow goes another way.
    pub fn path(&self, time_us: u64, path: &PathSecond) {
        let words = format!("the path is now: {}", path.words());
        self.record(Some(time_us), &words);
        self.put(Line::Path { time_s: time_us as f64 * 1e-6, path: *path, words });
    }

    /// What there is no notice for.
    pub fn words(&self, words: String) {
        self.record(None, &words);
        self.put(Line::Words { words });
    }
}

impl Drop for Teller {
    fn drop(&mut self) {
        self.queue = None;
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Shows a person so many lines about the network, and counts the others.
struct Limiter(Allowance, u64);

impl Limiter {
    fn new(now: Instant) -> Self {
        Self(Allowance::new(SHOWN[1], now), 0)
    }

    /// The line as it is shown, if it is.
    fn shown(&mut self, now: Instant, line: String) -> Option<String> {
        if !self.0.takes(now, 1.0, SHOWN) {
            self.1 += 1;
            return None;
        }
        let left_out = std::mem::take(&mut self.1);
        Some(if left_out == 0 { line } else { format!("{line} ({left_out} lines before it are left out)") })
    }
}

fn say(lines: &Receiver<Line>, manner: Manner) {
    let mut limiter = Limiter::new(Instant::now());
    for line in lines {
        if manner != Manner::Json {
            let (about_the_network, words) = match line {
                Line::Second(_) if manner == Manner::Events => continue,
                Line::Second(second) => (false, second.words()),
                Line::Words { words } => (false, words),
                Line::Notice(Noticed { words, .. }) | Line::Path { words, .. } => (true, words),
            };
            let shown = if about_the_network { limiter.shown(Instant::now(), words) } else { Some(words) };
            shown.into_iter().for_each(cohold_io::say);
            continue;
        }
        // Whoever does not read on is sent nothing more; the run goes on.
        if cohold_io::out(format_args!("{}\n", json!(line))).is_err() {
            return;
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/tell.rs"]
mod tests;
