//! What passivity costs: every way to hold the copies together, beside each other, on a good network and on one that loses a
//! fifth of the packets.
//!
//! | column | what | ideal |
//! |---|---|---|
//! | added delay | from one peer's tick to the other's that acts on it, less the network's own delay | 0 |
//! | true discrepancy | mean of \|x_o1 − x_o2\| under the forces of the campaign | 0 |
//! | apparent mass | what both hands feel when they move the object together (transparency) | 2·m_O |
//! | drag | what they lose while they do | 0 |
//!
//! Laws of core's that are not in [`CHOICES`] are measured as well. The scenes are those of [`super::campaign`]; delay, mass and
//! drag are measured on a slow swing ([`haptic_sim::measure::swing`]). A sample that is held for a packet period is
//! (M − 1)/2 ticks late on average, in every row; a wave is sent a tick after it was made.

use rayon::prelude::*;

use super::campaign::{DURATION_S, scene, with_unnamed};
use haptic_sim::measure::swing::felt;
use haptic_sim::report::Columns;
use haptic_sim::run::{Options, run};

/// Ways to hold the copies together: name and settings.
pub const CHOICES: [(&str, &[&str]); 9] = [
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
pub const NETWORKS: [(&str, &[&str]); 2] = [("no loss", &[]), ("20 % lost", &["network.loss=0.2"])];

/// Periods of the swing: losses average out.
const PERIODS: u32 = 60;

/// One way to hold the copies together over one network.
#[derive(Clone, Debug)]
pub struct Cost {
    /// Which way.
    pub choice: String,
    /// Which network.
    pub network: String,
    /// Neither peer faulted, and no oscillation grew.
    pub stable: bool,
    /// Energy taken from the network over energy given to it, worse direction.
    pub energy_out_over_in: f64,
    /// Delay of the line less the network's own, ms; none where the scene is not stable.
    pub added_delay_ms: Option<f64>,
    /// Mean |x_o1 − x_o2| over the last half, mm.
    pub true_discrepancy_mm: f64,
    /// Apparent mass of the shared object, kg; none where the scene is not stable.
    pub apparent_mass_kg: Option<f64>,
    /// What moving it loses, N·s/m; none where the scene is not stable.
    pub drag_n_s_per_m: Option<f64>,
}

/// Measures every choice over every network, in parallel; every bit is the same on any number of threads.
pub fn costs(laws: haptic_sim::Laws) -> Result<Vec<Cost>, Box<dyn std::error::Error + Send + Sync>> {
    let choices = with_unnamed(laws, &CHOICES);
    let cells: Vec<_> =
        NETWORKS.iter().flat_map(|network| choices.iter().map(move |choice| (choice, network))).collect();
    cells
        .into_par_iter()
        .map(|((choice, settings), (name, network))| {
            let scene = scene(laws, settings, network)?;
            let outcome = run::<f64>(&scene, Options { duration_s: DURATION_S, record_every: 0 }, &|_| {})?;
            let swing = if outcome.bounded { Some(felt(&scene, PERIODS)?) } else { None };
            let timing = &scene.peer.timing;
            let own_s = timing.control_period_s
                * f64::from(timing.ticks_per_packet * scene.world.network.one_way_delay_packets);
            Ok(Cost {
                choice: (*choice).to_owned(),
                network: (*name).to_owned(),
                stable: outcome.bounded,
                energy_out_over_in: outcome.energy_out_over_in(),
                added_delay_ms: swing.map(|swing| 1e3 * (swing.delay_s - own_s)),
                true_discrepancy_mm: outcome.true_discrepancy_mm,
                apparent_mass_kg: swing.map(|swing| swing.mass_kg),
                drag_n_s_per_m: swing.map(|swing| swing.drag_n_s_per_m),
            })
        })
        .collect()
}

/// The costs as a table.
pub fn columns(costs: &[Cost]) -> Columns {
    Columns::of(costs)
        .value("network", |cost| cost.network.as_str())
        .value("choice", |cost| cost.choice.as_str())
        .head("comm")
        .value("stable", |cost| cost.stable)
        .number("energy_out_over_in", 4, |cost| cost.energy_out_over_in)
        .head("energy out/in")
        .number("added_delay_ms", 1, |cost| cost.added_delay_ms)
        .number("true_discrepancy_mm", 2, |cost| cost.true_discrepancy_mm)
        .head("true")
        .number("apparent_mass_kg", 3, |cost| cost.apparent_mass_kg)
        .head("mass")
        .number("drag_n_s_per_m", 2, |cost| cost.drag_n_s_per_m)
        .done()
}
