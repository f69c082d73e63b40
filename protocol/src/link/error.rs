//! Why a link cannot be made, or does not take a datagram.

use core::fmt;

use crate::{ends, handshake, session, wire};

/// Why a link cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigError {
    /// Both ends were given the same number.
    SameNumber {
        /// That number.
        number: u8,
    },
    /// The shared key is all zeros: nobody has set it.
    ZeroKey,
    /// The entropy is all zeros: the random number generator was not asked, or failed.
    ZeroEntropy,
    /// The packet period is out of range.
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

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SameNumber { number } => write!(f, "both ends of a link have the number {number}: give one another"),
            Self::ZeroKey => f.write_str("the shared key is all zeros: make one and give it to both peers"),
            Self::ZeroEntropy => f.write_str("the entropy is all zeros: the random number generator failed"),
            Self::PacketPeriod { us } => write!(
                f,
                "packet period = {us} µs is not allowed: it must be from {} to {} µs",
                Self::SHORTEST_US,
                Self::LONGEST_US
            ),
        }
    }
}

impl core::error::Error for ConfigError {}

/// Why a datagram is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// It is not a datagram of version 1, or what was sealed in it is not a message of version 1.
    Wire(wire::Error),
    /// It does not go from the other end to this one.
    Ends(ends::Error),
    /// It is a greeting that this peer does not accept.
    Handshake(handshake::Error),
    /// It is sealed, and there is no session that could open it.
    NoSession,
    /// It is sealed, and the session does not open it.
    Session(session::Error),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wire(error) => error.fmt(f),
            Self::Ends(error) => error.fmt(f),
            Self::Handshake(error) => error.fmt(f),
            Self::NoSession => f.write_str("a sealed datagram, and no session to open it"),
            Self::Session(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for Error {}
