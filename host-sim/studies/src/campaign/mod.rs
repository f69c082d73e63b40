//! Every kind of communications over bad networks: the fault campaign, and what passivity costs.
//!
//! The forces are those of the cooperation paper's §5.2 and the peers those of the paper's gains, with the implicit decode
//! and no object delay, so that what breaks is the network's doing.
//!
//! It is a [`Study`] of the laws' scenes over the networks that measures more of a run than a row of a sweep has.
//!
//! **Nothing is chosen**: where the network draws random numbers a cell is [`SEEDS`] runs, of the scene's seed and those after it, else one. If a
//! single one of them failed the cell has no figures; of copies that came apart only the figures that say how far are kept.
//!
//! | column | what | ideal |
//! |---|---|---|
//! | verdict | the worst of the seeds, and how many of them had it | stable |
//! | every mode | whether the analyser says stable with both hands on, one and none: nobody lets go in these runs | true |
//! | true | mean of \|x_o1 − x_o2\| over the last half of [`DURATION_S`]: mean over the seeds and half of its 95 % interval (Student) | F/K_T + F·T/b |
//! | worst | the largest of it at any instant of any seed | |
//! | channel | what a peer took from the network over what the other one gave to it, worst direction and seed: above 1 the network makes energy, which is what a hand feels as an object that comes alive (THEORY §5) | ≤ 1 |
//! | peer | what left the ports of a peer's coordination over what entered them ([`cohold_sim::measure::port`]), worst peer and seed: above 1 the peer makes energy | ≤ 1 |
//! | peak, jump | largest F_T of any seed, and its largest change from tick to tick | |
//! | way | how far the copies (their mean) are after both users have pushed [`PUSH_N`] the same way for [`PUSH_S`], after [`REST_S`] at rest, over the same on the scene's own network: mean over the seeds | 1 |
//! | its peak | largest F_T in any of those runs: what an object that moves and is held by a bad network does to a hand | |
//!
//! | column of the costs | what | ideal |
//! |---|---|---|
//! | added delay | from one peer's tick to the other's that acts on it, less the network's own delay | 0 |
//! | apparent mass | what both hands feel when they move the object together (transparency) | 2·m_O |
//! | drag | what they lose while they do | 0 |
//!
//! Delay, mass and drag are measured on a slow swing ([`cohold_sim::measure::swing`]) with the first seed. A sample that is held for a
//! packet period is (M − 1)/2 ticks late on average, in every row; a wave is sent a tick after it was made.
//!
//! A law from outside the crate is tried as well, at the gains that it declares; core's own are, if they are asked for: [`laws`].

mod cells;
pub mod laws;

use cohold_core::law::Sends;

use cohold_report::{Columns, Rows};
use cohold_sim::peers::Laws;
use cohold_sim::run::{Outcome, Verdict};
use cohold_sim::{scene::Scene, scenes, user::User};

use super::Error;
use crate::entrant::Entrant;
use crate::networks::{self, Named, Network};
use crate::study::Study;
use crate::sweep::{EVERY_MODE, UNSTABLE_MODES};

pub use self::cells::{Cell, DURATION_S, PUSH_N, PUSH_S, REST_S, SEEDS};

/// A law: name and settings.
type Choice = (&'static str, &'static [&'static str]);

/// The communications of the campaign: name and settings.
pub const COMMS: [Choice; 5] = [CHOICES[0], CHOICES[1], CHOICES[4], CHOICES[7], ("self-timed", SELF_TIMED)];

/// The built-in scene `any-network` on the forces of the others.
const SELF_TIMED: &[&str] = &[
    "coordination.comm=self-timed",
    "object.integrator=midpoint",
    "timing.ticks_per_packet=1",
    "network.one_way_delay_packets=8",
    "object.mass_kg=0.02",
    "coordination.wave_impedance_n_s_per_m=60",
    "coordination.tautness=0.9",
    "coordination.even_s=0.02",
    "coordination.stiffness_n_per_m=10000",
    "safety.fade_s=5",
    "safety.disengage_s=8",
];

/// These ways to hold the copies together, and every law from outside the crate that sends something.
fn with_outside(laws: Laws, named: &[Choice]) -> Vec<(&'static str, Vec<String>)> {
    let owned = |settings: &[&str]| settings.iter().map(|setting| (*setting).to_owned()).collect();
    let mut all: Vec<(&str, Vec<String>)> = named.iter().map(|(name, settings)| (*name, owned(settings))).collect();
    for name in laws.outside() {
        let law = laws.all().iter().find(|law| law.name == name && law.sends != Sends::Nothing);
        all.extend(law.map(|law| (name, [vec![format!("coordination.comm={name}")], owned(law.gains)].concat())));
    }
    all
}

const STIFF: &str = "coordination.stiffness_n_per_m=10000";
const WAVE: &[&str] = &["coordination.comm=wave", "coordination.stiffness_n_per_m=1590", LEDGER];
const PASSIVE_WAVE: &[&str] = &["coordination.comm=passive-wave", STIFF, LEDGER];
const MEAN: &[&str] = &[
    "coordination.comm=passive-mean",
    STIFF,
    LEDGER,
    "coordination.drift_correction=true",
    "network.playout_packets=2",
];
const LEDGER: &str = "coordination.ledger=true";

/// Ways to hold the copies together: name and settings.
pub const CHOICES: [Choice; 10] = [
    ("power", &["coordination.comm=power", "coordination.stiffness_n_per_m=310"]),
    ("wave", WAVE.split_at(2).0),
    ("wave + ledger", WAVE),
    ("passive-wave", PASSIVE_WAVE.split_at(2).0),
    ("passive-wave + ledger", PASSIVE_WAVE),
    ("passive-mean", MEAN.split_at(2).0),
    ("passive-mean + ledger", MEAN.split_at(3).0),
    ("passive-mean + ledger + correction", MEAN.split_at(4).0),
    ("passive-mean + ledger + correction + play-out", MEAN),
    ("self-timed", &["coordination.comm=self-timed", STIFF, "object.integrator=midpoint"]),
];

/// The scene that every law is tried in, with gains of its own.
const BASE: &str = "paper-5.2-passive-wave-16ms";

/// With these peers, so that what breaks is the network's doing.
const PEERS: [&str; 3] =
    ["coordination.decode=implicit", "object.integrator=semi-implicit", "object.force_delay_ticks=0"];

/// Periods of the swing: losses average out.
const PERIODS: u32 = 60;

/// The study of these scenes over these networks; periods of the swing, 0 for none.
fn over_networks(entrants: Vec<Entrant>, networks: &[Named], periods: u32) -> Result<Vec<Cell>, Error> {
    cells::of(&Study::new(entrants, Network::named(networks), &[], None, SEEDS, DURATION_S)?, periods)
}

/// The scenes of these ways to hold the copies together, and of every law from outside the crate that sends something.
fn scenes(laws: Laws, named: &[Choice]) -> Result<Vec<Entrant>, Error> {
    let scene = |(law, settings): (&str, Vec<String>)| {
        let mut scene = scenes::load(laws, BASE)?;
        PEERS.into_iter().chain(settings.iter().map(String::as_str)).try_for_each(|set| scene.apply_override(set))?;
        Ok(Entrant { name: law.to_owned(), scene })
    };
    with_outside(laws, named).into_iter().map(scene).collect()
}

/// Runs every law over every impaired network.
///
/// # Errors
/// A scene that cannot be built or run.
pub fn campaign(laws: Laws) -> Result<Vec<Cell>, Error> {
    over_networks(scenes(laws, &COMMS)?, networks::IMPAIRMENTS, 0)
}

/// The campaign of one scene as it is, called `name`: its peers, its packets, its network where an impairment says
/// nothing, its users if any of them does something, else those of the paper's §5.2. A recording is that of its own network alone: an
/// impairment takes its place.
///
/// # Errors
/// A scene that cannot be built or run.
pub fn of_scene(laws: Laws, name: &str, scene: &Scene) -> Result<Vec<Cell>, Error> {
    let mut scene = scene.clone();
    if !scene.users.iter().any(User::acts) {
        scene.users = scenes::load(laws, BASE)?.users;
    }
    over_networks(vec![Entrant { name: name.to_owned(), scene }], networks::IMPAIRMENTS, 0)
}

/// What every way to hold the copies together costs, network by network.
///
/// # Errors
/// A scene that cannot be built or run.
pub fn costs(laws: Laws) -> Result<Vec<Cell>, Error> {
    let mut cells = over_networks(scenes(laws, &CHOICES)?, networks::FEW, PERIODS)?;
    cells.sort_by_key(|cell| networks::FEW.iter().position(|(name, _)| *name == cell.network));
    Ok(cells)
}

/// Columns that campaign and costs share.
fn runs<'a>(rows: Rows<'a, Cell>) -> Rows<'a, Cell> {
    rows.data("stable", Cell::is_stable)
        .means("whether every seed's run is stable")
        .value("verdict", Cell::verdict)
        .means("the worst of the seeds (stable, apart, NO), and how many of them had it")
        .value("every_mode_stable", |cell| cell.unstable_modes.is_empty())
        .means(EVERY_MODE)
        .head("every mode")
        .data("unstable_modes", |cell| Some(cell.unstable_modes.as_str()).filter(|modes| !modes.is_empty()))
        .means(UNSTABLE_MODES)
        .number("true_discrepancy_mm", 2, |cell| cell.true_discrepancy_mm().map(|estimate| estimate.mean))
        .means("mean of |x_o1 - x_o2| over the last half, mean over the seeds")
        .head("true")
        .number("true_discrepancy_95_mm", 2, |cell| cell.true_discrepancy_mm().and_then(|estimate| estimate.within_95))
        .means("half of its 95 % interval over the seeds (Student)")
        .head("±")
        .data("decoded_discrepancy_mm", |cell| cell.decoded_discrepancy_mm().map(|estimate| estimate.mean))
        .means("mean of |x_o - x_d| at peer 2 over the last half, mean over the seeds")
        .data("decoded_discrepancy_95_mm", |cell| cell.decoded_discrepancy_mm().and_then(|one| one.within_95))
        .means("half of its 95 % interval over the seeds (Student)")
        .number("worst_true_discrepancy_mm", 2, |cell| cell.worst(|o| o.whole.largest_true_discrepancy_mm))
        .means("the largest |x_o1 - x_o2| at any instant of any seed")
        .head("worst")
        .number("energy_made_mj", 3, |cell| cell.worst(Outcome::energy_made_mj))
        .means("the most, at the end of any tick, that a peer had taken from the network beyond what the other one had given to it, worst direction and seed")
        .head("channel made")
        .number("peer_energy_made_mj", 3, |cell| cell.worst(|o| o.peer_energy_made_mj().unwrap_or(f64::NAN)))
        .means("the most, at the end of any tick, that had left the ports of a peer's coordination beyond what had entered them, worst peer and seed")
        .head("peer made")
}

/// The campaign as a table.
pub fn columns(cells: &[Cell]) -> Columns {
    let named = Columns::of(cells)
        .value("comm", |cell| cell.law.as_str())
        .means("how the copies are held together")
        .data("passive", |cell| cell.passive)
        .means("whether it promises to be passive on any network")
        .value("impairment", |cell| cell.network.as_str())
        .means("what the network does")
        .head("network");
    runs(named)
        .number("peak_force_n", 2, |cell| cell.worst(|o| o.whole.peak_coordination_force_n))
        .means("largest |F_T| of any seed")
        .head("peak")
        .number("largest_jump_n", 3, |cell| cell.worst(|o| o.whole.largest_jump_n))
        .means("largest change of F_T from tick to tick, of any seed")
        .head("jump")
        .number("way", 2, |cell| cell.mobility().map(|estimate| estimate.mean))
        .means("how far a common push moves the copies, over the same on the scene's own network: mean over the seeds")
        .data("way_95", |cell| cell.mobility().and_then(|estimate| estimate.within_95))
        .means("half of its 95 % interval over the seeds (Student)")
        .number("way_peak_force_n", 2, Cell::push_peak_n)
        .means("largest |F_T| in any of those runs")
        .head("its peak")
        .data("seeds", |cell| cell.outcomes.len())
        .means("runs of the cell")
        .data("stable_seeds", |cell| cell.count(Verdict::Stable))
        .means("how many of them are stable")
        .data("apart_seeds", |cell| cell.count(Verdict::Apart))
        .means("in how many of them the copies came apart")
        .value("fault", |cell| cell.fault().map(|(peer, fault)| format!("peer {peer}: {fault:?}")))
        .means("the fault of the first run that had one, and whose it is")
        .data("reason", Cell::reason)
        .means("why the first of the runs with the worst verdict is not stable")
        .done()
}

/// The costs as a table.
pub fn cost_columns(costs: &[Cell]) -> Columns {
    let named = Columns::of(costs)
        .value("network", |cost| cost.network.as_str())
        .means("what the network does")
        .value("choice", |cost| cost.law.as_str())
        .means("how the copies are held together")
        .head("comm");
    runs(named)
        .number("added_delay_ms", 1, |cost| cost.swing.map(|swing| 1e3 * swing.delay_s))
        .means("from one peer's tick to the other's that acts on it, less the network's own delay")
        .number("apparent_mass_kg", 3, |cost| cost.swing.map(|swing| swing.mass_kg))
        .means("what both hands feel when they move the object together")
        .head("mass")
        .number("drag_n_s_per_m", 2, |cost| cost.swing.map(|swing| swing.drag_n_s_per_m))
        .means("drag that both hands feel while they move it")
        .done()
}

#[cfg(test)]
#[path = "../../tests/inside/campaign.rs"]
mod tests;
