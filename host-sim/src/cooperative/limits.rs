//! The longest round trip that a stiffness bears, without and with the bounder, simulated and by eigenvalues.
//!
//! The paper (eq. 7): the latency of the haptic loop must not exceed 5 to 10 ms for stiff objects, 30 ms for soft ones; and
//! (§2.3) 1000 N/m needs less than 5 ms. All of it is K = b/θ of the device that the second statement identifies
//! (b = 5 N·s/m, [`crate::analysis::rendering::identify`]): 1000, 500 and 167 N/m for 5, 10 and 30 ms. Two systems show it:
//! contact at the server with an object that hardly moves, and contact at the clients with two users of 0.3 kg.
//!
//! **Simulated**: whole worlds ([`super::world`]) are struck once and watched; the longest round trip is closed in by
//! bisection over whole ticks of 0.2 ms. **By eigenvalues**: the sampled map of one device and one object with delay at the
//! places of the paper's Fig. 3 ([`crate::analysis::rendering`]), which shares no code with it. N equal users on one object
//! are N − 1 modes in which it rests and one in which all move alike, as one of them would on an Nth of the object.

use serde::Serialize;

use super::world::{World, WorldError};
use super::{Collision, Setup};
use crate::analysis::AnalysisError;
use crate::analysis::rendering::{Body, Renderer, Rendering};
use crate::scene::SceneError;
use haptic_core::render::bounder::Bounder;

/// Control period of these runs, s: fine against 5 ms.
pub const PERIOD_S: f64 = 2e-4;

/// Time that a strike is watched, s.
const WATCHED_S: f64 = 4.0;

/// Stiffnesses looked at, N/m, and what the paper calls them.
pub const STIFFNESSES: [(&str, f64); 3] = [("stiff", 1000.0), ("stiff", 500.0), ("soft", 500.0 / 3.0)];

/// The longest round trips of one stiffness.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Longest {
    /// What the paper calls it.
    pub kind: &'static str,
    /// N/m.
    pub stiffness_n_per_m: f64,
    /// Where contact is computed.
    pub collision: Collision,
    /// Its users.
    pub users: usize,
    /// b/K, ms.
    pub closed_form_ms: f64,
    /// Longest stable round trip in simulation, ms.
    pub simulated_ms: f64,
    /// The same by eigenvalues, ms.
    pub eigenvalues_ms: f64,
}

/// What may go wrong.
#[derive(Debug, thiserror::Error)]
pub enum LimitError {
    /// In the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// In the world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// In the analysis.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}

/// Longest round trip looked at, ticks: 60 ms.
const MOST_TICKS: u32 = 300;

/// The setup of one point: delay in ticks, there and back together.
fn setup(stiffness: f64, collision: Collision, ticks: u32) -> Result<Setup, SceneError> {
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
    ];
    let mut keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    let users = match collision {
        Collision::Server => {
            keys.push("object.mass_kg=1000");
            1
        }
        Collision::Client => 2,
    };
    let mut setup = Setup::base(f64::from(up) * PERIOD_S, &keys)?;
    (setup.users, setup.bounder, setup.collision) = (users, false, collision);
    Ok(setup)
}

/// Whether what a strike left dies out: its largest force in the last quarter against the third.
///
/// # Errors
/// What the world refuses.
pub fn dies_out(setup: &Setup, watched_s: f64) -> Result<bool, WorldError> {
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
/// Eigenvalues that do not converge.
pub fn bounded_radius(setup: &Setup, round_trip_s: f64) -> Result<f64, AnalysisError> {
    let (peer, device) = (&setup.scene.peer, &setup.scene.world.device);
    let (contact, period_s) = (&peer.contact, peer.timing.control_period_s);
    let bounder =
        Bounder::<f64>::new(contact.stiffness_n_per_m, contact.damping_n_s_per_m, device.damping_n_s_per_m, period_s);
    let bound = bounder.bound(round_trip_s);
    let mut rendering = rendering(setup, round_trip_s, bound.drag);
    rendering.contact_damping_n_s_per_m = bound.damping;
    Renderer::default().radius(&rendering, bound.stiffness)
}

/// The largest number of ticks for which `stable` holds from 1 on, by bisection.
fn longest<E>(mut stable: impl FnMut(u32) -> Result<bool, E>) -> Result<u32, E> {
    let (mut low, mut high) = (0, MOST_TICKS);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if stable(middle)? { low = middle } else { high = middle }
    }
    Ok(low)
}

/// The longest round trip for one stiffness (N/m), contact computed at `collision`.
///
/// # Errors
/// What world and analysis refuse.
pub fn longest_round_trip(kind: &'static str, stiffness: f64, collision: Collision) -> Result<Longest, LimitError> {
    let simulated = longest(|ticks| -> Result<bool, LimitError> {
        Ok(dies_out(&setup(stiffness, collision, ticks)?, WATCHED_S)?)
    })?;
    let mut renderer = Renderer::default();
    let eigenvalues = longest(|ticks| -> Result<bool, LimitError> {
        let setup = setup(stiffness, collision, ticks)?;
        let radius = renderer.radius(&rendering(&setup, f64::from(ticks) * PERIOD_S, 0.0), stiffness)?;
        Ok(radius <= 1.0 + 1e-9)
    })?;
    let Setup { scene, users, .. } = setup(stiffness, collision, 1)?;
    let damping = scene.world.device.damping_n_s_per_m;
    let ms = |ticks: u32| 1e3 * PERIOD_S * f64::from(ticks);
    Ok(Longest {
        kind,
        stiffness_n_per_m: stiffness,
        collision,
        users,
        closed_form_ms: 1e3 * damping / stiffness,
        simulated_ms: ms(simulated),
        eigenvalues_ms: ms(eigenvalues),
    })
}

/// All of [`STIFFNESSES`], contact at the server and at the clients.
///
/// # Errors
/// What world and analysis refuse.
pub fn table() -> Result<Vec<Longest>, LimitError> {
    let places = [Collision::Server, Collision::Client];
    let all = places.into_iter().flat_map(|place| STIFFNESSES.map(|(kind, stiffness)| (kind, stiffness, place)));
    all.map(|(kind, stiffness, place)| longest_round_trip(kind, stiffness, place)).collect()
}
