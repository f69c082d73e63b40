//! The faces: the command line, the page, and what tries peers and servers over real sockets. The peers themselves are `haptic_core`, the same lines that fly on the board.
#![forbid(unsafe_code)]

mod cli;
mod error;
mod play;
pub mod trials;

pub use cli::{Cli, provenance};
pub use error::Error;
