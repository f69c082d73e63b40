//! Ends: which two peers a link connects, and whether a datagram goes from the other to this one.
//!
//! Numbers are not secret and prove nothing; they give every direction its own keys, and they tell a person which wire
//! was crossed.

use crate::{error::Refusal, wire::PeerId};

/// The two ends of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ends {
    /// Number of this peer.
    pub local: PeerId,
    /// Number of the other peer.
    pub remote: PeerId,
}

impl Ends {
    /// Whether a datagram from `from` for `to` goes from the other end to this one.
    pub(crate) fn check(self, from: PeerId, to: PeerId) -> Result<(), Refusal> {
        if from == self.local {
            Err(Refusal::OwnNumber)
        } else if from != self.remote {
            Err(Refusal::Stranger)
        } else if to != self.local {
            Err(Refusal::NotForUs)
        } else {
            Ok(())
        }
    }
}
