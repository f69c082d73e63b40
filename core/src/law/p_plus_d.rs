//! P+d: a spring to the other copy's position as it was last heard, and a damper to the ground.
//!
//! > F_T = K_T·(x_d − x_o) − B_T·v
//!
//! (Nuño, Basañez, Ortega & Spong 2009; Lee & Spong 2006 with the damper of the other end in it). Only positions are sent. The spring alone makes energy: over
//! a delay of T each way it pulls by what has changed since, at most K_T·|sin(ωT)/ω| ≤ K_T·T of what a damper takes. So both copies together are
//! passive where
//!
//! > B_T ≥ K_T·T
//!
//! with T the mean of both delays, hold included (Lee & Spong's K_d, by Parseval's identity; for delays that vary Nuño's 4·B² > K²·(T₁² + T₂²) of the
//! longest ones). **What it costs** is drag: who pushes the object pushes it through 2·(B_T + K_T·T), whether the network is good or bad.
//!
//! **Promises**: nothing drifts, for positions are what is sent. It is passive up to the delay that its gains are for, and no further.

use super::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use crate::num::{Motion, Scalar};
use crate::object::Solve;
use crate::settings::{Refused, Settings};

/// A spring to the last received position, and a damper to the ground.
#[derive(Clone, Copy, Debug)]
pub struct PPlusD<S> {
    spring: Spring<S>,
}

configured!([S: Scalar] PPlusD<S> { spring });

impl<S: Scalar> Law<S> for PPlusD<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "p-plus-d",
        gains: &["coordination.stiffness_n_per_m=310", "coordination.damping_n_s_per_m=30"],
        source: "Nuño, Basañez, Ortega & Spong 2009, P+d; Lee & Spong 2006",
        promises: &[Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    /// The remote copy as last received, at rest there: x_d.
    type State = Motion<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self { spring: Spring::build(settings) })
    }

    fn start(&self, local: Motion<S>) -> Motion<S> {
        Motion::at(local.position)
    }

    fn receive(&self, desired: &mut Motion<S>, packet: Packet<S>) {
        *desired = Motion::at(packet.motion.position);
    }

    fn only_holds(&self) -> bool {
        true
    }

    #[inline]
    fn couple(&self, desired: &mut Motion<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        // What is sent is a position: between two packets the far end of the spring stands, and no energy crosses.
        let force = self.spring.force(*desired, observed.local, solve);
        Coupled { desired: *desired, force, ..Coupled::default() }
    }

    fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: Motion::at(local.position), ..Packet::default() }
    }
}
