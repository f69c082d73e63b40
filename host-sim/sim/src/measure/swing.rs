//! What a slow swing shows: how heavy the shared object feels and how late one peer acts on the other, on any network.
//!
//! Both users push the same way with a sine of one period a second. Every signal is projected on that sine over whole
//! periods, which leaves the losses' noise out: the ratio of contact force to speed of the copies is a mass (its imaginary part
//! over ω) and a drag (its real part); the phase between what one peer sends and what the other acts on, over ω, is a time,
//! whatever a ledger or a fading took off its size. Low enough that springs and filters are far away: a delay is a delay.
//!
//! [`super::apparent_mass`] gives the same mass at rest, for scenes that are linear.

use cohold_core::{law::Sends, settings::Refused};

use super::impedance::Complex;
use crate::{pair::Pair, scene::Scene, user::User};

/// Angular frequency, rad/s: one period a second.
const OMEGA: f64 = core::f64::consts::TAU;
const PUSH_N: f64 = 0.5;
/// Time for what the start of the swing leaves to die away, s.
const SETTLE_S: u32 = 10;

/// What the hands feel of the shared object in a slow swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Apparent mass of the whole shared object, kg.
    pub mass_kg: f64,
    /// Drag that the hands feel, N·s/m.
    pub drag_n_s_per_m: f64,
    /// Delay from a tick of one peer to the tick of the other that acts on it, mean of both ways, s.
    pub delay_s: f64,
}

/// Swings a scene with permanent contact for `periods` periods of 1 s, after it has settled.
///
/// # Errors
/// The first key of the scene that is out of range or impossible beside the others.
pub fn felt(scene: &Scene, periods: u32) -> Result<Felt, Refused<'static>> {
    let mut swung = scene.clone();
    for (user, sign) in swung.users.iter_mut().zip([1.0, -1.0]) {
        // A push of user 2 toward the other peer is toward negative x.
        *user = User::default();
        user.settings.user.sine_n = sign * PUSH_N;
        user.settings.user.sine_rad_per_s = OMEGA;
    }
    let mut pair = Pair::<f64>::new(&swung)?;
    let per_period = (1.0 / scene.peer.timing.control_period_s).round() as u32;
    for _ in 0..SETTLE_S * per_period {
        pair.step();
    }
    let sends = scene.law().sends;
    let share = 1.0 / scene.peer.coordination.wave_impedance_n_s_per_m;
    // A signal is the real part of z·e^(iωt).
    let mut phasors = [Complex::default(); 4];
    for _ in 0..periods * per_period {
        let turn = Complex::cis(OMEGA * pair.time_s()).conj();
        pair.step();
        for seen in pair.sides().into_iter().map(|side| side.peer.observed()[0]) {
            // What a law sends and acts on: positions, or waves in units of speed, u·√(2/b) (THEORY §2).
            let (out, into) = match sends {
                Sends::Motion => (seen.object.position, seen.desired.position),
                _ => {
                    let (speed, force) = (seen.desired.velocity, share * seen.coordination_force);
                    (speed - force, speed + force)
                }
            };
            let values = [seen.contact_force, seen.object.velocity / 2.0, out, into];
            phasors.iter_mut().zip(values).for_each(|(phasor, value)| *phasor += turn * value);
        }
    }
    let [force, speed, sent, acted_on] = phasors;
    let (felt, late) = (force / speed, acted_on / sent);
    Ok(Felt { mass_kg: felt.im / OMEGA, drag_n_s_per_m: felt.re, delay_s: -late.arg() / OMEGA })
}
