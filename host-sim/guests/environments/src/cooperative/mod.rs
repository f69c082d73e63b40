//! Cooperative environment: users push one object at the same time, one dynamics engine (DE) moves it (architectures paper
//! §3.3, Fig. 10; THEORY §6, row 3.3).
//!
//! ```text
//!   device ─ CDE ─┐ push: force      ┌───────────────┐
//!   device ─ CDE ─┼────── up ──────► │ server: DE    │   or the server is a relay and the DE is at the first client
//!   device ─ CDE ─┘ ◄──── down ───── └───────────────┘   or the CDEs are at the server too, and forces come down
//!                     state: motion
//! ```
//!
//! Every device is the software plant, every contact `cohold_core`'s, limits included, the object one of its integrators;
//! every packet goes through the scene's network, with its own fate; round trips are measured by the protocol's clock, and
//! who has the engine is decided by the protocol's cooperative role. Time is in ticks: packets that arrive at tick n are
//! taken in before the forces of tick n, forces that arrive at tick n act from n on.

pub mod bounder;
pub mod client;
mod engine;
pub mod hub;
pub mod junction;
pub mod lifted;
pub mod limits;
pub mod node;
mod packet;
pub mod run;
pub mod waves;
pub mod world;

use bounder::Bounder;
use cohold_core::names::Choice;
use cohold_sim::scene::Scene;

/// Largest number of users.
pub const MOST_USERS: usize = 16;

/// What bounds the contact of the users of a scene.
fn bounder(scene: &Scene) -> Bounder<f64> {
    let (contact, damping) = (&scene.peer.contact, scene.world.device.damping_n_s_per_m);
    Bounder::new(contact.stiffness_n_per_m, contact.damping_n_s_per_m, damping, scene.peer.timing.control_period_s)
}

/// Where contact is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Collision {
    /// Every client computes its own contact with the object as it last heard of it.
    #[default]
    Client,
    /// The server computes every contact with the devices as it last heard of them; forces come back.
    Server,
}

/// Where the object is moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// The engine stays at the server.
    #[default]
    Server,
    /// At the server, from a quarter to three quarters of the run at the first client.
    Moves,
    /// At the first client as soon as it has it.
    Client,
}

impl Choice for Collision {
    const NAMES: &'static [&'static str] = &["client", "server"];
    const ALL: &'static [Self] = &[Self::Client, Self::Server];
}

impl Choice for Engine {
    const NAMES: &'static [&'static str] = &["server", "moves", "client"];
    const ALL: &'static [Self] = &[Self::Server, Self::Moves, Self::Client];
}

/// Scene and settings of a cooperative environment.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Devices, contact, object, network, and two users whose profiles alternate.
    pub scene: Scene,
    /// Number of users of the environment.
    pub users: usize,
    /// Stiffness and damping follow the measured round trip.
    pub bounder: bool,
    /// Where contact is computed.
    pub collision: Collision,
    /// Where the object is moved.
    pub engine: Engine,
}

impl Setup {
    /// Keys that a cooperative environment starts from instead of the defaults: one packet each tick, prompt forces.
    pub const BASE: [&str; 6] = [
        "timing.ticks_per_packet=1",
        "network.one_way_delay_packets=0",
        "device.force_delay_ticks=0",
        "device.damping_n_s_per_m=5",
        "object.force_delay_ticks=0",
        "object.integrator=exact",
    ];

    /// Two users in this scene, engine and bounder at the server and on.
    pub fn new(scene: Scene) -> Self {
        Self { scene, users: 2, bounder: true, collision: Collision::default(), engine: Engine::default() }
    }

    /// The base scene with this delay of every packet to or from the server, s, and these keys.
    ///
    /// # Errors
    /// A key that does not exist, or a value that it does not accept.
    pub fn base(one_way_s: f64, keys: &[&str]) -> Result<Self, crate::Error> {
        let delay = format!("network.extra_delay_s={one_way_s}");
        let keys: Vec<String> =
            Self::BASE.iter().chain(&[delay.as_str()]).chain(keys).map(|key| (*key).to_owned()).collect();
        Ok(Self::new(Scene::load(cohold_sim::Laws::built_in(), None, &keys)?))
    }
}
