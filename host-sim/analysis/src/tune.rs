//! Gains for a scene: the stiffest contact and coordination that leave a margin.
//!
//! **Margin** m: every pair of gains from (0, 0) up to (1 + m) times the proposal is stable. Both gains, or either, may be
//! raised by m, or lowered to nothing, as an adaptive bounder does, without meeting a boundary or a pocket.
//!
//! **Stiffest**: of all such proposals the one through which one hand feels the other as stiffly as gains can make it: two
//! contacts and the coordination in a row yield 2/K_LC + 1/K_T metres per newton, and that is least. A coordination
//! [`ENOUGH`] times as stiff as the stiffest contact adds next to nothing, so no stiffer one is looked for: it would only
//! make rounding louder.
//!
//! **A taut line** has a third number: of what it gives way, as much is taken back as (1 + m) times still is stable with both gains raised,
//! and never more than all. Its time constant needs no proposal: the law keeps it longer than the modes that it could feed.
//!
//! Found on a grid of contact stiffnesses: at each the first K_T that is unstable, pockets followed
//! (`limit`), is where the rectangle below it must end. Rounded down to three digits, then verified afresh: at the
//! proposal, at its three raised corners, along both keys from 0 through the proposal and through the raised gains. Whatever
//! fails takes 2 % off both gains, and is verified again. The linear scene is what is proved
//! ([`cohold_sim::scene::Scene::linear`]), in every mode ([`super::judge`]); [`try_out`] runs the scene itself, and [`let_go`]
//! with nobody holding it.

use cohold_core::law::self_timed::TAUTNESS;
use cohold_core::num::StateVector;
use cohold_core::settings::Allowed;
use cohold_sim::of_axes;
use cohold_sim::pair::Pair;
use cohold_sim::peers::{Builds, Number};
use cohold_sim::plant::Plant;
use cohold_sim::run::{Options, Outcome, Run, run};
use cohold_sim::scene::Scene;
use cohold_sim::user::User;
use rayon::prelude::*;
use serde::Serialize;

use super::limit::{Effort, along};
use super::modes::judge;
use super::sweep::{Range, Sweep};
use super::verdict::{Analyser, Verdict, is_stable};
use crate::error::Error;

/// Key of the contact stiffness K_LC, N/m.
pub const CONTACT: &str = "contact.stiffness_n_per_m";
/// Key of the coordination stiffness K_T, N/m.
pub const COORDINATION: &str = "coordination.stiffness_n_per_m";

/// Coordination this many times as stiff as the stiffest contact is stiff enough: 1/K_T is then 1/40 of 2/K_LC.
pub const ENOUGH: f64 = 20.0;

/// Margins that make sense.
pub const MARGINS: [f64; 2] = [0.0, 10.0];

/// Contact stiffnesses that are tried.
const COLUMNS: usize = 48;

/// How far beyond the proposal (times 1 + m) limits are looked for.
pub const BEYOND: f64 = 4.0;

/// Times 2 % is taken off before giving up.
const RETREATS: usize = 50;

/// The gains proposed for a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proposal {
    /// Contact stiffness K_LC, N/m.
    pub contact_stiffness_n_per_m: f64,
    /// Coordination stiffness K_T, N/m.
    pub coordination_stiffness_n_per_m: f64,
    /// m: every pair of gains up to (1 + m) times these is stable.
    pub margin: f64,
    /// Spectral radius with the proposal.
    pub spectral_radius: f64,
    /// The largest at the three raised corners: either gain, or both, times 1 + m.
    pub raised_spectral_radius: f64,
    /// First unstable K_LC with the proposed K_T; absent where there is none up to [`BEYOND`] times the proposal.
    pub contact_limit_n_per_m: Option<f64>,
    /// First unstable K_T with the proposed K_LC; absent where there is none up to [`BEYOND`] times the proposal.
    pub coordination_limit_n_per_m: Option<f64>,
    /// 2/K_LC + 1/K_T, mm/N: what the gains let one hand yield against the other.
    pub compliance_mm_per_n: f64,
    /// The most of what a taut line gives way that may be taken back ([`TAUTNESS`]), up to all of it: (1 + m) times that is stable, with both
    /// gains raised, and all else here is with it. Absent where the line is not taut.
    pub tautness: Option<f64>,
}

impl Proposal {
    /// The overrides that set it.
    pub fn overrides(&self) -> Vec<String> {
        let mut sets = vec![
            format!("{CONTACT}={}", self.contact_stiffness_n_per_m),
            format!("{COORDINATION}={}", self.coordination_stiffness_n_per_m),
        ];
        sets.extend(self.tautness.map(|share| format!("{}={share}", TAUTNESS.name)));
        sets
    }

    /// The scene with the proposal.
    ///
    /// # Errors
    /// A value beyond its key's range.
    pub fn applied(&self, scene: &Scene) -> Result<Scene, Error> {
        let mut scene = scene.clone();
        for set in self.overrides() {
            scene.apply_override(&set)?;
        }
        Ok(scene)
    }
}

/// The scene with these gains, N/m.
fn with(scene: &Scene, contact: f64, coordination: f64) -> Result<Scene, Error> {
    let mut scene = scene.clone();
    scene.set_number(CONTACT, contact)?;
    scene.set_number(COORDINATION, coordination)?;
    Ok(scene)
}

/// Proposes gains; `None` where not even the softest contact is stable. `done` is called once for every contact stiffness
/// tried, of which there are at most [`steps`].
///
/// # Errors
/// A margin that is out of range, or a scene that the analyser cannot judge.
pub fn tune(scene: &Scene, margin: f64, done: impl Fn() + Sync) -> Result<Option<Proposal>, Error> {
    Error::within("margin", margin, MARGINS, "")?;
    let raised = 1.0 + margin;
    let stiffest = first(&with(scene, 0.0, 0.0)?, CONTACT, largest(CONTACT))?.unwrap_or(largest(CONTACT));
    let enough = (ENOUGH * stiffest).min(largest(COORDINATION));
    // The first unstable K_T of every contact; stable up to there for every softer contact too, once the minimum runs.
    let ends = (0..=COLUMNS)
        .into_par_iter()
        .map(|at| {
            let contact = stiffest * at as f64 / COLUMNS as f64;
            let end = first(&with(scene, contact, 0.0)?, COORDINATION, enough)?.unwrap_or(enough);
            done();
            Ok((contact, end))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let mut lowest = f64::INFINITY;
    let corners = ends.into_iter().map(|(contact, end)| {
        lowest = lowest.min(end);
        (contact / raised, lowest / raised)
    });
    let stiffness = |(contact, coordination): &(f64, f64)| 1.0 / (2.0 / contact + 1.0 / coordination);
    let Some(mut gains) = corners.max_by(|a, b| stiffness(a).total_cmp(&stiffness(b))) else { return Ok(None) };
    for _ in 0..RETREATS {
        let (contact, coordination) = (rounded_down(gains.0), rounded_down(gains.1));
        if contact > 0.0
            && coordination > 0.0
            && let Some(proposal) = verified(scene, contact, coordination, margin)?
        {
            return Ok(Some(proposal));
        }
        gains = (0.98 * gains.0, 0.98 * gains.1);
    }
    Ok(None)
}

/// Calls of `done` that [`tune`] makes.
pub fn steps() -> u64 {
    COLUMNS as u64 + 1
}

/// The proposal, if all of it holds.
fn verified(scene: &Scene, contact: f64, coordination: f64, margin: f64) -> Result<Option<Proposal>, Error> {
    let raised = 1.0 + margin;
    let mut scene = with(scene, raised * contact, raised * coordination)?;
    let tautness = tauten(&mut scene, raised)?;
    let verdict = |contact, coordination| Ok(judge(&with(&scene, contact, coordination)?)?.worst);
    let point: Verdict = verdict(contact, coordination)?;
    let corners = [(raised, 1.0), (1.0, raised), (raised, raised)]
        .into_iter()
        .map(|(a, b)| verdict(a * contact, b * coordination))
        .collect::<Result<Vec<Verdict>, Error>>()?;
    if !point.stable || corners.iter().any(|corner| !corner.stable) {
        return Ok(None);
    }
    let least = raised * (1.0 - 1e-4);
    let clear = |limit: Option<f64>, gain: f64| limit.is_none_or(|limit| limit >= least * gain);
    let mut limits = [None; 2];
    for factor in [raised, 1.0] {
        let to = |key: &str, gain: f64| largest(key).min(BEYOND * raised * gain);
        let base = with(&scene, 0.0, factor * coordination)?;
        let along_contact = first(&base, CONTACT, to(CONTACT, contact))?;
        let base = with(&scene, factor * contact, 0.0)?;
        let along_coordination = first(&base, COORDINATION, to(COORDINATION, coordination))?;
        if !clear(along_contact, contact) || !clear(along_coordination, coordination) {
            return Ok(None);
        }
        limits = [along_contact, along_coordination];
    }
    let radii = corners.iter().map(|corner| corner.spectral_radius);
    Ok(Some(Proposal {
        contact_stiffness_n_per_m: contact,
        coordination_stiffness_n_per_m: coordination,
        margin,
        spectral_radius: point.spectral_radius,
        raised_spectral_radius: radii.fold(0.0, f64::max),
        contact_limit_n_per_m: limits[0],
        coordination_limit_n_per_m: limits[1],
        compliance_mm_per_n: 1e3 * (2.0 / contact + 1.0 / coordination),
        tautness,
    }))
}

/// Lets a taut line take back the most that is stable with a margin, and says how much that is; `None` where nothing is taken back.
fn tauten(scene: &mut Scene, raised: f64) -> Result<Option<f64>, Error> {
    if scene.peer.own(&TAUTNESS) <= 0.0 {
        return Ok(None);
    }
    let to = raised.min(largest(TAUTNESS.name));
    let share = rounded_down(first(scene, TAUTNESS.name, to)?.unwrap_or(to) / raised);
    scene.set_number(TAUTNESS.name, share)?;
    Ok(Some(share))
}

/// The first unstable value of a gain from 0 on; `None` where there is none.
fn first(scene: &Scene, key: &str, to: f64) -> Result<Option<f64>, Error> {
    if to <= 0.0 {
        return Ok(Some(0.0));
    }
    let sweep = Sweep::new(scene, Range::up_to(key, to))?;
    let limit = along(&sweep, Effort { steps: 120, ..Effort::every_mode() })?;
    if !limit.stable_at_start {
        return Ok(Some(0.0));
    }
    // A crossing is known to its tolerance: stay on the stable side of it.
    let Some(crossing) = limit.crossings.first() else { return Ok(None) };
    let inside = crossing * (1.0 - Effort::default().tolerance);
    let stable = is_stable(sweep.radius(&mut Analyser::default(), inside, None)?);
    Ok(Some(if stable { inside } else { crossing * (1.0 - 1e-3) }))
}

/// The largest value that a key allows.
fn largest(key: &str) -> f64 {
    let keys = Scene::default().keys();
    let found = keys.iter().find(|(name, _)| name == key);
    match found.map(|(_, key)| key.allowed) {
        Some(Allowed::Number { max, .. }) => max,
        _ => 0.0,
    }
}

/// Three digits, never more than the value.
fn rounded_down(value: f64) -> f64 {
    let power = value.log10().floor() - 2.0;
    let digits = (value / 10_f64.powf(power) * (1.0 + 1e-12)).floor();
    // Of 0, infinity and no number this is no number.
    format!("{digits}e{power}").parse().unwrap_or(0.0)
}

/// Runs the scene with the proposal, as it is, gaps, encoders and all; users who do nothing get the pushes and pulses of
/// the cooperation paper's §5.1, 1 N and 1 N on top for 25 ms.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn try_out<S: Run>(scene: &Scene, proposal: &Proposal, duration_s: f64) -> Result<Outcome, Error> {
    let mut scene = proposal.applied(scene)?;
    let idle = |user: &User| {
        let does = &user.settings.user;
        let moves = [does.push_n, does.pulse_n, does.sine_n, does.reach_m, does.tremor_m];
        moves.iter().all(|amount| *amount == 0.0) && user.trace.is_none()
    };
    if scene.users.iter().all(idle) {
        for user in &mut scene.users {
            user.settings.user.push_n = 1.0;
        }
        scene.users[0].settings.user.pulse_n = 1.0;
    }
    Ok(run::<S>(&scene, Options::unrecorded(duration_s), &|_| {})?)
}

/// Speed at which [`let_go`] sets the first copy moving, m/s.
const LET_GO_M_PER_S: f64 = 0.1;

/// How a scene did with nobody holding it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Released {
    /// No peer stopped, and in the last half the copies had no more energy than they were given.
    pub bounded: bool,
    /// Kinetic energy of the copies at the start, J.
    pub given_j: f64,
    /// The largest in the last half, J.
    pub late_j: f64,
}

/// Runs the scene with the proposal and all that is not linear about it, but released ([`Scene::hands_off`]): copy 1 is set
/// moving along the first axis, and nobody puts in any energy after that.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn let_go<S: Number>(scene: &Scene, proposal: &Proposal, duration_s: f64) -> Result<Released, Error> {
    let scene = proposal.applied(scene)?.hands_off();
    of_axes!(scene, let_go_along::<S>(&scene, duration_s))
}

fn let_go_along<S: Number + Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    scene: &Scene,
    duration_s: f64,
) -> Result<Released, Error> {
    let mut pair = Pair::<S, Plant<N>, SHARED, N>::build(scene)?;
    if let Some(side) = pair.sides_mut().next() {
        // A peer's state begins with position and velocity of its copy.
        let mut numbers = 0;
        side.peer.visit(&mut |number: &mut S| {
            if numbers == 1 {
                *number = S::from_f64(LET_GO_M_PER_S);
            }
            numbers += 1;
        });
    }
    let kinetic_j = |speed: f64| 0.5 * scene.peer.object.mass_kg * speed * speed;
    let (given_j, mut late_j) = (kinetic_j(LET_GO_M_PER_S), 0.0_f64);
    let ticks = (duration_s / scene.peer.timing.control_period_s).round() as u64;
    for tick in 0..ticks {
        pair.step();
        if tick >= ticks / 2 {
            let speeds = pair.sides().into_iter().flat_map(|side| side.peer.observed());
            late_j = late_j.max(speeds.map(|seen| kinetic_j(seen.object.velocity.to_f64())).sum());
        }
    }
    Ok(Released { bounded: pair.fault().is_none() && late_j <= given_j, given_j, late_j })
}

#[cfg(test)]
#[path = "../tests/inside/tune.rs"]
mod tests;
