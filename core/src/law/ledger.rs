//! Energy ledger of one peer: what came in from the network and what went out, J, since arming.
//!
//! Summed every tick with compensation (Kahan), so that an hour of f32 ticks loses nothing that matters: the error stays
//! at a few ulp of the sum, whatever the number of terms.

use super::Coupled;
use crate::num::{Scalar, Sum};

/// Energy that crossed the network port of one peer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger<S> {
    received: Sum<S>,
    sent: Sum<S>,
}

impl<S: Scalar> Ledger<S> {
    /// Adds the energies of one tick of `period` seconds.
    #[inline]
    pub fn book(&mut self, coupled: &Coupled<S>, period: S) {
        self.received.add(coupled.power_in * period);
        self.sent.add(coupled.power_out * period);
    }

    /// Energy from the network, T_c·Σ½u_in², J.
    pub fn received_j(&self) -> S {
        self.received.total()
    }

    /// Energy to the network, T_c·Σ½u_out², J.
    pub fn sent_j(&self) -> S {
        self.sent.total()
    }
}
