//! Peers in real time, over real sockets: each an actor on the one loop of [`endpoint`], with its recordings.
#![forbid(unsafe_code)]

pub mod addresses;
pub mod allowance;
pub mod batch;
pub mod devices;
pub mod discrepancy;
pub mod endpoint;
mod error;
pub mod hand;
#[doc(hidden)]
pub mod key_file;
pub mod measuring;
pub mod node;
pub mod operator;
pub mod path_watch;
pub mod peer;
pub mod playable;
pub mod quantiles;
pub mod recording;
pub mod refused;
pub mod relay;
pub mod road;
#[doc(hidden)]
pub mod start;
pub mod steering;
pub mod tell;
pub mod verdict;
pub mod watch;

pub use error::Error;
