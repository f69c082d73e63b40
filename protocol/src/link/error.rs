//! Why a link cannot be made, or does not take a datagram.

use crate::{ends, handshake, session, wire};

/// Why a link cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigError {
    /// Both ends were given the same number.
    #[error("both ends of a link have the number {number}: give one another")]
    SameNumber {
        /// That number.
        number: u8,
    },
    /// The shared key is all zeros: nobody has set it.
    #[error("the shared key is all zeros: make one and give it to both peers")]
    ZeroKey,
    /// The entropy is all zeros: the random number generator was not asked, or failed.
    #[error("the entropy is all zeros: the random number generator failed")]
    ZeroEntropy,
    /// The packet period is out of range.
    #[error("packet period = {us} µs is not allowed: it must be from {} to {} µs", Self::SHORTEST_US, Self::LONGEST_US)]
    PacketPeriod {
        /// What was asked for, µs.
        us: u32,
    },
}

impl ConfigError {
    /// The shortest packet period, µs.
    pub const SHORTEST_US: u32 = 100;
    /// The longest packet period, µs.
    pub const LONGEST_US: u32 = 10_000_000;
}

/// Why a datagram is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// It is not a datagram of version 1, or what was sealed in it is not a message of version 1.
    #[error(transparent)]
    Wire(wire::Error),
    /// It does not go from the other end to this one.
    #[error(transparent)]
    Ends(ends::Error),
    /// It is a greeting that this peer does not accept.
    #[error(transparent)]
    Handshake(handshake::Error),
    /// It is sealed, and there is no session that could open it.
    #[error("a sealed datagram, and no session to open it")]
    NoSession,
    /// It is sealed, and the session does not open it.
    #[error(transparent)]
    Session(session::Error),
}
