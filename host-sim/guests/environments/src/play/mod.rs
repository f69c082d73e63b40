//! The shared environments that a page can show ([`PLAYABLE`]).

mod hub;
mod squash;
mod turns;
mod visit;

use cohold_live::playable::{Column, Open, PERIOD_S, Playable, route};
use cohold_sim::engine::{Actor, Engine, Seat};
use cohold_sim::scene::Scene;
use serde_json::{Value, json};

use hub::Hub;
use squash::Squash;
use turns::Turns;
use visit::Visit;

/// The environments of this guest.
pub(crate) static PLAYABLE: [Playable; 5] = [
    Playable { axes: Some(1), ..of("hub", &hub::COLUMNS, |scene| Ok(Box::new(Hub::open(scene)?))) },
    Playable {
        more: || json!({ "size_m": squash::size(), "pointer": squash::POINTER }),
        ..of("squash", &squash::COLUMNS, |scene| Ok(Box::new(Squash::open(scene))))
    },
    Playable { more: visit::outlines, ..of("world", &visit::COLUMNS, |scene| Ok(Box::new(Visit::open(scene)?))) },
    of("lock", &turns::COLUMNS, |scene| Ok(Box::new(Turns::<true>::open(scene)?))),
    of("ring", &turns::COLUMNS, |scene| Ok(Box::new(Turns::<false>::open(scene)?))),
];

/// An environment that a page draws without knowing more.
const fn of(name: &'static str, columns: &'static [Column], open: Open) -> Playable {
    Playable { name, axes: None, columns, more: || Value::Null, open }
}

/// These ends, with the scene's network between them.
fn engine<A: Actor<usize>>(scene: &Scene, seats: Vec<Seat<A>>) -> Engine<A> {
    Engine::new((1e9 * PERIOD_S) as u64, seats, |from, to| route(scene, from, to))
}

#[cfg(test)]
#[path = "../../tests/inside/play.rs"]
mod tests;
