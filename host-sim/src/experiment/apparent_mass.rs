//! How heavy the shared object feels: what both hands push against when they move it together.
//!
//! A wave line of impedance b and transit time T is itself an inertia of about b·T (THEORY §4), so a shared object weighs
//! more than its copies. Measured, not derived: both users push the same way with a slow ramp, on which every linear
//! scene settles at a constant acceleration; the sum of the contact forces, less what the copies' damping takes, over
//! that acceleration is the mass. Forces are tiny, so that no limit is touched.

use haptic_core::settings::Refused;

use crate::harness::Pair;
use crate::scene::SceneFile;

/// Ramp of each user's push, N/s.
const RAMP_N_PER_S: f64 = 1e-3;

/// Apparent mass of the whole shared object, kg. Meaningful for a stable scene in contact; NaN where nothing moves.
///
/// # Errors
/// What the peers' `build()` refuses.
pub fn measure(scene: &SceneFile) -> Result<f64, Refused<'static>> {
    let mut linear = scene.linear();
    let device = &scene.world.device;
    // Slowest time constant of the free pair: the terminal velocity of everything that moves.
    let mass = 2.0 * (device.mass_kg + scene.peer.object.mass_kg) + 1.0;
    let damping = 2.0 * (device.damping_n_s_per_m + scene.peer.object.damping_n_s_per_m);
    let settle_s = if damping > 0.0 { (8.0 * mass / damping).clamp(2.0, 60.0) } else { 10.0 };
    let period_s = scene.peer.timing.control_period_s;
    linear.users = ramps(settle_s + 1.0);
    let mut pair = Pair::<f64>::new(&linear)?;
    let ticks = (settle_s / period_s) as u64;
    // A whole number of packets, a second or more: the staircase of the line averages out.
    let window = u64::from(scene.peer.timing.ticks_per_packet) * 125;
    let mut force = 0.0;
    let mut speeds = [0.0; 2];
    for tick in 0..ticks + window {
        pair.step();
        if tick + 1 == ticks {
            speeds[0] = speed(&pair);
        }
        if tick >= ticks {
            force += pair.sides.iter().map(|side| side.state.observed().contact_force).sum::<f64>();
            force -= 2.0 * scene.peer.object.damping_n_s_per_m * speed(&pair);
        }
    }
    speeds[1] = speed(&pair);
    let acceleration = (speeds[1] - speeds[0]) / (window as f64 * period_s);
    Ok(force / window as f64 / acceleration)
}

fn speed(pair: &Pair<f64>) -> f64 {
    pair.sides.iter().map(|side| side.state.observed().object.velocity).sum::<f64>() / 2.0
}

/// Both users push toward positive x: user 2 away from the other peer.
fn ramps(until_s: f64) -> [crate::user::User; 2] {
    [1.0, -1.0].map(|sign| crate::user::User {
        settings: crate::user::UserSettings::default(),
        trace: Some(crate::user::Trace::line(until_s, sign * RAMP_N_PER_S * until_s)),
    })
}
