//! Average position: a virtual coupling of each copy to the mean of all copies, where the power-domain law couples it to the others one by one.
//!
//! Of N copies, with the own one as it was when the packet came and both held until the next,
//!
//! > x_d = (x_i + Σ_{j≠i} x_j)/N,   F_T = K_T·(x_d − x_o) + B_T·(ẋ_d − ẋ_o)
//!
//! (Li & Constantinescu 2009; Rakhsha & Constantinescu, Average-Position Coordination). What it is for: N copies that are each held to each other
//! swing against each other at ω² = N·K_T/m_O, so that K_T must fall as users come; held to the mean they swing at **ω² = K_T/m_O, whatever N
//! is** (without delay; the laws' forces sum to nothing, so that the mean itself moves as one object of mass N·m_O). Here N = 2: the copies swing at
//! K_T/m_O where the power-domain law has 2·K_T/m_O, and stand F/K_T from the mean, 2F/K_T apart, when two hands push F against each other.
//!
//! Li and Constantinescu leave the own copy out of the mean; with N = 2 that is the power-domain law. With the own copy in it and taken anew with every
//! packet, what the network brings acts by half. Fotoohi, Sirouspour & Capson 2007 analyse the multirate loop of such couplings; Cheong, Niculescu & Kim 2009
//! delay the own copy as long as the others are on the way.
//!
//! **Promises**: nothing drifts, for positions are what is sent. It is not passive: delay lowers the largest stable K_T as in the power-domain law.

use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::Solve;
use cohold_core::settings::{Refused, Settings};

/// A virtual coupling to the mean of both copies.
#[derive(Clone, Copy, Debug)]
pub struct AveragePosition<S> {
    spring: Spring<S>,
    /// 1/N.
    share: S,
}

configured!([S: Scalar] AveragePosition<S> { spring, share });

/// The mean, the other copy as last received, and whether that is new.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AveragePositionState<S> {
    /// x_d, ẋ_d: the mean as the newest packet made it.
    mean: Motion<S>,
    /// The other copy as last received.
    remote: Motion<S>,
    /// It came since the last tick.
    due: bool,
}

visited!([S: Scalar] AveragePositionState<S> { mean, remote });

impl<S: Scalar> AveragePosition<S> {
    /// x_d, ẋ_d of this tick: made anew in the first one after a packet.
    #[inline]
    fn desired(&self, state: &mut AveragePositionState<S>, local: Motion<S>) -> Motion<S> {
        if core::mem::take(&mut state.due) {
            let mean = |own: S, other: S| own + self.share * (other - own);
            state.mean = Motion {
                position: mean(local.position, state.remote.position),
                velocity: mean(local.velocity, state.remote.velocity),
            };
        }
        state.mean
    }
}

impl<S: Scalar> Law<S> for AveragePosition<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "average-position",
        gains: &["coordination.stiffness_n_per_m=500"],
        source: "Li & Constantinescu 2009; Rakhsha & Constantinescu, average-position coordination",
        promises: &[Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    type State = AveragePositionState<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self { spring: Spring::build(settings), share: S::from_f64(0.5) })
    }

    fn start(&self, local: Motion<S>) -> AveragePositionState<S> {
        AveragePositionState { mean: local, remote: local, due: false }
    }

    fn receive(&self, state: &mut AveragePositionState<S>, packet: Packet<S>) {
        (state.remote, state.due) = (packet.motion, true);
    }

    #[inline]
    fn couple(
        &self,
        state: &mut AveragePositionState<S>,
        observed: &Observation<S>,
        solve: impl Solve<S>,
    ) -> Coupled<S> {
        let desired = self.desired(state, observed.local);
        Coupled::toward(desired, self.spring.force(desired, observed.local, solve))
    }

    fn send(&self, _: &AveragePositionState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
