//! The stiffest object that a round trip allows, without and with the bounder, simulated and by eigenvalues.
//!
//! The paper (eq. 7): the latency of the haptic loop must not exceed 5 to 10 ms for stiff objects, 30 ms for soft ones; and
//! (§2.3) 1000 N/m needs less than 5 ms. All of it is K = b/θ of the device that the second statement identifies
//! (b = 5 N·s/m, [`cohold_analysis::rendering::identify`]): 1000, 500 and 167 N/m for 5, 10 and 30 ms. Two systems show it:
//! contact at the server with an object that hardly moves, and contact at the clients with two users of `SHARED_KG`.
//!
//! **Simulated**: whole worlds ([`super::world`]) are struck once and watched, from half of the closed form upwards in steps
//! of 15 % to the first stiffness that is not stable; bisection closes it in. **By eigenvalues**: every crossing of the
//! sampled map of one device and one object with delay at the places of the paper's Fig. 3, pockets followed
//! ([`cohold_analysis::rendering`]); it shares no code with the worlds. N equal users on one object are N − 1 modes in which
//! it rests and one in which all move alike, as one of them would on an Nth of the object.

use rayon::prelude::*;
use serde::Serialize;

use cohold_analysis::rendering::closed::largest_stiffness;
use cohold_analysis::rendering::maps::{first, stiffness_limit};
use cohold_analysis::rendering::{Body, Renderer, Rendering};

use super::world::World;
use super::{Collision, Setup, bounder};
use crate::Error;

/// Control period of these runs, s: fine against 5 ms.
const PERIOD_S: f64 = 2e-4;

/// Time that a strike is watched, s.
const WATCHED_S: f64 = 4.0;

/// From stiffness to stiffness on the way up in simulation.
const STEP: f64 = 1.15;

/// How closely the stiffest is then found, relative.
const TOLERANCE: f64 = 0.005;

/// What two users share, kg. An undamped object bears no delay above m_o/b, m_o for each user, however soft the contact is
/// ([`cohold_analysis::rendering::closed`]): with the default 0.3 kg that is 30 ms, and nothing would be left there.
const SHARED_KG: f64 = 0.35;

/// Round trips looked at, ms, and what the paper calls the objects that they allow.
const ROUND_TRIPS_MS: [(&str, f64); 3] = [("stiff", 5.0), ("stiff", 10.0), ("soft", 30.0)];

/// The stiffest objects of one round trip, N/m.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stiffest {
    /// What the paper calls them.
    pub kind: &'static str,
    /// Both ways together, ms.
    pub round_trip_ms: f64,
    /// Where contact is computed.
    pub(crate) collision: Collision,
    pub(crate) users: usize,
    /// b/delay, with what the object gives way ([`cohold_analysis::rendering::closed`]).
    pub(crate) closed_form_n_per_m: f64,
    /// Stiffest that is stable in simulation; 0 where half of the closed form is not.
    pub simulated_n_per_m: f64,
    /// First crossing by eigenvalues; 0 where even the softest is not stable.
    pub eigenvalues_n_per_m: f64,
}

/// The setup of one point.
fn setup(stiffness: f64, collision: Collision, round_trip_s: f64) -> Result<Setup, Error> {
    let (users, mass_kg) = match collision {
        Collision::Server => (1, 1000.0),
        Collision::Client => (2, SHARED_KG),
    };
    let ticks = (round_trip_s / PERIOD_S).round() as u32;
    let (up, down) = (ticks / 2, ticks - ticks / 2);
    let keys = [
        format!("timing.control_period_s={PERIOD_S}"),
        format!("contact.stiffness_n_per_m={stiffness}"),
        "contact.damping_n_s_per_m=0".to_owned(),
        format!("network.asymmetry_s={}", f64::from(down - up) * PERIOD_S),
        "safety.max_force_n=200".to_owned(),
        "safety.max_slew_n_per_s=1000000".to_owned(),
        "user.1.pulse_n=0.1".to_owned(),
        "user.1.pulse_s=0.01".to_owned(),
        "user.1.pulse_every_s=1000".to_owned(),
        format!("object.mass_kg={mass_kg}"),
    ];
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    let mut setup = Setup::base(f64::from(up) * PERIOD_S, &keys)?;
    (setup.users, setup.bounder, setup.collision) = (users, false, collision);
    Ok(setup)
}

/// Whether what a strike left dies out: its largest force in the last quarter against the third.
fn dies_out(setup: &Setup, watched_s: f64) -> Result<bool, Error> {
    let mut world = World::new(setup)?;
    let ticks = (watched_s / setup.scene.peer.timing.control_period_s) as u64;
    let mut quarters = [0.0_f64; 4];
    for tick in 0..ticks {
        world.step();
        let quarter = &mut quarters[(4 * tick / ticks) as usize];
        *quarter =
            world.forces().map(f64::abs).fold(*quarter, |a, b| if b.is_finite() { a.max(b) } else { f64::INFINITY });
    }
    // What f32 on the wire rounds to is a few micronewtons, and never dies out.
    let stopped = world.clients().any(|client| client.fault.is_some());
    Ok(!stopped && (quarters[3] <= quarters[2] || quarters[3] < 1e-4))
}

/// The scene of one user among `users` as the analysis sees it, with this round trip, s, and drag of the object for each.
pub fn rendering(setup: &Setup, round_trip_s: f64, drag: f64) -> Rendering {
    let (peer, device) = (&setup.scene.peer, &setup.scene.world.device);
    let (half_s, users, period_s) = (0.5 * round_trip_s, setup.users as f64, peer.timing.control_period_s);
    let delays_s = match setup.collision {
        // The server's force leaves with the next packet.
        Collision::Server => [half_s, half_s + period_s, 0.0, 0.0],
        Collision::Client => [0.0, 0.0, half_s, half_s],
    };
    Rendering {
        device: Body { mass_kg: device.mass_kg, damping_n_s_per_m: device.damping_n_s_per_m },
        object: Some(Body {
            mass_kg: peer.object.mass_kg / users,
            damping_n_s_per_m: peer.object.damping_n_s_per_m / users + drag,
        }),
        contact_damping_n_s_per_m: peer.contact.damping_n_s_per_m,
        period_s,
        computing_ticks: 0.0,
        delays_s,
    }
}

/// The spectral radius of a setup whose bounder has settled on a round trip, s.
///
/// # Errors
/// A setup that cannot be analysed.
pub fn bounded_radius(setup: &Setup, round_trip_s: f64) -> Result<f64, Error> {
    let bound = bounder(&setup.scene).bound(round_trip_s);
    let mut rendering = rendering(setup, round_trip_s, bound.drag);
    rendering.contact_damping_n_s_per_m = bound.damping;
    Ok(Renderer::default().radius(&rendering, bound.stiffness)?)
}

/// The stiffest of the worlds, N/m, looked for around `near`.
fn stiffest_simulated(near: f64, collision: Collision, round_trip_s: f64) -> Result<f64, Error> {
    let stable =
        |stiffness: f64| -> Result<bool, Error> { dies_out(&setup(stiffness, collision, round_trip_s)?, WATCHED_S) };
    let (mut low, mut high) = (0.0, 0.5 * near);
    // A stiffness that a scene refuses ends it at the latest.
    while stable(high)? {
        (low, high) = (high, STEP * high);
    }
    while low > 0.0 && high - low > TOLERANCE * high {
        let middle = low.midpoint(high);
        if stable(middle)? { low = middle } else { high = middle }
    }
    Ok(low)
}

/// The stiffest objects for one round trip (ms), contact computed at `collision`.
///
/// # Errors
/// A setup that cannot be analysed.
pub fn stiffest(kind: &'static str, round_trip_ms: f64, collision: Collision) -> Result<Stiffest, Error> {
    let round_trip_s = 1e-3 * round_trip_ms;
    let setup = setup(1.0, collision, round_trip_s)?;
    let rendering = rendering(&setup, round_trip_s, 0.0);
    let closed_form_n_per_m = largest_stiffness(&rendering);
    Ok(Stiffest {
        kind,
        round_trip_ms,
        collision,
        users: setup.users,
        closed_form_n_per_m,
        simulated_n_per_m: stiffest_simulated(closed_form_n_per_m, collision, round_trip_s)?,
        eigenvalues_n_per_m: first(&stiffness_limit(&rendering)?).unwrap_or(f64::INFINITY),
    })
}

/// All of `ROUND_TRIPS_MS`, contact at the server and at the clients.
///
/// # Errors
/// A setup that cannot be analysed.
pub fn table() -> Result<Vec<Stiffest>, Error> {
    let places = [Collision::Server, Collision::Client];
    let all: Vec<_> = places.into_iter().flat_map(|place| ROUND_TRIPS_MS.map(|(kind, ms)| (kind, ms, place))).collect();
    all.into_par_iter().map(|(kind, ms, place)| stiffest(kind, ms, place)).collect()
}
