//! Shared environments for a page ([`Playable`]). The page and the guests that declare them depend on this file, and not on each other.

use std::fmt;

use cohold_core::safety::Mode;
use cohold_sim::network::{link::Route, rule::Direction};
use cohold_sim::scene::Scene;
use serde_json::Value;

/// Control period, s. The page keeps real time.
pub const PERIOD_S: f64 = 0.001;

/// Most columns of an environment.
pub const MOST_COLUMNS: usize = 56;

/// Name, unit and meaning of a number in a sample.
pub type Column = (&'static str, &'static str, &'static str);

/// An environment that a page can show.
pub struct Playable {
    /// The name by which it is chosen.
    pub name: &'static str,
    /// Along how many axes its peers share an object, if it cannot share it along as many as a scene says.
    pub axes: Option<u32>,
    /// The numbers of a sample, at most [`MOST_COLUMNS`].
    pub columns: &'static [Column],
    /// More values for the page to draw it.
    pub more: fn() -> Value,
    /// Opens it at rest, in a scene.
    pub open: Open,
}

/// Opens an environment, or says why this scene does not allow it.
pub type Open = fn(&Scene) -> Result<Box<dyn Play>, Box<dyn std::error::Error + Send + Sync>>;

impl fmt::Debug for Playable {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name)
    }
}

impl PartialEq for Playable {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// The holder of a hand, and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// A bot or nobody.
    ByNobody,
    /// A person who has released it.
    Free,
    /// A person with the pointer here, m.
    At([f64; 2]),
}

/// An environment that is played.
pub trait Play {
    /// Sets the holder of a hand for the next tick. Persons can hold hands 0 and 1.
    fn hold(&mut self, hand: usize, held: Held);

    /// Position of the device of a hand, m, if a model of a person is to hold it while no person does.
    fn device(&self, _hand: usize) -> Option<f64> {
        None
    }

    /// Steps the environment by one tick.
    fn step(&mut self);

    /// The numbers of its columns.
    fn numbers(&self, number: &mut dyn FnMut(f64));

    /// Number of ends of its network.
    fn seats(&self) -> usize;

    /// The network from one end to another. A page changes it at any time.
    fn route(&mut self, from: usize, to: usize) -> &mut Route;

    /// The end of hand 1. A page can cut its line.
    fn seat(&self) -> usize {
        1
    }

    /// Whether it is over and is to be restarted.
    fn is_over(&self) -> bool {
        false
    }

    /// Modes of the first two peers.
    fn modes(&self) -> [Mode; 2] {
        [Mode::Armed; 2]
    }
}

/// The scene's network from one end to another. Each direction has a separate stream of random numbers.
pub fn route(scene: &Scene, from: usize, to: usize) -> Route {
    let direction = if from < to { Direction::OneToTwo } else { Direction::TwoToOne };
    Route::of_scene(scene, direction, (16 * from + to) as u32)
}
