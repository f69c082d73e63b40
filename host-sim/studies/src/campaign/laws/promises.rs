//! Whether a law kept on the bench what its [`LawInfo`](cohold_core::settings::LawInfo) promises.
//!
//! | promise | looked at | kept |
//! |---|---|---|
//! | passive on any network | every run over every network | its channel makes no energy in any, at the end of any tick |
//! | passive on a constant delay | those whose delay is constant and that lose nothing | the same |
//! | no drift | 8 s of pushing against each other at 20 % lost in bursts of 40 ms, then 12 s without either | the copies are within 0.1 mm in the last second |
//!
//! What is kept here is kept on these networks and seeds; tests of the laws and proofs say more.

use cohold_core::settings::Promise;
use cohold_sim::network::rule::Direction;
use cohold_sim::pair::Pair;
use cohold_sim::run::Outcome;
use cohold_sim::scene::Scene;
use cohold_sim::user::{Trace, User};

use super::super::Cell;
use crate::Error;
use crate::networks::{self, Named};

/// Above this a channel makes energy; sums of some 10⁴ products round by less.
const ROUNDING_MJ: f64 = 1e-6;

/// Time of pushing and losing, and of neither, s.
const DRIFTING_S: [f64; 2] = [8.0, 12.0];

/// The network of it.
const LOSING: &str = "loss=0.2 loss_burst_packets=40ms";

/// How far apart the copies may stay, mm.
const TOGETHER_MM: f64 = 0.1;

/// Whether a promise was kept.
#[derive(Clone, Debug)]
pub struct Kept {
    /// The promise that was looked at.
    pub promise: Promise,
    /// Whether it was kept.
    pub kept: bool,
    /// What was measured, in words.
    pub found: String,
}

/// Every promise of the scene's law.
pub(super) fn kept(scene: &Scene, cells: &[Cell], networks: &[Named]) -> Result<Vec<Kept>, Error> {
    let start_j = scene.law().budgets().map(|budget| scene.peer.own(budget)).sum();
    let of = |promise: &Promise| {
        let (kept, found) = match promise {
            Promise::Passive => channel(start_j, cells.iter()),
            Promise::PassiveOnConstantDelay => {
                let constant = cells.iter().zip(networks).map(|(cell, (_, settings))| {
                    Ok::<_, Error>(networks::is_constant(&networks::over(scene, settings)?).then_some(cell))
                });
                channel(start_j, constant.collect::<Result<Vec<_>, _>>()?.into_iter().flatten())
            }
            Promise::NoDrift => match drift_mm(scene)? {
                Some(drift_mm) => (drift_mm <= TOGETHER_MM, format!("{drift_mm:.3} mm")),
                None => (false, "a peer stopped".to_owned()),
            },
        };
        Ok(Kept { promise: *promise, kept, found })
    };
    scene.law().promises.iter().map(of).collect()
}

/// Whether none of these channels gave out more than came in and `start_j`, J, which the law held at first; and the most that was made.
fn channel<'a>(start_j: f64, cells: impl Iterator<Item = &'a Cell>) -> (bool, String) {
    let largest = |(most, place): (f64, &'a str), cell: &'a Cell| {
        let made_mj = cell.outcomes.iter().map(Outcome::energy_made_mj).fold(0.0, f64::max);
        if made_mj > most { (made_mj, cell.network.as_str()) } else { (most, place) }
    };
    let (most_mj, place) = cells.fold((0.0, "no network"), largest);
    (most_mj <= 1e3 * start_j + ROUNDING_MJ, format!("{most_mj:.3} mJ over {place}"))
}

/// How far apart the copies are once the network has recovered and nobody pushes, mm; none where a peer stopped.
fn drift_mm(scene: &Scene) -> Result<Option<f64>, Error> {
    let mut scene = networks::over(scene, LOSING)?;
    for user in &mut scene.users {
        *user = User { trace: Some(Trace::step(DRIFTING_S[0], -1.0)), ..User::default() };
        user.settings.user.push_n = 1.0;
    }
    let mut pair = Pair::<f64>::new(&scene)?;
    let ticks = DRIFTING_S.map(|time_s| (time_s / scene.peer.timing.control_period_s).round() as u64);
    (0..ticks[0]).for_each(|_| pair.step());
    for direction in [Direction::OneToTwo, Direction::TwoToOne] {
        pair.route(direction).rule = None;
    }
    let last = (1.0 / scene.peer.timing.control_period_s).round() as u64;
    let mut distance_m = 0.0;
    for tick in 0..ticks[1] {
        pair.step();
        if tick + last >= ticks[1] {
            let [one, other] = pair.sides().map(|side| side.peer.observed()[0].object.position);
            distance_m += (one - other).abs() / last as f64;
        }
    }
    Ok(pair.fault().is_none().then_some(1e3 * distance_m))
}
