//! The test of some gains: every motion over every test network, with every seed, measured at the hand. A motion is a [`Study`] of one scene.

use std::sync::LazyLock;

use cohold_analysis::judge;
use cohold_core::names::Choice;
use cohold_core::settings::LawInfo;
use cohold_report::Columns;
use cohold_sim::measure::at_hand;
use cohold_sim::run::Outcome;
use cohold_sim::scene::Scene;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::motions::Motion;
use super::search::Tuning;
use super::{Bench, Step, protocol, tables};
use crate::Error;
use crate::entrant::Entrant;
use crate::networks::perfect;
use crate::study::Study;
use crate::sweep::{Book, Kept, Plan, bytes_per_s, unstable_modes};

/// First seed; those of the tuning networks are others.
const SEED: u32 = 1;

/// One run. What is no number there is NaN: of a run in which a peer stopped, all but what was measured until then.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the law.
    pub law: String,
    /// Name of its gains: `declared`, or the bound within which they were chosen.
    pub point: String,
    /// Seed of the search that found them.
    pub search_seed: u32,
    /// Name of the motion.
    pub motion: String,
    /// Name of the network.
    pub network: String,
    /// `network.seed` of the run.
    pub seed: u32,
    /// Whether the scene is stable in every mode over that network.
    pub every_mode_stable: bool,
    /// The modes in which it is not, as in [`crate::sweep::Row`].
    pub unstable_modes: String,
    /// Whether a peer stopped, or what the run did grew until its end.
    pub stopped: bool,
    /// Why, or why the copies came apart; else empty.
    pub reason: String,
    /// Mean of |x_o1 − x_o2| over the last half, mm.
    pub true_mm: f64,
    /// Largest |x_o1 − x_o2|, mm.
    pub worst_true_mm: f64,
    /// That mean over the mean force of contact, mm/N.
    pub mm_per_n: f64,
    /// Largest force at either hand, N.
    pub hand_peak_n: f64,
    /// Largest change of it in a tick, N.
    pub hand_change_n: f64,
    /// Root mean square of the force at a hand less the same without a network, N.
    pub hand_error_n: f64,
    /// Where both copies are in the end, mm.
    pub way_mm: f64,
    /// Least balance of the energy of the link, J.
    pub least_balance_j: f64,
    /// Packets that a peer sent, /s.
    pub packets_per_s: f64,
    /// The same in bytes, /s.
    pub bytes_per_s: f64,
}

impl Kept for Run {
    const ROWS: &'static str = "runs";
    type Key = (String, String, u32, String, String, u32);

    fn key(&self) -> Self::Key {
        let [law, point, motion, network] = [&self.law, &self.point, &self.motion, &self.network].map(String::clone);
        (law, point, self.search_seed, motion, network, self.seed)
    }

    fn columns() -> Columns {
        tables::runs(&[])
    }
}

/// Every run of these gains of a law, in the order of motions, networks and seeds; what the book holds already is not run again.
///
/// # Errors
/// What the book cannot keep, or a scene that cannot be run.
pub fn test(
    bench: &Bench,
    law: &LawInfo,
    gains: &str,
    tuning: &Tuning,
    book: &Book<Run>,
    step: Step<'_>,
) -> Result<Vec<Run>, Error> {
    let scene = protocol::scene(bench.laws, law, &tuning.gains)?;
    let of_motion = |&motion: &Motion| {
        let mut entrant = Entrant { name: motion.name().to_owned(), scene: motion.of(&scene)? };
        entrant.scene.world.network.seed = SEED;
        let networks = bench.networks.clone();
        let study = Study::new(vec![entrant], networks, &[], None, bench.seeds, motion.duration_s())?;
        // What a hand feels without a network; not where all runs are there.
        let free = LazyLock::new(|| Ok(at_hand::run(&motion.of(&perfect(&scene)?)?, study.seconds(), None)?));
        // The same of every seed.
        let modes_at = |at| {
            let study = &study;
            LazyLock::new(move || Ok(unstable_modes(&judge(&study.scene_at(at)?)?)))
        };
        let modes: Vec<LazyLock<Result<String, Error>, _>> = (0..study.points()).map(modes_at).collect();
        let run = |at: usize, over: &Scene| {
            let (network, seed) = (study.networks[study.place(at).network].name.as_str(), over.world.network.seed);
            let names = [law.name, gains, motion.name(), network];
            let [law, point, hands, over_network] = names.map(str::to_owned);
            if let Some(known) = book.known(&(law, point, tuning.search_seed, hands, over_network, seed)) {
                return Ok(known.clone());
            }
            let free = free.as_ref().map_err(|error: &Error| error.to_string())?;
            let forces = Some(free).filter(|free| free.outcome.fault.is_none()).map(|free| free.forces.as_slice());
            let found = at_hand::run(over, study.seconds(), forces)?;
            let modes = modes[at].as_ref().map_err(|error| error.to_string())?;
            book.kept(row(names, [tuning.search_seed, seed], modes, &found, motion))
        };
        let runs = study.each(&run)?;
        step();
        Ok::<_, Error>(runs.into_iter().flatten().collect::<Vec<_>>())
    };
    let runs = Motion::ALL.par_iter().map(of_motion).collect::<Result<Vec<_>, _>>()?;
    Ok(runs.into_iter().flatten().collect())
}

/// The row of a run.
fn row(
    [law, point, motion, network]: [&str; 4],
    [search_seed, seed]: [u32; 2],
    modes: &str,
    found: &at_hand::AtHand,
    of: Motion,
) -> Run {
    let outcome = &found.outcome;
    // What grows is told of where hands push on without end; other motions end when they are largest.
    let fails = |outcome: &Outcome| if of == Motion::Against { !outcome.bounded } else { outcome.fault.is_some() };
    let stopped = fails(outcome);
    let reason = outcome.reason.filter(|_| stopped || of == Motion::Against);
    let whole = |value: f64| if stopped { f64::NAN } else { value };
    let (figures, force_n) = (&outcome.whole, outcome.whole.contact_force_n);
    Run {
        law: law.to_owned(),
        point: point.to_owned(),
        search_seed,
        motion: motion.to_owned(),
        network: network.to_owned(),
        seed,
        every_mode_stable: modes.is_empty(),
        unstable_modes: modes.to_owned(),
        stopped,
        reason: reason.map_or_else(String::new, |reason| reason.to_string()),
        true_mm: whole(figures.true_discrepancy_mm),
        worst_true_mm: figures.largest_true_discrepancy_mm,
        mm_per_n: if force_n > 0.0 { whole(figures.true_discrepancy_mm / force_n) } else { f64::NAN },
        hand_peak_n: figures.peak_hand_force_n,
        hand_change_n: figures.largest_hand_change_n,
        hand_error_n: found.error_rms_n.unwrap_or(f64::NAN),
        way_mm: whole(1e3 * found.way_m),
        least_balance_j: found.least_balance_j,
        packets_per_s: outcome.packets_per_s,
        bytes_per_s: bytes_per_s(outcome),
    }
}
