//! Fewer packets: the self-timed line that sends N samples together beside the one that sends a packet a tick, over every network of the campaign and along N.
//!
//! The scene is `any-network` under two motions: **pushes**, those of the cooperation paper's §5.2, and **led**, user 1 leading the object by ±50 mm once a
//! second while user 2 presses 2 N against it. Asked is whether [`MOST_PACKETS`] a second do: [`Row::meets`]. A run is [`super::DURATION_S`] long, with
//! [`super::SEEDS`] seeds wherever the network draws random numbers.

use haptic_core::settings::Value;
use haptic_report::{Columns, Rows};
use haptic_sim::peers::Laws;
use haptic_sim::run::Outcome;
use haptic_sim::scenes;

use super::{Cell, over_networks};
use crate::Error;
use crate::entrant::Entrant;
use crate::networks::{self, Named};

/// Packets that are enough, /s and each way.
pub const MOST_PACKETS: f64 = 120.0;

/// Share of the true discrepancy that they may cost.
pub const MOST_COST: f64 = 0.1;

/// Above this a channel makes energy, mJ; sums round by less.
const ROUNDING_MJ: f64 = 1e-6;

/// Samples in a packet by default.
const TOGETHER: u32 = 9;

/// N of the curve.
const ALONG: [u32; 11] = [1, 2, 4, 8, 9, 10, 12, 16, 24, 32, 64];

/// What the users do.
pub(super) const MOTIONS: [Named; 2] = [
    ("pushes", &["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"]),
    (
        "led",
        &[
            "user.1.arm_stiffness_n_per_m=1000",
            "user.1.arm_damping_n_s_per_m=20",
            "user.1.tremor_m=0.05",
            "user.1.tremor_hz=1",
            "user.2.push_n=2",
        ],
    ),
];

/// Networks of the curve.
const CURVE: [&str; 4] = ["none", "loss 20 %", "bursts of 40 ms, 5 %", "bandwidth 110 kbit/s"];

/// N samples in a packet, over one network, beside a packet a tick.
#[derive(Clone, Debug)]
pub struct Row {
    /// What the users do.
    pub motion: &'static str,
    /// Samples in one packet N.
    pub together: u32,
    /// A packet a tick.
    pub each: Cell,
    /// N samples in one.
    pub sparse: Cell,
    /// What a peer's law may give before it has taken anything, mJ.
    pub capital_mj: f64,
}

fn true_mm(cell: &Cell) -> Option<f64> {
    cell.true_discrepancy_mm().map(|estimate| estimate.mean)
}

fn mean(cell: &Cell, of: impl Fn(&Outcome) -> f64) -> f64 {
    cell.outcomes.iter().map(of).sum::<f64>() / cell.outcomes.len() as f64
}

fn largest(cell: &Cell, of: impl Fn(&Outcome) -> f64) -> f64 {
    cell.outcomes.iter().map(of).fold(0.0, f64::max)
}

impl Row {
    /// Relative increase of the true discrepancy; negative is a gain. None where either is not stable.
    pub fn cost(&self) -> Option<f64> {
        Some(true_mm(&self.sparse)? / true_mm(&self.each)? - 1.0)
    }

    /// The most energy that the channel made, of any seed, mJ.
    fn channel(&self) -> f64 {
        largest(&self.sparse, Outcome::energy_made_mj)
    }

    /// The most that a peer made, mJ.
    fn peer(&self) -> f64 {
        largest(&self.sparse, |outcome| outcome.peer_energy_made_mj().unwrap_or(0.0))
    }

    /// Whether few packets do here; else what fails.
    ///
    /// # Errors
    /// What fails, in words.
    pub fn meets(&self) -> Result<(), &'static str> {
        match () {
            () if largest(&self.sparse, |outcome| outcome.packets_per_s) > MOST_PACKETS => Err("packets"),
            () if self.channel() > ROUNDING_MJ || self.peer() > self.capital_mj + ROUNDING_MJ => Err("energy"),
            () if !self.sparse.is_stable() && self.each.is_stable() => Err("apart"),
            () if !self.sparse.is_stable() => Err("both apart"),
            () if self.cost().is_some_and(|cost| cost > MOST_COST) => Err("discrepancy"),
            () => Ok(()),
        }
    }
}

/// This motion over these networks, N by N.
pub(super) fn rows(laws: Laws, (motion, users): Named, networks: &[Named], along: &[u32]) -> Result<Vec<Row>, Error> {
    let scene = |together: Option<u32>| {
        let mut set: Vec<String> = users.iter().map(|text| (*text).to_owned()).collect();
        if let Some(together) = together {
            set.extend(["event.longest_s=0.05".to_owned(), format!("event.together_ticks={together}")]);
        }
        scenes::find(laws, Some("any-network".as_ref()), &set)
    };
    let capital_mj = match scene(None)?.get("coordination.carry_energy_j") {
        Some(Value::Number(capital_j)) => 1e3 * capital_j,
        _ => 0.0,
    };
    let scenes = std::iter::once(None).chain(along.iter().map(|together| Some(*together)));
    let entrant = |together: Option<u32>| {
        let name = together.map_or_else(|| motion.to_owned(), |together| format!("{motion}, {together} together"));
        Ok(Entrant { name, scene: scene(together)? })
    };
    let entrants = scenes.map(entrant).collect::<Result<Vec<_>, Error>>()?;
    // Scene by scene, network by network.
    let mut cells = over_networks(entrants, networks, 0)?.into_iter();
    let each: Vec<Cell> = cells.by_ref().take(networks.len()).collect();
    let together = along.iter().flat_map(|together| each.iter().map(move |cell| (*together, cell)));
    Ok(together
        .zip(cells)
        .map(|((together, each), sparse)| Row { motion, together, each: each.clone(), sparse, capital_mj })
        .collect())
}

/// N = 9 over every network, both users pushing.
///
/// # Errors
/// Settings that no peer accepts.
pub fn over_all(laws: Laws) -> Result<Vec<Row>, Error> {
    rows(laws, MOTIONS[0], networks::IMPAIRMENTS, &[TOGETHER])
}

/// Along N, over a few networks; the led hand on the scene's own.
///
/// # Errors
/// Settings that no peer accepts.
pub fn curve(laws: Laws) -> Result<Vec<Row>, Error> {
    let few: Vec<Named> = networks::IMPAIRMENTS.iter().copied().filter(|(name, _)| CURVE.contains(name)).collect();
    let own = &few[..1];
    Ok([rows(laws, MOTIONS[0], &few, &ALONG)?, rows(laws, MOTIONS[1], own, &ALONG)?].concat())
}

/// What both tables have.
fn described(rows: Rows<'_, Row>) -> Rows<'_, Row> {
    rows.number("each_true_discrepancy_mm", 3, |row| true_mm(&row.each))
        .means("true discrepancy with a packet a tick, mean over the seeds; none where a run is not stable")
        .head("a packet a tick")
        .number("true_discrepancy_mm", 3, |row| true_mm(&row.sparse))
        .means("the same with N samples in a packet")
        .head("N together")
        .number("true_discrepancy_95_mm", 3, |row| row.sparse.true_discrepancy_mm().and_then(|one| one.within_95))
        .means("half of its 95 % interval over the seeds (Student)")
        .head("±")
        .number("cost", 1, |row| row.cost().map(|cost| 100.0 * cost))
        .means("what N costs in true discrepancy, %")
        .head("cost %")
        .number("packets_per_s", 0, |row| mean(&row.sparse, |outcome| outcome.packets_per_s))
        .means("packets that a peer sends, mean over the seeds")
        .number("bytes_per_s", 0, |row| mean(&row.sparse, Outcome::bytes_per_s))
        .means("the same in bytes, with UDP and IP version 4")
        .head("bytes")
        .number("energy_made_mj", 3, Row::channel)
        .means("the most, at the end of any tick, that a peer had taken from the network beyond what the other one had given to it, worst direction and seed")
        .head("channel made")
        .number("peer_energy_made_mj", 3, Row::peer)
        .means("the most, at the end of any tick, that had left the ports of a peer's coordination beyond what had entered them, worst peer and seed")
        .head("peer made")
        .value("verdict", |row| row.sparse.verdict())
        .means("the worst of the seeds, and how many of them had it")
}

/// The rows over every network.
pub fn columns(rows: &[Row]) -> Columns {
    let named = Columns::of(rows)
        .value("impairment", |row| row.each.network.as_str())
        .means("what the network does")
        .head("network");
    described(named)
        .value("meets", |row| row.meets().map_or_else(|why| why, |()| "yes"))
        .means("yes: at most 120 packets/s cost at most 10 % and make no energy; else what fails")
        .done()
}

/// The rows along N, samples in a packet.
pub fn curve_columns(rows: &[Row]) -> Columns {
    let named = Columns::of(rows)
        .value("motion", |row| row.motion)
        .means("what the users do")
        .value("impairment", |row| row.each.network.as_str())
        .means("what the network does")
        .head("network")
        .value("together_ticks", |row| row.together)
        .means("N, samples in a packet")
        .head("N");
    described(named)
        .number("peak_force_n", 1, |row| row.sparse.worst(|outcome| outcome.whole.peak_coordination_force_n))
        .means("largest |F_T| of any seed")
        .head("peak")
        .number("way", 2, |row| row.sparse.mobility().map(|estimate| estimate.mean))
        .means("how far a common push moves the copies, over the same on the scene's own network")
        .done()
}
