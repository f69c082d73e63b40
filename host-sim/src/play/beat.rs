//! 1 kHz by the clock, on the calling thread, at a real-time priority where the system gives one.
//!
//! **Deadline**: each tick is done within its millisecond. One that begins more than a millisecond late is counted, the next come
//! quicker until they are in time again, so that none is left out; more than [`SLEPT`] behind, the machine slept, and the beat
//! begins anew from now. What is late here is no fault of the peers: they are not told (`Sensors::overrun`), for a desktop would
//! disarm them every minute.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::desk::{Desk, Papers, Status};
use super::environment::{Environment, Opening, Sample};
use super::session::{COLUMNS, PERIOD_S};
use crate::live::endpoint::{Punctuality, Stop, Ticker};
use crate::recording::mcap::Channel;
use crate::recording::recorder::Recorder;

/// A tick this late is not caught up.
const SLEPT: Duration = Duration::from_millis(500);

/// How well the beat was kept.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Kept {
    /// Ticks.
    pub(crate) ticks: u64,
    /// Ticks that began more than a period late.
    pub(crate) late: u64,
    /// Latest that a tick began, µs.
    pub(crate) worst_us: u64,
    /// How often the machine slept.
    pub(crate) slept: u64,
    /// The thread runs at a real-time priority.
    pub(crate) realtime_priority: bool,
}

/// Keeps the beat until it is stopped, or so many seconds are over.
pub(super) fn run(
    desk: &Desk,
    open: Opening,
    seconds: f64,
    recorder: Option<&Recorder>,
    stop: &Stop,
) -> Result<Kept, String> {
    let mut shown = open()?;
    let mut ticker = Ticker::realtime(Duration::from_secs_f64(PERIOD_S)).lasting(seconds);
    let (mut slept, mut waiting, begun) = (0, VecDeque::new(), Instant::now());
    while !stop.is_asked() && !ticker.is_over() {
        let late = ticker.wait();
        if late > SLEPT {
            slept += 1;
            ticker.postpone(late);
        }
        if let Some(mut papers) = desk.try_lock() {
            exchange(&mut *shown, &mut papers, &mut waiting, &ticker.kept)?;
        }
        let sample = shown.step()?;
        if let Some(recorder) = recorder {
            recorder.put(0, begun.elapsed().as_nanos() as u64, &recorded(begun.elapsed().as_secs_f64(), &sample));
        }
        waiting.push_back(sample);
    }
    let Punctuality { ticks, missed: late, worst_us, realtime_priority, .. } = ticker.kept;
    Ok(Kept { ticks, late, worst_us, slept, realtime_priority })
}

/// What a recording holds: the time, and every sample.
pub(super) fn channel(topic: &str) -> Channel {
    let named = |(name, unit, meaning): (&str, &str, &str)| {
        let name = if unit.is_empty() { name.to_owned() } else { format!("{name}_{}", unit.to_lowercase()) };
        (name, meaning.to_owned())
    };
    let time = ("time_s".to_owned(), "since the beat began".to_owned());
    Channel::new(topic, "Tick", std::iter::once(time).chain(COLUMNS.map(named)))
}

fn recorded(time_s: f64, sample: &Sample) -> [f64; 1 + COLUMNS.len()] {
    std::array::from_fn(|at| at.checked_sub(1).map_or(time_s, |at| sample[at].into()))
}

/// Takes what lies on the desk, and lays down what it is waited for.
fn exchange(
    shown: &mut dyn Environment,
    papers: &mut Papers,
    waiting: &mut VecDeque<Sample>,
    kept: &Punctuality,
) -> Result<(), String> {
    while let Some(command) = papers.next_command() {
        shown.command(command)?;
    }
    if let Some(scene) = papers.scene.take() {
        shown.set(*scene)?;
    }
    let anybody = papers.holder.iter().any(Option::is_some);
    for index in 0..2 {
        if papers.holder[index].is_some() {
            if let Some(pointed) = papers.pointed[index].take() {
                shown.point(index, pointed.at.map(|at| at.map(f64::from)), pointed.restarts);
            }
        } else if anybody {
            shown.play(index);
        } else {
            // Nobody looks: nobody plays.
            shown.point(index, None, 0);
        }
    }
    waiting.drain(..).for_each(|sample| papers.put(sample));
    papers.status = Status {
        late: u32::try_from(kept.missed).unwrap_or(u32::MAX),
        worst_us: u32::try_from(kept.worst_us).unwrap_or(u32::MAX),
        standing: shown.standing(),
    };
    Ok(())
}
