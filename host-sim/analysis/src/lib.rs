//! Stability, computed from the code that flies.
//!
//! | ask | to know |
//! |---|---|
//! | [`judge`] | is this scene stable in every mode that it can enter, and by how much? |
//! | [`verdict`] | and with both hands on, and nothing else: the papers' question |
//! | [`is_linear`] | does a matrix say all of its law? |
//! | [`limit`] | at which values of one key does that change? |
//! | [`map`] | and of two keys? |
//! | [`conclude`] | what is to be said of a run, together with all this? |
//! | [`advice`] | what to change in a scene that is unstable |
//! | [`find`] | both, quickly, while somebody waits, also at delays that were [`measured`] |
//! | [`mod@tune`] | the stiffest contact and coordination that leave a margin |
//! | [`figure4`] | the cooperation paper's Figure 4; [`picture`] draws it, and any map |
//! | [`rendering`] | one device and one object, delay at any of four places: the architectures paper's Figure 4 |
//! | [`answers()`] | what a hand feels, and what comes of it at the far end, frequency by frequency |
//!
//! What is analysed is the linear scene behind a scene ([`cohold_sim::scene::Scene::linear`]): permanent two-sided contact of
//! both hands, of one or of none, exact sensors and motors, nobody pushing, each constant delay that the network can produce.
//! An object that is shared along several axes is judged along all of them at once, as the mass of the device couples them.
//! What a scene has beyond that is named with the judgement ([`Judgement::not_judged`]). Any law is analysed, also one from
//! outside, as long as it is linear.

mod advice;
mod answers;
mod conclusion;
mod delays;
mod direction;
mod error;
mod exponential;
mod family;
pub mod figure4;
mod finding;
mod lifted;
mod limit;
mod linear;
mod map;
mod matrix;
mod modes;
mod outline;
pub mod picture;
pub mod rendering;
mod search;
mod spectrum;
mod sweep;
pub mod tune;
mod verdict;

pub use advice::{Change, MARGIN, advice, change};
pub use answers::answers;
pub use conclusion::{Analysis, Conclusion, conclude};
pub use direction::Direction;
pub use error::Error;
pub use exponential::exponential;
pub use finding::{Finding, Hand, Question, find, measured};
pub use lifted::delay::delays_ticks;
pub use lifted::driven::Response;
pub use lifted::pair::{is_symmetric, pair_matrix};
pub use lifted::{Lifted, Matrix, apply};
pub use limit::{Effort, InMode, Limit, limit};
pub use linear::is_linear;
pub use map::{Axis, Column, Map, map};
pub use modes::{Hands, Judgement, Mode, judge};
pub use sweep::Range;
pub use tune::tune;
pub use verdict::{Analyser, ROUNDING, Verdict, verdict};

#[cfg(test)]
#[path = "../tests/oracle/mod.rs"]
mod oracle;

/// The examples of the page that registries show.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
