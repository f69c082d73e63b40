//! Runs of many scenes: in lanes where these pay, else alone.

use haptic_core::settings::Refused;

use super::kinds::kinds;
use super::number::{F32s, F64s, Lanes, lanes_left};
use super::pairs::Pairs;
use crate::of_axes;
use crate::peers::{Builds, Number};
use crate::run::{Accounts, Options, Outcome, Run, Ticked};
use crate::scene::Scene;

/// Fewest scenes that are worth lanes: a tick of all costs as much as so many scenes' alone, whether or not each lane has one. AVX-512 has masks, which
/// choose between numbers without a branch (docs/speed.md).
const FEWEST: usize = if cfg!(target_feature = "avx512f") { 3 } else { 9 };

/// A number type in which scenes can be run in lanes.
pub trait InLanes: Run {
    /// The type that holds a number for each lane.
    type Lanes: Lanes<Alone = Self> + Number;
    /// [`run_group`] in these lanes. Compiled here, once and optimised, and not wherever it is called.
    #[doc(hidden)]
    fn run_group(scenes: &[&Scene], options: Options, fewest: usize) -> Result<Vec<Option<Outcome>>, Refused<'static>>;
}

macro_rules! in_lanes {
    ($($Number:ty: $Lanes:ty),+) => {
        $(impl InLanes for $Number {
            type Lanes = $Lanes;
            fn run_group(
                scenes: &[&Scene],
                options: Options,
                fewest: usize,
            ) -> Result<Vec<Option<Outcome>>, Refused<'static>> {
                of_axes!(scenes[0], run_group::<$Lanes>(scenes, options, fewest))
            }
        })+
    };
}
in_lanes!(f32: F32s, f64: F64s);

/// Runs all scenes for `duration_s` (s); gives, to the last bit, what [`crate::run::run`] does for each; nothing is recorded.
///
/// # Errors
/// The first key of the first refused scene that is out of range or impossible beside the others.
pub fn run<S: InLanes>(scenes: &[Scene], duration_s: f64) -> Result<Vec<Outcome>, Refused<'static>> {
    run_from::<S>(FEWEST, scenes, duration_s)
}

/// [`run`] that takes so many scenes of a kind, or more, for worth lanes.
///
/// # Errors
/// As [`run`].
pub fn run_from<S: InLanes>(
    fewest: usize,
    scenes: &[Scene],
    duration_s: f64,
) -> Result<Vec<Outcome>, Refused<'static>> {
    let options = Options { duration_s, record_every: 0 };
    let (groups, mut alone) = kinds(scenes);
    let mut outcomes: Vec<Option<Outcome>> = scenes.iter().map(|_| None).collect();
    for group in groups {
        if group.len() < fewest {
            alone.extend(group);
            continue;
        }
        let members: Vec<&Scene> = group.iter().map(|at| &scenes[*at]).collect();
        let together = S::run_group(&members, options, fewest)?;
        for (at, outcome) in group.into_iter().zip(together) {
            match outcome {
                Some(outcome) => outcomes[at] = Some(outcome),
                None => alone.push(at),
            }
        }
    }
    for at in alone {
        outcomes[at] = Some(crate::run::run::<S>(&scenes[at], options, &|_| {})?);
    }
    Ok(outcomes.into_iter().flatten().collect())
}

/// One group side by side; nothing of those that left.
fn run_group<S: Lanes + Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    scenes: &[&Scene],
    options: Options,
    fewest: usize,
) -> Result<Vec<Option<Outcome>>, Refused<'static>> {
    let ticks = options.ticks(scenes[0]);
    let mut pairs = Pairs::<S, SHARED, N>::new(scenes)?;
    let of = |number: fn(&Scene) -> f64| F64s::of(|lane| number(scenes[lane.min(scenes.len() - 1)]));
    let mut account = Accounts::<SHARED, F64s>::of_each(scenes[0], ticks, options, of);
    let some = (1_u32 << scenes.len()) - 1;
    for _ in 0..ticks {
        pairs.step(&mut |seen| {
            account.ticked(seen.number - 1, Ticked::of(seen.peer));
            account.pressed(seen.number - 1, seen.motors_n());
        });
        pairs.hash();
        account.measure();
        if (some & !lanes_left()).count_ones() < fewest as u32 {
            // The rest is faster alone.
            return Ok(scenes.iter().map(|_| None).collect());
        }
    }
    let (left, hashes, packets_per_s) = (lanes_left(), pairs.hashes(), pairs.packets_per_s());
    let whole = |lane: usize| {
        let outcome = || account.map(|figure| figure.lane(lane)).outcome();
        (left >> lane & 1 == 0).then(|| Outcome { hash: hashes[lane], packets_per_s, ..outcome() })
    };
    Ok((0..scenes.len()).map(whole).collect())
}
