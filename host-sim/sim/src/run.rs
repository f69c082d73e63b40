//! One run of two peers: the scene's experiment for a duration, its figures of merit, and what was recorded.
//!
//! Discrepancies are two, always by name (THEORY §4): **true** |x_o1 − x_o2| at one instant, and **decoded** |x_o − x_d| at
//! peer 2, which is what the cooperation paper plots as the distance to the "remote copy". Means run over the last half.
//!
//! A run is **stable** (THEORY §9) if no peer faulted, neither the coordination force nor the energy of the copies grew, the copies
//! are within [`APART_MM`] of each other, or as near as springs and line let them be ([`compliance_m_per_n`]), and both peers were engaged
//! in the end; else [`Outcome::reason`] is the first of these that failed. What a run computed that stopped, grew or let go is no figure
//! of merit: [`Outcome::metric`] gives none. That copies came apart is said, and takes no figure away.
//! Peaks and ratios stand for the whole run.

mod account;
mod accounts;
mod outcome;
mod reason;
mod statics;

use std::cmp::Ordering;

use cohold_core::contact::{Impacts, RenderingName};
use cohold_core::num::{Fixed, Scalar};
use cohold_core::settings::Refused;

pub use self::account::{Account, Ticked};
pub use self::accounts::Accounts;
pub use self::outcome::{AXIS_NAMES, AxisOutcome, Figures, Options, Outcome, Until};
pub use self::reason::{Reason, Verdict};
pub use self::statics::{APART_FACTOR, APART_MM, END_FACTOR, compliance_m_per_n};
pub use crate::measure::port::PortEnergy;

use crate::double_double::DoubleDouble;
use crate::of_axes;
use crate::pair::{HASH_SEED, Pair};
use crate::peers::{Builds, Number};
use crate::plant::Plant;
use crate::scene::Scene;

/// Is called every 10,000 ticks with the number of ticks done, to report how far a long run is.
pub type Progress<'a> = &'a dyn Fn(u64);

/// Is called every 10,000 ticks with the number of ticks done; answers whether the run is to go on.
pub type GoOn<'a> = &'a dyn Fn(u64) -> bool;

/// Is called with every recorded row, as the index of its shared axis (from 0) and the values of its columns.
pub type EachRow<'a> = &'a dyn Fn(usize, &[f64]);

/// Who watches a run while it goes on.
pub type Watch<'a> = (GoOn<'a>, Option<EachRow<'a>>);

/// What a run comes to, or the first key of the scene that is out of range or impossible beside the others.
pub type Ran = Result<Outcome, Refused<'static>>;

/// A number type in which scenes can be run.
pub trait Run: Number + Scalar<Counter = f64> {
    /// [`run`] in this type. Compiled here, once and optimised, and not wherever it is called.
    #[doc(hidden)]
    fn run(scene: &Scene, options: Options, watch: Watch<'_>) -> Ran;
}

macro_rules! runs {
    ($($(#[$inline:meta])? $Number:ty),+) => {
        $(impl Run for $Number {
            $(#[$inline])?
            fn run(scene: &Scene, options: Options, watch: Watch<'_>) -> Ran {
                of_axes!(scene, run_alone::<Self>(scene, options, Until::TheEnd, watch))
            }
        })+
    };
}
// No command runs a scene in the last: a program that does compiles it.
runs!(
    f32,
    f64,
    Fixed,
    #[inline]
    DoubleDouble
);

/// Runs the scene with peers that compute in `S`.
///
/// # Errors
/// The first key of the scene that is out of range or impossible beside the others.
pub fn run<S: Run>(scene: &Scene, options: Options, progress: Progress<'_>) -> Ran {
    run_seen::<S>(scene, options, progress, None)
}

/// [`run`] for as long as `go_on`, which is asked every 10,000 ticks, says so. A run that is ended early has made
/// fewer [`Outcome::ticks`], and its figures say nothing of the scene.
///
/// # Errors
/// As [`run`].
pub fn run_while<S: Run>(scene: &Scene, options: Options, go_on: GoOn<'_>) -> Ran {
    S::run(scene, options, (go_on, None))
}

/// [`run`]; `each`, if it is there, sees every tick of every axis as a row of [`Account::columns`], whatever is kept in the tables.
///
/// # Errors
/// As [`run`].
pub fn run_seen<S: Run>(scene: &Scene, options: Options, progress: Progress<'_>, each: Option<EachRow<'_>>) -> Ran {
    let go_on = |tick| {
        progress(tick);
        true
    };
    S::run(scene, options, (&go_on, each))
}

/// A run of which the first ticks are accounted for already: the lanes that it left have seen to them ([`crate::lanes`]).
pub(crate) struct Begun<const SHARED: usize> {
    /// Control periods that are accounted for, and ticks of peers in the one after them.
    pub(crate) ticks: u64,
    pub(crate) turns: u64,
    pub(crate) accounts: Accounts<SHARED>,
    pub(crate) hash: u64,
}

impl<const SHARED: usize> Begun<SHARED> {
    /// Nothing is.
    pub(crate) fn at_the_start(scene: &Scene, options: Options) -> Self {
        Self { ticks: 0, turns: 0, accounts: Accounts::new(scene, options.ticks(scene), options), hash: HASH_SEED }
    }
}

/// A run from its start, in no lane.
pub(crate) fn run_alone<S: Scalar<Counter = f64> + Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    scene: &Scene,
    options: Options,
    until: Until,
    watch: Watch<'_>,
) -> Ran {
    run_from::<S, SHARED, N>(scene, Begun::at_the_start(scene, options), (options.ticks(scene), until), watch)
}

/// A run of so many ticks at most, from its start, accounted for from where it is not yet.
pub(crate) fn run_from<S: Scalar<Counter = f64> + Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    scene: &Scene,
    begun: Begun<SHARED>,
    (ticks, until): (u64, Until),
    (go_on, each): Watch<'_>,
) -> Ran {
    let mut pair = Pair::<S, Plant<N>, SHARED, N>::build(scene)?;
    let Begun { ticks: known, turns, mut accounts, mut hash } = begun;
    for tick in 0..ticks {
        let mut known_turns = match tick.cmp(&known) {
            Ordering::Less => u64::MAX,
            Ordering::Equal => turns,
            Ordering::Greater => 0,
        };
        pair.step_watched(&mut |seen| {
            if known_turns > 0 {
                known_turns -= 1;
                return;
            }
            accounts.ticked(seen.number - 1, Ticked::of(seen.peer));
            accounts.pressed(seen.number - 1, seen.motors_n());
        });
        if tick < known {
            continue;
        }
        hash = pair.hash_in_place(hash);
        accounts.period();
        if let Some(each) = each {
            accounts.rows().enumerate().for_each(|(axis, row)| each(axis, &row));
        }
        if until == Until::Stopped && accounts.is_over() || tick % 10_000 == 0 && !go_on(tick) {
            break;
        }
    }
    let impacts = (scene.peer.contact.rendering == RenderingName::Impulsive).then(|| {
        pair.sides().map(|side| {
            // Along the first axis: such contact is refused along several.
            let along = side.peer.impacts()[0];
            Impacts {
                count: along.count,
                wanted_n_s: along.wanted_n_s.to_f64(),
                delivered_n_s: along.delivered_n_s.to_f64(),
                lost_j: along.lost_j.to_f64(),
            }
        })
    });
    let packets_per_s = pair.packets_per_s();
    Ok(Outcome { hash, impacts, packets_per_s, ..accounts.outcome() })
}
