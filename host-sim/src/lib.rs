//! The command line around `haptic-sim` and `haptic-analysis`: live peers, the studies that papers and documents print, the
//! shared environments, and what tries them. The peers themselves are `haptic_core`, the same lines that fly on the board.
#![forbid(unsafe_code)]

mod cli;
pub mod live;
mod play;
pub mod recording;
pub mod shared;
pub mod studies;
pub mod trials;

pub use cli::{Cli, made};
