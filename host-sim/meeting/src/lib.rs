//! Two homes, one link: how two peers behind two routers find each other, and the best path for what they seal.
//!
//! ```text
//!   invite ──► agreement: a key, once ──► carrier ──┬── relay at the meeting place, from the first moment
//!   (link)     (X25519 under the secret)            └── direct, as soon as ICE has found a way
//! ```
//!
//! Above a carrier is the link of this end, or a [`bridge`] to a board whose link is its own.
//!
//! Nothing here opens a socket or reads a clock: bytes and `now` in, bytes and their addresses out (`haptic-live` has the sockets). The sealed
//! datagrams of [`haptic_protocol`] pass through as they are; whoever carries them cannot read them.
//!
#![forbid(unsafe_code)]

pub mod agreement;
pub mod allowance;
pub mod bridge;
pub mod carrier;
mod error;
pub mod frame;
mod hold;
mod ice;
pub mod invite;
pub mod mapping;
mod paths;
pub mod place;
pub mod seat;
mod signal;
pub mod stun;

pub use error::Error;
pub use paths::{PathFigures, Way};

/// Takes a datagram, and where it goes.
pub type Send<'a> = dyn FnMut(std::net::SocketAddr, &[u8]) + 'a;
