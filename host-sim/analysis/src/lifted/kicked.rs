//! How fast a kicked pair settles or grows, where no matrix says all of it: a line that pauses now and then, a law that keeps silent on purpose, is
//! not linear, or learns.
//!
//! An end that has no sample for one tick of each round trip, say, repeats itself after a round trip and not after a packet, and what it
//! remembers while it pauses no state vector visits. So the pair itself runs on its network: at rest until its rhythm is that of
//! the end, then kicked by next to nothing ([`super::driven`] says why no limit acts). In each window of time the differences of its forces from
//! those at the end of the window before have a size: a constant force hides nothing. The slope of its logarithm over the second half of all
//! windows (least squares) is that of the largest |eigenvalue|. While the slope is not clear, the run goes on: a slow growth shows when all else
//! has died away. Speeds count as forces of a drag, and a place has neither.
//!
//! **Not linear.** Such a law has no eigenvalues: its run tells that it grows, or else gives a radius of 0. A swing may jump and yet settle, so
//! the run ends when it has become small ([`SETTLED`]). A law that learns is kicked so hard that it learns ([`LEARNS_UNIT`]), and its account is
//! never short.
//!
//! **Exact to** 2 % of the slope (`tests/suite/reached.rs`). A slope below [`SLOW_PER_S`] is none: a pair that glides on has it, and a line that
//! is made longer or shorter by a tick now and then has a swing that wanders by a factor of four.

use cohold_core::settings::{PLENTY_J, Refused};
use cohold_sim::of_axes;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Builds;
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;
use cohold_sim::user::User;

use super::delay::delays_ticks;
use super::driven::{UNIT, counts, keeps_silent};

/// For how long the pair rests first, s and round trips: a line is made shorter once a second, and learns a delay in a few round trips.
const RESTS: (f64, usize) = (4.0, 64);

/// A window, s and round trips, within so many ticks, and how many there are at first and at most.
const WINDOW: (f64, usize) = (0.25, 4);
const WINDOW_TICKS: [usize; 2] = [512, 8192];
const WINDOWS: [usize; 2] = [64, 256];

/// A speed counts as the force that this drag has, N·s/m.
const DRAG: f64 = 10.0;

/// A run is over when it is this much smaller than at first, or larger, as a logarithm.
const ENOUGH: [f64; 2] = [-25.0, 14.0];

/// A law that is not linear has settled when its run is this much smaller than it was, as a logarithm.
const SETTLED: f64 = 3.0;

/// Forces that take more than ten minutes to become e times as large do not grow, 1/s.
const SLOW_PER_S: f64 = 1.0 / 600.0;

/// Growth over the second half that is clear, as a logarithm.
const CLEAR: f64 = 2.0;

/// A unit of the states of a law that learns: forces of newtons, well above the noise that such a law allows for.
const LEARNS_UNIT: f64 = 1e-3;

/// By which factor forces change in a packet period at the end, in a linear scene whose hands are on or `released`; none where the peers do
/// not act on each other.
pub(crate) fn radius(linear: &Scene, released: [bool; 2]) -> Result<Option<f64>, Refused<'static>> {
    let mut scene = linear.clone();
    for end in (0..2).filter(|end| released[*end]) {
        scene.users[end] = User::default();
        for key in ["stiffness_n_per_m", "damping_n_s_per_m"] {
            // 0 is allowed.
            let _ = scene.set_number(&format!("peer.{}.contact.{key}", end + 1), 0.0);
        }
    }
    if linear.law().learns {
        for budget in linear.law().budgets() {
            // It learns only if its account is below this limit.
            let _ = scene.set_number(budget.name, 0.5 * PLENTY_J);
        }
    }
    of_axes!(scene, radius_of(&scene))
}

fn radius_of<const SHARED: usize, const N: usize>(scene: &Scene) -> Result<Option<f64>, Refused<'static>>
where
    f64: Builds<SHARED, N>,
{
    let timing = &scene.peer.timing;
    let round_trip = delays_ticks(scene).iter().sum::<usize>() + timing.ticks_per_packet as usize;
    let ticks = |(seconds, trips): (f64, usize)| (trips * round_trip).max((seconds / timing.control_period_s) as usize);
    // The others have no rhythm, and no slope that lasts.
    let is_linear = counts(scene) || keeps_silent(scene);
    let unit = if scene.law().learns { LEARNS_UNIT } else { UNIT };
    let mut pair = Pair::<f64, Plant<N>, SHARED, N>::build(scene)?;
    (0..ticks(if is_linear { RESTS } else { (0.0, 2) })).for_each(|_| pair.step());
    if !pair.sides().iter().all(|side| side.peer.is_engaged()) {
        return Ok(None);
    }
    // Any numbers do that are not alike.
    let mut kick = 0.0;
    for side in pair.sides_mut() {
        side.peer.visit_state(&mut |number| {
            kick = (kick + 0.618) % 1.0;
            *number += kick * unit;
        });
    }
    let window = ticks(WINDOW).clamp(WINDOW_TICKS[0], WINDOW_TICKS[1]);
    let window_s = window as f64 * timing.control_period_s;
    let (mut sizes, mut windows, mut largest) = (Vec::<f64>::new(), WINDOWS[0], f64::NEG_INFINITY);
    let (mut from, mut now) = (vec![0.0; 6 * SHARED], Vec::with_capacity(6 * SHARED));
    let slope = loop {
        // At rest there is no logarithm.
        let mut sum = f64::MIN_POSITIVE;
        for _ in 0..window {
            pair.step();
            let seen = pair.sides().into_iter().flat_map(|side| side.peer.observed());
            now.clear();
            now.extend(seen.flat_map(|seen| {
                [seen.coordination_force, seen.contact_force, DRAG * seen.object.velocity].map(|force| force / unit)
            }));
            sum += now.iter().zip(&from).map(|(now, from)| (now - from).powi(2)).sum::<f64>();
        }
        if is_linear {
            std::mem::swap(&mut now, &mut from);
        }
        // A window over a long delay may have room for all that there is up to a limit.
        if pair.fault().is_some() || sum.is_nan() || sum == f64::INFINITY {
            return Ok(Some(f64::INFINITY));
        }
        let size = 0.5 * sum.ln();
        sizes.push(size);
        largest = largest.max(size);
        let last = &sizes[(sizes.len() - 1) / 2..];
        let middle = 0.5 * (last.len() - 1) as f64;
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            (0..).zip(last).map(|(at, size)| of(f64::from(at) - middle, *size)).sum()
        };
        let slope = sum(&|at, size| at * size) / sum(&|at, _| at * at).max(1.0);
        let growth = 2.0 * middle * slope;
        if !is_linear && size < largest - SETTLED {
            break f64::NEG_INFINITY;
        }
        if !(ENOUGH[0]..ENOUGH[1]).contains(&(size - sizes[0])) {
            break slope;
        }
        if sizes.len() == windows {
            if growth.abs() > CLEAR || windows == WINDOWS[1] || !is_linear {
                break if (0.0..SLOW_PER_S * window_s).contains(&slope) { 0.0 } else { slope };
            }
            windows *= 2;
        }
    };
    let grows_by = (slope * f64::from(timing.ticks_per_packet) / window as f64).exp();
    Ok(Some(if is_linear || grows_by > 1.0 { grows_by } else { 0.0 }))
}
