//! 1 kHz by the clock, on the calling thread, at a real-time priority where the system gives one.
//!
//! **Deadline**: each tick is done within its millisecond. One that begins more than a millisecond late is counted, the
//! next come quicker until they are in time again, so that none is left out; more than [`SLEPT`] behind, the machine
//! slept, and the control loop begins anew from now. What is late here is no fault of the peers: they are not told
//! (`Sensors::overrun`), for a desktop would disarm them every minute.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cohold_core::names::Choice as _;
use cohold_live::endpoint::{Punctuality, Stop, Ticker};
use cohold_live::recording::mcap::Channel;
use cohold_live::recording::recorder::Recorder;
use serde::Serialize;

use super::environment::{Column, Command, Environment, LineReport, MODES, Opening, Sample, mode_and_fault};
use super::kinds::{EnvironmentKind, Kinds};
use super::mailbox::{Contents, Mailbox, Request, Status};
use super::opened::in_unit;
use super::partner::Model;
use super::session::PERIOD_S;
use cohold_cli::Failure;

/// A tick this late is not caught up.
const SLEPT: Duration = Duration::from_millis(500);

/// How well the control loop kept time.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Kept {
    /// Number of ticks that were kept.
    pub(crate) ticks: u64,
    /// Ticks that began more than a period late.
    pub(crate) late: u64,
    /// Latest that a tick began, µs.
    pub(crate) worst_us: u64,
    /// How often the machine slept.
    pub(crate) slept: u64,
    /// The thread runs at a real-time priority.
    pub(crate) realtime_priority: bool,
    /// What there was to see of a line to another process.
    #[serde(flatten)]
    pub(crate) line: Option<LineReport>,
}

/// Where what is shown is recorded.
pub(super) struct Recording {
    pub(super) recorder: Arc<Recorder>,
    /// When its clock began.
    pub(super) start: Instant,
    /// Channels of it that come before those of the samples.
    pub(super) others: u16,
}

/// Runs the control loop until it is stopped, or so many seconds are over.
pub(super) fn run(
    mailbox: &Mailbox,
    kind: EnvironmentKind,
    open: Opening,
    seconds: f64,
    record: Option<&Recording>,
    stop: &Stop,
) -> Result<Kept, Failure> {
    let mut shown = Shown { environment: open()?, kind };
    if let Some(record) = record {
        shown.environment.record(Arc::clone(&record.recorder));
    }
    let mut ticker = Ticker::realtime(Duration::from_secs_f64(PERIOD_S)).lasting(seconds);
    let (mut slept, mut waiting, mut said) = (0, VecDeque::new(), [[0.0; 2]; 2]);
    while !stop.is_asked() && !ticker.is_over() {
        let late = ticker.wait();
        if late > SLEPT {
            slept += 1;
            ticker.postpone(late);
        }
        if let Some(mut contents) = mailbox.try_lock() {
            exchange(&mut shown, &mut contents, &mut waiting, &ticker.kept)?;
        }
        if shown.environment.stands() {
            continue;
        }
        let sample = shown.environment.step()?;
        if let Some(Recording { recorder, start, others }) = record {
            let at = start.elapsed();
            let modes = shown.environment.standing().modes.map(mode_and_fault);
            // A peer that is recorded as one says it itself.
            let says = modes.into_iter().enumerate().filter(|_| *others == 0);
            for (index, now) in says {
                recorder.log_mode(at.as_nanos() as u64, ["peer 1", "peer 2"][index], &mut said[index], now);
            }
            let sample = &sample[..shown.kind.columns().len()];
            let mut row = vec![at.as_secs_f64()];
            row.extend(sample.iter().map(|number| f64::from(*number)));
            row.extend(modes.concat());
            recorder.put(others + u16::from(shown.kind.number()), at.as_nanos() as u64, &row);
        }
        waiting.push_back(sample);
    }
    let Punctuality { ticks, missed: late, worst_us, realtime_priority, .. } = ticker.kept;
    Ok(Kept { ticks, late, worst_us, slept, realtime_priority, line: shown.environment.line() })
}

/// What a recording holds: of every environment that a page can show the time, and every sample while it is shown.
pub(crate) fn channels(kinds: Kinds, topic: &str) -> Vec<Channel> {
    let named = |(name, unit, meaning): &Column| (in_unit(name, unit), (*meaning).to_owned());
    let (place, _) = topic.rsplit_once('/').unwrap_or_default();
    let channel = |kind: EnvironmentKind| {
        let time = ("time_s".to_owned(), "since the recording's clock began".to_owned());
        let fields = std::iter::once(time).chain(kind.columns().iter().chain(&MODES).map(named));
        match kind {
            // What a page shows where nobody says has the recording's own topic.
            EnvironmentKind::Pair => Channel::new(topic, "Tick", fields),
            kind => {
                let name = kind.name();
                // A dash is in no name of a schema.
                Channel::new(format!("{place}/{name}"), &format!("Tick_{}", name.replace('-', "_")), fields)
            }
        }
    };
    kinds.all().map(channel).collect()
}

/// The environment that is stepped, and its kind.
pub(super) struct Shown {
    pub(super) environment: Box<dyn Environment>,
    pub(super) kind: EnvironmentKind,
}

/// Takes what lies in the mailbox, and puts in what is waited for.
pub(super) fn exchange(
    shown: &mut Shown,
    contents: &mut Contents,
    waiting: &mut VecDeque<Sample>,
    kept: &Punctuality,
) -> Result<(), Failure> {
    let (show, set) = match contents.take_wanted() {
        // An object that is shared along other axes is another one.
        Some(Request::Scene(scene)) if shown.kind.in_scene(&scene) != shown.kind => {
            (Some((shown.kind.in_scene(&scene), scene)), None)
        }
        Some(Request::Scene(scene)) => (None, Some(scene)),
        Some(Request::Show(kind, scene)) => (Some((kind, scene)), None),
        None => (None, None),
    };
    if let Some((kind, scene)) = show {
        let partner = shown.environment.standing().partner;
        *shown = Shown { environment: kind.open(&scene)?, kind };
        if let Some(model) = Model::ALL.get(usize::from(partner)) {
            shown.environment.command(Command::Partner(*model))?;
        }
        waiting.clear();
        contents.clear();
    }
    let Shown { environment: shown, kind } = shown;
    while let Some(command) = contents.next_command() {
        shown.command(command)?;
    }
    if let Some(scene) = set {
        shown.set(*scene)?;
    }
    if std::mem::take(&mut contents.operator_asked) {
        shown.attend();
    }
    let anybody = contents.holder.iter().any(Option::is_some);
    for index in 0..2 {
        if contents.holder[index].is_some() {
            if let Some(pointed) = contents.pointed[index].take() {
                shown.point(index, pointed.at.map(|at| at.map(f64::from)), pointed.restarts);
            }
        } else if anybody {
            shown.play(index);
        } else {
            // Nobody looks: nobody plays.
            shown.point(index, None, 0);
        }
    }
    if let Some(news) = shown.news() {
        contents.tell_news(news);
    }
    waiting.drain(..).for_each(|sample| contents.put(sample));
    contents.status = Status {
        late: u32::try_from(kept.missed).unwrap_or(u32::MAX),
        worst_us: u32::try_from(kept.worst_us).unwrap_or(u32::MAX),
        standing: shown.standing(),
        kind: *kind,
    };
    Ok(())
}
