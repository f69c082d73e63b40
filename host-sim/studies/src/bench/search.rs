//! The tuning of a law: a search of a study ([`study::around`](crate::study::around)), of which a try is a tuning.
//!
//! A tuning **counts** whatever comes of it: gains that the law refuses, gains that are not stable, gains of which a hand feels too much. It is measured no
//! further than what it fails first:
//!
//! | in this order | on | admitted |
//! |---|---|---|
//! | what a hand feels at 0.2, 1 and 5 Hz ([`cohold_sim::measure::led`]) | 8 ms and 24 ms, nothing lost, the larger of both | mass at 1 Hz up to [`protocol::MOST_MASS_KG`], \|Z\| up to the largest bound |
//! | every mode, by the analyser, of a law that is linear | 8 ms | stable |
//! | a hand lets go | 8 ms | nobody stops, nothing grows |
//! | one hand is led for 3 s | every tuning network | nobody stops |
//! | pushes against each other for 6 s | every tuning network | nobody stops, nothing grows |
//!
//! What is made least is the **worst tuning network's** distance of the copies over the force of contact, mm/N.

use cohold_analysis::{Hands, judge};
use cohold_core::names::Choice;
use cohold_core::settings::{LawInfo, Value};
use cohold_report::Columns;
use cohold_sim::measure::led::felt;
use cohold_sim::run::{Options, Outcome, Verdict, run};
use cohold_sim::scene::Scene;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::motions::Motion;
use super::protocol::{self, BOUNDS_N_S_PER_M, FREQUENCIES_HZ, MOST_AT_5_HZ_N_S_PER_M, MOST_MASS_KG};
use super::{Bench, Step, tables};
use crate::Error;
use crate::campaign::laws::stability::{GROWS, not_linear};
use crate::networks::{Network, TUNING};
use crate::study::around::{Around, Gain, Tried, best};
use crate::sweep::{Book, Kept};

/// Time of the runs, s.
const PUSHED_S: f64 = 6.0;
const LED_S: f64 = 3.0;
/// First seed of the tuning networks; those of the test begin at 1.
const SEED: u32 = 1001;

/// One tuning of a law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// Name of the law.
    pub law: String,
    /// Seed of the search.
    pub search_seed: u32,
    /// Its number in that search, from 0.
    pub number: usize,
    /// The gains, as settings with blanks between; none are the law's own.
    pub gains: String,
    /// |Z| that a hand alone feels at [`FREQUENCIES_HZ`] on the worse of the constant tuning networks, N·s/m; NaN where it was not measured.
    pub felt_n_s_per_m: [f64; 3],
    /// The object's mass as felt at 1 Hz, kg: what pulls it back shows as less.
    pub mass_kg: f64,
    /// The worst tuning network's distance of the copies over the force of contact, mm/N; NaN where it was not measured.
    pub worst_mm_per_n: f64,
    /// Why it is not admitted; empty where it is.
    pub reason: String,
}

impl Kept for Tuning {
    const ROWS: &'static str = "tunings";
    type Key = (String, u32, usize);

    fn key(&self) -> Self::Key {
        (self.law.clone(), self.search_seed, self.number)
    }

    fn columns() -> Columns {
        tables::tunings(&[])
    }
}

impl Tuning {
    /// How much more than this bound a hand feels, at the worst of the frequencies, relative; 0 within it.
    fn excess(&self, bound_n_s_per_m: f64) -> f64 {
        let most = [bound_n_s_per_m, bound_n_s_per_m, MOST_AT_5_HZ_N_S_PER_M];
        let over = |(felt, most): (&f64, f64)| if felt.is_nan() { 0.0 } else { (felt / most - 1.0).max(0.0) };
        self.felt_n_s_per_m.iter().zip(most).map(over).fold((self.mass_kg / MOST_MASS_KG - 1.0).max(0.0), f64::max)
    }

    /// Whether it may be chosen within this bound.
    pub fn is_within(&self, bound_n_s_per_m: f64) -> bool {
        self.reason.is_empty() && self.worst_mm_per_n.is_finite() && self.excess(bound_n_s_per_m) == 0.0
    }
}

impl Tried for Tuning {
    fn gains(&self) -> &str {
        &self.gains
    }

    /// What is admitted before what is not, and that by how far it is from it.
    fn cost(&self, bound_n_s_per_m: f64) -> f64 {
        match () {
            () if self.is_within(bound_n_s_per_m) => self.worst_mm_per_n,
            () if self.felt_n_s_per_m[1].is_nan() => f64::MAX,
            () if self.reason.is_empty() => 1e6 * (1.0 + self.excess(bound_n_s_per_m)),
            () => 1e9 * (1.0 + self.excess(bound_n_s_per_m)),
        }
    }
}

/// What is tested of a law, by name: its own gains, and within each bound the best of each search that found any, the best of all first.
pub fn chosen(tunings: &[Tuning]) -> Vec<(String, Tuning)> {
    let own = tunings.first().map(|tuning| ("declared".to_owned(), tuning.clone()));
    let tuned = BOUNDS_N_S_PER_M.iter().flat_map(|bound| {
        let searches = tunings.chunk_by(|one, other| one.search_seed == other.search_seed);
        let mut found: Vec<&Tuning> = searches.filter_map(|search| best(search, *bound)).collect();
        found.retain(|best| best.is_within(*bound));
        found.sort_by(|one, other| one.worst_mm_per_n.total_cmp(&other.worst_mm_per_n));
        found.into_iter().map(|best| (point_name(*bound), best.clone()))
    });
    own.into_iter().chain(tuned).collect()
}

/// Name of the best gains within a bound.
pub fn point_name(bound_n_s_per_m: f64) -> String {
    format!("≤ {bound_n_s_per_m}")
}

/// Tunes a law by each search; what the book holds already is not measured again.
///
/// # Errors
/// What the book cannot keep, or a law that its own gains do not suit.
pub fn tune(bench: &Bench, law: &'static LawInfo, book: &Book<Tuning>, step: Step<'_>) -> Result<Vec<Tuning>, Error> {
    let gains = protocol::gains(bench.laws, law)?;
    let scene = protocol::scene(bench.laws, law, "")?;
    let is_linear = is_linear(&scene)?;
    let own = |gain: &Gain| match scene.get(&gain.key) {
        Some(Value::Number(value)) => value,
        _ => gain.ends[0],
    };
    let own: Vec<f64> = gains.iter().map(own).collect();
    let searched = |seed: u32| {
        let search = Around { gains: &gains, own: &own, bounds: &BOUNDS_N_S_PER_M, budget: bench.budget, seed };
        search.search(&|number, gains| {
            // What was found for other gains, as by another version of the search, is no answer.
            let known = book.known(&(law.name.to_owned(), seed, number)).filter(|known| known.gains == gains);
            let tuning = match known {
                Some(known) => known.clone(),
                None => book.kept(measured(bench, law, is_linear, (seed, number), gains)?)?,
            };
            step();
            Ok(tuning)
        })
    };
    let found = (1..=bench.searches).into_par_iter().map(searched).collect::<Result<Vec<_>, _>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// Whether the analyser's matrices say all of a law: of its own gains they do, and the run is not stable where they say it grows.
fn is_linear(own: &Scene) -> Result<bool, Error> {
    if not_linear(own)?.is_some() {
        return Ok(false);
    }
    let judged = judge(own)?;
    let both = judged.modes.iter().find(|mode| mode.mode == Hands::Both);
    let grows = both.is_some_and(|both| both.verdict.spectral_radius > GROWS);
    Ok(!grows || outcome(&Motion::Against.of(own)?, PUSHED_S)?.verdict() == Verdict::Unstable)
}

fn outcome(scene: &Scene, duration_s: f64) -> Result<Outcome, Error> {
    Ok(run::<f64>(scene, Options::unrecorded(duration_s), &|_| {})?)
}

/// Measures a tuning.
fn measured(
    bench: &Bench,
    law: &LawInfo,
    is_linear: bool,
    (search_seed, number): (u32, usize),
    gains: String,
) -> Result<Tuning, Error> {
    let nothing = f64::NAN;
    let mut tuning = Tuning {
        law: law.name.to_owned(),
        search_seed,
        number,
        felt_n_s_per_m: [nothing; 3],
        mass_kg: nothing,
        worst_mm_per_n: nothing,
        reason: String::new(),
        gains,
    };
    match protocol::scene(bench.laws, law, &tuning.gains) {
        Ok(scene) => tuning.reason = fill(&scene, is_linear, &mut tuning)?.unwrap_or_default(),
        // A combination that a law does not accept is a tuning that was tried.
        Err(refused) => tuning.reason = refused.to_string(),
    }
    Ok(tuning)
}

/// Fills in what is measured; why it is not admitted, if so.
fn fill(scene: &Scene, is_linear: bool, tuning: &mut Tuning) -> Result<Option<String>, Error> {
    let largest = BOUNDS_N_S_PER_M.into_iter().fold(0.0, f64::max);
    let networks = Network::named(TUNING);
    let constant = [networks[0].over(scene)?, networks[networks.len() - 1].over(scene)?];
    // 1 Hz first: what fails there is measured no further.
    for at in [1, 0, 2] {
        for over in &constant {
            let Some(impedance) = felt(over, FREQUENCIES_HZ[at])? else {
                return Ok(Some("a peer stops where a hand leads it".to_owned()));
            };
            // The larger of both; what is no number yet gives way.
            tuning.felt_n_s_per_m[at] = tuning.felt_n_s_per_m[at].max(impedance.norm());
            if at == 1 {
                let omega = core::f64::consts::TAU * FREQUENCIES_HZ[at];
                tuning.mass_kg = tuning.mass_kg.max(impedance.im / omega - scene.world.device.mass_kg);
            }
        }
        if tuning.excess(largest) > 0.0 {
            return Ok(Some("a hand feels more than any bound allows".to_owned()));
        }
    }
    if is_linear {
        let worst = judge(scene)?.worst;
        if !worst.stable {
            return Ok(Some(format!("not stable in every mode: spectral radius {:.6}", worst.spectral_radius)));
        }
    }
    let failed = |motion: Motion, network: &str, outcome: &Outcome| {
        let reason = outcome.reason.filter(|_| outcome.verdict() == Verdict::Unstable)?;
        Some(format!("{} over {network}: {reason}", motion.name()))
    };
    let let_go = outcome(&Motion::LetGo.of(scene)?, Motion::LetGo.duration_s())?;
    if let Some(reason) = failed(Motion::LetGo, TUNING[0].0, &let_go) {
        return Ok(Some(reason));
    }
    let mut worst = 0.0_f64;
    for (at, network) in networks.iter().enumerate() {
        let mut over = network.over(scene)?;
        over.world.network.seed = SEED + at as u32;
        let led = outcome(&Motion::Led.of(&over)?, LED_S)?;
        if led.fault.is_some() {
            return Ok(failed(Motion::Led, &network.name, &led));
        }
        let pushed = outcome(&Motion::Against.of(&over)?, PUSHED_S)?;
        if let Some(reason) = failed(Motion::Against, &network.name, &pushed) {
            return Ok(Some(reason));
        }
        worst = worst.max(pushed.whole.true_discrepancy_mm / pushed.whole.contact_force_n);
    }
    tuning.worst_mm_per_n = worst;
    Ok(None)
}
