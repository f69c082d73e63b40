//! Runs of many scenes: in lanes where these pay, else alone.

use cohold_core::settings::Refused;

use super::kinds::kinds;
use super::number::{F64s, LANES, lanes_left};
use super::pairs::Pairs;
use crate::of_axes;
use crate::peers::Builds;
use crate::run::{Accounts, Begun, Options, Outcome, Ticked, Until, Watch, run_alone, run_from};
use crate::scene::Scene;

/// Fewest scenes that are worth lanes: a tick of all costs as much as so many scenes' alone, whether or not each lane has one. AVX-512 has masks, which
/// choose between numbers without a branch (docs/results/speed.md).
const FEWEST: usize = if cfg!(target_feature = "avx512f") { 3 } else { 9 };

/// How scenes are run.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// Fewest scenes of a kind that are worth lanes.
    pub fewest: usize,
    /// How long.
    pub until: Until,
}

impl How {
    /// In lanes if these pay on this processor.
    pub const fn until(until: Until) -> Self {
        Self { fewest: FEWEST, until }
    }
}

/// Runs all scenes for `duration_s` (s). With [`Until::TheEnd`] it gives, to the last bit, what [`crate::run::run`] does for each; nothing
/// is recorded.
///
/// # Errors
/// The first key of the first refused scene that is out of range or impossible beside the others.
pub fn run(how: How, scenes: &[Scene], duration_s: f64) -> Result<Vec<Outcome>, Refused<'static>> {
    let options = Options::unrecorded(duration_s);
    let (groups, mut alone) = kinds(scenes);
    let mut outcomes: Vec<Option<Outcome>> = scenes.iter().map(|_| None).collect();
    for group in groups {
        if group.len() < how.fewest {
            alone.extend(group);
            continue;
        }
        let members: Vec<&Scene> = group.iter().map(|at| &scenes[*at]).collect();
        let together = of_axes!(members[0], run_group(&members, options, how))?;
        group.into_iter().zip(together).for_each(|(at, outcome)| outcomes[at] = Some(outcome));
    }
    for at in alone {
        outcomes[at] = Some(of_axes!(scenes[at], run_alone::<f64>(&scenes[at], options, how.until, TO_THE_END))?);
    }
    Ok(outcomes.into_iter().flatten().collect())
}

/// Nobody ends it.
const TO_THE_END: Watch<'_> = (&|_| true, None);

/// Lanes that have left, and what was known of each until then.
struct Leavers<const SHARED: usize> {
    lanes: u32,
    known: [Option<Begun<SHARED>>; LANES],
}

impl<const SHARED: usize> Leavers<SHARED> {
    fn nobody() -> Self {
        Self { lanes: 0, known: [const { None }; LANES] }
    }

    /// These lanes have left by now; `known` is what there is of one that has just done so.
    #[inline]
    fn note(&mut self, left: u32, known: impl Fn(usize) -> Option<Begun<SHARED>>) {
        if left != self.lanes {
            self.add(left & !self.lanes, &known);
        }
    }

    #[cold]
    #[inline(never)]
    fn add(&mut self, lanes: u32, known: &dyn Fn(usize) -> Option<Begun<SHARED>>) {
        self.lanes |= lanes;
        (0..LANES).filter(|lane| lanes >> lane & 1 == 1).for_each(|lane| self.known[lane] = known(lane));
    }
}

/// One group side by side. Those that leave are run alone, and accounted for from where they left.
fn run_group<const SHARED: usize, const N: usize>(
    scenes: &[&Scene],
    options: Options,
    how: How,
) -> Result<Vec<Outcome>, Refused<'static>>
where
    f64: Builds<SHARED, N>,
    F64s: Builds<SHARED, N>,
{
    let ticks = options.ticks(scenes[0]);
    let mut pairs = Pairs::<SHARED, N>::new(scenes)?;
    let of = |number: fn(&Scene) -> f64| F64s::of(|lane| number(scenes[lane.min(scenes.len() - 1)]));
    let mut account = Accounts::<SHARED, F64s>::of_each(scenes[0], ticks, options, of);
    let some = (1_u32 << scenes.len()) - 1;
    let mut leavers = Leavers::nobody();
    leavers.note(lanes_left(), |_| None);
    let begun = |account: &Accounts<SHARED, F64s>, [ticks, turns]: [u64; 2], hash: u64, lane: usize| {
        Some(Begun { ticks, turns, accounts: account.map(|figure| figure.lane(lane)), hash })
    };
    for tick in 0..ticks {
        let hashes = pairs.hashes();
        let mut turns = 0;
        pairs.step(&mut |seen| {
            leavers.note(lanes_left(), |lane| begun(&account, [tick, turns], hashes[lane], lane));
            account.ticked(seen.number - 1, Ticked::of(seen.peer));
            account.pressed(seen.number - 1, seen.motors_n());
            turns += 1;
            // Whom the account itself asked has none.
            leavers.note(lanes_left(), |_| None);
        });
        leavers.note(lanes_left(), |lane| begun(&account, [tick, turns], hashes[lane], lane));
        pairs.hash();
        account.measure();
        leavers.note(lanes_left(), |_| None);
        if (some & !leavers.lanes).count_ones() < how.fewest as u32 {
            // The rest is faster alone.
            let hashes = pairs.hashes();
            leavers.note(leavers.lanes | some, |lane| begun(&account, [tick + 1, 0], hashes[lane], lane));
            break;
        }
        if how.until == Until::Stopped && account.is_over() {
            break;
        }
    }
    let (hashes, packets_per_s) = (pairs.hashes(), pairs.packets_per_s());
    let mut outcome = |(lane, scene): (usize, &&Scene)| {
        if leavers.lanes >> lane & 1 == 0 {
            let outcome = account.map(|figure| figure.lane(lane)).outcome();
            return Ok(Outcome { hash: hashes[lane], packets_per_s, ..outcome });
        }
        let begun = leavers.known[lane].take().unwrap_or_else(|| Begun::at_the_start(scene, options));
        run_from::<f64, SHARED, N>(scene, begun, (ticks, how.until), TO_THE_END)
    };
    scenes.iter().enumerate().map(&mut outcome).collect()
}
