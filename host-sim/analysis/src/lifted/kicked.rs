//! How fast what a kick leaves dies away or grows, for a line that goes on holding still now and then.
//!
//! An end that has no sample for one tick of each round trip, say, repeats itself after a round trip and not after a packet, and what it
//! remembers while it holds still no state vector visits. So the pair itself runs on its network: at rest until its rhythm is that of
//! the end, then kicked by next to nothing ([`super::driven`] says why no limit acts), and its forces are followed. In a window of
//! time they have a size. The slope of its logarithm over the second half of all windows (least squares) is that of the largest |eigenvalue|. Speeds count as forces of a drag, and a place has neither.
//!
//! **Exact to** 2 % of the slope (`tests/suite/reached.rs`). A slope that adds up to less than [`SMALL`] is none: a pair that glides on
//! has it.

use haptic_core::settings::Refused;
use haptic_sim::of_axes;
use haptic_sim::pair::Pair;
use haptic_sim::peers::Builds;
use haptic_sim::plant::Plant;
use haptic_sim::scene::Scene;
use haptic_sim::user::User;

use super::delay::delays_ticks;
use super::driven::UNIT;

/// For how long the pair rests first, s and round trips: a line is made shorter once a second, and learns a delay in a few round trips.
const RESTS: (f64, usize) = (4.0, 64);

/// A window, s and round trips, within so many ticks, and how many there are.
const WINDOW: (f64, usize) = (0.25, 4);
const WINDOW_TICKS: [usize; 2] = [512, 8192];
const WINDOWS: usize = 64;

/// A speed counts as the force that this drag has, N·s/m.
const DRAG: f64 = 10.0;

/// What is this much smaller than at first, is rounding; what is this much larger, has told enough.
const RANGE: [f64; 2] = [1e-11, 1e60];

/// Growth over the second half that is none, as a logarithm.
const SMALL: f64 = 0.02;

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
    of_axes!(scene, radius_of(&scene))
}

fn radius_of<const SHARED: usize, const N: usize>(scene: &Scene) -> Result<Option<f64>, Refused<'static>>
where
    f64: Builds<SHARED, N>,
{
    let timing = &scene.peer.timing;
    let round_trip = delays_ticks(scene).iter().sum::<usize>() + timing.ticks_per_packet as usize;
    let ticks = |(seconds, trips): (f64, usize)| (trips * round_trip).max((seconds / timing.control_period_s) as usize);
    let mut pair = Pair::<f64, Plant<N>, SHARED, N>::build(scene)?;
    (0..ticks(RESTS)).for_each(|_| pair.step());
    if !pair.sides().iter().all(|side| side.peer.is_engaged()) {
        return Ok(None);
    }
    // Any numbers do that are not alike.
    let mut kick = 0.0;
    for side in pair.sides_mut() {
        side.peer.visit_state(&mut |number| {
            kick = (kick + 0.618) % 1.0;
            *number += kick * UNIT;
        });
    }
    let window = ticks(WINDOW).clamp(WINDOW_TICKS[0], WINDOW_TICKS[1]);
    let mut sizes: Vec<f64> = Vec::new();
    for _ in 0..WINDOWS {
        let mut sum = 0.0;
        for _ in 0..window {
            pair.step();
            let seen = pair.sides().into_iter().flat_map(|side| side.peer.observed());
            let forces =
                seen.flat_map(|seen| [seen.coordination_force, seen.contact_force, DRAG * seen.object.velocity]);
            sum += forces.map(|force| (force / UNIT).powi(2)).sum::<f64>();
        }
        sizes.push(0.5 * sum.ln());
        let of_first = (sizes[sizes.len() - 1] - sizes[0]).exp();
        if !(RANGE[0]..RANGE[1]).contains(&of_first) {
            break;
        }
    }
    let last = &sizes[(sizes.len() - 1) / 2..];
    let middle = 0.5 * (last.len() - 1) as f64;
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        (0..).zip(last).map(|(at, size)| of(f64::from(at) - middle, *size)).sum()
    };
    let slope = sum(&|at, size| at * size) / sum(&|at, _| at * at).max(1.0);
    let slope = if (0.0..SMALL).contains(&(2.0 * middle * slope)) { 0.0 } else { slope };
    Ok(Some((slope * f64::from(timing.ticks_per_packet) / window as f64).exp()))
}
