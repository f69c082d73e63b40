//! Simulation of two haptic peers on a PC: the scene, devices and users, the network, and the outcome of a run.
//!
//! The peers are those of `cohold_core`, the same code that runs on the board; its page also explains the two papers
//! and THEORY, which comments cite. Everything that a program needs to run scenes is at the root:
//!
//! ```
//! use cohold_sim::{Laws, Options, Pair, Scene, run, scenes};
//!
//! // A built-in scene, run to its outcome …
//! let scene: Scene = scenes::load(Laws::built_in(), "paper-5.2-wave-16ms")?;
//! let outcome = run::<f64>(&scene, Options::default(), &|_| ())?;
//! assert!(outcome.is_stable());
//! // … or tick by tick.
//! let mut pair = Pair::<f64>::new(&scene)?;
//! pair.step();
//! # Ok::<(), cohold_sim::Error>(())
//! ```
//!
//! | for | see |
//! |---|---|
//! | a scene and its built-in ones | [`Scene`], [`scenes`], [`Laws`], [`Family`], [`Error`] |
//! | a run, and what came of it | [`run()`], [`run_while`], [`Options`], [`Outcome`], [`AxisOutcome`], [`Figures`], [`Verdict`], [`Reason`] |
//! | two peers tick by tick | [`Pair`], [`Side`], [`PeerTick`], [`DynPeer`], [`Number`], [`of_axes!`], [`AXES`] |
//! | devices and people | [`Device`], [`device`], [`Plant`], [`User`], [`Trace`] |
//! | a network of one's own | [`Rule`], [`Fate`], [`NetworkTrace`] |
//! | many runs at once | [`lanes`] |
#![forbid(unsafe_code)]

mod choices;
pub mod device;
pub mod double_double;
pub mod engine;
mod error;
pub mod lanes;
pub mod measure;
pub mod network;
pub mod pair;
pub mod peers;
pub mod plant;
#[doc(hidden)]
pub mod quantities;
pub mod rng;
pub mod run;
pub mod scene;
pub mod scenes;
pub mod student;
pub mod user;

pub use cohold_core::device::AXES;
pub use device::Device;
pub use error::Error;
pub use network::rule::{Fate, Rule};
pub use network::trace::NetworkTrace;
pub use pair::{Pair, PeerTick, Side};
pub use peers::{DynPeer, Family, Laws, Number};
pub use plant::Plant;
pub use run::{AxisOutcome, Figures, Options, Outcome, Reason, Verdict, run, run_while};
pub use scene::Scene;
pub use user::{Trace, User};

/// The examples of the page that registries show.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
