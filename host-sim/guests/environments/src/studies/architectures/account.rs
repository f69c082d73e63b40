//! Account of a run: what is measured, tick by tick, in every architecture.

use cohold_analysis::ROUNDING;
use cohold_protocol::wire::{Ack, Event, Presence, SEAL_LEN, Sighting};
use cohold_sim::measure::growth::Forces;

use super::{Architecture, Row, TASK};

/// Bytes of a sealed event of this length and of its acknowledgement.
pub(super) fn event_bytes(event: &Event) -> usize {
    SEAL_LEN + event.emitted_len() + SEAL_LEN + Ack::LEN
}

/// Bytes a second of telling where a hand is, each 50 ms as in the architectures paper.
pub(super) fn presence_bytes_per_s() -> f64 {
    let mut out = [0; Presence::MAX_LEN];
    let len = Presence::new(0, [Sighting::default()]).emit(&mut out).unwrap_or(Presence::MAX_LEN);
    20.0 * (SEAL_LEN + len) as f64
}

/// What else there is to know at the end of a run.
pub(super) struct End {
    /// Nobody stopped, every turn was taken.
    pub(super) done: bool,
    pub(super) spectral_radius: f64,
    pub(super) contact_n_per_m: [f64; 2],
    /// Sent by both users and by the server, in all.
    pub(super) bytes: [f64; 2],
}

pub(super) struct Account {
    forces: Forces,
    views: Vec<[f64; 2]>,
    discrepancy: f64,
    peak_m: f64,
    felt: f64,
}

impl Account {
    pub(super) fn new(ticks: u64) -> Self {
        Self {
            forces: Forces::new(ticks),
            views: Vec::with_capacity(ticks as usize),
            discrepancy: 0.0,
            peak_m: 0.0,
            felt: 0.0,
        }
    }

    /// One tick: the body as both users feel it, m, and what they push it with, N.
    pub(super) fn see(&mut self, views: [f64; 2], forces: [f64; 2]) {
        self.forces.see(self.views.len() as u64, forces);
        let distance_m = (views[0] - views[1]).abs();
        self.discrepancy += distance_m;
        self.peak_m = self.peak_m.max(distance_m);
        self.felt += 0.5 * (forces[0].abs() + forces[1].abs());
        self.views.push(views);
    }

    pub(super) fn row(self, architecture: Architecture, delay_ms: f64, end: End) -> Row {
        let count = self.views.len().max(1) as f64;
        let duration_s = TASK.duration_s;
        let rests = self.views.last().copied().unwrap_or_default();
        let moving = |view: &[f64; 2]| view.iter().zip(rests).any(|(at, rest)| (at - rest).abs() > 2e-3);
        let reasons = [
            (!end.done, "somebody stopped, or a turn was not taken"),
            (self.forces.grew(), "the forces felt grew until the end"),
            (end.spectral_radius > 1.0 + ROUNDING, "an eigenvalue lies outside the unit circle"),
        ];
        let reason = reasons.into_iter().find_map(|(failed, reason)| failed.then_some(reason));
        let placed = self.views.iter().rposition(moving).map_or(0, |at| at + 1);
        Row {
            architecture,
            delay_ms,
            stable: reason.is_none(),
            reason,
            spectral_radius: end.spectral_radius,
            contact_n_per_m: end.contact_n_per_m,
            true_discrepancy_mm: 1e3 * self.discrepancy / count,
            peak_discrepancy_mm: 1e3 * self.peak_m,
            felt_n: self.felt / count,
            peak_n: self.forces.peak(),
            rests_mm: rests.map(|at| 1e3 * at),
            placed_s: placed as f64 / count * duration_s,
            user_bytes_per_s: end.bytes[0] / duration_s / 2.0,
            server_bytes_per_s: end.bytes[1] / duration_s,
        }
    }
}
