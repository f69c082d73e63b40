//! What a hand feels of a scene: its mass and its drag.

pub mod apparent_mass;
pub mod swing;
