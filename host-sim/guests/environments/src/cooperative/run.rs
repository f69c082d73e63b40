//! One run of a cooperative environment and its figures of merit.
//!
//! Means run over the last half. **Coherency** is the true discrepancy at one instant: the largest distance between the
//! object as any client renders it and the object where it is moved. An environment is stable when no client stopped with a
//! fault and no force grew from eighth to eighth of the run.

use cohold_report::Columns;
use cohold_sim::measure::{LastHalf, growth::Forces};
use cohold_sim::quantities::Named;
use serde::Serialize;

use super::client::Client;
use super::world::World;
use super::{Engine, Setup};
use crate::Error;

/// What a run gave.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Nobody stopped, nothing grew.
    pub stable: bool,
    /// Who stopped first, and why.
    pub fault: Option<String>,
    /// Mean over the last half of the largest distance between the object as rendered and as moved, mm.
    pub true_discrepancy_mm: f64,
    /// The largest of it in the whole run, mm.
    pub peak_discrepancy_mm: f64,
    /// Mean |contact force| over users and the last half, N.
    pub felt_n: f64,
    /// Largest |contact force| of any user in the whole run, N.
    pub peak_n: f64,
    /// Largest change of any contact force from tick to tick, N.
    pub largest_jump_n: f64,
    /// Round trip as the first client measured it at the end, ms.
    pub round_trip_ms: Option<f64>,
    /// What the last client may render and asks for at the end.
    pub stiffness_n_per_m: f64,
    /// Damping of the object at its engine that the last client asks for at the end, N·s/m.
    pub drag_n_s_per_m: f64,
    pub(crate) moved_mm: f64,
    /// Ticks on which nobody, the server or a client had the engine.
    pub engine_ticks: [u64; 3],
    pub(crate) hand_overs: u32,
    /// Bytes a client sends each second, sealed.
    pub up_bytes_per_s: f64,
    /// Bytes the server sends to a client each second, sealed.
    pub down_bytes_per_s: f64,
    /// Control periods that the run lasted.
    pub ticks: u64,
    /// What was recorded, tick by tick.
    #[serde(skip)]
    pub table: Columns,
}

/// Columns of the record.
pub const COLUMNS: [Named; 7] = [
    ("time_s", "since the start of the run"),
    ("object_m", "position of the object where it is moved"),
    ("view_1_m", "position of the object as the first client renders it"),
    ("view_last_m", "position of the object as the last client renders it"),
    ("force_1_n", "contact force of the first client"),
    ("force_last_n", "contact force of the last client"),
    ("engine", "who moves the object: 0 the server, else the number of a client; nothing while it is handed over"),
];

/// Runs the environment for `duration_s`.
///
/// # Errors
/// A setup that cannot be built.
pub fn run(setup: &Setup, duration_s: f64) -> Result<Outcome, Error> {
    let mut world = World::new(setup)?;
    let period_s = setup.scene.peer.timing.control_period_s;
    let ticks = (duration_s / period_s).round() as u64;
    let record_every = ticks.div_ceil(20_000).max(1);
    let mut table = Columns::named(COLUMNS);
    let (mut forces, mut halves, mut peak_m) = (Forces::new(ticks), LastHalf::new(ticks), 0.0_f64);
    let (mut engine_ticks, mut hand_overs, mut last_holder) = ([0; 3], 0, 0);
    for tick in 0..ticks {
        match setup.engine {
            Engine::Moves if tick == ticks / 4 => world.ask(),
            Engine::Moves if tick == ticks / 4 * 3 => world.recall(),
            Engine::Client => world.ask(),
            Engine::Server | Engine::Moves => {}
        }
        world.step();
        let object = world.object().position;
        let distance_m = world.clients().map(|client| (client.view().position - object).abs()).fold(0.0, f64::max);
        forces.see(tick, world.forces());
        peak_m = peak_m.max(distance_m);
        let felt_n = forces.last().iter().map(|force| force.abs()).sum::<f64>() / setup.users as f64;
        halves.see(tick, [distance_m, felt_n]);
        let holder = world.holders().first().copied();
        engine_ticks[holder.map_or(0, |holder| holder.min(1) + 1)] += 1;
        if let Some(holder) = holder {
            hand_overs += u32::from(holder != last_holder);
            last_holder = holder;
        }
        if tick % record_every == 0 {
            let views: Vec<f64> = world.clients().map(|client| client.view().position).collect();
            let (first, last) = (views.first().copied(), views.last().copied());
            let engine = holder.map_or(f64::NAN, |holder| holder as f64);
            let row = [tick as f64 * period_s, object, first.unwrap_or(0.0), last.unwrap_or(0.0), forces.last()[0]];
            table.push_row(&[&row[..], &[forces.last()[setup.users - 1], engine]].concat());
        }
    }
    let fault = world
        .clients()
        .enumerate()
        .find_map(|(index, client)| client.fault.map(|fault| format!("client {}: {}", index + 1, fault.explain())));
    let [discrepancy_m, felt_n] = halves.means();
    let rate = |bytes: u64| bytes as f64 / (ticks as f64 * period_s) / setup.users as f64;
    let [up, down] = world.bytes();
    let last = world.clients().last().map(|client| client.bound).unwrap_or_default();
    let first: Option<&Client> = world.clients().next();
    Ok(Outcome {
        stable: fault.is_none() && !forces.grew(),
        fault,
        true_discrepancy_mm: 1e3 * discrepancy_m,
        peak_discrepancy_mm: 1e3 * peak_m,
        felt_n,
        peak_n: forces.peak(),
        largest_jump_n: forces.largest_change(),
        round_trip_ms: first.and_then(|client| client.clock.round_trip_us()).map(|us| 1e-3 * f64::from(us)),
        stiffness_n_per_m: last.stiffness,
        drag_n_s_per_m: last.drag,
        moved_mm: 1e3 * world.object().position,
        engine_ticks,
        hand_overs,
        up_bytes_per_s: rate(up),
        down_bytes_per_s: rate(down),
        ticks,
        table,
    })
}
