//! Who watches a hub: a recording of it along every shared axis, a line each second, and the true discrepancy of its users along the first,
//! which is the one that telemetry tells of; all beside the control loop.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Instant;

use cohold_live::discrepancy::Sum;
use cohold_live::recording::common_clock::Watched;
use cohold_live::recording::recorder::Recorder;
use cohold_live::recording::ticks;
use cohold_live::tell::{Second, Teller};
use cohold_live::watch::{LiveOptions, LiveSummary};
use cohold_protocol::link::Notice;
use cohold_sim::scene::Scene;

use super::copies::Copies;
use crate::Error;
use crate::cooperative::hub::Hub;

/// Records and reports what a hub does.
pub(crate) struct HubWatch {
    recorder: Option<Arc<Recorder>>,
    pub teller: Teller,
    period_s: f64,
    packet_s: f64,
    packets: u64,
    clocks: Vec<Watched>,
    reported: Vec<Option<u32>>,
    copies: Copies,
    of_second: Sum,
    of_half: Sum,
    of_all: Sum,
    ticks: u64,
    noticed: Vec<u64>,
    row: Vec<f64>,
}

impl HubWatch {
    /// Of so many lines, whose clock began at `start`, and which runs for so many packet periods.
    pub(crate) fn new(
        wanted: &LiveOptions,
        scene: &Scene,
        lines: usize,
        start: Instant,
        packets: u64,
    ) -> Result<Self, Error> {
        let timing = &scene.peer.timing;
        let channels = ticks::hub_channels(lines, scene.peer.axis.shared as usize);
        let recorder = wanted.recorder("hub", start, channels)?.map(Arc::new);
        let mut teller = Teller::new(wanted.manner);
        teller.log = recorder.clone();
        Ok(Self {
            recorder,
            teller,
            period_s: timing.control_period_s,
            packet_s: timing.packet_period_s(),
            packets,
            clocks: vec![Watched::default(); lines],
            reported: vec![None; lines],
            copies: Copies::new(lines),
            of_second: Sum::default(),
            of_half: Sum::default(),
            of_all: Sum::default(),
            ticks: 0,
            noticed: vec![0; lines],
            row: Vec::new(),
        })
    }

    fn record(&self, channel: u16, time_ns: u64, values: &[f64]) {
        if let Some(recorder) = &self.recorder {
            recorder.put(channel, time_ns, values);
        }
    }

    /// A datagram was taken.
    pub(crate) fn heard<const SHARED: usize>(&mut self, now_ns: u64, hub: &Hub<SocketAddr, SHARED>) {
        for (at, (end, _)) in hub.lines().enumerate() {
            let line = &end.line;
            if let Some(exchange) = self.clocks[at].see(line.link.clock().newest()) {
                let row = ticks::exchange(&exchange, line.link.session_number());
                self.record(ticks::EXCHANGES, now_ns, &[&row[..], &[at as f64 + 1.0]].concat());
                if self.clocks[at].relation.is_none() {
                    self.clocks[at].look();
                }
            }
            let tick = line.heard.as_ref().map(|said| said.tick);
            if let Some(said) = line.heard.as_ref().filter(|_| tick != self.reported[at]) {
                let sealed_us = line.link.sealed_us();
                if let Some(discrepancy) = self.copies.observe(at, said, sealed_us, self.period_s, &self.clocks[at]) {
                    self.of_second.add(discrepancy);
                    self.of_all.add(discrepancy);
                    if hub.packets.unwrap_or(0) >= self.packets / 2 {
                        self.of_half.add(discrepancy);
                    }
                }
            }
            self.reported[at] = tick;
        }
    }

    /// A tick is over.
    pub(crate) fn ticked<const SHARED: usize>(&mut self, now_ns: u64, hub: &Hub<SocketAddr, SHARED>) {
        let time_s = now_ns as f64 * 1e-9;
        for (axis, motion) in hub.junction.motion.iter().enumerate() {
            self.row.clear();
            self.row.extend([time_s, self.ticks as f64, motion.position]);
            for port in hub.junction.ports.iter().map(|port| &port.axes[axis]) {
                self.row.extend([port.force_n, port.energy.taken_j, port.energy.sent_j]);
            }
            self.record(ticks::of_axis(axis, ticks::SECONDS), now_ns, &self.row);
        }
        self.ticks += 1;
        for ((end, _), (at, reported)) in hub.lines().zip(self.noticed.iter_mut().enumerate()) {
            let line = &end.line;
            if line.noticed == *reported {
                continue;
            }
            for (time_us, notice) in line.notices.iter().rev().take((line.noticed - *reported) as usize).rev() {
                self.teller.notice(*time_us, &format!("line {}: ", at + 1), notice);
                if let Notice::NewPeer(_) = notice {
                    // Another life has another clock.
                    self.clocks[at].forget();
                }
            }
            *reported = line.noticed;
        }
        if self.ticks.is_multiple_of((1.0 / self.period_s).round().max(1.0) as u64) {
            self.second(now_ns, time_s, hub);
        }
    }

    fn second<const SHARED: usize>(&mut self, now_ns: u64, time_s: f64, hub: &Hub<SocketAddr, SHARED>) {
        self.clocks.iter_mut().for_each(Watched::look);
        let sum = std::mem::take(&mut self.of_second);
        let up = hub.lines().filter(|(end, _)| end.line.link.is_up()).count();
        let live = hub.lines().filter(|(_, port)| port.is_engaged()).count();
        let error_s =
            self.clocks.iter().filter_map(|clock| Some(clock.relation.as_ref()?.error_s(time_s))).reduce(f64::max);
        let round_trip_us = hub.lines().filter_map(|(end, _)| end.line.link.clock().round_trip_us()).max();
        let fault = (1..).zip(hub.lines()).find_map(|(at, (end, _))| {
            let fault = end.line.heard.as_ref().map_or(0, |said| said.fault);
            (fault != 0).then(|| format!("line {at}: fault {fault}"))
        });
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let values =
            [time_s, up as f64, number(sum.rms_m()), number(sum.largest_m()), number(sum.error_m()), number(error_s)];
        self.record(ticks::SECONDS, now_ns, &values);
        let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
        let packets = hub.packets.unwrap_or(0);
        self.teller.second(Second {
            time_s,
            done_s: packets as f64 * self.packet_s,
            of_s: self.packets as f64 * self.packet_s,
            state: if hub.packets.is_some() { "meeting" } else { "waiting" },
            partner: format!("{up} of {} lines", self.clocks.len()),
            round_trip_us,
            rms_true_discrepancy_mm: mm(sum.rms_m()),
            largest_true_discrepancy_mm: mm(sum.largest_m()),
            true_discrepancy_error_mm: mm(sum.error_m()),
            clock_error_us: error_s.map(|error_s| 1e6 * error_s),
            live_share: hub.packets.is_some().then_some(live as f64 / self.clocks.len() as f64),
            stable: None,
            path: None,
            fault,
        });
    }

    /// What there was to see; the recording is closed.
    pub(crate) fn end(mut self) -> LiveSummary {
        self.teller.log = None;
        let recorded = self.recorder.take().and_then(Arc::into_inner).map(|recorder| recorder.finish().summary());
        if let Some(reported) = &recorded {
            self.teller.words(reported.clone());
        }
        LiveSummary::of(&self.of_half, &self.of_all, None, recorded)
    }
}
