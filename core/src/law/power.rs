//! Power-domain coordination: position and velocity of the remote copy, one packet each T_n, held between packets.
//!
//! The simplest law and the one that delay hurts: its largest stable stiffness falls with every packet of delay
//! (cooperation paper §3, Fig. 2 and Fig. 4a).

use super::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use crate::num::{Motion, Scalar};
use crate::object::Solve;
use crate::settings::{Refused, Settings};

/// Virtual coupling to the last received motion.
#[derive(Clone, Copy, Debug)]
pub struct Power<S> {
    spring: Spring<S>,
}

configured!([S: Scalar] Power<S> { spring });

impl<S: Scalar> Law<S> for Power<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "power",
        gains: &["coordination.stiffness_n_per_m=310"],
        source: "Rakhsha & Constantinescu 2012, eq. 7",
        promises: &[Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    /// The remote copy's motion as last received: x_d, ẋ_d.
    type State = Motion<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self { spring: Spring::build(settings) })
    }

    fn start(&self, local: Motion<S>) -> Motion<S> {
        local
    }

    fn receive(&self, desired: &mut Motion<S>, packet: Packet<S>) {
        *desired = packet.motion;
    }

    fn only_holds(&self) -> bool {
        true
    }

    #[inline]
    fn couple(&self, desired: &mut Motion<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        Coupled::toward(*desired, self.spring.force(*desired, observed.local, solve))
    }

    fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
