//! What is recorded of one peer: its ticks, its questions to the other end's clock, and what a second came to.

use cohold_core::num::Scalar;
use cohold_core::peer::Observed;
use cohold_core::sample::{OfAxis, OfPeer, Quantities, SAMPLE};

use crate::road::PathReport;
use cohold_board_tools::operator::Session;
use cohold_protocol::{link::Link, wire::Sample};
use cohold_sim::quantities::{self, Named};
use cohold_sim::run::AXIS_NAMES;

use super::common_clock::{Exchange, Relation, Watched};
use super::mcap::{Channel, INFO, TIME};
use super::recorder::Recorder;

/// Columns of a tick.
pub const TICK: [Named; 2 + SAMPLE.columns()] = tick_columns(&SAMPLE);

/// The same of another list of quantities.
pub const fn tick_columns<const N: usize>(quantities: &Quantities) -> [Named; N] {
    let live = ("live", "1 while what is heard is fresh, or the line lives; 0 while it stands");
    quantities::around(quantities, [&[TIME], &[], &[live]])
}

/// Columns of an exchange: times of a probe and its answer.
pub const EXCHANGE: [Named; 5] = [
    ("sent_s", "t1: the probe left here"),
    ("there_s", "t2: it came there, by the other clock"),
    ("answered_s", "t3: its answer left there, by the other clock"),
    ("back_s", "t4: the answer came here"),
    ("session", "number of the sealed session, which only its two ends have"),
];

/// Columns of a second.
pub const SECOND: [Named; 12] = [
    TIME,
    ("clock_offset_s", "the other end's clock less this one"),
    (
        "clock_error_s",
        "by how much the offset may be wrong: half of the smallest round trip, and twice the standard error",
    ),
    ("clock_drift_ppm", "how much faster the other clock runs"),
    ("clock_drift_error_ppm", "by how much the drift may be wrong"),
    ("smallest_round_trip_s", "smallest round trip of the last minute"),
    ("true_discrepancy_m", "root of the mean square of |x_o1 - x_o2| in this second, as far as telemetry came"),
    ("largest_true_discrepancy_m", "largest distance of the two copies at one instant of this second"),
    ("true_discrepancy_error_m", "the largest that the clock's error makes of it: speed of the copy times that"),
    ("live_share", "share of the second in which the line lived"),
    ("missing", "datagrams of the other end that never came, since the start"),
    (
        "stable",
        "1 where the scene is stable at the delays that are measured, 0 where not; empty where that is not known",
    ),
];

/// Columns of a change of path, and of a second of a carried line.
pub const PATH: [Named; 10] = [
    TIME,
    ("way", "0 no path; 1 relayed; 2 from end to end, the relay beside it; 3 from end to end"),
    ("lan", "1 where the path from end to end stays within a local network"),
    ("relayed_round_trip_s", "median round trip by the meeting place, since the start"),
    ("relayed_p99_s", "round trip by the meeting place that 99 % do not exceed"),
    ("relayed_lost", "share of the carriers' signals that were lost there"),
    ("direct_round_trip_s", "median round trip from end to end, since the start"),
    ("direct_p99_s", "round trip from end to end that 99 % do not exceed"),
    ("direct_lost", "share of the carriers' signals that were lost there"),
    ("copies", "datagrams that both paths brought, since the start: the second of each"),
];

/// The channel of a peer's paths: a row for each change of way, and one each second.
pub fn path_channel(of: &str) -> Channel {
    Channel::new(format!("/{of}/paths"), "Path", PATH)
}

/// A row of [`PATH`].
pub fn path(time_ns: u64, report: &PathReport) -> [f64; PATH.len()] {
    let of = [report.relayed, report.direct].map(|path| {
        let figures = [1e-3 * path.round_trip_ms, 1e-3 * path.p99_ms, path.lost];
        if path.signals > 0 { figures } else { [f64::NAN; 3] }
    });
    let [[relayed, relayed_p99, relayed_lost], [direct, direct_p99, direct_lost]] = of;
    let (time_s, way, lan) = (time_ns as f64 * 1e-9, report.way.number().into(), u8::from(report.lan).into());
    let copies = report.copies as f64;
    [time_s, way, lan, relayed, relayed_p99, relayed_lost, direct, direct_p99, direct_lost, copies]
}

/// Columns of a hub's second.
const HUB_SECOND: [Named; 6] = [
    TIME,
    ("lines_up", "lines with a session"),
    (
        "true_discrepancy_m",
        "root of the mean square in this second of the largest distance of two copies, from telemetry",
    ),
    ("largest_true_discrepancy_m", "largest distance of two copies at one instant of this second"),
    ("true_discrepancy_error_m", "the largest that clocks and the time between two tellings make of it"),
    ("clock_error_s", "by how much the clock may be wrong of the line whose clock is known least"),
];

/// The channels of a peer that shares so many axes, in this order: ticks, exchanges, seconds; ticks of each further axis.
pub fn channels(of: &str, axes: usize) -> Vec<Channel> {
    let mut channels = vec![
        Channel::new(format!("/{of}/ticks"), "Tick", TICK),
        Channel::new(format!("/{of}/exchanges"), "Exchange", EXCHANGE),
        Channel::new(format!("/{of}/seconds"), "Second", SECOND),
    ];
    channels.extend((1..axes).map(|axis| Channel::new(format!("/{of}/{}", name_of(axis)), "Tick", TICK)));
    channels
}

/// What ticks of a shared axis are called, from axis 0.
pub fn name_of(axis: usize) -> String {
    if axis == 0 { "ticks".to_owned() } else { format!("ticks-{}", AXIS_NAMES[axis]) }
}

/// The channel of a shared axis' ticks, from axis 0: [`TICKS`], or one after `last`, the last of the channels that are there anyway.
pub fn of_axis(axis: usize, last: u16) -> u16 {
    // There are three axes at most.
    if axis == 0 { TICKS } else { last + axis as u16 }
}

/// Index of the ticks in [`channels`].
pub const TICKS: u16 = 0;
/// Index of the clock exchanges in [`channels`].
pub const EXCHANGES: u16 = 1;
/// Index of the seconds in [`channels`].
pub const SECONDS: u16 = 2;

/// Index of the paths of a peer that shares so many axes: they follow [`channels`].
pub fn paths(axes: usize) -> u16 {
    SECONDS + axes as u16
}

/// The channels of a board that shares so many axes, as its operator records them: [`TICKS`] as the board tells them, with when each
/// was sealed, and [`EXCHANGES`]; ticks of each further axis; PWM periods before a fault.
pub fn board_channels(number: u8, axes: usize) -> Vec<Channel> {
    let sealed = || ("sealed_s".to_owned(), "when the record was sealed, by the board's clock");
    let ticks = |axis: usize| {
        let columns = cohold_board_tools::recording::columns(axis, axes).chain([sealed()]);
        Channel::new(format!("/board_{number}/{}", name_of(axis)), "Tick", columns)
    };
    let exchanges = Channel::new(format!("/board_{number}/exchanges"), "Exchange", EXCHANGE);
    let mut channels = vec![ticks(0), exchanges];
    channels.extend((1..axes).map(ticks));
    channels.push(Channel::new(format!("/board_{number}/periods"), "Period", cohold_board_tools::recording::PERIOD));
    channels
}

/// The channels of a hub with so many lines of an object that is shared along so many axes, in the order of [`channels`].
pub fn hub_channels(lines: usize, axes: usize) -> Vec<Channel> {
    let own = [TIME, TICK[quantities::place(&TICK, "tick")], ("object_m", "where the lines meet")];
    let own = own.map(|(name, meaning)| (name.to_owned(), meaning.to_owned()));
    let of_line = |line: usize| {
        let described =
            [("force_n", "force at the hub's end"), ("taken_j", "energy taken out"), ("sent_j", "energy sent into it")];
        described.map(|(name, meaning)| (format!("line_{line}_{name}"), format!("line {line}: {meaning}")))
    };
    let ticks = |axis: usize| {
        let columns = own.iter().cloned().chain((1..=lines).flat_map(of_line));
        Channel::new(format!("/hub/{}", name_of(axis)), "Tick", columns)
    };
    let line = ("line", "which line, from 1");
    let exchanges = Channel::new("/hub/exchanges", "Exchange", EXCHANGE.into_iter().chain([line]));
    let mut channels = vec![ticks(0), exchanges, Channel::new("/hub/seconds", "Second", HUB_SECOND)];
    channels.extend((1..axes).map(ticks));
    channels
}

/// A board while it is recorded: what has come over its operator's link becomes rows.
#[derive(Debug)]
pub struct BoardTicks {
    period_s: f64,
    axes: usize,
    clock: Watched,
    /// Number of ticks that came.
    pub ticks: u64,
    /// Mode and fault that the log has said last.
    mode: [f64; 2],
}

impl BoardTicks {
    /// A board with this control period, s, that shares so many axes.
    pub fn new(period_s: f64, axes: usize) -> Self {
        Self { period_s, axes, clock: Watched::default(), ticks: 0, mode: [0.0; 2] }
    }

    /// Records what came in a session since the last time: samples, lines of the board's log, and changes of its mode; whether a sample did.
    pub fn record(&mut self, recorder: &Recorder, now_ns: u64, session: &mut Session) -> bool {
        let samples = session.take_stamped();
        while let Some((at_us, words)) = session.logged() {
            recorder.log(1000 * at_us, INFO, words);
        }
        let place = |name| quantities::place(&cohold_board_tools::recording::COLUMNS, name);
        let (places, mut mode) = (["mode", "fault"].map(place), self.mode);
        self.take(session.link(), &samples, |channel, row| {
            recorder.put(channel, now_ns, row);
            if channel == TICKS {
                recorder.log_mode(now_ns, &recorder.who, &mut mode, places.map(|at| row[at]));
            }
        });
        self.mode = mode;
        !samples.is_empty()
    }

    /// Takes samples that came over a link, each with when it was sealed, µs of the board's clock; `put` gets rows of
    /// [`board_channels`].
    pub fn take(&mut self, link: &Link, samples: &[(u64, Sample)], mut put: impl FnMut(u16, &[f64])) {
        for (sealed_us, sample) in samples {
            // Their channel is behind those of all axes.
            cohold_board_tools::recording::periods(sample).for_each(|row| put(of_axis(self.axes, EXCHANGES), &row));
            let row = cohold_board_tools::recording::row(sample.payload(), self.period_s);
            if let Some((axis, row)) = row.filter(|(axis, _)| *axis < self.axes) {
                self.ticks += u64::from(axis == 0);
                put(of_axis(axis, EXCHANGES), &[&row[..], &[1e-6 * *sealed_us as f64]].concat());
            }
        }
        if let Some(one) = self.clock.see(link.clock().newest()) {
            put(EXCHANGES, &exchange(&one, link.session_number()));
        }
    }
}

/// A row of [`TICK`].
pub fn tick<S: Scalar>(
    time_ns: u64,
    peer: OfPeer,
    seen: &Observed<S>,
    [received_j, sent_j]: [S; 2],
    live: bool,
) -> [f64; TICK.len()] {
    let [received_j, sent_j] = [received_j, sent_j].map(S::to_f64);
    let axis = OfAxis { observed: &seen.map(S::to_f64), received_j, sent_j };
    tick_of(&SAMPLE, time_ns, peer, &axis, live)
}

/// A row of [`tick_columns`].
pub fn tick_of<const N: usize>(
    of: &Quantities,
    time_ns: u64,
    peer: OfPeer,
    axis: &OfAxis<'_, f64>,
    live: bool,
) -> [f64; N] {
    let values = [time_ns as f64 * 1e-9].into_iter().chain(of.of_peer(peer));
    let values = values.chain(of.recorded.iter().map(|quantity| (quantity.get)(axis)));
    let mut row = [0.0; N];
    row.iter_mut().zip(values.chain([f64::from(u8::from(live))])).for_each(|(to, from)| *to = from);
    row
}

/// A row of [`EXCHANGE`].
pub fn exchange(exchange: &Exchange, session: Option<u32>) -> [f64; EXCHANGE.len()] {
    let [t1, t2, t3, t4] = exchange.times_s;
    [t1, t2, t3, t4, session.map_or(f64::NAN, f64::from)]
}

/// The first columns of [`SECOND`]; no numbers while nothing is known.
pub fn relation(time_s: f64, relation: Option<&Relation>) -> [f64; 6] {
    let Some(relation) = relation else { return [time_s, f64::NAN, f64::NAN, f64::NAN, f64::NAN, f64::NAN] };
    [
        time_s,
        relation.offset_s(time_s),
        relation.error_s(time_s),
        1e6 * relation.drift,
        1e6 * relation.drift_error(),
        relation.round_trip_s,
    ]
}
