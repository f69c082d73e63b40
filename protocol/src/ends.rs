//! Ends: which two peers a link connects, and whether a datagram goes from the other to this one.
//!
//! Numbers are not secret and prove nothing; they give every direction its own keys, and they tell a person which wire
//! was crossed.

use crate::wire::PeerId;

/// The two ends of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ends {
    /// This peer.
    pub local: PeerId,
    /// The other one.
    pub remote: PeerId,
}

/// Why a datagram is none of this link's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// It comes from this peer's own number: reflected, or two peers were given the same one.
    #[error("a datagram from this peer's own number: reflected, or two peers have the same number")]
    OwnNumber,
    /// It comes from a peer that this link does not lead to.
    #[error("a datagram from a peer that this link does not lead to")]
    Stranger,
    /// It is for another peer.
    #[error("a datagram for another peer")]
    NotForUs,
}

impl Ends {
    /// Whether a datagram from `from` for `to` goes from the other end to this one.
    pub fn check(self, from: PeerId, to: PeerId) -> Result<(), Error> {
        if from == self.local {
            Err(Error::OwnNumber)
        } else if from != self.remote {
            Err(Error::Stranger)
        } else if to != self.local {
            Err(Error::NotForUs)
        } else {
            Ok(())
        }
    }
}
