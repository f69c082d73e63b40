//! The fault campaign: every kind of communications over every kind of bad network.
//!
//! The forces are those of the cooperation paper's §5.2 and the peers those of the paper's gains, with the implicit decode
//! and no object delay, so that what breaks is the network's doing. `energy_out_over_in` is what a peer took from the
//! network over what the other one gave to it, in the worse direction: above 1 the network makes energy, which is what a
//! hand feels as an object that comes alive (THEORY §5).
//!
//! A law that is not in [`COMMS`] is tried as well, at the gains that it declares, and promises nothing.

use haptic_core::law::Sends;
use haptic_core::settings::Refused;
use rayon::prelude::*;

use haptic_sim::peers::Laws;
use haptic_sim::report::Columns;
use haptic_sim::run::{Options, run};
use haptic_sim::scene::{Scene, SceneError};
use haptic_sim::scenes;

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
pub(super) fn with_unnamed(laws: Laws, named: &[(&'static str, &[&str])]) -> Vec<(&'static str, Vec<String>)> {
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
pub const IMPAIRMENTS: [(&str, &[&str]); 29] = [
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

/// One comm over one network.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Communications.
    pub comm: String,
    /// Whether they promise to be passive on any network.
    pub passive: bool,
    /// Network.
    pub impairment: String,
    /// Neither peer faulted, and no oscillation grew.
    pub stable: bool,
    /// What stopped a peer.
    pub fault: Option<String>,
    /// Energy taken from the network over energy given to it, worse direction.
    pub energy_out_over_in: f64,
    /// Largest coordination force of either peer, N.
    pub peak_force_n: f64,
    /// Largest change of a coordination force from tick to tick, N.
    pub largest_jump_n: f64,
    /// Mean |x_o1 − x_o2| over the last half, mm.
    pub true_discrepancy_mm: f64,
}

/// The scene of one cell.
pub fn scene(laws: Laws, comm: &[impl AsRef<str>], impairment: &[&str]) -> Result<Scene, SceneError> {
    let mut scene = scenes::load(laws, "paper-5.2-passive-wave-16ms")?;
    let peers = ["coordination.decode=implicit", "object.integrator=semi-implicit", "object.force_delay_ticks=0"];
    let comm = comm.iter().map(AsRef::as_ref);
    for setting in peers.into_iter().chain(comm).chain(impairment.iter().copied()) {
        scene.apply_override(setting)?;
    }
    scene.check("campaign")?;
    Ok(scene)
}

/// Runs every comm over every network, in parallel; the order and every bit are the same on any number of threads.
pub fn campaign(laws: Laws) -> Result<Vec<Cell>, Box<dyn std::error::Error + Send + Sync>> {
    let comms = with_unnamed(laws, &COMMS.map(|(name, settings, _)| (name, settings)));
    let cells: Vec<_> =
        comms.iter().flat_map(|comm| IMPAIRMENTS.iter().map(move |impairment| (comm, impairment))).collect();
    cells
        .into_par_iter()
        .map(|((comm, settings), (impairment, network))| {
            let passive = COMMS.iter().any(|(name, _, passive)| name == comm && *passive);
            Ok(cell(&scene(laws, settings, network)?, comm, passive, impairment)?)
        })
        .collect()
}

fn cell(scene: &Scene, comm: &str, passive: bool, impairment: &str) -> Result<Cell, Refused<'static>> {
    let outcome = run::<f64>(scene, Options { duration_s: DURATION_S, record_every: 0 }, &|_| {})?;
    Ok(Cell {
        comm: comm.to_owned(),
        passive,
        impairment: impairment.to_owned(),
        stable: outcome.bounded,
        fault: outcome.fault.map(|(peer, fault)| format!("peer {peer}: {fault:?}")),
        energy_out_over_in: outcome.energy_out_over_in(),
        peak_force_n: outcome.peak_coordination_force_n,
        largest_jump_n: outcome.largest_jump_n,
        true_discrepancy_mm: outcome.true_discrepancy_mm,
    })
}

/// The campaign as a table.
pub fn columns(cells: &[Cell]) -> Columns {
    Columns::of(cells)
        .value("comm", |cell| cell.comm.as_str())
        .value("passive", |cell| cell.passive)
        .data_only()
        .value("impairment", |cell| cell.impairment.as_str())
        .head("network")
        .value("stable", |cell| cell.stable)
        .number("energy_out_over_in", 4, |cell| cell.energy_out_over_in)
        .head("energy out/in")
        .number("peak_force_n", 2, |cell| cell.peak_force_n)
        .head("peak")
        .number("largest_jump_n", 3, |cell| cell.largest_jump_n)
        .head("jump")
        .number("true_discrepancy_mm", 2, |cell| cell.true_discrepancy_mm)
        .head("true")
        .value("fault", |cell| cell.fault.clone())
        .done()
}
