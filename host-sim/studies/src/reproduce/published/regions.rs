//! The stable region of every law by two constructions: where the analyser's matrix has an eigenvalue outside the unit circle, and where
//! a run of the pair grows. Both with both hands on, in the linear scene behind the law's own (tanks that are never short, and `LINEAR`).
//!
//! The run knows nothing of matrices: two users kick the scene with 1 mN for 50 ms; it is unstable where the copies' motion is larger in
//! the last fifth of `RUN_S` than in its middle one or than right after the kick (where forces have met their limits it grows no more), or
//! a peer stopped. Its boundary is found by halving an interval about that of the matrix, so that of several crossings the same is meant;
//! **stable on one side and unstable on the other** is what each construction says for itself. Of a law that is linear in no way no matrix says
//! anything: it has neither boundary.

use haptic_analysis::tune::{CONTACT, COORDINATION};
use haptic_analysis::{Effort, Hands, Range, is_linear, limit};
use haptic_core::settings::LawInfo;
use haptic_report::Columns;
use haptic_sim::Laws;
use haptic_sim::pair::Pair;
use haptic_sim::scene::Scene;
use rayon::prelude::*;

use super::measure::kicked;
use crate::Error;
use crate::campaign::laws::law_scene;

/// Keys with which a law is linear that is not by itself: it keeps no silence, and learns nothing.
const LINEAR: [(&str, f64); 2] = [("event.longest_s", 0.0), ("model_mediated.rate_per_s", 0.0)];

/// Stiffnesses are looked at up to this, N/m.
const TO_N_PER_M: f64 = 20_000.0;

/// Simulated time of a run, s.
const RUN_S: f64 = 20.0;

/// The interval that is halved, over the matrix's boundary.
const ABOUT: [f64; 2] = [0.8, 1.2];

/// Halvings: the boundary is known to 0.4/2⁷ = 0.3 %.
const HALVINGS: u32 = 7;

/// The boundary along one stiffness.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    /// First unstable by the matrix, N/m.
    pub matrix: f64,
    /// By runs, N/m; none where the runs do not change from stable to unstable within `ABOUT` of it.
    pub run: Option<f64>,
}

/// The stable region of one law.
#[derive(Clone, Debug)]
pub struct Region {
    /// Name of the law.
    pub law: &'static str,
    /// Along K_T; none where it is stable up to `TO_N_PER_M`, or the law is not linear.
    pub coordination: Option<Boundary>,
    /// Along K_LC, at the K_T that the law declares, or half of the boundary if it is not stable there.
    pub contact: Option<Boundary>,
}

/// Every law of the registry; `done` is called once for each.
///
/// # Errors
/// Settings that no peer accepts, or what the analyser has against a scene.
pub fn regions(laws: Laws, done: impl Fn() + Sync) -> Result<Vec<Region>, Error> {
    let of = |law| {
        let found = region(laws, law);
        done();
        found
    };
    laws.all().par_iter().map(of).collect()
}

fn region(laws: Laws, law: &'static LawInfo) -> Result<Region, Error> {
    let own = LINEAR.iter().filter(|(key, _)| law.keys.iter().any(|known| known.name == *key));
    let own: Vec<String> = own.map(|(key, value)| format!("{key}={value}")).collect();
    let mut linear = law_scene(laws, law, None, &own)?.linear();
    if !is_linear(&linear)? {
        return Ok(Region { law: law.name, coordination: None, contact: None });
    }
    let coordination = boundary(&linear, COORDINATION)?;
    if let Some(found) = coordination {
        let declared = linear.peer.coordination.stiffness_n_per_m;
        linear.set_number(COORDINATION, declared.min(found.matrix / 2.0))?;
    }
    Ok(Region { law: law.name, coordination, contact: boundary(&linear, CONTACT)? })
}

fn boundary(linear: &Scene, key: &str) -> Result<Option<Boundary>, Error> {
    let range = Range { key: key.to_owned(), from: 0.0, to: TO_N_PER_M };
    let found = limit(linear, range, Effort { hands: Some(Hands::Both), ..Effort::default() })?;
    let ends = found.crossings.iter().skip(usize::from(!found.stable_at_start));
    let Some(matrix) = ends.copied().next() else { return Ok(None) };
    let is_stable = |value: f64| {
        let mut scene = linear.clone();
        scene.set_number(key, value)?;
        settles(&scene)
    };
    let [mut low, mut high] = ABOUT.map(|about| about * matrix);
    if !is_stable(low)? || is_stable(high)? {
        return Ok(Some(Boundary { matrix, run: None }));
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if is_stable(middle)? { &mut low } else { &mut high }) = middle;
    }
    Ok(Some(Boundary { matrix, run: Some(0.5 * (low + high)) }))
}

/// Whether what a kick leaves behind dies away.
fn settles(linear: &Scene) -> Result<bool, Error> {
    let mut pair = Pair::<f64>::new(&kicked(linear, false))?;
    let ticks = (RUN_S / linear.peer.timing.control_period_s).round() as u64;
    let [mut kick, mut middle, mut last] = [0.0_f64; 3];
    for tick in 0..ticks {
        pair.step();
        let sides = pair.sides();
        let motions = sides.iter().map(|side| side.peer.observed()[0]);
        let speed: f64 = motions.map(|seen| seen.object.velocity.abs()).fold(0.0, f64::max);
        match 5 * tick / ticks {
            _ if 100 * tick < ticks => kick = kick.max(speed),
            2 => middle = middle.max(speed),
            4 => last = last.max(speed),
            _ => {}
        }
    }
    Ok(pair.fault().is_none() && last <= middle.min(kick))
}

/// Declares the columns of the regions.
pub fn columns(regions: &[Region]) -> Columns {
    let matrix = |found: Option<Boundary>| found.map(|found| found.matrix);
    let run = |found: Option<Boundary>| found.and_then(|found| found.run);
    Columns::of(regions)
        .value("law", |region| region.law)
        .means("what coordination.comm calls it")
        .number("coordination_matrix_n_per_m", 0, move |region| matrix(region.coordination))
        .means("first unstable K_T by the lifted matrix, both hands on; none up to 20000")
        .head("K_T matrix")
        .number("coordination_run_n_per_m", 0, move |region| run(region.coordination))
        .means("the same by runs")
        .head("K_T run")
        .number("contact_matrix_n_per_m", 0, move |region| matrix(region.contact))
        .means("first unstable K_LC by the lifted matrix, both hands on")
        .head("K_LC matrix")
        .number("contact_run_n_per_m", 0, move |region| run(region.contact))
        .means("the same by runs")
        .head("K_LC run")
        .done()
}
