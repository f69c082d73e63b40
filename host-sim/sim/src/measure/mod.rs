//! What is measured of a run: means, and what a hand feels of a scene, its mass and its drag.

pub mod apparent_mass;
mod statistics;
pub mod swing;

pub use statistics::{LastHalf, Statistics};
