//! A steady beat from the operating system.
//!
//! Each beat has an absolute deadline, so that errors do not add up. A beat that begins more than one period late is a miss;
//! none is skipped, the loop catches up. The thread asks for a real-time priority and says whether it got one.

use std::time::{Duration, Instant};

use serde::Serialize;

/// How well the beat was kept.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Punctuality {
    /// Beats.
    pub beats: u64,
    /// Beats that began more than a period late.
    pub missed: u64,
    /// Latest a beat began, µs.
    pub worst_us: u64,
    /// Sum of all lateness, µs.
    #[serde(skip)]
    total_us: u64,
    /// The thread runs at a real-time priority.
    pub realtime_priority: bool,
}

impl Punctuality {
    /// Mean lateness, µs.
    pub fn mean_us(&self) -> f64 {
        self.total_us as f64 / self.beats.max(1) as f64
    }
}

/// Asks for a real-time priority for this thread, and says whether it got one.
pub(crate) fn realtime() -> bool {
    let priority = thread_priority::ThreadPriority::Crossplatform(50.try_into().unwrap_or_default());
    thread_priority::set_thread_priority_and_policy(
        thread_priority::thread_native_id(),
        priority,
        thread_priority::ThreadSchedulePolicy::Realtime(thread_priority::RealtimeThreadSchedulePolicy::Fifo),
    )
    .is_ok()
}

/// A beat.
#[derive(Debug)]
pub struct Pace {
    start: Instant,
    period: Duration,
    kept: Punctuality,
}

impl Pace {
    /// A beat of `period` that begins now, on this thread.
    pub fn new(period: Duration) -> Self {
        let kept = Punctuality { realtime_priority: realtime(), ..Punctuality::default() };
        Self { start: Instant::now(), period, kept }
    }

    /// Time since the beat began, µs.
    pub fn now_us(&self) -> u64 {
        self.start.elapsed().as_micros() as u64
    }

    /// Sleeps until the next beat.
    pub fn wait(&mut self) {
        let deadline = self.start + self.period.saturating_mul(u32::try_from(self.kept.beats).unwrap_or(u32::MAX));
        let now = Instant::now();
        if deadline > now {
            std::thread::sleep(deadline - now);
        }
        let late = Instant::now().saturating_duration_since(deadline);
        let late_us = late.as_micros() as u64;
        self.kept.beats += 1;
        self.kept.missed += u64::from(late > self.period);
        self.kept.worst_us = self.kept.worst_us.max(late_us);
        self.kept.total_us += late_us;
    }

    /// How well it was kept so far.
    pub fn punctuality(&self) -> Punctuality {
        self.kept
    }
}
