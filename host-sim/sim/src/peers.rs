//! Peers behind one door, whatever their law and number type: what everything that runs a scene on a PC holds.
//!
//! Behind [`DynPeer`] runs the very peer that flies; one virtual call a tick is little beside what a tick computes.

use std::fmt::Debug;

use haptic_core::contact::Impacts;
use haptic_core::device::AXES;
use haptic_core::device::probe::{Outcome, Probe};
use haptic_core::law::ledger::Ledger;
use haptic_core::law::{AnyLaw, Law, Packet};
use haptic_core::num::{Fixed, Motion, Scalar, StateVector};
use haptic_core::peer::{Actuators, Observed, Peer, Sensors};
use haptic_core::safety::{Command, Mode};
use haptic_core::settings::{Refused, Settings};

use crate::double_double::DoubleDouble;

/// One haptic peer, configuration and state: the methods of `haptic_core::peer`, by number type only.
pub trait DynPeer<S: Scalar>: Debug + Send + Sync {
    /// One control period: sensors in, forces out.
    fn tick(&mut self, sensors: &Sensors<S>) -> Actuators<S>;
    /// One packet period: takes in what the network brought and gives what to send.
    fn exchange(&mut self, incoming: Option<Packet<S>>) -> Packet<S>;
    /// What it would send now.
    fn outgoing(&self) -> Packet<S>;
    /// Whether [`DynPeer::exchange`] is due before the next tick.
    fn packet_due(&self) -> bool;
    /// Carries out an operator's command.
    fn command(&mut self, command: Command);
    /// Lets go of the other peer until a packet comes.
    fn part(&mut self);
    /// Begins a probe, if disarmed.
    fn probe(&mut self, probe: Probe<S>);
    /// What came of the last probe.
    fn probed(&self) -> Outcome;
    /// The mode, with the fault that latched.
    fn mode(&self) -> Mode;
    /// Whether the coordination acts.
    fn is_engaged(&self) -> bool;
    /// What the last tick saw and did.
    fn observed(&self) -> &Observed<S>;
    /// Energy that crossed the network port since arming.
    fn ledger(&self) -> &Ledger<S>;
    /// Impacts since arming, where contact is impulsive.
    fn impacts(&self) -> Impacts<S>;
    /// Calls `each` for every number of the dynamic state, always in the same order.
    fn visit_state(&mut self, each: &mut dyn FnMut(&mut S));
    /// A hash (FNV-1a over 64-bit words) of the bits of the dynamic state, continued from `seed`.
    fn hash(&self, seed: u64) -> u64;
    /// The same peer once more.
    fn boxed(&self) -> Box<dyn DynPeer<S>>;
}

impl<S: Scalar> Clone for Box<dyn DynPeer<S>> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl<S: Scalar> StateVector<S> for dyn DynPeer<S> + '_ {
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.visit_state(each);
    }
}

/// A number type that a peer can be asked for at run time: `f32`, as the board, `f64`, [`Fixed`], or [`DoubleDouble`].
pub trait Number: Scalar {}
impl Number for f32 {}
impl Number for f64 {}
impl Number for Fixed {}
impl Number for DoubleDouble {}

impl<S: Scalar, L: Law<S>> DynPeer<S> for Peer<S, L> {
    fn tick(&mut self, sensors: &Sensors<S>) -> Actuators<S> {
        Peer::tick(self, sensors)
    }
    fn exchange(&mut self, incoming: Option<Packet<S>>) -> Packet<S> {
        Peer::exchange(self, incoming)
    }
    fn outgoing(&self) -> Packet<S> {
        Peer::outgoing(self)
    }
    fn packet_due(&self) -> bool {
        Peer::packet_due(self)
    }
    fn command(&mut self, command: Command) {
        Peer::command(self, command);
    }
    fn part(&mut self) {
        Peer::part(self);
    }
    fn probe(&mut self, probe: Probe<S>) {
        Peer::probe(self, probe);
    }
    fn probed(&self) -> Outcome {
        Peer::probed(self)
    }
    fn mode(&self) -> Mode {
        Peer::mode(self)
    }
    fn is_engaged(&self) -> bool {
        Peer::is_engaged(self)
    }
    fn observed(&self) -> &Observed<S> {
        Peer::observed(self)
    }
    fn ledger(&self) -> &Ledger<S> {
        Peer::ledger(self)
    }
    fn impacts(&self) -> Impacts<S> {
        Peer::impacts(self)
    }
    fn visit_state(&mut self, each: &mut dyn FnMut(&mut S)) {
        self.visit(&mut |number| each(number));
    }
    fn hash(&self, seed: u64) -> u64 {
        let mut hash = seed;
        { *self }.visit(&mut |number: &mut S| {
            // The fold brings the high bits down, where the next product spreads them again.
            hash = (hash ^ number.bits()).wrapping_mul(0x0000_0100_0000_01b3);
            hash ^= hash >> 32;
        });
        hash
    }
    fn boxed(&self) -> Box<dyn DynPeer<S>> {
        Box::new(*self)
    }
}

/// A peer that is told these settings, disarmed. `device` is where the device is when its encoders are first read.
///
/// # Errors
/// The first key whose value is out of range, or impossible beside the others.
pub fn build<S: Number>(
    settings: &Settings,
    device: [Motion<S>; AXES],
) -> Result<Box<dyn DynPeer<S>>, Refused<'static>> {
    Ok(Box::new(Peer::<S, AnyLaw<S>>::new(settings, device)?))
}
