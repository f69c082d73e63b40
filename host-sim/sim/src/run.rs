//! One run of two peers: the scene's experiment for a duration, its figures of merit, and what was recorded.
//!
//! Discrepancies are two, always by name (THEORY §4): **true** |x_o1 − x_o2| at one instant, and **decoded** |x_o − x_d| at
//! peer 2, which is what the cooperation paper plots as the distance to the "remote copy". Means run over the last half.

use haptic_core::contact::{Impacts, RenderingName};
use haptic_core::safety::Fault;
use haptic_core::settings::Refused;

use crate::measure::{LastHalf, Statistics};
use crate::pair::{HASH_SEED, Pair};
use crate::peers::Number;
use crate::report::Columns;
use crate::scene::Scene;

/// How to run.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Simulated time, s.
    pub duration_s: f64,
    /// Keep every how-many-th tick; 0 keeps none.
    pub record_every: u64,
}

impl Options {
    /// Records at most about 100,000 rows.
    pub fn recorded(duration_s: f64, period_s: f64) -> Self {
        Self { duration_s, record_every: ((duration_s / period_s) as u64).div_ceil(100_000).max(1) }
    }
}

/// Energy that crossed one peer's network port, J.
#[derive(Clone, Copy, Debug, Default)]
pub struct PortEnergy {
    /// From the network.
    pub received_j: f64,
    /// To the network.
    pub sent_j: f64,
}

/// What a run gave.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Neither peer faulted, and no envelope grew without bound.
    pub bounded: bool,
    /// Who stopped, and why.
    pub fault: Option<(usize, Fault)>,
    /// When, s.
    pub fault_time_s: Option<f64>,
    /// Mean of |x_o1 − x_o2| over the last half, mm.
    pub true_discrepancy_mm: f64,
    /// Mean of |x_o − x_d| at peer 2 over the last half, mm.
    pub decoded_discrepancy_mm: f64,
    /// F_T at peer 2 over the last half, N.
    pub coordination_force_n: Statistics,
    /// Mean of |F_LC| over both peers and the last half, N.
    pub contact_force_n: f64,
    /// Largest |F_T| of either peer, N.
    pub peak_coordination_force_n: f64,
    /// Largest change of either F_T from one tick to the next, N.
    pub largest_jump_n: f64,
    /// Energy through both network ports.
    pub energy: [PortEnergy; 2],
    /// Impacts at both peers, where contact is impulsive.
    pub impacts: Option<[Impacts<f64>; 2]>,
    /// Ticks done.
    pub ticks: u64,
    /// Hash of both peers' states over every tick.
    pub hash: u64,
    /// What was recorded; empty if nothing was.
    pub table: Columns,
}

impl Outcome {
    /// Energy that a peer took from the network over what the other one gave to it, in the worse direction; above 1 the
    /// network makes energy.
    pub fn energy_out_over_in(&self) -> f64 {
        let [first, second] = self.energy;
        let ratio = |out: f64, into: f64| if into > 0.0 { out / into } else { 0.0 };
        ratio(second.received_j, first.sent_j).max(ratio(first.received_j, second.sent_j))
    }
}

/// The columns that are recorded, each peer's by its number.
const PEER_COLUMNS: [&str; 8] = [
    "device_{}_m",
    "object_{}_m",
    "desired_{}_m",
    "object_velocity_{}_m_per_s",
    "contact_force_{}_n",
    "coordination_force_{}_n",
    "energy_received_{}_j",
    "energy_sent_{}_j",
];

/// The last columns, of both.
const COMMON_COLUMNS: [&str; 2] = ["true_discrepancy_m", "decoded_discrepancy_2_m"];

/// Tells how far a long run is, in ticks.
pub type Progress<'a> = &'a dyn Fn(u64);

/// Runs the scene with peers that compute in `S`.
pub fn run<S: Number>(scene: &Scene, options: Options, progress: Progress<'_>) -> Result<Outcome, Refused<'static>> {
    let mut pair = Pair::<S>::new(scene)?;
    let ticks = (options.duration_s / scene.peer.timing.control_period_s).round() as u64;
    let peers = (1..=2).flat_map(|peer| PEER_COLUMNS.map(|name| name.replace("{}", &peer.to_string())));
    let names = [["time_s".to_owned()].to_vec(), peers.collect(), COMMON_COLUMNS.map(str::to_owned).to_vec()];
    let mut table = Columns::named(names.concat());
    let mut halves = LastHalf::new(ticks);
    let mut seen = Forces::new(ticks);
    let mut hash = HASH_SEED;
    let mut fault_time_s = None;
    for tick in 0..ticks {
        let time_s = pair.time_s();
        pair.step();
        hash = pair.hash(hash);
        if fault_time_s.is_none() && pair.fault().is_some() {
            fault_time_s = Some(time_s);
        }
        let [first, second] = pair.sides().map(|side| side.peer.observed());
        let true_m = (first.object.position.to_f64() - second.object.position.to_f64()).abs();
        let decoded_m = (second.object.position.to_f64() - second.desired.position.to_f64()).abs();
        let forces = [first, second].map(|seen| seen.coordination_force.to_f64());
        let contacts = [first, second].map(|seen| seen.contact_force.to_f64());
        seen.see(tick, forces);
        let contact = 0.5 * (contacts[0].abs() + contacts[1].abs());
        halves.see(tick, [true_m, decoded_m, forces[1], forces[1] * forces[1], contact]);
        if options.record_every > 0 && tick % options.record_every == 0 {
            let peers = pair.sides().into_iter().flat_map(|side| {
                let (seen, ledger) = (side.peer.observed(), side.peer.ledger());
                [
                    seen.device.position,
                    seen.object.position,
                    seen.desired.position,
                    seen.object.velocity,
                    seen.contact_force,
                    seen.coordination_force,
                    ledger.received_j(),
                    ledger.sent_j(),
                ]
                .map(S::to_f64)
            });
            let row: Vec<f64> = core::iter::once(time_s).chain(peers).chain([true_m, decoded_m]).collect();
            table.push_row(&row);
        }
        if tick % 10_000 == 0 {
            progress(tick);
        }
    }
    let fault = pair.fault();
    let [true_m, decoded_m, force, force_squared, contact] = halves.means();
    Ok(Outcome {
        bounded: fault.is_none() && !seen.grew(),
        fault,
        fault_time_s,
        true_discrepancy_mm: 1e3 * true_m,
        decoded_discrepancy_mm: 1e3 * decoded_m,
        coordination_force_n: Statistics::of_moments(force, force_squared),
        contact_force_n: contact,
        peak_coordination_force_n: seen.peak(),
        largest_jump_n: seen.largest_change(),
        energy: pair.sides().map(|side| PortEnergy {
            received_j: side.peer.ledger().received_j().to_f64(),
            sent_j: side.peer.ledger().sent_j().to_f64(),
        }),
        impacts: (scene.peer.contact.rendering == RenderingName::Impulsive).then(|| {
            pair.sides().map(|side| {
                let Impacts { count, wanted_n_s, delivered_n_s, lost_j } = side.peer.impacts();
                let [wanted_n_s, delivered_n_s, lost_j] = [wanted_n_s, delivered_n_s, lost_j].map(S::to_f64);
                Impacts { count, wanted_n_s, delivered_n_s, lost_j }
            })
        }),
        ticks,
        hash,
        table,
    })
}

/// What forces do over a run: how large they get, by how much they change from tick to tick, and whether that grows.
pub struct Forces {
    window: u64,
    last: Vec<f64>,
    peak: f64,
    /// Largest change in each eighth of the run.
    changes: [f64; 8],
}

impl Forces {
    /// For a run of `ticks` ticks, from no force on.
    pub fn new(ticks: u64) -> Self {
        Self { window: ticks.div_ceil(8).max(1), last: Vec::new(), peak: 0.0, changes: [0.0; 8] }
    }

    /// Takes in the forces of a tick, always as many.
    pub fn see(&mut self, tick: u64, forces: impl IntoIterator<Item = f64>) {
        let largest = &mut self.changes[((tick / self.window) as usize).min(7)];
        for (at, force) in forces.into_iter().enumerate() {
            if at == self.last.len() {
                self.last.push(0.0);
            }
            let change = (force - self.last[at]).abs();
            *largest = if change.is_finite() { largest.max(change) } else { f64::INFINITY };
            self.peak = self.peak.max(force.abs());
            self.last[at] = force;
        }
    }

    /// Those of the last tick.
    pub fn last(&self) -> &[f64] {
        &self.last
    }

    /// The largest there was.
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// The largest change of any from one tick to the next.
    pub fn largest_change(&self) -> f64 {
        self.changes.iter().copied().fold(0.0, f64::max)
    }

    /// Whether an oscillation grows: the changes are larger in each of the last four eighths than in the one before, fourfold in
    /// all.
    pub fn grew(&self) -> bool {
        let tail = &self.changes[3..];
        tail.windows(2).all(|pair| pair[1] > 1.05 * pair[0]) && tail[4] > 4.0 * tail[0]
            || self.changes.iter().any(|change| change.is_infinite())
    }
}
