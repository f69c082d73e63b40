//! How heavy the shared object feels: what both hands push against when they move it together.
//!
//! A wave line of impedance b and transit time T is itself an inertia of about b·T (THEORY §4), so a shared object weighs
//! more than its copies. Measured, not derived: both users push the same way with a slow ramp, on which every linear
//! scene settles to a velocity that grows steadily; the sum of the contact forces is then m·a + c·v, a straight line over
//! v whose intercept is the mass times the acceleration and whose slope c is the drag (the copies' damping, and what a
//! delayed power-domain coupling adds). Forces are tiny, so that no limit is touched.

use cohold_core::settings::Refused;

use crate::user::{Trace, User};
use crate::{of_axes, pair::Pair, peers::Builds, plant::Plant, scene::Scene};

const RAMP_N_PER_S: f64 = 1e-3;

/// Apparent mass of the whole shared object, kg. Meaningful for a stable scene in contact; NaN where nothing moves.
/// Of an object that is shared along several axes, along the first.
///
/// # Errors
/// The first key whose value is out of range or impossible beside the others.
pub fn measure(scene: &Scene) -> Result<f64, Refused<'static>> {
    of_axes!(scene, measured(scene))
}

fn measured<const SHARED: usize, const N: usize>(scene: &Scene) -> Result<f64, Refused<'static>>
where
    f64: Builds<SHARED, N>,
{
    let mut linear = scene.linear();
    let device = &scene.world.device;
    // Slowest time constant of the free pair: the terminal velocity of everything that moves.
    let mass = 2.0 * (device.mass_kg + scene.peer.object.mass_kg) + 1.0;
    let damping = 2.0 * (device.damping_n_s_per_m + scene.peer.object.damping_n_s_per_m);
    let settle_s = if damping > 0.0 { (8.0 * mass / damping).clamp(2.0, 60.0) } else { 10.0 };
    let period_s = scene.peer.timing.control_period_s;
    let ticks = (settle_s / period_s) as u64;
    // Whole packets: the staircase of the line averages out.
    let window = u64::from(scene.peer.timing.ticks_per_packet) * 125;
    ramp(&mut linear, (ticks + 2 * window) as f64 * period_s);
    let mut pair = Pair::<f64, Plant<N>, SHARED, N>::build(&linear)?;
    for _ in 0..ticks {
        pair.step();
    }
    // Two windows, one after the other: force and speed of each, averaged.
    let [(f0, v0), (f1, v1)] = [(); 2].map(|()| {
        let (mut force, mut speed) = (0.0, 0.0);
        for _ in 0..window {
            pair.step();
            for seen in pair.sides().into_iter().map(|side| side.peer.observed()[0]) {
                force += seen.contact_force / window as f64;
                speed += seen.object.velocity / 2.0 / window as f64;
            }
        }
        (force, speed)
    });
    let (acceleration, drag) = ((v1 - v0) / (window as f64 * period_s), (f1 - f0) / (v1 - v0));
    Ok(((f0 + f1) - drag * (v0 + v1)) / 2.0 / acceleration)
}

/// Both users push toward positive x, user 2 away from the other peer, harder and harder.
fn ramp(scene: &mut Scene, until_s: f64) {
    for (user, sign) in scene.users.iter_mut().zip([1.0, -1.0]) {
        *user = User { trace: Some(Trace::line(until_s, sign * RAMP_N_PER_S * until_s)), ..User::default() };
    }
}
