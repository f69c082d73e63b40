//! A member that holds a valid key and says what it likes: searched programs against a hub, a peer and a server. At every honest end all
//! numbers stay finite and the force on the hand within `safety.max_force_n` and `safety.max_slew_n_per_s`; around a hub
//! the copy stays below 3·√(2/b)·U = 3·(V + F/b), what a free end makes of the largest wave that it takes
//! ([`cohold_core::law::bounds`]), and the copies come together again.
//!
//! `HOSTILE_PROGRAMS` sets how many programs each of the two large trials makes (10,000 by default), `HOSTILE_SEED` with which they
//! begin.

mod hub;
mod live;
mod peer;
mod program;
mod server;
mod table;

use cohold_sim::scene::Scene;
use cohold_sim::scenes;

/// A number from the environment, or this one.
pub(crate) fn asked(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

pub(crate) fn scene(name: &str, keys: &[&str]) -> Scene {
    let mut scene = scenes::load(cohold_guest_laws::laws(), name).expect("a built-in scene");
    keys.iter().for_each(|key| scene.apply_override(key).expect("a good override"));
    scene.check("the test").expect("a good scene");
    scene
}
