//! Two homes, one link: how two peers behind two routers find each other, and the best path for what they seal.
//!
//! ```text
//!   invite ──► agreement: a key, once ──► carrier ──┬── relay at the meeting place, from the first moment
//!   (link)     (X25519 under the secret)            └── direct, as soon as ICE has found a way
//! ```
//!
//! Above a carrier is the link of this end, or a [`bridge`] to a board whose link is its own.
//!
//! [`carried`], [`meet`], [`invitation`] and [`beside`] have the sockets, the rest opens none and reads no clock: bytes and `now` in, bytes and their
//! addresses out. The sealed datagrams of [`cohold_protocol`] pass through as they are; whoever carries them cannot read them. [`join`] adds the
//! commands and flags to a command line.
#![forbid(unsafe_code)]

pub mod agreement;
pub mod allowance;
pub mod beside;
mod board_command;
pub mod bridge;
pub mod carried;
pub mod carrier;
mod command;
mod error;
pub mod frame;
mod hold;
mod ice;
pub mod invitation;
pub mod invite;
pub mod mapping;
pub mod meet;
mod paths;
pub mod place;
pub mod seat;
mod signal;
pub mod stun;

pub use cohold_live::road::{PathFigures, Way};
pub use error::Error;

use board_command::BoardCommands;
use cohold_cli::Cli;
use command::{MEETING, MeetCommands, MeetingFlags, declare};

/// Adds the commands of two homes, and the flags by which both ends meet, to a command line.
pub fn join(cli: Cli) -> Cli {
    cli.with_commands::<MeetCommands>("")
        .with_commands::<BoardCommands>("board")
        .with_road::<MeetingFlags>(&MEETING, declare)
}

/// Takes a datagram, and where it goes.
pub type Send<'a> = dyn FnMut(std::net::SocketAddr, &[u8]) + 'a;
