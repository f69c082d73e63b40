//! Proof that forces stay within their limits, from the lines that fly.
//!
//! [`Unknown`] is a number type of which only a range is known. A peer is built in it, brought into a state, and then everything it has
//! computed is forgotten but for what the guard itself keeps true: from there one tick runs in every way that it may go
//! ([`mod@prove`]). What holds on every path holds for every number that a board could have been in.
//!
//! | module | holds |
//! |---|---|
//! | [`range`] | ranges of f32 and f64, and what every operation makes of them, to the bit |
//! | [`explore`] | what is known of each number, and both answers to every open question |
//! | [`unknown`](Unknown) | the number type |
//! | [`mod@prove`] | scenes, states and claims; the verdict on each law |
//! | [`whatever`](Whatever) | the law that says anything |

mod graph;
pub mod prove;
pub mod range;
pub mod unknown;
pub mod whatever;

pub use graph::{Path, begin, explore};
pub use prove::{Proved, prove, prove_named};
pub use range::Range;
pub use unknown::{Number, Unknown};
pub use whatever::Whatever;
