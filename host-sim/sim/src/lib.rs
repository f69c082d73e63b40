//! A run on a PC: the scene, the software plant, the network, two peers stepped together, and the outcome.
//!
//! The peers themselves are `haptic_core`, the same lines that fly on the board.
#![forbid(unsafe_code)]

pub mod double_double;
pub mod engine;
mod error;
pub mod key_file;
pub mod lanes;
pub mod measure;
pub mod network;
pub mod node;
pub mod pair;
pub mod peers;
pub mod plant;
pub mod quantities;
pub mod rng;
pub mod run;
pub mod scene;
pub mod scenes;
pub mod student;
pub mod user;

pub use error::Error;
pub use haptic_core::device::AXES;
pub use peers::{DynPeer, Family, Laws, Number};
pub use scene::Scene;
