//! The faces: the command line and the page. The peers themselves are `haptic_core`, the same lines that fly on the board.
#![forbid(unsafe_code)]

mod cli;
mod error;
pub mod live_peer;
mod play;
mod published;

pub use cli::{Cli, provenance};
pub use error::Error;
pub use haptic_guest_laws::laws;
#[cfg(fuzzing)]
pub use play::page_hears;
