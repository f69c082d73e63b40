//! Every kind of communications over bad networks: the fault campaign, and what passivity costs.
//!
//! The forces are those of the cooperation paper's §5.2 and the peers those of the paper's gains, with the implicit decode
//! and no object delay, so that what breaks is the network's doing. `energy_out_over_in` is what a peer took from the
//! network over what the other one gave to it, in the worse direction: above 1 the network makes energy, which is what a
//! hand feels as an object that comes alive (THEORY §5).
//!
//! | column of the costs | what | ideal |
//! |---|---|---|
//! | added delay | from one peer's tick to the other's that acts on it, less the network's own delay | 0 |
//! | true discrepancy | mean of \|x_o1 − x_o2\| under the forces of the campaign | 0 |
//! | apparent mass | what both hands feel when they move the object together (transparency) | 2·m_O |
//! | drag | what they lose while they do | 0 |
//!
//! Delay, mass and drag are measured on a slow swing ([`haptic_sim::measure::swing`]). A sample that is held for a packet period
//! is (M − 1)/2 ticks late on average, in every row; a wave is sent a tick after it was made.
//!
//! A law that is in neither [`COMMS`] nor [`CHOICES`] is tried as well, at the gains that it declares, and promises nothing.

use haptic_core::law::Sends;
use rayon::prelude::*;

use haptic_sim::measure::swing::{Felt, felt};
use haptic_sim::peers::Laws;
use haptic_sim::report::Columns;
use haptic_sim::run::{Options, Outcome, run};
use haptic_sim::scene::{Scene, SceneError};
use haptic_sim::scenes;

use super::Failure;

/// A comm or a network: name and settings.
type Named = (&'static str, &'static [&'static str]);

/// Simulated time of a cell, s.
pub const DURATION_S: f64 = 20.0;

/// Communications, with what they need: name, settings, and whether they promise passivity.
pub const COMMS: [(&str, &[&str], bool); 4] = [
    ("power", &["coordination.comm=power", "coordination.stiffness_n_per_m=310"], false),
    ("wave", &["coordination.comm=wave", "coordination.stiffness_n_per_m=1590"], false),
    (
        "passive-wave+ledger",
        &["coordination.comm=passive-wave", "coordination.stiffness_n_per_m=10000", "coordination.ledger=true"],
        true,
    ),
    (
        "passive-mean+ledger+correction",
        &[
            "coordination.comm=passive-mean",
            "coordination.stiffness_n_per_m=10000",
            "coordination.ledger=true",
            "coordination.drift_correction=true",
        ],
        true,
    ),
];

/// These ways to hold the copies together, and every law that none of them names and that sends something.
fn with_unnamed(laws: Laws, named: &[Named]) -> Vec<(&'static str, Vec<String>)> {
    let owned = |settings: &[&str]| settings.iter().map(|setting| (*setting).to_owned()).collect();
    let mut all: Vec<(&str, Vec<String>)> = named.iter().map(|(name, settings)| (*name, owned(settings))).collect();
    for law in laws.kinds().iter().filter(|law| law.sends != Sends::Nothing) {
        let comm = format!("coordination.comm={}", law.name);
        if !all.iter().any(|(_, settings)| settings.contains(&comm)) {
            all.push((law.name, [vec![comm], owned(law.gains)].concat()));
        }
    }
    all
}

/// Networks: name and settings.
const IMPAIRMENTS: [Named; 29] = [
    ("none", &[]),
    ("loss 5 %", &["network.loss=0.05"]),
    ("loss 10 %", &["network.loss=0.1"]),
    ("loss 20 %", &["network.loss=0.2"]),
    ("loss 50 %", &["network.loss=0.5"]),
    ("bursts of 40 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=5"]),
    ("bursts of 200 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=25"]),
    ("bursts of 1 s, 20 %", &["network.loss=0.2", "network.loss_burst_packets=125"]),
    ("delay 0 ms", &["network.one_way_delay_packets=0"]),
    ("delay 24 ms", &["network.one_way_delay_packets=3"]),
    ("delay 48 ms", &["network.one_way_delay_packets=6"]),
    ("delay 104 ms", &["network.one_way_delay_packets=13"]),
    ("delay 200 ms", &["network.one_way_delay_packets=25"]),
    ("jitter 4 ms", &["network.jitter=uniform", "network.jitter_s=0.004"]),
    ("jitter 8 ms", &["network.jitter=uniform", "network.jitter_s=0.008"]),
    ("jitter 12 ms", &["network.jitter=uniform", "network.jitter_s=0.012"]),
    ("jitter 12 ms, play-out", &["network.jitter=uniform", "network.jitter_s=0.012", "network.playout_packets=2"]),
    ("jitter gamma 6 ms", &["network.jitter=gamma", "network.jitter_s=0.006"]),
    ("reorder 30 %, depth 16", &["network.reorder=0.3", "network.reorder_depth_packets=16"]),
    ("duplication 20 %", &["network.duplicate=0.2", "network.jitter=uniform", "network.jitter_s=0.012"]),
    ("corruption 20 %", &["network.corrupt=0.2"]),
    ("delay step +100 ms", &["network.delay_step_s=0.1", "network.delay_step_at_s=5"]),
    ("delay step -100 ms", &["network.extra_delay_s=0.1", "network.delay_step_s=-0.1", "network.delay_step_at_s=5"]),
    ("asymmetry 40 ms", &["network.asymmetry_s=0.04"]),
    ("asymmetry 100 ms", &["network.asymmetry_s=0.1"]),
    ("drift +500 ppm", &["network.clock_drift_ppm=500"]),
    ("drift -500 ppm", &["network.clock_drift_ppm=-500"]),
    ("bandwidth 110 kbit/s", &["network.bandwidth_bit_per_s=111000"]),
    (
        "all at once",
        &[
            "network.one_way_delay_packets=3",
            "network.asymmetry_s=0.02",
            "network.jitter=gamma",
            "network.jitter_s=0.006",
            "network.loss=0.1",
            "network.loss_burst_packets=4",
            "network.reorder=0.1",
            "network.duplicate=0.1",
            "network.corrupt=0.02",
            "network.clock_drift_ppm=200",
        ],
    ),
];

/// Ways to hold the copies together: name and settings.
pub const CHOICES: [Named; 9] = [
    ("power", &["coordination.comm=power", "coordination.stiffness_n_per_m=310"]),
    ("wave", &["coordination.comm=wave", "coordination.stiffness_n_per_m=1590"]),
    ("wave + ledger", &["coordination.comm=wave", "coordination.stiffness_n_per_m=1590", "coordination.ledger=true"]),
    ("passive-wave", &["coordination.comm=passive-wave", "coordination.stiffness_n_per_m=10000"]),
    (
        "passive-wave + ledger",
        &["coordination.comm=passive-wave", "coordination.stiffness_n_per_m=10000", "coordination.ledger=true"],
    ),
    ("passive-mean", &["coordination.comm=passive-mean", "coordination.stiffness_n_per_m=10000"]),
    (
        "passive-mean + ledger",
        &["coordination.comm=passive-mean", "coordination.stiffness_n_per_m=10000", "coordination.ledger=true"],
    ),
    (
        "passive-mean + ledger + correction",
        &[
            "coordination.comm=passive-mean",
            "coordination.stiffness_n_per_m=10000",
            "coordination.ledger=true",
            "coordination.drift_correction=true",
        ],
    ),
    (
        "passive-mean + ledger + correction + play-out",
        &[
            "coordination.comm=passive-mean",
            "coordination.stiffness_n_per_m=10000",
            "coordination.ledger=true",
            "coordination.drift_correction=true",
            "network.playout_packets=2",
        ],
    ),
];

/// Networks: name and settings.
const NETWORKS: [Named; 2] = [("no loss", &[]), ("20 % lost", &["network.loss=0.2"])];

/// Periods of the swing: losses average out.
const PERIODS: u32 = 60;

/// One way to hold the copies together over one network.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Which way.
    pub comm: String,
    /// Which network.
    pub network: String,
    /// What the run gave.
    pub outcome: Outcome,
    /// What a slow swing shows of a scene that is stable, its delay less the network's own; of [`costs`] only.
    pub swing: Option<Felt>,
}

impl Cell {
    /// Whether the comm promises to be passive on any network.
    pub fn passive(&self) -> bool {
        COMMS.iter().any(|(name, _, passive)| *name == self.comm && *passive)
    }
}

/// The scene of one cell.
fn scene(laws: Laws, comm: &[String], network: &[&str]) -> Result<Scene, SceneError> {
    let mut scene = scenes::load(laws, "paper-5.2-passive-wave-16ms")?;
    let peers = ["coordination.decode=implicit", "object.integrator=semi-implicit", "object.force_delay_ticks=0"];
    for setting in peers.into_iter().chain(comm.iter().map(String::as_str)).chain(network.iter().copied()) {
        scene.apply_override(setting)?;
    }
    scene.check("campaign")?;
    Ok(scene)
}

/// Runs every comm over every network, in parallel; the order and every bit are the same on any number of threads.
fn cells(laws: Laws, comms: &[Named], networks: &[Named], periods: u32) -> Result<Vec<Cell>, Failure> {
    let comms = with_unnamed(laws, comms);
    let cells: Vec<_> = comms.iter().flat_map(|comm| networks.iter().map(move |network| (comm, network))).collect();
    let cell = |((comm, settings), (name, network)): (&(&str, Vec<String>), &Named)| {
        let scene = scene(laws, settings, network)?;
        let outcome = run::<f64>(&scene, Options { duration_s: DURATION_S, record_every: 0 }, &|_| {})?;
        let own_s = scene.peer.timing.packet_period_s() * f64::from(scene.world.network.one_way_delay_packets);
        let swing = if periods > 0 && outcome.is_stable() { Some(felt(&scene, periods)?) } else { None };
        let swing = swing.map(|swing| Felt { delay_s: swing.delay_s - own_s, ..swing });
        Ok(Cell { comm: (*comm).to_owned(), network: (*name).to_owned(), outcome, swing })
    };
    cells.into_par_iter().map(cell).collect()
}

/// The campaign.
pub fn campaign(laws: Laws) -> Result<Vec<Cell>, Failure> {
    cells(laws, &COMMS.map(|(name, settings, _)| (name, settings)), &IMPAIRMENTS, 0)
}

/// What every way to hold the copies together costs, network by network.
pub fn costs(laws: Laws) -> Result<Vec<Cell>, Failure> {
    let mut cells = cells(laws, &CHOICES, &NETWORKS, PERIODS)?;
    cells.sort_by_key(|cell| NETWORKS.iter().position(|(name, _)| *name == cell.network));
    Ok(cells)
}

/// The campaign as a table.
pub fn columns(cells: &[Cell]) -> Columns {
    Columns::of(cells)
        .value("comm", |cell| cell.comm.as_str())
        .value("passive", Cell::passive)
        .data_only()
        .value("impairment", |cell| cell.network.as_str())
        .head("network")
        .value("stable", |cell| cell.outcome.is_stable())
        .data_only()
        .value("verdict", |cell| cell.outcome.verdict().name())
        .number("energy_out_over_in", 4, |cell| cell.outcome.whole(Outcome::energy_out_over_in))
        .head("energy out/in")
        .number("peer_energy_out_over_in", 4, |cell| cell.outcome.whole(Outcome::peer_energy_out_over_in).flatten())
        .head("peer")
        .number("peak_force_n", 2, |cell| cell.outcome.whole(|o| o.peak_coordination_force_n))
        .head("peak")
        .number("largest_jump_n", 3, |cell| cell.outcome.whole(|o| o.largest_jump_n))
        .head("jump")
        .number("true_discrepancy_mm", 2, |cell| cell.outcome.whole(|o| o.true_discrepancy_mm))
        .head("true")
        .value("fault", |cell| cell.outcome.fault.map(|(peer, fault)| format!("peer {peer}: {fault:?}")))
        .value("reason", |cell| cell.outcome.reason.map(|reason| reason.to_string()))
        .data_only()
        .done()
}

/// The costs as a table.
pub fn cost_columns(costs: &[Cell]) -> Columns {
    Columns::of(costs)
        .value("network", |cost| cost.network.as_str())
        .value("choice", |cost| cost.comm.as_str())
        .head("comm")
        .value("stable", |cost| cost.outcome.is_stable())
        .data_only()
        .value("verdict", |cost| cost.outcome.verdict().name())
        .number("energy_out_over_in", 4, |cost| cost.outcome.whole(Outcome::energy_out_over_in))
        .head("energy out/in")
        .number("peer_energy_out_over_in", 4, |cost| cost.outcome.whole(Outcome::peer_energy_out_over_in).flatten())
        .head("peer")
        .number("added_delay_ms", 1, |cost| cost.swing.map(|swing| 1e3 * swing.delay_s))
        .number("true_discrepancy_mm", 2, |cost| cost.outcome.whole(|o| o.true_discrepancy_mm))
        .head("true")
        .number("apparent_mass_kg", 3, |cost| cost.swing.map(|swing| swing.mass_kg))
        .head("mass")
        .number("drag_n_s_per_m", 2, |cost| cost.swing.map(|swing| swing.drag_n_s_per_m))
        .done()
}
